"""Measured data of every sort as blocks: prediction against measurement, and its derivatives."""
