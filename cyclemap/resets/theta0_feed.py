"""Orientations from a file or a folder that grows while it is read."""

from __future__ import annotations

import csv
import hashlib
import math
import stat
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.pushes.conventions import OURS, Convention, convention_of
from cyclemap.evidence.pushes.mit_names import PushFacts, push_facts
from cyclemap.evidence.pushes.own_tables import is_own, read_orientations
from cyclemap.evidence.pushes.push_files import SUFFIXES, PushRecord, read_push_file
from cyclemap.evidence.pushes.push_table import CSV_SUFFIX
from cyclemap.resets.bias_monitor import LARGEST_ORIENTATION
from cyclemap.text_files import UNFINISHED_SUFFIX, CsvRow, CsvTable

COLUMNS = ("theta0_deg", "theta0_accum_deg")
_LOST_FRACTION = (
    "at such a size the fraction of a turn is lost; mend it, or give angles within a turn"
)
MOST_BYTES = 64 << 20  # of new rows at one look
_PART_BYTES = 1 << 20


@dataclass(frozen=True)
class NewOrientations:
    """What a look at a growing file found: the new θ0, rad, and whether the file began anew before
    them.

    words, guessed : of a table with other columns, what was read as what, and whether that was
        guessed.
    """

    theta: tuple[float, ...]
    began_anew: bool = False
    words: tuple[str, ...] = ()
    guessed: bool = False


def theta0_feed(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Sequence[str] = (),
    convention: Convention | None = None,
) -> Theta0Feed:
    """The feed of a CSV file with a column theta0_deg (or theta0_accum_deg), or of a folder of
    pushes, MIT layout.

    Its ``look(finished=False)`` gives the orientations added since the last look, one a push, in
    the order of the pushes; ``finished``: nothing more is being written.

    columns, units : of a table of one's own, as `read_own_table` takes them; other data are told by
        themselves.
    convention : of the angles, None: what a collection.toml with the data says; orientations alone
        cannot tell it.

    Of a tree with pushes in one folder it is that one's; InvalidInput where several hold some.
    """
    place = Path(path)
    convention = convention or convention_of(path)
    if columns or units or is_own(place):
        return OwnTableFeed(place, columns or {}, units, convention)
    if _has_poses_in_radians(place):
        return OwnTableFeed(place, {}, ("rad",), convention)
    if not place.is_dir():
        return Theta0CsvFeed(place, convention)
    homes = sorted(
        {file.parent for file in place.rglob("*") if push_facts(file) is not None} or {place}
    )
    if len(homes) > 1 and place not in homes:
        raise InvalidInput(
            f"{place}: several folders below hold pushes: watch one, such as {homes[0]}"
        )
    return PushFolderFeed(place if place in homes else homes[0], convention)


def _has_poses_in_radians(path: Path) -> bool:
    """Whether a table has poses before pushes under the names that `load_pushes` reads, and no θ0
    in degrees.
    """
    if not path.is_file() or path.suffix.lower() != CSV_SUFFIX:
        return False
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        names = {name.strip().lower() for name in file.readline(_PART_BYTES).split(",")}
    return {"x0", "y0"} <= names and bool({"th0", "theta0"} & names) and not set(COLUMNS) & names


