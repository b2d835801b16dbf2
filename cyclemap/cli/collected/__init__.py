"""The commands that read collected data, or make some."""
