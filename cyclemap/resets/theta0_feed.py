"""Orientations from a file or a folder that grows while it is read."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.motion_check import check_pushes
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.push_table import PushTable, load_pushes, pushes_in_table
from cyclemap.evidence.pushes.recordings import PushFacts, PushRecord, push_facts
from cyclemap.evidence.tables.columns import ENDS, Convention, convention_of
from cyclemap.evidence.tables.data_kinds import (
    SUFFIXES,
    FileKind,
    file_kind,
    is_record,
    tells_orientations_alone,
    tells_radians_alone,
)
from cyclemap.evidence.tables.own_tables import read_orientations, read_own_table
from cyclemap.protocol.collection_file import data_table
from cyclemap.resets.bias_monitor import LARGEST_ORIENTATION
from cyclemap.text_files import UNFINISHED_SUFFIX, csv_table, decoded, read_bytes

COLUMNS = ("theta0_deg", "theta0_accum_deg")
_LOST_FRACTION = (
    "at such a size the fraction of a turn is lost; mend it, or give angles within a turn"
)
MOST_BYTES = 64 << 20


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
    if not (columns or units) and tells_radians_alone(place):
        units = ("rad",)
    if columns or units or file_kind(place) is FileKind.OTHER:
        read = partial(_own_orientations, place, columns or {}, units, convention)
        return Theta0Feed(None if place.is_dir() else place, read)
    if not place.is_dir():
        return Theta0Feed(place, partial(_csv_orientations, place, convention))
    homes = sorted(
        {file.parent for file in place.rglob("*") if push_facts(file) is not None} or {place}
    )
    if len(homes) > 1 and place not in homes:
        raise InvalidInput(
            f"{place}: several folders below hold pushes: watch one, such as {homes[0]}"
        )
    folder = _PushFolder(place if place in homes else homes[0], convention)
    return Theta0Feed(None, folder.read)


def check_feed(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Sequence[str] = (),
    *,
    loop: CollectionLoop | None = None,
    **said: Any,
) -> None:
    """Test how data that are whole were read against the motions of their pushes, where poses stand
    before and after these.

    columns, units : as `theta0_feed` takes them. loop : the one that made them, where it is known.
    said : of the convention, as `load_pushes` takes it.

    Raises OtherConvention where another reading explains the motions far better.
    """
    place = Path(path)
    # What cannot be read as pushes tells no motion: of its orientations the feed has its own word.
    with suppress(DataFileError):
        if columns or units or file_kind(place) is FileKind.OTHER:
            own = read_own_table(place, columns, units, **said)
            if not {*own.rows} >= {*ENDS}:
                return
            rows, _ = pushes_in_table(csv_table(place, own.csv_text()))
            keys = data_table(place) | {key: word for key, word in said.items() if word is not None}
            is_told = {"angles", "frame"} <= {*keys}
            pushes = PushTable(rows, rows[:0], (), convention_of(place, **said), is_told)
        elif file_kind(place) is FileKind.PLANNED or tells_orientations_alone(place):
            return
        else:
            pushes = load_pushes(place, **said)
        check_pushes(pushes, loop)


def _own_orientations(
    path: Path,
    columns: Mapping[str, str],
    units: Sequence[str],
    convention: Convention,
    finished: bool,
) -> NewOrientations:
    """All θ0 of a table of one's own; DataFileError where `read_orientations` raises it."""
    table = read_orientations(path, columns, units, not finished, convention)
    theta = tuple(table.columns["theta0"].tolist())
    return NewOrientations(theta, words=table.words, guessed=table.guessed)


def _csv_orientations(path: Path, convention: Convention, finished: bool) -> NewOrientations:
    """All θ0 of a CSV file with a column of that name; other columns are passed over, and so is,
    unless ``finished``, a last line without a line break.

    Rows are pushes in order: a file of pairs is read by its first column.
    """
    content = read_bytes(path, MOST_BYTES)
    if not finished:
        content = content[: content.rfind(b"\n") + 1]
    table = csv_table(path, decoded(path, content, "plain CSV"))
    column = next((name for name in COLUMNS if name in table.header), None)
    if column is None:
        header = ",".join(table.header)
        raise table.error(1, f"the header is {header}; it must have {' or '.join(COLUMNS)}")
    theta = np.radians(table.numbers(column))
    for row, angle in zip(table.rows, theta, strict=True):
        if abs(angle) > LARGEST_ORIENTATION:
            raise table.error(
                row.line, f"{column} is '{table.text(row, column)}'; {_LOST_FRACTION}"
            )
    return NewOrientations(tuple(map(convention.theta, theta.tolist())))