class Theta0CsvFeed:
    """The column theta0_deg, or theta0_accum_deg, of a CSV file, row after row; other columns are
    passed over.

    Rows are pushes in order: a file of pairs is read by its first column. A last line without a
    line break waits until it is whole, or ``finished``. At each look the checksum of all that was
    read is compared with what the file now holds there: one that was rotated, cut short, rewritten
    or edited in place, in any row, is read from its start. Between two looks it may be away.
    """

    def __init__(self, path: Path, convention: Convention = OURS) -> None:
        self.path = path
        self.convention = convention
        self._seen = self._dropped = False
        self._start_over()

    def look(self, finished: bool = False) -> NewOrientations:
        """The θ0 of the rows added since the last look.

        DataFileError where the file is absent at the first look, is no regular file or no UTF-8
        text, its header has neither column, a row has more or fewer fields than the header, or its
        θ0 is no finite number or over 1e9 rad: with file, line and value. ``finished``: also where
        it holds no row.
        """
        try:
            # A pipe would wait for a writer for ever, and cannot be read twice.
            if not stat.S_ISREG(self.path.stat().st_mode):
                raise DataFileError(
                    f"{self.path}: not a regular file; give a CSV file, or a folder of pushes"
                )
            with self.path.open("rb") as file:
                if not self._is_as_read(file):
                    self._dropped = self._dropped or self._rows > 0
                    self._start_over()
                    file.seek(0)
                content = file.read(MOST_BYTES + 1)
            if len(content) > MOST_BYTES:
                raise DataFileError(
                    f"{self.path}: over {MOST_BYTES >> 20} MB more at one look; give a table of "
                    "θ0 alone"
                )
            end = len(content) if finished else content.rfind(b"\n") + 1
            self._checksum.update(content[:end])
            self._read += end
            lines = content[:end].split(b"\n")[: None if finished else -1]
        except FileNotFoundError as error:
            if self._seen and not finished:
                return NewOrientations(())
            raise DataFileError(f"{self.path}: there is no such file; check the path") from error
        except OSError as error:
            raise DataFileError(
                f"{self.path}: cannot be read ({error.strerror}); give a readable CSV file"
            ) from error
        self._seen = True
        theta = tuple(angle for line in lines for angle in self._taken(line))
        if finished and not self._rows:
            raise DataFileError(
                f"{self.path}: no row of θ0; it needs a header line and at least one row"
            )
        # What was fed stands until there is something to begin anew with.
        began_anew = self._dropped and bool(theta)
        self._dropped = self._dropped and not theta
        return NewOrientations(theta, began_anew)

    def _start_over(self) -> None:
        self._read = 0
        self._line = 0
        self._rows = 0
        self._checksum = hashlib.sha256()
        self._table: CsvTable | None = None

    def _is_as_read(self, file: BinaryIO) -> bool:
        """Read the file up to where it was read to before, and tell whether that is what it was."""
        found = hashlib.sha256()
        left = self._read
        while left:
            part = file.read(min(left, _PART_BYTES))
            if not part:
                return False
            found.update(part)
            left -= len(part)
        return found.digest() == self._checksum.digest()

    def _taken(self, line: bytes) -> list[float]:
        """The θ0 of a line, rad; nothing from the header and from blank lines."""
        self._line += 1
        try:
            text = line.decode("utf-8-sig" if self._line == 1 else "utf-8")
            fields = next(csv.reader([text.rstrip("\r")], strict=True), [])
        except UnicodeDecodeError as error:
            place = f"{self.path}, line {self._line}"
            raise DataFileError(
                f"{place}: byte {error.start} is not UTF-8 text; save it as plain CSV"
            ) from error
        except csv.Error as error:
            raise DataFileError(
                f"{self.path}, line {self._line}: {error}; mend the quotes of this line"
            ) from error
        row = CsvRow(self._line, tuple(field.strip() for field in fields))
        if not any(row.fields):
            return []
        if self._table is None:
            table = CsvTable(self.path, tuple(name.lower() for name in row.fields), ())
            if not set(COLUMNS) & set(table.header):
                raise table.error(
                    row.line,
                    f"the header is {','.join(table.header)}; it must have {' or '.join(COLUMNS)}",
                )
            self._table = table
            return []
        if len(row.fields) != len(self._table.header):
            counts = (
                f"{len(row.fields)} of {len(self._table.header)} fields ('{','.join(row.fields)}')"
            )
            raise self._table.error(
                row.line, f"{counts}; the line is cut off or has a stray comma: mend or remove it"
            )
        self._rows += 1
        column = next(name for name in COLUMNS if name in self._table.header)
        theta = math.radians(self._table.number(row, column))
        if abs(theta) > LARGEST_ORIENTATION:
            raise self._table.error(
                row.line, f"{column} is '{self._table.text(row, column)}'; {_LOST_FRACTION}"
            )
        return [self.convention.theta(theta)]


@dataclass
class OwnTableFeed:
    """The orientations of a table with other columns.

    It is read whole whenever it has changed: where its first rows are no longer what they were, it
    began anew.
    """

    path: Path
    columns: Mapping[str, str]
    units: Sequence[str]
    convention: Convention = OURS
    _fed: tuple[float, ...] = ()
    _seen: tuple[int, int] | None = None

    def look(self, finished: bool = False) -> NewOrientations:
        """The θ0 of the rows added since the last look; DataFileError where `read_orientations`
        raises it.

        Unless ``finished`` a file that holds no whole row, or is away after the first look, is
        waited for.
        """
        try:
            status = self.path.stat()
        except OSError as error:
            if self._seen and not finished:
                return NewOrientations(())
            raise DataFileError(f"{self.path}: there is no such file; check the path") from error
        now = (status.st_size, status.st_mtime_ns)
        if not finished and (
            now == self._seen or (self.path.is_file() and self.path.read_bytes().count(b"\n") < 2)
        ):
            return NewOrientations(())
        found = read_orientations(
            self.path, self.columns, self.units, not finished, self.convention
        )
        theta = tuple(found.columns["theta0"].tolist())
        fed = self._fed
        self._seen = now
        self._fed = theta
        anew = theta[: len(fed)] != fed
        return NewOrientations(
            theta if anew else theta[len(fed) :], anew, found.words, found.guessed
        )


