"""The store of a sweep: one SQLite file, a row a point, written as the sweep goes and whole after
any interruption.

Write-ahead log with full synchronisation (SQLite's documentation, "Write-Ahead Logging"): what a
committed chunk holds survives a killed process and a lost supply of power. Rows are in SI units,
columns by the names of keys and quantities, lists as JSON; each row carries a digest of itself. The
log needs a local disk: file systems of a network lack what it is built on.
"""

import hashlib
import json
import math
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from cyclemap.errors import CycleMapError, DataFileError, InvalidInput
from cyclemap.sweeps.portrait_numbers import PointOutcome, SweptPoint
from cyclemap.sweeps.sweep_plan import SweepPlan

# What a store tells of its plan, as JSON.
Description = dict[str, Any]
# "cysw": tells a sweep's store from any other SQLite file.
_APPLICATION = 0x63797377
_FORMAT = 2
_PATIENCE_SECONDS = 60.0
_WRITE_FAULTS = (
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_CANTOPEN,
    sqlite3.SQLITE_PERM,
)
_BUSY = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)


class StoreWriteError(CycleMapError):
    """A store that could not be written, as on a full disk; what it held before is unharmed.

    Examples
    --------
    >>> from cyclemap import CycleMapError
    >>> from cyclemap.sweeps import StoreWriteError
    >>> issubclass(StoreWriteError, CycleMapError)
    True
    """


@dataclass(frozen=True)
class SweepStatus:
    """How far a sweep is.

    Attributes
    ----------
    points : int
        Points in all.
    stored : int
        Points that are stored.
    refused : int
        How many of these tell a refusal.

    Examples
    --------
    >>> from cyclemap.sweeps import SweepStatus
    >>> SweepStatus(points=6, stored=4, refused=1).complete
    False
    """

    points: int
    stored: int
    refused: int

    @property
    def complete(self) -> bool:
        """Whether every point is stored."""
        return self.stored == self.points


