"""The compiled engine: what it is generated from, how it is loaded."""
