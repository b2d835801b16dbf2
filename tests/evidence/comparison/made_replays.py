"""Made records of pushes: the simulator's own motion written down at uneven times."""

import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.evidence.pushes.recordings import PushRecord
from cyclemap.mechanics import EllipseFriction, Material, Pose, Pusher, QuasiStaticModel, Slider

FRICTION = EllipseFriction.isotropic(0.25)
START = Pose(0.3, -0.1, 2.9)


def model_of(name, accuracy=1e-6):
    slider = name if isinstance(name, Slider) else Slider.mit(name)
    return QuasiStaticModel(slider, FRICTION, Pusher(friction=0.25), accuracy=accuracy)


def loop_on(friction=FRICTION, slider=None, **known):
    """The loop whose rod is that of `model_of`, on a material of which so much is known."""
    material = Material("made", friction, **known)
    return CollectionLoop.mit(material, slider=slider, pusher=Pusher(friction=0.25))


def clock(length, samples=300):
    """Times (s) and travels (m) of a tip that rests, speeds up, slows down and rests again."""
    time = np.linspace(0.0, 1.3, samples) ** 1.1
    share = np.clip((time - 0.2) / 0.8, 0.0, 1.0)
    return time, length * share**2 * (3.0 - 2.0 * share)


def record_of(time, poses, tip):
    """A record of poses (n, 3), angles wrapped as in the files, and tips (n, 2)."""
    wrapped = np.column_stack([poses[:, :2], np.angle(np.exp(1j * poses[:, 2]))])
    still = np.zeros((len(time), 1))
    return PushRecord(
        np.column_stack([1e9 + time, wrapped]),
        np.column_stack([1e9 + time, tip, still]),
        np.column_stack([1e9 + time, np.tile(still, 3)]),
    )


def world(pose, place):
    return np.array(pose.to_world(*place))
