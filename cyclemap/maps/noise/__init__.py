"""Laws of the noise that is added after each cycle."""
