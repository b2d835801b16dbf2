"""Noisy paths over many cycles: sampling, slow zones, wear, steps found and compared."""
