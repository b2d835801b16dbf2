"""Kernels in C: the CasADi functions of the strokes, generated, compiled once, cached, and run below Python."""
