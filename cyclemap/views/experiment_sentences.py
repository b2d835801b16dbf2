"""The numerical experiment in sentences: where the batches end and after how many cycles, and how far paths spread."""

from cyclemap.collection.batch_experiment import WITHIN, BatchExperiment, BatchRun
from cyclemap.views.sentences import angle


def experiment_headline(experiment: BatchExperiment) -> str:
    """Where the batches end on the material, and how soon."""
    return _ends(experiment.anisotropic, experiment.cycles)


def isotropic_sentence(experiment: BatchExperiment) -> str:
    """What the batches do on the isotropic twin, and that they follow one path in the object's frame."""
    run = experiment.isotropic
    turns = run.theta[:, 1:] - run.theta[:, :-1]
    turned = f"turns the object by {angle(float(turns.mean()), 2)}"
    surface = "On isotropic friction of the same mean coefficient"
    if turns.size == 1:
        return f"{surface} the cycle {turned}."
    return f"{surface} every cycle {turned}, whatever θ0: {_path_clause(run)}."


def spread_sentence(experiment: BatchExperiment) -> str:
    """How far the paths on the material spread in the object's frame."""
    if experiment.anisotropic.theta[:, 1:].size == 1:
        return f"On {experiment.loop.material.name} there is one path, and none to compare it with."
    return f"On {experiment.loop.material.name} {_path_clause(experiment.anisotropic)}."


def method_line(experiment: BatchExperiment) -> str:
    """How the experiment was run."""
    batches = len(experiment.starts)
    total = f"{_count(batches * experiment.cycles, 'cycle')}: {_count(batches, 'batch', 'es')} of {experiment.cycles}"
    if experiment.speed is None:
        return f"quasi-static cycles; {total}"
    return f"dynamic simulation at {1e3 * experiment.speed:g} mm/s; {total}"


def length(metres: float) -> str:
    """A small length for people, in mm or µm; a nanometre where it is less.

    >>> length(0.0123), length(4.2e-7), length(3e-12)
    ('12.3 mm', '0.42 µm', '0.001 µm')
    """
    return f"{1e3 * metres:.1f} mm" if metres >= 1e-4 else f"{max(1e6 * metres, 1e-3):.2g} µm"


def _ends(run: BatchRun, cycles: int) -> str:
    count, directions = len(run.theta), run.directions()
    who = "The batch ends" if count == 1 else f"All {count} batches end"
    if not directions:
        return _moving(run, cycles)
    most = int(run.settled_after().max())
    at_most = "" if count == 1 else "at most "
    soon = f"within 1° of it for good after {at_most}{_count(most, 'cycle')}"
    if len(directions) == 1:
        return f"{who} at {angle(directions[0])}, {soon}."
    places = ", ".join(angle(direction) for direction in directions)
    return f"The {count} batches end at {len(directions)} directions ({places}), {soon.replace('of it', 'of them')}."


def _moving(run: BatchRun, cycles: int) -> str:
    """Batches that end nowhere; of small steps also why they are no rest."""
    step = float(run.last_step.max())
    slow = ", and such steps do not soon die out" if step <= 0.1 * WITHIN else ""
    turned = f"{angle(step, 2)}{slow}."
    if len(run.theta) == 1:
        return (
            f"The batch does not come to rest in {_count(cycles, 'cycle')}: the last cycle still turns it by {turned}"
        )
    return f"Not every batch comes to rest in {_count(cycles, 'cycle')}: the last cycle still turns one by {turned}"


def _count(number: int, noun: str, plural: str = "s") -> str:
    return f"{number} {noun}{plural * (number != 1)}"


def _path_clause(run: BatchRun) -> str:
    paths = run.theta[:, 1:].size
    if run.spread < 1e-4:
        return f"seen in the object's frame all {paths} paths are one (none is further than {length(run.spread)} off)"
    return f"seen in the object's frame the {paths} paths spread by up to {length(run.spread)} about their mean"
