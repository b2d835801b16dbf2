"""The simulators that take part, and why others do not."""

from importlib import import_module

from tests.benchmarks.peers import package_push, plain_push
from tests.benchmarks.peers.push_problem import Simulator

# Modules of the engines that have to be installed for this: pip install cyclemap[peers].
_ENGINES = {"mujoco": "tests.benchmarks.peers.mujoco_push", "drake": "tests.benchmarks.peers.drake_push"}


def engine(name: str) -> Simulator | str:
    """The simulator of a physics engine, `mujoco` or `drake`; where it is not installed, the reason in words."""
    try:
        module = import_module(_ENGINES[name])
    except ModuleNotFoundError as missing:
        return f"{name} takes no part: {missing}; install the extra `peers`"
    found: Simulator = module.SIMULATOR
    return found


def simulators() -> dict[str, Simulator | str]:
    """All simulators by the names that the search knows them by, this package's engine first."""
    return {
        "cyclemap": package_push.ENGINE,
        **{name: engine(name) for name in _ENGINES},
        "dynamic": package_push.DYNAMIC,
        "scipy": plain_push.SCIPY,
        "numpy": plain_push.NUMPY,
    }
