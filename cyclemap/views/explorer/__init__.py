"""The explorer: a local page with sliders, and what it asks of the rooms; report and explorer share the drawing."""
