"""The push in MuJoCo: a plate on four small spheres, pushed by a heavy rod that keeps its speed."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, PushProblem, Simulator

# The rod's mass, kg: so much that pushing does not slow it, and no controller has to be called at every step.
_ROD_MASS = 1e8
_FOOT = 0.002
_SETTLE = 500


@dataclass(frozen=True)
class MujocoSettings:
    """What the accuracy and the time of a push hang on.

    speed : of the rod, m/s. step : s. impratio : how much stiffer friction is than the normal force.
    floor_time, friction_time, rod_time, rod_friction_time : time constants of the floor's and the rod's contacts, s.
    floor_softness, rod_softness : one less MuJoCo's impedance. A contact that slides is pushed open in proportion to
    its speed over friction_time, so that the load would shift between hard feet: the floor has to be soft.
    tilts : six degrees of freedom, else the four that the push needs: across the floor, up, and about the vertical.
    tolerance : of MuJoCo's solver.
    """

    speed: float
    step: float
    impratio: float
    floor_time: float
    floor_softness: float
    friction_time: float
    rod_time: float
    rod_friction_time: float
    rod_softness: float
    tilts: bool = True
    tolerance: float = 1e-10


class MujocoPush:
    """One model, built once, in which pushes are run; raises AssertionError for friction that has directions."""

    def __init__(self, problem: PushProblem, settings: MujocoSettings) -> None:
        assert problem.friction.mu_a == problem.friction.mu_b and problem.friction.m0 == problem.friction.n0 == 0.0
        self.problem, self.settings = problem, settings
        self.model = mujoco.MjModel.from_xml_string(_scene(problem, settings))
        self.data = mujoco.MjData(self.model)
        self._rest = self._settled()

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops."""
        place, direction = self.problem.rod_path(pose, push)
        data, steps = self.data, self.steps(push)
        mujoco.mj_resetData(self.model, data)
        self._place_plate(pose)
        data.qpos[-2:] = place
        data.qvel[-2:] = np.multiply(direction, push.distance / (steps * self.settings.step))
        mujoco.mj_step(self.model, data, nstep=steps)
        return self._plate_pose(pose)

    def steps(self, push: SidePush) -> int:
        """How many steps a push takes."""
        return round(push.distance / self.settings.speed / self.settings.step)

    def _settled(self) -> float:
        """Height at which the plate rests, m, the rod out of its way."""
        self.data.qpos[-2:] = 10.0
        mujoco.mj_step(self.model, self.data, nstep=_SETTLE)
        return float(self.data.qpos[2])

    def _place_plate(self, pose: Pose) -> None:
        self.data.qpos[:3] = pose.x, pose.y, self._rest
        if self.settings.tilts:
            self.data.qpos[3:7] = np.cos(pose.theta / 2.0), 0.0, 0.0, np.sin(pose.theta / 2.0)
        else:
            self.data.qpos[3] = pose.theta

    def _plate_pose(self, start: Pose) -> Pose:
        x, y = self.data.qpos[:2].tolist()
        if not self.settings.tilts:
            return Pose(x, y, float(self.data.qpos[3]))
        theta = 2.0 * float(np.arctan2(self.data.qpos[6], self.data.qpos[3]))
        return Pose(x, y, start.theta + float(np.remainder(theta - start.theta + np.pi, 2.0 * np.pi) - np.pi))


def _scene(problem: PushProblem, settings: MujocoSettings) -> str:
    """The model in MuJoCo's own format; what touches what is said pair by pair, so that nothing else is looked for."""
    points, _ = problem.footprint.quadrature
    feet = "".join(f'<geom name="foot{i}" size="{_FOOT}" pos="{x} {y} {_FOOT}"/>' for i, (x, y) in enumerate(points))
    half = float(np.abs(points).max())
    joints = (
        "<freejoint/>"
        if settings.tilts
        else '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="slide" axis="0 0 1"/>'
        '<joint type="hinge" axis="0 0 1"/>'
    )
    mass, inertia = problem.slider.mass, problem.slider.inertia
    floor = _softness(settings.floor_time, settings.friction_time, settings.floor_softness)
    touch = _softness(settings.rod_time, settings.rod_friction_time, settings.rod_softness)
    ground, rod = problem.friction.mu_a, problem.pusher.friction
    pairs = "".join(
        f'<pair geom1="floor" geom2="foot{i}" condim="3" friction="{ground} {ground}" {floor}/>'
        for i in range(len(points))
    )
    return f"""
<mujoco>
  <option timestep="{settings.step}" cone="elliptic" impratio="{settings.impratio}" solver="Newton"
          tolerance="{settings.tolerance}" gravity="0 0 -9.80665"/>
  <default><geom contype="0" conaffinity="0" type="sphere"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 1"/>
    <body name="plate">{joints}
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia / 2.0} {inertia / 2.0} {inertia}"/>
      <geom name="plate" type="box" size="{half} {half} {half}"/>{feet}
    </body>
    <body name="rod">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="{_ROD_MASS}" diaginertia="1 1 1"/>
      <geom name="rod" size="{problem.pusher.radius}"/>
    </body>
  </worldbody>
  <contact>{pairs}<pair geom1="rod" geom2="plate" condim="3" friction="{rod} {rod}" {touch}/></contact>
</mujoco>"""


def _softness(time: float, friction_time: float, softness: float) -> str:
    impedance = 1.0 - softness
    return f'solref="{time} 1" solreffriction="{friction_time} 1" solimp="{impedance} {impedance} 0.001"'


SIMULATOR = Simulator(
    "MuJoCo",
    mujoco.__version__,
    MujocoPush,
    chosen={
        # The best of searches by `python -m tests.benchmarks.peers.settings mujoco`, 4 to 6 minutes from several seeds.
        CORNERS: MujocoSettings(
            speed=0.008834,
            step=0.03032,
            impratio=119.7,
            floor_time=0.01985,
            floor_softness=0.03006,
            friction_time=0.07547,
            rod_time=0.002253,
            rod_friction_time=0.1544,
            rod_softness=0.008136,
            tolerance=3.854e-11,
        )
    },
    finer=lambda settings: replace(settings, step=settings.step / 8.0),
    searched={
        "speed": (0.003, 0.2),
        "step": (1e-4, 0.05),
        "impratio": (1.0, 1e6),
        "floor_time": (0.002, 3.0),
        "floor_softness": (0.001, 0.9999),
        "friction_time": (0.002, 10.0),
        "rod_time": (0.002, 0.5),
        "rod_friction_time": (0.002, 3.0),
        "rod_softness": (1e-4, 0.99),
        "tolerance": (1e-14, 1e-7),
    },
)
