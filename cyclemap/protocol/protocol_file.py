"""A data collection as a TOML protocol file: the settings of its loop, its strategy, and what was
predicted of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from pathlib import Path

from cyclemap.checks import positive_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput, located, unknown_name
from cyclemap.mechanics import SidePush
from cyclemap.protocol.collection_file import PREDICTED, STRATEGY, collection_tables, read_settings
from cyclemap.protocol.settings import SETTINGS, Settings
from cyclemap.protocol.strategy import ORDERS, RANDOM, CycleAction, ResetStrategy
from cyclemap.text_files import read_toml, write_whole
from cyclemap.written import (
    DEGREES,
    MILLIMETRES,
    NUMBER,
    FileUnit,
    toml_text,
    with_checksum,
)

Prediction = Mapping[str, object]

_COMMENTS = (
    "Protocol of a data collection: how the robot pushes the object and drags it back, cycle "
    "after cycle.",
    "Lengths in mm; angles in degrees, counter-clockwise; way-points and directions from the "
    "target.",
    "In Python: cyclemap.read_protocol(FILE). Commands take it as: cyclemap portrait MATERIAL "
    "--protocol FILE",
)


def write_protocol(
    path: str | Path,
    loop: CollectionLoop,
    strategy: ResetStrategy | None,
    *,
    noise: float | None = None,
    predicted: Prediction | None = None,
) -> None:
    """Write the protocol of a collection as TOML; whole, or not at all.

    Parameters
    ----------
    path : str or Path
        The file to write.
    loop : CollectionLoop
        The loop; its surface is named in a comment only.
    strategy : ResetStrategy or None
        What the robot does, in a table [strategy], from which `read_protocol` makes the equal
        one; None: no strategy.
    noise : float or None, optional
        Of one cycle, standard deviation in rad.
    predicted : mapping or None, optional
        Scores by name (numbers, texts, booleans, lists of them; None is left out), a table that
        readers pass over.

    Raises
    ------
    InvalidInput
        For a loop that settings cannot say.
    OSError
        Where the file cannot be written.

    Notes
    -----
    The file holds the robot's side of the loop as --set keys, and the strategy. Its first line is a
    checksum of the rest.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop, SidePush, read_protocol, write_protocol
    >>> from cyclemap.resets import ResetStrategy
    >>> coin = ResetStrategy.pushes(SidePush(), (1, 2))
    >>> with tempfile.TemporaryDirectory() as place:
    ...     write_protocol(f"{place}/coin.toml", CollectionLoop.mit(), coin, predicted={"tv": 0.04})
    ...     settings, strategy = read_protocol(f"{place}/coin.toml")
    >>> strategy == coin, settings["push_mm"]
    (True, 150)
    """
    write_whole(
        Path(path), protocol_text(loop, strategy, noise=noise, predicted=predicted).encode()
    )


def protocol_text(
    loop: CollectionLoop,
    strategy: ResetStrategy | None,
    *,
    noise: float | None = None,
    predicted: Prediction | None = None,
) -> str:
    """Return the text that `write_protocol` writes."""
    tables = collection_tables(loop, noise)
    x, y = (1e3 * coordinate for coordinate in loop.slider.hitch)
    comments = [
        *_COMMENTS,
        f"Written for {loop.material.name}, with the ring at ({x:.4f}, {y:.4f}) mm of the object.",
    ]
    if strategy is not None:
        tables[STRATEGY] = _strategy_table(strategy)
        needs = f"; needs: {', '.join(strategy.needs)}" if strategy.needs else ""
        comments.append(f"{len(strategy.actions)} actions, {strategy.order}{needs}")
    if predicted is not None:
        _check_prediction(predicted)
        tables[PREDICTED] = {key: value for key, value in predicted.items() if value is not None}
    return with_checksum(toml_text(tables, tuple(comments)))


def read_protocol(path: str | Path) -> tuple[Settings, ResetStrategy | None]:
    """Return the settings of a protocol file and its strategy.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    settings : mapping
        By the keys of `--set`, in the file's units, for `loop_from_settings`; `noise_deg` among
        them.
    strategy : ResetStrategy or None
        None where the file has no table [strategy].

    Raises
    ------
    DataFileError
        Naming file, key and value, where the file is none of settings, or holds no strategy.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap import CollectionLoop, read_protocol, write_protocol
    >>> with tempfile.TemporaryDirectory() as place:
    ...     write_protocol(f"{place}/mit.toml", CollectionLoop.mit(), None)
    ...     settings, strategy = read_protocol(f"{place}/mit.toml")
    >>> settings["fraction"], strategy is None
    (0.7, True)
    """
    settings = read_settings(path)
    # Decimals, so that no number is rounded before its unit is known.
    tables = read_toml(path, Decimal)
    with located(str(path), DataFileError):
        _check_prediction(tables.get(PREDICTED, {}))
        strategy = _strategy(tables[STRATEGY]) if STRATEGY in tables else None
    return settings, strategy


def _check_prediction(table: object) -> None:
    if not isinstance(table, Mapping):
        raise InvalidInput(f"{PREDICTED} must be a table of scores, not {table!r}")
    for key, value in table.items():
        if not isinstance(key, str):
            raise InvalidInput(f"[{PREDICTED}] names its scores by texts, not {key!r}")
        entries = value if isinstance(value, list) else [value]
        if value is not None and not all(
            isinstance(entry, (bool, int, float, Decimal, str)) for entry in entries
        ):
            raise InvalidInput(
                f"[{PREDICTED}] {key} must be a number, text or list of them, not {value!r}"
            )


PUSH_UNITS = {key: SETTINGS[key].unit for key in ("fraction", "angle_deg", "push_mm")}
_PUSH_KEYS = ("side", *PUSH_UNITS)
ACTION_KEYS = ("weight", *_PUSH_KEYS, "way_points_mm", "gripper_turn_deg")
STRATEGY_KEYS = ("order", "block", "hitch_mm", "actions")


def push_numbers(push: SidePush) -> dict[str, Decimal]:
    """Where, in which direction and how far a push goes, as files have it."""
    values = zip(PUSH_UNITS.items(), (push.fraction, push.angle, push.distance), strict=True)
    return {key: unit.written(value) for (key, unit), value in values}


def _strategy_table(strategy: ResetStrategy) -> dict[str, object]:
    table: dict[str, object] = {"order": strategy.order}
    if strategy.block is not None:
        table["block"] = strategy.block
    if strategy.hitch is not None:
        table["hitch_mm"] = [MILLIMETRES.written(coordinate) for coordinate in strategy.hitch]
    actions = []
    for index, action in enumerate(strategy.actions):
        row = dict[str, object]()
        if strategy.weights is not None:
            row["weight"] = NUMBER.written(strategy.weights[index])
        if action.push is not None:
            row |= {"side": action.push.side, **push_numbers(action.push)}
        if action.way_points is not None:
            row["way_points_mm"] = [
                [MILLIMETRES.written(coordinate) for coordinate in place]
                for place in action.way_points
            ]
        if action.turn or not row:
            row["gripper_turn_deg"] = DEGREES.written(action.turn)
        actions.append(row)
    return {**table, "actions": actions}


def _strategy(table: object) -> ResetStrategy:
    """The strategy of a table [strategy]; InvalidInput that names the place,
    the key and its value."""
    with located("[strategy]"):
        if isinstance(table, Mapping) and "kind" in table:
            raise InvalidInput(
                f"kind = {table['kind']!r} is how earlier versions said it: give order, one of "
                f"{', '.join(ORDERS)}, and a table [[strategy.actions]] for each push, drag or "
                "gripper's turn"
            )
        given = _checked(table, STRATEGY_KEYS, ("actions",))
        rows = given["actions"]
        if not isinstance(rows, list) or not rows:
            raise InvalidInput("actions must be one or more tables [[strategy.actions]]")
        block = None if "block" not in given else whole_number("block", given["block"], least=1)
        hitch = None if "hitch_mm" not in given else _point("hitch_mm", given["hitch_mm"])
    actions = []
    weights = []
    for place, row in enumerate(rows, 1):
        with located(f"[[strategy.actions]] {place}"):
            action, weight = _action(row)
            actions.append(action)
            weights.append(weight)
    given_weights = [weight for weight in weights if weight is not None]
    with located("[strategy]"):
        if len(given_weights) not in (0, len(weights)):
            raise InvalidInput(
                f"{len(given_weights)} of {len(weights)} actions have a weight: give all of them "
                "one, or none"
            )
        return ResetStrategy(
            tuple(actions),
            tuple(given_weights) or None,
            str(given.get("order", RANDOM)),
            block,
            hitch,
        )


def _action(row: object) -> tuple[CycleAction, float | None]:
    given = _checked(row, ACTION_KEYS, ())
    if not given or set(given) == {"weight"}:
        raise InvalidInput(
            "it is empty: give side, fraction and push_mm, or way_points_mm, or gripper_turn_deg"
        )
    push = None
    of_push = {key: given[key] for key in _PUSH_KEYS if key in given}
    if of_push:
        whole = _checked({"angle_deg": 0, **of_push}, _PUSH_KEYS, ("side", "fraction", "push_mm"))
        side = whole_number("side", whole["side"], least=0)
        push = SidePush(side, *(_number(key, whole[key], unit) for key, unit in PUSH_UNITS.items()))
    points = None
    if "way_points_mm" in given:
        places = given["way_points_mm"]
        if not isinstance(places, list):
            raise InvalidInput(
                f"way_points_mm must be a list of points [[x, y], ...], not {places!r}"
            )
        points = tuple(_point("way_points_mm", place) for place in places)
    turn = _number("gripper_turn_deg", given.get("gripper_turn_deg", 0), DEGREES)
    weight = None
    if "weight" in given:
        weight = positive_number("weight", _number("weight", given["weight"], NUMBER))
    return CycleAction(points, push, turn), weight


def _number(key: str, value: object, unit: FileUnit) -> float:
    with located(f"{key} = {value}"):
        return unit.read(value)


def _point(key: str, value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise InvalidInput(f"{key} must hold [x, y], not {value!r}")
    return _number(key, value[0], MILLIMETRES), _number(key, value[1], MILLIMETRES)


def _checked(value: object, known: tuple[str, ...], needed: tuple[str, ...]) -> dict[str, object]:
    """A table with none but `known` keys and all the `needed` ones."""
    if not isinstance(value, Mapping):
        raise InvalidInput(f"must be a table with {', '.join(known)}, not {value!r}")
    for key in value:
        if key not in known:
            raise unknown_name("key", key, known)
    for key in needed:
        if key not in value:
            raise InvalidInput(f"{key} is missing")
    return dict(value)
