"""What integration says of motions that it cannot follow."""

import pytest

from cyclemap.errors import ConvergenceError, TooManySteps
from cyclemap.mechanics import EllipseFriction, Pose, QuasiStaticModel, Slider, event_integration
from cyclemap.mechanics.compiled.stroke_runner import interpreted


def test_a_motion_whose_steps_are_too_many_is_refused_by_name_with_what_to_do(monkeypatch):
    """A thousand to one: the trailing object turns to where it slides easily, in steps that stay short for it."""
    monkeypatch.setattr(event_integration, "MOST_STEPS", 300)
    steep, mild = (QuasiStaticModel(Slider.mit("rect1"), EllipseFriction(0.3, 0.3 / ratio)) for ratio in (1000.0, 2.0))
    with interpreted():
        with pytest.raises(TooManySteps, match=r"more than 300 steps.*friction law nearer to isotropic") as told:
            steep.drag(Pose(0.3, 0.1, 0.4), ((0.0, 0.0),))
        assert isinstance(told.value, ConvergenceError)
        assert mild.drag(Pose(0.3, 0.1, 0.4), ((0.0, 0.0),)).turn != 0.0