@dataclass
class Theta0Feed:
    """The orientations of data that grow, all of which are read whenever they have changed.

    Where the first ones are no longer what they were, the data began anew: they were rotated, cut
    short, rewritten or edited in place. Between two looks they may be away.

    path : of a file, whose bytes tell whether it has changed; None of a folder.
    read : all of its orientations, with or without a last line that is still being written.
    """

    path: Path | None
    read: Callable[[bool], NewOrientations]
    _fed: tuple[float, ...] = ()
    _content: bytes | None = None
    _dropped: bool = False

    def look(self, finished: bool = False) -> NewOrientations:
        """The θ0 added since the last look; DataFileError, with file, line and value, where they
        cannot be read.

        Unless ``finished`` a file that holds no whole row, or is away after the first look, is
        waited for.
        """
        if finished or self.path is None:
            return self._fresh(self.read(finished))
        try:
            content = read_bytes(self.path, MOST_BYTES)
            if content == self._content:
                return NewOrientations(())
            lines = [line for line in content.split(b"\n")[:-1] if line.strip()]
            read = self.read(False) if len(lines) > 1 else NewOrientations(())
        except DataFileError:
            if self._content is None or self.path.exists():
                raise
            return NewOrientations(())
        self._content = content
        return self._fresh(read)

    def _fresh(self, read: NewOrientations) -> NewOrientations:
        """What was not fed yet."""
        anew = read.theta[: len(self._fed)] != self._fed
        theta = read.theta if anew else read.theta[len(self._fed) :]
        self._fed = read.theta
        # What was fed stands until there is something to begin anew with.
        dropped = self._dropped or anew
        self._dropped = dropped and not theta
        return replace(read, theta=theta, began_anew=dropped and bool(theta))


@dataclass
class _PushFolder:
    """The first orientation of each recorded push in a folder (MIT layout), by repetition, then by
    name.

    Files that appear later are taken in that order among themselves; friction scans, folders and
    links to nothing are passed over. A file that cannot be read is looked at again; where it did
    not change between two looks, or with ``finished``, it is an error. Between two looks the folder
    may be away; once it is back it is read from its start.
    """

    path: Path
    convention: Convention
    _taken: dict[Path, tuple[float, ...]] = field(default_factory=dict)
    _doubtful: tuple[Path, int, int] | None = None

    def read(self, finished: bool) -> NewOrientations:
        """All θ0 so far, none while the folder is away.

        DataFileError for a damaged file, and for a folder that cannot be listed.
        ``finished``: also for a link to nothing, and for a folder that is absent or holds no push.
        """
        try:
            fresh = self._unread(finished)
        except FileNotFoundError as error:
            if finished:
                raise DataFileError(
                    f"{self.path}: there is no such folder; check the path"
                ) from error
            self._taken.clear()
            return NewOrientations(())
        except OSError as error:
            reason = error.strerror or error
            raise DataFileError(
                f"{self.path}: cannot be read ({reason}); give a folder that can be listed"
            ) from error
        self._take(fresh, finished)
        if finished and not self._taken:
            below = next(
                (file.parent for file in sorted(filter(is_record, self.path.rglob("*")))), None
            )
            where = "" if below is None else f"; there are some in {below}: give that"
            raise DataFileError(
                f"{self.path}: the folder holds no recorded push ({', '.join(SUFFIXES)}){where}"
            )
        return NewOrientations(tuple(chain(*self._taken.values())))

    def _unread(self, finished: bool) -> list[Path]:
        """The files that were not taken yet, by repetition, then by name."""
        listed = [
            file
            for file in filter(is_record, self.path.iterdir())
            if file not in self._taken and not file.name.endswith(UNFINISHED_SUFFIX)
        ]
        for file in listed if finished else ():
            if file.is_symlink() and not file.exists():
                raise DataFileError(
                    f"{file}: a link to a file that is not there; restore the file or remove "
                    "the link"
                )
        return sorted(filter(Path.is_file, listed), key=_order)

    def _take(self, fresh: list[Path], finished: bool) -> None:
        """Read the θ0 of the files, rad, up to one that is still being written."""
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
            self._taken[file] = ()
            # A friction scan has none.
            if isinstance(record, PushRecord):
                self._taken[file] = (self.convention.theta(float(record.start[2])),)

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


def _order(file: Path) -> tuple[float, str]:
    """By repetition, those without one last, then by name."""
    repetition = (push_facts(file) or PushFacts()).repetition
    return math.inf if math.isnan(repetition) else repetition, file.name
