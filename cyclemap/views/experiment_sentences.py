"""The numerical experiment in sentences: where the batches end and after how many cycles, and how far paths spread."""

from cyclemap.collection.batch_experiment import BatchExperiment, BatchRun
from cyclemap.views.sentences import angle


def experiment_headline(experiment: BatchExperiment) -> str:
    """Where the batches end on the material, and how soon."""
    return _ends(experiment.anisotropic, experiment.cycles)


def isotropic_sentence(experiment: BatchExperiment) -> str:
    """What the batches do on the isotropic twin, and that they follow one path in the object's frame."""
    run = experiment.isotropic
    turns = run.theta[:, 1:] - run.theta[:, :-1]
    turned = f"every cycle turns the object by {angle(float(turns.mean()), 2)}, whatever θ0"
    return f"On isotropic friction of the same mean coefficient {turned}: {_path_clause(run)}."


def spread_sentence(experiment: BatchExperiment) -> str:
    """How far the paths on the material spread in the object's frame."""
    return f"On {experiment.loop.material.name} {_path_clause(experiment.anisotropic)}."


def method_line(experiment: BatchExperiment) -> str:
    """How the experiment was run."""
    batches = len(experiment.starts)
    total = f"{batches * experiment.cycles} cycles: {batches} batches of {experiment.cycles}"
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
        moved = angle(float(run.last_step.max()), 2)
        return f"{'The batch' if count == 1 else 'Not every batch'} comes to rest in {cycles} cycles: the last cycle " \
               f"still turns it by up to {moved}."  # fmt: skip
    most = int(run.settled_after().max())
    soon = f"within 1° of it for good after at most {most} cycle{'s' * (most != 1)}"
    if len(directions) == 1:
        return f"{who} at {angle(directions[0])}, {soon}."
    places = ", ".join(angle(direction) for direction in directions)
    return f"The {count} batches end at {len(directions)} directions ({places}), {soon.replace('of it', 'of them')}."


def _path_clause(run: BatchRun) -> str:
    paths = run.theta[:, 1:].size
    if run.spread < 1e-4:
        return f"seen in the object's frame all {paths} paths are one (none is further than {length(run.spread)} off)"
    return f"seen in the object's frame the {paths} paths spread by up to {length(run.spread)} about their mean"
