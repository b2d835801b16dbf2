"""How long noisy paths stay and where they go: passage times, hitting probabilities, survival."""
