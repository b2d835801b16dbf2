"""The noise that is added after each cycle, and the panels on which uniform noise is resolved."""