@dataclass
class PushFolderFeed:
    """The first orientation of each recorded push in a folder (MIT layout), by repetition, then by
    name.

    Files that appear later are taken in that order among themselves; friction scans, folders and
    links to nothing are passed over. A file that cannot be read is looked at again; where it did
    not change between two looks, or with ``finished``, it is an error. Between two looks the folder
    may be away; once it is back it is read from its start.
    """

    path: Path
    convention: Convention = OURS
    _taken: set[Path] = field(default_factory=set)
    _doubtful: tuple[Path, int, int] | None = None
    _dropped: bool = False

    def look(self, finished: bool = False) -> NewOrientations:
        """The θ0 of the files added since the last look, none while the folder is away.

        DataFileError for a damaged file, and for a folder that cannot be listed.
        ``finished``: also for a link to nothing, and for a folder that is absent or holds no push.
        """
        try:
            named = (file for file in self.path.iterdir() if file.suffix.lower() in SUFFIXES)
            found = [
                f for f in named if f not in self._taken and not f.name.endswith(UNFINISHED_SUFFIX)
            ]
            nowhere = next(
                (file for file in found if file.is_symlink() and not file.exists()), None
            )
            if finished and nowhere is not None:
                raise DataFileError(
                    f"{nowhere}: a link to a file that is not there; restore the file or remove "
                    "the link"
                )
            facts = [(file, push_facts(file) or PushFacts()) for file in found if file.is_file()]
            numbered = [
                (math.inf if math.isnan(one.repetition) else one.repetition, file.name)
                for file, one in facts
            ]
            fresh = [self.path / name for _, name in sorted(numbered)]
        except FileNotFoundError as error:
            if finished:
                raise DataFileError(
                    f"{self.path}: there is no such folder; check the path"
                ) from error
            self._dropped = self._dropped or bool(self._taken)
            self._taken.clear()
            return NewOrientations(())
        except OSError as error:
            reason = error.strerror or error
            raise DataFileError(
                f"{self.path}: cannot be read ({reason}); give a folder that can be listed"
            ) from error
        theta = self._theta_of(fresh, finished)
        if finished and not self._taken:
            below = next(
                (f.parent for f in sorted(self.path.rglob("*")) if f.suffix.lower() in SUFFIXES),
                None,
            )
            where = "" if below is None else f"; there are some in {below}: give that"
            raise DataFileError(
                f"{self.path}: the folder holds no recorded push ({', '.join(SUFFIXES)}){where}"
            )
        # What was fed stands until there is something to begin anew with.
        began_anew = self._dropped and bool(theta)
        self._dropped = self._dropped and not theta
        return NewOrientations(theta, began_anew)

    def _theta_of(self, fresh: list[Path], finished: bool) -> tuple[float, ...]:
        """The θ0 of the files, rad, up to one that is still being written."""
        theta: list[float] = []
        for file in fresh:
            try:
                record = read_push_file(file)
            except (DataFileError, OSError) as error:
                if not finished and not self._stale(file):
                    break
                if isinstance(error, DataFileError):
                    raise
                said = error.strerror or error
                raise DataFileError(
                    f"{file}: cannot be read ({said}); restore it or remove it"
                ) from error
            self._taken.add(file)
            # A friction scan has none.
            theta += (
                [self.convention.theta(float(record.start[2]))]
                if isinstance(record, PushRecord)
                else []
            )
        return tuple(theta)

    def _stale(self, file: Path) -> bool:
        """True where the file is as it was at the look before; not where it has gone."""
        try:
            status = file.stat()
        except FileNotFoundError:
            return False
        now = (file, status.st_size, status.st_mtime_ns)
        before = self._doubtful
        self._doubtful = now
        return now == before


Theta0Feed = Theta0CsvFeed | OwnTableFeed | PushFolderFeed
