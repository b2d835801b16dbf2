"""How long noisy paths stay and where they go: passage times, quasi-stationary laws, slips."""