class SweepStore(AbstractContextManager["SweepStore"]):
    """An open store; use it in a `with` block.

    Parameters
    ----------
    path : Path
        The file.
    plan : SweepPlan or None, optional
        With it the store is made where there is none, and must be of that plan.

    Raises
    ------
    InvalidInput
        For the store of another plan.
    StoreWriteError
        Where it cannot be written.
    DataFileError
        For a file that is damaged or no store of a sweep, and without a plan for one that is
        absent.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.sweeps import SweepPlan, SweepStore
    >>> plan = SweepPlan.grid("isotropic", {"noise_deg": (1.0, 2.0)})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with SweepStore(Path(folder, "sweep.sqlite"), plan) as store:
    ...         store.status()
    SweepStatus(points=2, stored=0, refused=0)
    """

    def __init__(self, path: Path, plan: SweepPlan | None = None) -> None:
        """Open the store at `path`; with a `plan` it is made where there is none, and must be of
        that plan.
        """
        self.path = path
        if path.is_dir():
            raise DataFileError(f"{path}: is a folder; give the path of the store in it")
        if plan is None and not path.exists():
            raise DataFileError(
                f"{path}: there is no such store; check the path, or run the sweep first"
            )
        with self._faults_told():
            if plan is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
            self.connection = sqlite3.connect(path, timeout=_PATIENCE_SECONDS, isolation_level=None)
        try:
            with self._faults_told():
                self.description = self._begun(plan)
        except BaseException:
            self.connection.close()
            raise

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.connection.close()

    def status(self) -> SweepStatus:
        """How far the sweep is."""
        with self._faults_told():
            counts = "SELECT count(*), coalesce(sum(refusal != ''), 0) FROM points"
            stored, refused = self.connection.execute(counts).fetchone()
        return SweepStatus(self.description["count"], stored, refused)

    def digests(self, first: int, end: int) -> set[str]:
        """The digests of the stored points with numbers from `first` up to, but without, `end`."""
        with self._faults_told():
            asked = "SELECT digest FROM points WHERE number >= ? AND number < ?"
            return {digest for (digest,) in self.connection.execute(asked, (first, end))}

    def rows(self) -> Iterator[dict[str, object]]:
        """Every stored row by column, in the order of the plan; lists are tuples, what is missing
        is None.
        """
        keys, scalars, lists = self._columns()
        names = ["digest", "number", *keys, *scalars, *lists, "refusal", "seal"]
        with self._faults_told():
            quoted = ", ".join(f'"{name}"' for name in names)
            for row in self.connection.execute(f"SELECT {quoted} FROM points ORDER BY number"):
                stored = dict(zip(names, row, strict=True))
                for name in lists:
                    if stored[name] is not None:
                        stored[name] = tuple(json.loads(stored[name]))
                for key in keys:
                    # Swept points, as against words.
                    if str(stored[key]).startswith("[["):
                        stored[key] = tuple(map(tuple, json.loads(stored[key])))
                yield stored

    def add(self, outcomes: Sequence[tuple[SweptPoint, PointOutcome]]) -> None:
        """Store outcomes, all or none of them; a point that is stored already stays as it is."""
        keys, scalars, lists = self._columns()
        marks = ", ".join("?" * (len(keys) + len(scalars) + len(lists) + 4))
        rows = []
        for point, outcome in outcomes:
            swept = [_kept(point.swept[key]) for key in keys]
            values = [_kept(outcome.values.get(name)) for name in (*scalars, *lists)]
            row = [point.digest, point.number, *swept, *values, outcome.refusal]
            rows.append((*row, _seal(row)))
        with self._faults_told(), self._transaction():
            self.connection.executemany(f"INSERT OR IGNORE INTO points VALUES ({marks})", rows)

    def finish(self) -> None:
        """Move what the log still holds into the file itself."""
        with self._faults_told():
            self.connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def _columns(self) -> tuple[list[str], list[str], list[str]]:
        """Names of the columns of keys, of numbers, and of lists."""
        columns = self.description["columns"]
        scalars = [column["name"] for column in columns if not column["many"]]
        lists = [column["name"] for column in columns if column["many"]]
        return self.description["keys"], scalars, lists

    def _begun(self, plan: SweepPlan | None) -> Description:
        """Check the file, or begin a new one; return its description."""
        run = self.connection.execute
        run(f"PRAGMA busy_timeout = {int(1000 * _PATIENCE_SECONDS)}")
        # In this order: where another process made the tables just now, it has set the number with
        # them.
        tables = run("SELECT count(*) FROM sqlite_master").fetchone()[0]
        application = run("PRAGMA application_id").fetchone()[0]
        if application == 0 and tables == 0 and plan is not None:
            self._create(plan)
            application = run("PRAGMA application_id").fetchone()[0]
        if application != _APPLICATION or run("PRAGMA user_version").fetchone()[0] != _FORMAT:
            raise DataFileError(
                f"{self.path}: not a store of this version's sweeps; choose another folder or "
                "remove it"
            )
        run("PRAGMA synchronous = FULL")
        checked = [row[0] for row in run("PRAGMA integrity_check")]
        if checked != ["ok"]:
            raise self._damaged(str(checked[0]))
        # Damage that leaves SQLite's own structure whole shows in the seals.
        for table in ("sweep", "points"):
            for row in run(f"SELECT * FROM {table}"):
                if _seal(row[:-1]) != row[-1]:
                    raise self._damaged(f"a row of its table {table} is not as it was written")
        description: Description = json.loads(run("SELECT description FROM sweep").fetchone()[0])
        if plan is not None:
            self._check_same(description, _description(plan))
        self.description = description
        if run("SELECT sql FROM sqlite_master WHERE name = 'points'").fetchone() != (
            self._points_table(),
        ):
            raise self._damaged("its columns are not as they were made")
        return description

    def _points_table(self) -> str:
        """The statement that makes the table of the points."""
        keys, scalars, lists = self._columns()
        columns = [
            "digest TEXT PRIMARY KEY",
            "number INTEGER NOT NULL UNIQUE",
            *(f'"{key}"' for key in keys),
        ]
        columns += [f'"{name}" REAL' for name in scalars] + [f'"{name}" TEXT' for name in lists]
        columns += ["refusal TEXT NOT NULL", "seal TEXT NOT NULL"]
        return f"CREATE TABLE points ({', '.join(columns)}) WITHOUT ROWID"

    def _create(self, plan: SweepPlan) -> None:
        """Make the tables, unless another process that began at the same time has made them."""
        self.description = _description(plan)
        run = self.connection.execute
        run("PRAGMA synchronous = FULL")
        with self._transaction():
            if run("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                return
            row = (json.dumps(self.description),)
            run("CREATE TABLE sweep (description TEXT NOT NULL, seal TEXT NOT NULL)")
            run("INSERT INTO sweep VALUES (?, ?)", (*row, _seal(row)))
            run(self._points_table())
            run(f"PRAGMA user_version = {_FORMAT}")
            run(f"PRAGMA application_id = {_APPLICATION}")
        # Only one of several connections can change the journal; any one will do, and rollback is
        # as safe.
        with suppress(sqlite3.OperationalError):
            run("PRAGMA journal_mode = WAL")

    def _check_same(self, stored: Description, wanted: Description) -> None:
        there = stored["plan"]
        plan = wanted["plan"]
        other = [name for name in plan if there.get(name) != plan[name]]
        if other == ["code"]:
            raise InvalidInput(
                f"{self.path} was computed by another version of the code, whose numbers may "
                "differ: choose another folder or remove it"
            )
        if other:
            raise InvalidInput(
                f"{self.path} is the store of another sweep, which differs in {', '.join(other)}: "
                "choose another folder or remove it"
            )

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self.connection.execute("BEGIN IMMEDIATE")
        try:
            yield
            self.connection.execute("COMMIT")
        except BaseException:
            if self.connection.in_transaction:
                self.connection.execute("ROLLBACK")
            raise

    @contextmanager
    def _faults_told(self) -> Iterator[None]:
        """Turn what SQLite raises into errors that tell what to do."""
        try:
            yield
        except sqlite3.Error as error:
            code = getattr(error, "sqlite_errorcode", 0) & 0xFF
            if code in _BUSY:
                raise StoreWriteError(
                    f"{self.path} is held by another process ({error}); wait for it to end"
                ) from error
            if code in _WRITE_FAULTS:
                raise StoreWriteError(
                    f"{self.path} cannot be written ({error}): the disk is full or refuses; what "
                    "was stored is kept: make room, then run the same sweep again"
                ) from error
            raise self._damaged(str(error)) from error
        except UnicodeDecodeError as error:
            raise self._damaged(str(error)) from error
        except OSError as error:
            raise StoreWriteError(
                f"{self.path} cannot be written ({error.strerror}): choose another folder"
            ) from error

    def _damaged(self, fault: str) -> DataFileError:
        words = " ".join(fault.split())
        return DataFileError(
            f"{self.path}: damaged, or no store of a sweep ({words}); remove it and sweep again"
        )


def _description(plan: SweepPlan) -> Description:
    """What the store tells about itself, after a passage through JSON."""
    columns = [asdict(quantity) for quantity in plan.numbers.quantities]
    facts = {"plan": plan.described(), "keys": plan.keys, "count": len(plan), "columns": columns}
    description: Description = json.loads(json.dumps(facts))
    return description


def _kept(value: object) -> object:
    """A value as a column keeps it: SQLite has neither nan nor a negative zero."""
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, (int, float)):
        return None if math.isnan(value) else float(value) + 0.0
    return json.dumps(value)


def _seal(row: Sequence[object]) -> str:
    return hashlib.sha256(repr(tuple(row)).encode()).hexdigest()[:16]
