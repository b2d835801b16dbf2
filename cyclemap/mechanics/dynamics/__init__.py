"""The dynamic simulation: the slider with its inertia, pushed and dragged through a stiff contact."""
