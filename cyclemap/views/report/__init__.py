"""The report: one HTML file that opens without a network, drawn by the explorer's own code."""
