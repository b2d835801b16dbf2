"""The folder of a simulated collection: what was asked, where its files are, and how far it has come."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from cyclemap.collection.collection_file import FILE_NAME, SIMULATION, collection_text
from cyclemap.errors import InvalidInput
from cyclemap.evidence.pushes.mit_names import PushFacts, ScanFacts, push_name, scan_name
from cyclemap.evidence.simulation.collection_plan import Arguments, CollectionPlan
from cyclemap.file_text import toml_text
from cyclemap.plain_text import plain_number
from cyclemap.text_files import read_toml
from cyclemap.whole_files import UNFINISHED_SUFFIX, file_stem, write_whole

# Neither is a kind of file that readers of push data look at.
TRUTH_FILE = "true_theta0.txt"
_COMMENTS = ("The collection that these data are of; [simulation] is what was asked when they were made.",)
PUSH_FOLDER, SCAN_FOLDER = "normal", "friction_scan"


class CollectionFolder:
    """A folder that holds one collection, begun or complete.

    `SURFACE/SHAPE/normal/` holds the pushes, `SURFACE/SHAPE/friction_scan/` the scans; `collection.toml` the
    collection and what was asked, `true_theta0.txt` the true θ0 (rad, not wrapped) of each cycle and of the one that
    would follow, with a seal behind each.

    Raises InvalidInput where the folder holds something else, or a collection that was asked for otherwise.
    """

    def __init__(self, folder: str | Path, plan: CollectionPlan) -> None:
        self.folder, self.plan = Path(folder), plan
        self.surface, self.shape = file_stem(plan.loop.material.name), file_stem(plan.loop.slider.name)
        self._begin(plan.arguments())

    def _begin(self, arguments: Arguments) -> None:
        record, unfinished = self.folder / FILE_NAME, f".*{UNFINISHED_SUFFIX}"
        begun = record.is_file()
        if begun:
            found = read_toml(record).get(SIMULATION)
            _refuse_other(self.folder, arguments, found if isinstance(found, dict) else {})
        elif self.folder.is_dir() and not all(path.match(unfinished) for path in self.folder.iterdir()):
            raise InvalidInput(f"{self.folder} holds other files; give a new or empty folder for the collection")
        for path in self.folder.rglob(unfinished):
            path.unlink(missing_ok=True)
        if begun:
            return
        write_whole(record, self._record(arguments).encode())

    def _record(self, arguments: Arguments) -> str:
        """The loop as every command reads it, and what was asked; that alone for a loop that no setting can say."""
        asked, noise = {SIMULATION: arguments}, self.plan.noise.turn or None
        try:
            return collection_text(self.plan.loop, noise=noise, more=asked, comments=_COMMENTS)
        except InvalidInput as error:
            return toml_text(asked, (*_COMMENTS, f"Not told here: object, push and reset, for {error}"))

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

        Every line of the truth is sealed with the file of the push that led to its θ0, and with the line before: a
        cycle is complete as long as neither is other than it was written. What comes behind does not count, and goes.
        """
        truth, theta = self.folder / TRUTH_FILE, [self.plan.start]
        lines = truth.read_bytes().splitlines(keepends=True) if truth.is_file() else []
        kept = [self._truth_line(0, self.plan.start, b"")]
        if lines[:1] == kept:
            for cycle, line in enumerate(lines[1 : self.plan.cycles + 1], 1):
                value = _number(line)
                if value is None or line != self._truth_line(cycle, value, kept[-1]):
                    break
                theta.append(value)
                kept.append(line)
        write_whole(truth, b"".join(kept))
        self._last = kept[-1]
        return theta

    def append_truth(self, cycle: int, theta: float) -> None:
        """Add the θ0 of `cycle`, once the push before is written; a line cut short does not count when it is read."""
        self._last = self._truth_line(cycle, theta, self._last)
        try:
            with (self.folder / TRUTH_FILE).open("ab") as file:
                file.write(self._last)
        except OSError as error:
            raise OSError(f"{self.folder / TRUTH_FILE} cannot be written ({error.strerror})") from error

    def _truth_line(self, cycle: int, theta: float, before: bytes) -> bytes:
        """The cycle, its θ0, and a digest of these, of the push that led there and of the line before."""
        push = self.push_path(cycle - 1) if cycle else None
        content = push.read_bytes() if push is not None and push.is_file() else b""
        told = f"{cycle} {theta!r}".encode()
        return told + b" # " + hashlib.sha256(b"\0".join((before, told, content))).hexdigest()[:16].encode() + b"\n"

    def size(self) -> int:
        """Bytes of all pushes and scans."""
        return sum(path.stat().st_size for path in self._home.rglob(f"*{self.plan.suffix}"))


def _number(line: bytes) -> float | None:
    """The θ0 of a line of the truth; None where it has none."""
    found = re.fullmatch(rb"\d+ (\S+) # \w+\n", line)
    try:
        return plain_number(found[1].decode()) if found else None
    except ValueError:
        return None


def _refuse_other(folder: Path, arguments: Arguments, recorded: dict[str, object]) -> None:
    names = [name for name in {**arguments, **recorded} if arguments.get(name) != recorded.get(name)]
    if names:
        told = "; ".join(f"{name} is {recorded.get(name)} there and {arguments.get(name)} here" for name in names)
        raise InvalidInput(f"{folder} holds a collection that was asked for otherwise: {told}. Choose another folder")
