"""The folder of a simulated collection: what was asked, where its files are, and how far it has come."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.mit_names import PushFacts, ScanFacts, push_name, scan_name
from cyclemap.evidence.simulation.collection_plan import Arguments, CollectionPlan
from cyclemap.text_files import read_toml
from cyclemap.whole_files import UNFINISHED_SUFFIX, write_whole

# Neither is a kind of file that readers of push data look at.
ARGUMENTS_FILE = "simulation.toml"
TRUTH_FILE = "true_theta0.txt"
PUSH_FOLDER, SCAN_FOLDER = "normal", "friction_scan"


class CollectionFolder:
    """A folder that holds one collection, begun or complete.

    `SURFACE/SHAPE/normal/` holds the pushes, `SURFACE/SHAPE/friction_scan/` the scans; `simulation.toml` what was
    asked, `true_theta0.txt` the true θ0 (rad, not wrapped) of each cycle and of the one that would follow.

    Raises InvalidInput where the folder holds something else, or a collection that was asked for otherwise.
    """

    def __init__(self, folder: str | Path, plan: CollectionPlan) -> None:
        self.folder, self.plan = Path(folder), plan
        self.surface, self.shape = name_part(plan.loop.material.name), name_part(plan.loop.slider.name)
        self._begin(plan.arguments())

    def _begin(self, arguments: Arguments) -> None:
        record, unfinished = self.folder / ARGUMENTS_FILE, f".*{UNFINISHED_SUFFIX}"
        begun = record.is_file()
        if begun:
            _refuse_other(self.folder, arguments, read_toml(record))
        elif self.folder.is_dir() and not all(path.match(unfinished) for path in self.folder.iterdir()):
            raise InvalidInput(f"{self.folder} holds other files; give a new or empty folder for the collection")
        for path in self.folder.rglob(unfinished):
            path.unlink(missing_ok=True)
        if begun:
            return
        lines = [f"{name} = {json.dumps(value, ensure_ascii=False)}\n" for name, value in arguments.items()]
        write_whole(record, "".join(["# What this simulated collection was asked to be.\n", *lines]).encode())

    def push_path(self, cycle: int) -> Path:
        """Where the push of `cycle` is kept."""
        push, plan = self.plan.push_at(cycle), self.plan
        place = (float(push.side), push.fraction, push.angle, float(cycle))
        facts = PushFacts(self.surface, self.shape, 0.0, plan.speed, *place)
        return self._home / PUSH_FOLDER / f"{push_name(facts)}{plan.suffix}"

    def scan_path(self, scan: ScanFacts) -> Path:
        """Where a friction scan is kept."""
        return self._home / SCAN_FOLDER / f"{scan_name(scan)}{self.plan.suffix}"

    @property
    def _home(self) -> Path:
        return self.folder / self.surface / self.shape

    def known_theta(self) -> list[float]:
        """The true θ0 of the cycles that are complete, and of the next: where to go on; the start if there are none.

        A cycle is complete when its file is there and its successor's θ0 is known; files behind a gap do not count.
        """
        theta = _leading_numbers(self.folder / TRUTH_FILE) or [self.plan.start]
        complete = 0
        while complete < min(len(theta) - 1, self.plan.cycles) and self.push_path(complete).is_file():
            complete += 1
        return theta[: complete + 1]

    def write_truth(self, theta: list[float]) -> None:
        """Write the θ0 of the cycles so far and of the next, in place of what was there."""
        lines = "".join(_truth_line(cycle, value) for cycle, value in enumerate(theta))
        write_whole(self.folder / TRUTH_FILE, lines.encode())

    def append_truth(self, cycle: int, theta: float) -> None:
        """Add the θ0 of `cycle`; a line cut short does not count when it is read."""
        try:
            with (self.folder / TRUTH_FILE).open("a", encoding="ascii", newline="") as file:
                file.write(_truth_line(cycle, theta))
        except OSError as error:
            raise OSError(f"{self.folder / TRUTH_FILE} cannot be written ({error.strerror})") from error

    def size(self) -> int:
        """Bytes of all pushes and scans."""
        return sum(path.stat().st_size for path in self._home.rglob(f"*{self.plan.suffix}"))


def name_part(name: str) -> str:
    """A surface's or an object's name as it can stand in a file name and name a folder.

    >>> name_part("plywood (changed)")
    'plywood_changed'
    """
    return re.sub(r"[^\w.-]+", "_", name).strip("_.") or "unnamed"


def _truth_line(cycle: int, theta: float) -> str:
    return f"{cycle} {theta!r}\n"


def _leading_numbers(path: Path) -> list[float]:
    """The numbers of the lines 0, 1, ... as long as they are whole and in order."""
    numbers: list[float] = []
    text = path.read_text(encoding="ascii", errors="replace") if path.is_file() else ""
    for line in text.splitlines(keepends=True):
        found = re.fullmatch(r"(\d+) (\S+)\n", line)
        try:
            value = float(found[2]) if found else math.nan
        except ValueError:
            value = math.nan
        if found is None or int(found[1]) != len(numbers) or not math.isfinite(value):
            break
        numbers.append(value)
    return numbers


def _refuse_other(folder: Path, arguments: Arguments, recorded: dict[str, object]) -> None:
    names = [name for name in {**arguments, **recorded} if arguments.get(name) != recorded.get(name)]
    if names:
        told = "; ".join(f"{name} is {recorded.get(name)} there and {arguments.get(name)} here" for name in names)
        raise InvalidInput(f"{folder} holds a collection that was asked for otherwise: {told}. Choose another folder")
