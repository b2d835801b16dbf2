"""The theory behind cyclemap in SymPy: each function returns an expression, and a test checks each
against the code.
"""
