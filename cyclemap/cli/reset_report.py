"""A designed reset as JSON: millimetres, degrees and seconds, every number finite or null."""

from __future__ import annotations

from pathlib import Path

from cyclemap.cli.json_numbers import degrees, number
from cyclemap.cli.json_report import Json
from cyclemap.mechanics import SidePush
from cyclemap.resets.design.push_proof import PushProof
from cyclemap.resets.design.reset_demands import LENGTHS, ResetDemands
from cyclemap.resets.design.reset_design import ResetDesign
from cyclemap.resets.design.reset_ranking import DemandOutlook, ScoredReset
from cyclemap.resets.design.reset_trial import ResetTrial, SampledStatistic
from cyclemap.resets.strategies.combined import Combined
from cyclemap.resets.strategies.push_strategies import PushChoice
from cyclemap.views import reset_sentences as sentences


def reset_report(design: ResetDesign, trial: ResetTrial | None, protocol: Path, schedule: Path) -> Json:
    """The report of `cyclemap reset`; with a trial it has one entry more, "trial"."""
    report: Json = {
        "material": design.loop.material.name,
        "noise_deg": degrees(getattr(design.noise, "sigma", None)),
        "demands": _demands(design.demands, design.keep_push),
        "met": design.met,
        "certified": design.certified,
        "chosen": {**_strategy(design.chosen), "pushes": _pushes(design)},
        "own": _strategy(design.own),
        "proof": None if design.proof is None else _proof(design.proof),
        "reasons": [] if design.met else list(sentences.reason_sentences(design)),
        "binding": [_outlook(one) for one in design.binding],
        "outlooks": [_outlook(one) for one in design.outlooks],
        "ranking": [_strategy(one) for one in design.ranking],
        "left_out": [{"name": one.name, "reason": one.reason} for one in design.left_out],
        "protocol": str(protocol),
        "schedule": str(schedule),
    }
    return report if trial is None else {**report, "trial": _trial(trial)}


def predicted_scores(one: ScoredReset) -> dict[str, float | bool]:
    """The scores that a protocol file carries along."""
    return {key: value for key, value in _scores(one).items() if isinstance(value, float | bool)}


def _demands(demands: ResetDemands, keep_push: bool) -> Json:
    return {
        "allow_tv": demands.allow_tv,
        "extra_tv": demands.extra_tv,
        "within": demands.within,
        "drag_ratio": demands.drag_ratio,
        "reach_mm": None if demands.reach is None else 1000 * demands.reach,
        "seconds": demands.seconds,
        "least_push_mm": None if demands.contact is None else 1000 * demands.contact,
        "abilities": list(demands.abilities),
        "keep_push": keep_push,
    }


def _strategy(one: ScoredReset) -> Json:
    return {
        "name": one.name,
        "kind": one.candidate.strategy.name,
        "meets": one.meets,
        **_scores(one),
        "misses": [
            {
                "demand": miss.demand,
                **_amount(miss.demand, "value", miss.value),
                **_amount(miss.demand, "limit", miss.limit),
            }
            for miss in one.misses
        ],
        "needs": list(one.candidate.strategy.needs),
        "lacking": list(one.lacking),
    }


def _scores(one: ScoredReset) -> Json:
    found, cost = one.numbers, one.cost
    return {
        "tv": number(found.tv),
        "tv_error": number(found.tv.error_bound) if found.bounded else None,
        "tv_after": number(found.tv_after),
        "tv_after_error": number(found.tv_after.error_bound) if found.bounded else None,
        "within": found.within,
        "reach_pushes": number(found.reach),
        "effective_per_100": number(found.effective_per_100),
        "certified": one.certain,
        "mean_drag_mm": number(1000 * cost.mean_drag_length),
        "longest_drag_mm": number(1000 * cost.longest_drag),
        "drag_ratio": number(one.drag_ratio),
        "mean_seconds": number(cost.mean_seconds),
        "reach_mm": number(1000 * cost.reach),
        "shortest_contact_mm": number(1000 * one.contact),
    }


def _pushes(design: ResetDesign) -> list[Json]:
    strategy = design.chosen.candidate.strategy
    parts = strategy.parts if isinstance(strategy, Combined) else (strategy,)
    choices = [part for part in parts if isinstance(part, PushChoice)]
    return [
        {**_push(push), "contact_mm": 1000 * design.cache.contact(push), "chance": chance}
        for choice in choices
        for push, chance in zip(choice.pushes, choice.chances.tolist(), strict=True)
    ]


def _push(push: SidePush) -> Json:
    return {
        "side": push.side,
        "fraction": push.fraction,
        "angle_deg": degrees(push.angle),
        "push_mm": 1000 * push.distance,
    }


def _proof(proof: PushProof) -> Json:
    return {
        "pushes": [_push(push) for push in proof.pushes],
        "demand": proof.demand,
        **_amount(proof.demand, "lower", proof.lower),
        **_amount(proof.demand, "limit", proof.limit),
    }


def _outlook(one: DemandOutlook) -> Json:
    other = one.with_others_by
    return {
        "demand": one.demand,
        **_amount(one.demand, "limit", one.limit),
        **_amount(one.demand, "least", one.least),
        "least_by": one.least_by.name,
        **_amount(one.demand, "least_with_others", one.least_with_others),
        "with_others_by": None if other is None else other.name,
    }


def _amount(demand: str, name: str, value: float | None) -> Json:
    """A value of a demand under its name, with the unit it is told in."""
    if demand in LENGTHS:
        return {f"{name}_mm": None if value is None else 1000 * value}
    return {name: value}


def _trial(trial: ResetTrial) -> Json:
    return {
        "pushes": trial.pushes,
        "seed": trial.run.seed,
        "bins": trial.bins,
        "agrees": trial.agrees,
        "total_variation": _statistic(trial.total_variation),
        "kuiper": _statistic(trial.kuiper),
        "distance_from_prediction": _statistic(trial.misfit),
    }


def _statistic(found: SampledStatistic) -> Json:
    return {
        "value": found.value,
        "predicted_mean": found.mean,
        "predicted_95": [found.low, found.high],
        "p_value": found.p_value,
    }
