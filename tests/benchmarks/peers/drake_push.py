"""The push in Drake: a plate on four small spheres, pushed by a heavy rod that keeps its speed."""

import logging
from importlib.metadata import version

import numpy as np
from pydrake import all as drake

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, EndPose, PushProblem, Simulator

# The rod's mass, kg: so much that pushing does not slow it, and no controller has to be called at
# every step.
_ROD_MASS = 1e8
_FOOT = 0.002
_SETTLE = 0.5
# It tells at every start that TAMSI will go one day, and that half spaces know no deformable
# bodies.
logging.getLogger("drake").setLevel(logging.ERROR)


# Of the rod, m/s; of the simulation, s. Then of the contacts, N/m; Hunt and Crossley's, s/m; the
# speed (m/s) below which friction fades.
SPEED, STEP = 0.005343, 0.06922
FLOOR_STIFFNESS, ROD_STIFFNESS, DISSIPATION, STICTION = 5.318e4, 9.061e5, 45.63, 7.967e-7
# `sap` pushes a contact that slides open, so that the load shifts between the feet and the object
# ends tens of mm off.
SOLVER = "tamsi"


class DrakePush:
    """One plant, built once, in which pushes are run; raises AssertionError for friction that has
    directions.
    """

    def __init__(self, problem: PushProblem, step: float = STEP) -> None:
        assert (
            problem.friction.mu_a == problem.friction.mu_b
            and problem.friction.m0 == problem.friction.n0 == 0.0
        )
        self.problem, self.step = problem, step
        builder = drake.DiagramBuilder()
        self.plant = _plant(builder, problem, step)
        self.simulator = drake.Simulator(builder.Build())
        self._context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        # The height at which the plate rests, m, the rod out of its way.
        self._rest = 0.0
        self._place(Pose(), (10.0, 0.0), np.zeros(2))
        self.simulator.AdvanceTo(_SETTLE)
        self._rest = float(self.plant.GetPositions(self._context)[2])

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops."""
        place, direction = self.problem.rod_path(pose, push)
        steps = round(push.distance / SPEED / self.step)
        self._place(pose, place, np.multiply(direction, push.distance / (steps * self.step)))
        self.simulator.AdvanceTo((steps - 0.5) * self.step)  # the first step is taken at once
        x, y, _, theta = self.plant.GetPositions(self._context)[:4].tolist()
        return Pose(x, y, theta)

    def _place(self, pose: Pose, rod: tuple[float, float], velocity: np.ndarray) -> None:
        self.simulator.get_mutable_context().SetTime(0.0)
        self.plant.SetPositions(self._context, [pose.x, pose.y, self._rest, pose.theta, *rod])
        self.plant.SetVelocities(self._context, [0.0, 0.0, 0.0, 0.0, *velocity])
        self.simulator.Initialize()


def _plant(
    builder: drake.DiagramBuilder, problem: PushProblem, step: float
) -> drake.MultibodyPlant:
    """Plate and rod above the floor; what does not take part in the push is kept from touching."""
    config = drake.MultibodyPlantConfig(
        time_step=step,
        contact_model="point",
        discrete_contact_approximation=SOLVER,
        stiction_tolerance=STICTION,
    )
    plant, scene = drake.AddMultibodyPlant(config, builder)
    plate, rod = _bodies(plant, problem)
    points, _ = problem.footprint.quadrature
    floor_touch = _properties(FLOOR_STIFFNESS, problem.friction.mu_a)
    rod_touch = _properties(ROD_STIFFNESS, problem.pusher.friction)
    half = float(np.abs(points).max())
    register, middle = plant.RegisterCollisionGeometry, drake.RigidTransform()
    floor = register(plant.world_body(), middle, drake.HalfSpace(), "floor", floor_touch)
    feet = [
        register(
            plate, drake.RigidTransform([x, y, _FOOT]), drake.Sphere(_FOOT), f"foot{i}", floor_touch
        )
        for i, (x, y) in enumerate(points.tolist())
    ]
    box = register(plate, middle, drake.Box(2 * half, 2 * half, 2 * half), "box", rod_touch)
    tip = register(rod, middle, drake.Sphere(problem.pusher.radius), "rod", rod_touch)
    apart = drake.CollisionFilterDeclaration()
    apart.ExcludeBetween(drake.GeometrySet([floor, *feet]), drake.GeometrySet([tip]))
    apart.ExcludeBetween(drake.GeometrySet([floor]), drake.GeometrySet([box]))
    scene.collision_filter_manager().Apply(apart)
    plant.Finalize()
    return plant


def _bodies(
    plant: drake.MultibodyPlant, problem: PushProblem
) -> tuple[drake.RigidBody, drake.RigidBody]:
    """Plate (along x, y, z, and turning about z) and rod (along x, y); what carries them in between
    weighs nothing.
    """
    inertia, mass = problem.slider.inertia, problem.slider.mass
    assert inertia is not None
    gyration = inertia / mass
    plate = plant.AddRigidBody(
        "plate",
        drake.SpatialInertia(
            mass, np.zeros(3), drake.UnitInertia(gyration / 2.0, gyration / 2.0, gyration)
        ),
    )
    rod = plant.AddRigidBody(
        "rod", drake.SpatialInertia(_ROD_MASS, np.zeros(3), drake.UnitInertia.SolidSphere(0.01))
    )
    carried = _carried(plant, "plate", 3)
    plant.AddJoint(
        drake.RevoluteJoint("plate_turn", carried.body_frame(), plate.body_frame(), [0.0, 0.0, 1.0])
    )
    between = _carried(plant, "rod", 1)
    plant.AddJoint(
        drake.PrismaticJoint("rod_y", between.body_frame(), rod.body_frame(), [0.0, 1.0, 0.0])
    )
    return plate, rod


def _carried(plant: drake.MultibodyPlant, name: str, axes: int) -> drake.RigidBody:
    """The last of so many weightless bodies that slide on each other along x, y, z."""
    last = plant.world_body()
    for axis in np.eye(3)[:axes]:
        label = f"{name}_{'xyz'[int(axis.argmax())]}"
        body = plant.AddRigidBody(label, drake.SpatialInertia.Zero())
        plant.AddJoint(drake.PrismaticJoint(label, last.body_frame(), body.body_frame(), axis))
        last = body
    return last


def _properties(stiffness: float, friction: float) -> drake.ProximityProperties:
    properties = drake.ProximityProperties()
    drake.AddContactMaterial(
        dissipation=DISSIPATION,
        point_stiffness=2.0 * stiffness,
        friction=drake.CoulombFriction(friction, friction),
        properties=properties,
    )
    return properties


def drake_push(problem: PushProblem, finer: bool = False) -> EndPose:
    """The push as it is timed; finer with an eighth of the step."""
    return DrakePush(problem, STEP / 8.0 if finer else STEP).end_pose


SIMULATOR = Simulator("Drake", version("drake"), drake_push, (CORNERS,))
