"""The push in Drake: a plate on four small spheres, pushed by a heavy rod that keeps its speed."""

import logging
from dataclasses import dataclass, replace
from importlib.metadata import version

import numpy as np
from pydrake.all import (
    AddContactMaterial,
    AddMultibodyPlant,
    Box,
    CollisionFilterDeclaration,
    CoulombFriction,
    DiagramBuilder,
    GeometrySet,
    HalfSpace,
    MultibodyPlant,
    MultibodyPlantConfig,
    PrismaticJoint,
    ProximityProperties,
    RevoluteJoint,
    RigidBody,
    RigidTransform,
    SpatialInertia,
    Sphere,
    UnitInertia,
)
from pydrake.all import Simulator as DrakeSimulator

from cyclemap.mechanics import Pose, SidePush
from tests.benchmarks.peers.push_problem import CORNERS, PushProblem, Simulator

# The rod's mass, kg: so much that pushing does not slow it, and no controller has to be called at every step.
_ROD_MASS = 1e8
_FOOT = 0.002
_SETTLE = 0.5
# It tells at every start that TAMSI will go one day, and that half spaces know no deformable bodies.
logging.getLogger("drake").setLevel(logging.ERROR)


@dataclass(frozen=True)
class DrakeSettings:
    """What the accuracy and the time of a push hang on.

    speed : of the rod, m/s. step : s. floor_stiffness, rod_stiffness : of the contacts, N/m. dissipation : Hunt and
    Crossley's, s/m. stiction : speed (m/s) below which friction fades. solver : `tamsi`, `lagged` or `similar`; `sap`
    pushes a contact that slides open, so that the load shifts between the feet and the object ends tens of mm off.
    """

    speed: float
    step: float
    floor_stiffness: float
    rod_stiffness: float
    dissipation: float
    stiction: float
    solver: str = "tamsi"


class DrakePush:
    """One plant, built once, in which pushes are run; raises AssertionError for friction that has directions."""

    def __init__(self, problem: PushProblem, settings: DrakeSettings) -> None:
        assert problem.friction.mu_a == problem.friction.mu_b and problem.friction.m0 == problem.friction.n0 == 0.0
        self.problem, self.settings = problem, settings
        builder = DiagramBuilder()
        self.plant = _plant(builder, problem, settings)
        self.simulator = DrakeSimulator(builder.Build())
        self._context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self._rest = 0.0
        self._rest = self._settled()

    def end_pose(self, pose: Pose, push: SidePush) -> Pose:
        """The object's pose when the rod stops."""
        place, direction = self.problem.rod_path(pose, push)
        steps, step = self.steps(push), self.settings.step
        self._place(pose, place, np.multiply(direction, push.distance / (steps * step)))
        self.simulator.AdvanceTo((steps - 0.5) * step)  # the first step is taken at once
        x, y, _, theta = self.plant.GetPositions(self._context)[:4].tolist()
        return Pose(x, y, theta)

    def steps(self, push: SidePush) -> int:
        """How many steps a push takes."""
        return round(push.distance / self.settings.speed / self.settings.step)

    def _place(self, pose: Pose, rod: tuple[float, float], velocity: np.ndarray) -> None:
        self.simulator.get_mutable_context().SetTime(0.0)
        self.plant.SetPositions(self._context, [pose.x, pose.y, self._rest, pose.theta, *rod])
        self.plant.SetVelocities(self._context, [0.0, 0.0, 0.0, 0.0, *velocity])
        self.simulator.Initialize()

    def _settled(self) -> float:
        """Height at which the plate rests, m, the rod out of its way."""
        self._place(Pose(), (10.0, 0.0), np.zeros(2))
        self.simulator.AdvanceTo(_SETTLE)
        return float(self.plant.GetPositions(self._context)[2])


