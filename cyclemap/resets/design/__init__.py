"""Design of resets: what to push and how often, ranked and bounded by what no rule can beat."""
