"""The noise that is added after each cycle, and chances of going from cell to cell under it."""