def _plant(builder: DiagramBuilder, problem: PushProblem, settings: DrakeSettings) -> MultibodyPlant:
    """Plate and rod above the floor; what does not take part in the push is kept from touching."""
    config = MultibodyPlantConfig(
        time_step=settings.step,
        contact_model="point",
        discrete_contact_approximation=settings.solver,
        stiction_tolerance=settings.stiction,
    )
    plant, scene = AddMultibodyPlant(config, builder)
    plate, rod = _bodies(plant, problem)
    points, _ = problem.footprint.quadrature
    floor_touch, rod_touch = (
        _properties(settings, settings.floor_stiffness, problem.friction.mu_a),
        _properties(settings, settings.rod_stiffness, problem.pusher.friction),
    )
    half = float(np.abs(points).max())
    floor = plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", floor_touch)
    feet = [
        plant.RegisterCollisionGeometry(plate, RigidTransform([x, y, _FOOT]), Sphere(_FOOT), f"foot{i}", floor_touch)
        for i, (x, y) in enumerate(points.tolist())
    ]
    box = plant.RegisterCollisionGeometry(plate, RigidTransform(), Box(2 * half, 2 * half, 2 * half), "box", rod_touch)
    tip = plant.RegisterCollisionGeometry(rod, RigidTransform(), Sphere(problem.pusher.radius), "rod", rod_touch)
    apart = CollisionFilterDeclaration()
    apart.ExcludeBetween(GeometrySet([floor, *feet]), GeometrySet([tip]))
    apart.ExcludeBetween(GeometrySet([floor]), GeometrySet([box]))
    scene.collision_filter_manager().Apply(apart)
    plant.Finalize()
    return plant


def _bodies(plant: MultibodyPlant, problem: PushProblem) -> tuple[RigidBody, RigidBody]:
    """Plate (along x, y, z, and turning about z) and rod (along x, y); what carries them in between weighs nothing."""
    inertia, mass = problem.slider.inertia, problem.slider.mass
    assert inertia is not None
    gyration = inertia / mass
    plate = plant.AddRigidBody(
        "plate", SpatialInertia(mass, np.zeros(3), UnitInertia(gyration / 2.0, gyration / 2.0, gyration))
    )
    rod = plant.AddRigidBody("rod", SpatialInertia(_ROD_MASS, np.zeros(3), UnitInertia.SolidSphere(0.01)))
    carried = _carried(plant, "plate", 3)
    plant.AddJoint(RevoluteJoint("plate_turn", carried.body_frame(), plate.body_frame(), [0.0, 0.0, 1.0]))
    between = _carried(plant, "rod", 1)
    plant.AddJoint(PrismaticJoint("rod_y", between.body_frame(), rod.body_frame(), [0.0, 1.0, 0.0]))
    return plate, rod


def _carried(plant: MultibodyPlant, name: str, axes: int) -> RigidBody:
    """The last of so many weightless bodies that slide on each other along x, y, z."""
    last = plant.world_body()
    for axis in np.eye(3)[:axes]:
        label = f"{name}_{'xyz'[int(axis.argmax())]}"
        body = plant.AddRigidBody(label, SpatialInertia.Zero())
        plant.AddJoint(PrismaticJoint(label, last.body_frame(), body.body_frame(), axis))
        last = body
    return last


def _properties(settings: DrakeSettings, stiffness: float, friction: float) -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=settings.dissipation,
        point_stiffness=2.0 * stiffness,
        friction=CoulombFriction(friction, friction),
        properties=properties,
    )
    return properties


SIMULATOR = Simulator(
    "Drake",
    version("drake"),
    DrakePush,
    chosen={
        # The best of searches by `python -m tests.benchmarks.peers.settings drake`, 3 to 5 minutes from several seeds.
        CORNERS: DrakeSettings(
            speed=0.005343,
            step=0.06922,
            floor_stiffness=5.318e4,
            rod_stiffness=9.061e5,
            dissipation=45.63,
            stiction=7.967e-7,
        )
    },
    finer=lambda settings: replace(settings, step=settings.step / 8.0),
    searched={
        "speed": (0.003, 0.3),
        "step": (3e-4, 0.1),
        "floor_stiffness": (10.0, 1e7),
        "rod_stiffness": (1e3, 1e8),
        "dissipation": (0.1, 1e4),
        "stiction": (1e-8, 1e-3),
    },
)
