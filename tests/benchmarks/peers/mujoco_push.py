"""The push in MuJoCo: a plate on four small spheres, pushed by a heavy rod that keeps its speed."""

import mujoco
import numpy as np

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, EndPose, PushProblem, Simulator

# The rod's mass, kg: so much that pushing does not slow it, and no controller has to be called at
# every step.
_ROD_MASS = 1e8
_FOOT = 0.002
_SETTLE = 500
# Of the rod, m/s; of the simulation, s; how much stiffer friction is than the normal force; of
# MuJoCo's solver.
SPEED, STEP, IMPRATIO, TOLERANCE = 0.008834, 0.03032, 119.7, 3.854e-11
# Time constants (s) of contact and of friction, and softness: one less MuJoCo's impedance. A
# contact that slides is pushed open in proportion to its speed over friction's time constant, so
# that the load would shift between hard feet: the floor has to be soft.
FLOOR, ROD = (0.01985, 0.07547, 0.03006), (0.002253, 0.1544, 0.008136)


class MujocoPush:
    """One model, built once, in which pushes are run; raises AssertionError for friction that has
    directions.
    """

    def __init__(self, problem: PushProblem, step: float = STEP, cone: str = "elliptic") -> None:
        assert (
            problem.friction.mu_a == problem.friction.mu_b
            and problem.friction.m0 == problem.friction.n0 == 0.0
        )
        self.problem, self.step = problem, step
        self.model = mujoco.MjModel.from_xml_string(_scene(problem, step, cone))
        self.data = mujoco.MjData(self.model)
        # The height at which the plate rests, m, the rod out of its way.
        self.data.qpos[-2:] = 10.0
        mujoco.mj_step(self.model, self.data, nstep=_SETTLE)
        self._rest = float(self.data.qpos[2])

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops."""
        place, direction = self.problem.rod_path(pose, push)
        data, steps = self.data, round(push.distance / SPEED / self.step)
        mujoco.mj_resetData(self.model, data)
        data.qpos[:3] = pose.x, pose.y, self._rest
        data.qpos[3:7] = np.cos(pose.theta / 2.0), 0.0, 0.0, np.sin(pose.theta / 2.0)
        data.qpos[-2:] = place
        data.qvel[-2:] = np.multiply(direction, push.distance / (steps * self.step))
        mujoco.mj_step(self.model, data, nstep=steps)
        x, y = data.qpos[:2].tolist()
        theta = 2.0 * float(np.arctan2(data.qpos[6], data.qpos[3]))
        return Pose(
            x, y, pose.theta + float(np.remainder(theta - pose.theta + np.pi, 2.0 * np.pi) - np.pi)
        )


def _scene(problem: PushProblem, step: float, cone: str) -> str:
    """The model in MuJoCo's own format; what touches what is said pair by pair, so that nothing
    else is looked for.
    """
    points, _ = problem.footprint.quadrature
    feet = "".join(
        f'<geom name="foot{i}" size="{_FOOT}" pos="{x} {y} {_FOOT}"/>'
        for i, (x, y) in enumerate(points)
    )
    half = float(np.abs(points).max())
    mass, inertia = problem.slider.mass, problem.slider.inertia
    floor, touch = (
        f'solref="{time} 1" solreffriction="{friction_time} 1" solimp="{1.0 - softness} '
        f'{1.0 - softness} 0.001"'
        for time, friction_time, softness in (FLOOR, ROD)
    )
    ground, rod = problem.friction.mu_a, problem.pusher.friction
    pairs = "".join(
        f'<pair geom1="floor" geom2="foot{i}" condim="3" friction="{ground} {ground}" {floor}/>'
        for i in range(len(points))
    )
    return f"""
<mujoco>
  <option timestep="{step}" cone="{cone}" impratio="{IMPRATIO}" solver="Newton"
          tolerance="{TOLERANCE}" gravity="0 0 -9.80665"/>
  <default><geom contype="0" conaffinity="0" type="sphere"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 1"/>
    <body name="plate"><freejoint/>
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


def mujoco_push(problem: PushProblem, finer: bool = False) -> EndPose:
    """The push as it is timed; finer with an eighth of the step."""
    return MujocoPush(problem, STEP / 8.0 if finer else STEP).end_pose


SIMULATOR = Simulator("MuJoCo", mujoco.__version__, mujoco_push, (CORNERS,))
