"""A world that is not this package's: MuJoCo's plate on many soft feet, with elliptic cones.

The feet press as a foundation does: what a foot carries is the depth to which it is pressed, and
it stands out of the plate by the plate's shape and, as the plate turns, by the floor's. Cones have
two axes, so that friction is an ellipse about them; MuJoCo knows no ellipse off its centre.
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import Pose, PressedFootprint, SurfaceShape, WorldPush, grid_footprint
from cyclemap.mechanics.foundation import SHAPE_RADIUS

SIDE = 6
# Of a foot, m; of the rod, kg: so heavy that no push slows it. Of rod and ring, m/s; of a step, s;
# steps between looks at how the feet stand.
_FOOT, _ROD_MASS = 0.002, 1e8
SPEED, STEP, LOOK = 0.01, 0.002, 10
_SETTLE = 2000
# How much stiffer friction is than the normal force.
_STIFFER = 1e3
# Time constants (s) of contact and of friction, and softness: one less MuJoCo's impedance.
_FLOOR, _ROD = (0.03, 0.3, 0.5), (0.004, 0.1, 0.001)


@dataclass(frozen=True)
class Scene:
    """A model, its data, and where a plate rests on it whose feet are even, m."""

    model: mujoco.MjModel
    data: mujoco.MjData
    height: float
    depth: float


class MujocoWorld:
    """A loop whose object is pushed by a rod and dragged by a ring in MuJoCo.

    The ellipse's offset and the ring's friction are left out. Beside the quasi-static model's,
    pushes of 50 mm end within 1 degree and 3 mm, drags within 2 degrees.
    """

    def __init__(self, loop: CollectionLoop) -> None:
        self.loop = loop
        footprint = loop.model.footprint
        assert isinstance(footprint, PressedFootprint)
        self.pressed = footprint
        self.points = grid_footprint(loop.slider.outline, SIDE).quadrature[0]
        self.pushing = _scene(loop, self.points, ring=False)
        self.dragging = _scene(loop, self.points, ring=True)

    def push(self, pose: Pose, push: WorldPush) -> Pose:
        """The object's pose when the rod stops."""
        way = np.array((math.cos(push.direction), math.sin(push.direction)))
        return self._moved(self.pushing, pose, np.array(push.start), way, push.distance)

    def drag(self, pose: Pose, goal: tuple[float, float]) -> Pose:
        """The object's pose when its ring has come straight to a place."""
        ring = np.array(pose.to_world(*self.loop.slider.hitch))
        way = np.array(goal) - ring
        far = float(np.hypot(*way))
        return self._moved(self.dragging, pose, ring, way / far, far)

    def _moved(
        self, scene: Scene, pose: Pose, rod: np.ndarray, way: np.ndarray, far: float
    ) -> Pose:
        """Run from rest; the model's axes are those of friction."""
        model, data = scene.model, scene.data
        axis = self.loop.material.friction.phi
        c, s = math.cos(axis), math.sin(axis)
        turned = np.array(((c, s), (-s, c)))
        rounds = math.ceil(far / SPEED / (LOOK * STEP))
        mujoco.mj_resetData(model, data)
        data.qpos[:2] = turned @ (pose.x, pose.y)
        data.qpos[2] = scene.height
        half = 0.5 * (pose.theta - axis)
        data.qpos[3:7] = math.cos(half), 0.0, 0.0, math.sin(half)
        data.qpos[7:9] = turned @ rod
        theta = pose.theta
        self._stand(scene, theta)
        mujoco.mj_step(model, data, nstep=_SETTLE // 4)
        data.qvel[6:8] = turned @ way * far / (rounds * LOOK * STEP)
        for _ in range(rounds):
            mujoco.mj_step(model, data, nstep=LOOK)
            now = 2.0 * math.atan2(data.qpos[6], data.qpos[3]) + axis
            theta += math.remainder(now - theta, math.tau)
            self._stand(scene, theta)
        x, y = (turned.T @ data.qpos[:2]).tolist()
        return Pose(x, y, theta)

    def _stand(self, scene: Scene, theta: float) -> None:
        """Let the feet stand out as the plate's and the floor's shape have it."""
        heights = _shape(self.pressed.plate, self.points, 0.0)
        heights = heights + _shape(self.pressed.floor, self.points, theta)
        scene.model.geom_pos[1 : 1 + len(self.points), 2] = _FOOT - scene.depth * heights


def _shape(shape: SurfaceShape, points: np.ndarray, theta: float) -> np.ndarray:
    """The pressure that a shape adds at points of the plate, in mean pressures."""
    x, y = points.T / SHAPE_RADIUS
    radius, angle = np.hypot(x, y), np.arctan2(y, x) + theta
    return radius**2 * (shape.dome + shape.bow * np.cos(2.0 * (angle - shape.axis)))


def _scene(loop: CollectionLoop, points: np.ndarray, *, ring: bool) -> Scene:
    """Build the model and let the plate come to rest on even feet."""
    slider, friction, pusher = loop.slider, loop.material.friction, loop.pusher
    feet, pairs = [], []
    floor, touch = (
        f'solref="{time} 1" solreffriction="{friction_time} 1" solimp="{1.0 - softness} '
        f'{1.0 - softness} 0.001"'
        for time, friction_time, softness in (_FLOOR, _ROD)
    )
    # MuJoCo's first tangent of a level floor is its y axis.
    cone = f"{friction.mu_b} {friction.mu_a}"
    for index, (x, y) in enumerate(points.tolist()):
        feet.append(f'<geom name="foot{index}" size="{_FOOT}" pos="{x} {y} {_FOOT}"/>')
        pairs.append(
            f'<pair geom1="floor" geom2="foot{index}" condim="4" '
            f'friction="{cone} 1e-9 1e-9 1e-9" {floor}/>'
        )
    half_x, half_y = np.abs(slider.outline.array).max(axis=0).tolist()
    hitch_x, hitch_y = slider.hitch
    rod = f"{pusher.friction} {pusher.friction}"
    join = '<equality><connect site1="hitch" site2="pin" solref="0.004 1"/></equality>'
    contact = f'<pair geom1="rod" geom2="plate" condim="3" friction="{rod}" {touch}/>'
    inertia = slider.inertia or slider.mass * (half_x**2 + half_y**2) / 3.0
    model = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{STEP}" cone="elliptic" impratio="{_STIFFER}" solver="Newton"
          tolerance="1e-12" gravity="0 0 -9.80665"/>
  <default><geom contype="0" conaffinity="0" type="sphere"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 1"/>
    <body name="plate"><freejoint/>
      <inertial pos="0 0 0" mass="{slider.mass}"
                diaginertia="{inertia / 2.0} {inertia / 2.0} {inertia}"/>
      {"".join(feet)}
      <geom name="plate" type="box" size="{half_x} {half_y} 0.01"/>
      <site name="hitch" pos="{hitch_x} {hitch_y} 0"/></body>
    <body name="rod">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
      <inertial pos="0 0 0" mass="{_ROD_MASS}" diaginertia="1 1 1"/>
      <geom name="rod" size="{pusher.radius}"/>
      <body name="pin" gravcomp="1"><joint type="slide" axis="0 0 1"/>
        <inertial pos="0 0 0" mass="1e-3" diaginertia="1e-3 1e-3 1e-3"/><site name="pin"/></body>
    </body>
  </worldbody>
  {join if ring else ""}
  <contact>{"".join(pairs)}{"" if ring else contact}</contact>
</mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[7:9] = slider.hitch if ring else (10.0, 10.0)
    mujoco.mj_step(model, data, nstep=_SETTLE)
    height = float(data.qpos[2])
    return Scene(model, data, height, -height)
