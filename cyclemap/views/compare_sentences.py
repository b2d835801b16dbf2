"""A comparison in sentences: how many questions agree, what was compared, and every verdict."""

from collections.abc import Sequence

from cyclemap.evidence.comparison.compare import Comparison
from cyclemap.evidence.comparison.push_agreement import mean_distances
from cyclemap.evidence.comparison.verdicts import Verdict
from cyclemap.views.sentences import angle

# A lag correlation beyond this makes p-values of independent noise too small.
CORRELATED = 0.2
ISOTROPIC = "isotropic friction under even pressure"


def headline(name: str, found: Comparison) -> str:
    """How many of the questions that could be answered agree."""
    answered = [one for one in found.verdicts if one.agrees is not None]
    kept = sum(one.agrees is True for one in answered)
    if not answered:
        return f"{name} beside the data"
    return f"{name} agrees with the data in {kept} of {len(answered)} questions"


def data_sentence(found: Comparison) -> str:
    """What was compared, and what was left out."""
    pushes = sum(one.count for one in found.pushes)
    cycles = 0 if found.data.pairs is None else found.data.pairs.theta.size
    used = [f"{pushes} push{'es' * (pushes > 1)} with end poses"] * bool(pushes) + [f"{cycles} cycles"] * bool(cycles)
    out = [f"{count} ({reason})" for reason, count in found.data.left_out.items() if count]
    files = [f"{found.data.unreadable} unreadable files"] * bool(found.data.unreadable)
    left = f"; left out: {', '.join(out + files)}" if out or files else ""
    return f"Compared: {' and '.join(used)}{left}."


def trust_sentences(found: Comparison) -> list[str]:
    """What to know before the p-values are believed."""
    told = [f"Not certified: {one}." for one in found.uncertified]
    if found.refitted:
        told.append("The prediction was fitted to these data: it was fitted again on every simulated collection.")
    correlation = 0.0 if found.cycle is None else found.cycle.lag_correlation or 0.0
    if found.orientations is not None and abs(correlation) > CORRELATED:
        told.append(
            f"What a measured cycle differs from the best smooth map by goes with the next one's (correlation "
            f"{correlation:.2f}): the surface wears or is disturbed slowly, the simulated noise is not."
        )
    return told


def summary_sentence(found: Comparison) -> str:
    """The questions by their answer, in a line or two."""
    groups = {"Agree": True, "Do not agree": False, "Open": None}
    listed = {word: _listed(found.verdicts, answer) for word, answer in groups.items()}
    return " ".join(f"{word}: {questions}." for word, questions in listed.items() if questions)


def noise_words(found: Comparison) -> str:
    """What is simulated."""
    model = {"loop": "mechanics", "map": "map", "drifting map": "map that wears"}.get(found.prediction.kind, "fit")
    if found.cycle is None:
        return f"predicted by the {model}"
    return f"predicted by the {model} with {angle(found.cycle.noise)} of noise a cycle"


def _listed(verdicts: Sequence[Verdict], answer: bool | None) -> str:
    return ", ".join(one.question for one in verdicts if one.agrees is answer)


def explanation_sentences(name: str, found: Comparison) -> list[str]:
    """What the turns of the measured cycles are explained by, and which of the explanations leaves least."""
    said = []
    if found.pushes:
        sides = zip((name, ISOTROPIC), mean_distances(found.pushes), strict=True)
        by_place = sorted(sides, key=lambda side: side[1])
        told = ", ".join(f"{1e3 * place:.1f} mm and {angle(turn)} by {one}" for one, (place, turn) in by_place)
        said.append(f"Of {sum(one.count for one in found.pushes)} pushes there is left on average: {told}.")
    if found.cycle is None:
        return said
    cycle = found.cycle
    left = {name: cycle.agreement.rms, "one turn for all orientations": cycle.blind_rms}
    if cycle.isotropic_rms is not None:
        left[ISOTROPIC] = cycle.isotropic_rms
    told = ", ".join(f"{angle(rms)} by {one}" for one, rms in sorted(left.items(), key=lambda pair: pair[1]))
    fitted = "" if cycle.scatter is None else f"; the best smooth map, fitted to these, {angle(cycle.scatter)}"
    return [*said, f"Of the turns of {cycle.agreement.pairs} cycles there is left as root mean square {told}{fitted}."]
