"""Where measured data are looked for, and what a figure says where there are none."""

import os
from dataclasses import dataclass
from pathlib import Path

from cyclemap.errors import InvalidInput

THETA0_FILE = "plywood_rect1_theta0_2000.csv"
NO_DATA = "no measured data found"


@dataclass(frozen=True)
class MeasuredFolder:
    """A folder of measured data; `path` is None where there is none."""

    path: Path | None = None

    @classmethod
    def found(cls, given: Path | None = None) -> "MeasuredFolder":
        """Return the folder `given`, else the one $CYCLEMAP_DATA names, else `shared/data` beside the checkout.

        Raises InvalidInput where `given` or $CYCLEMAP_DATA is no folder.
        """
        named = given or (Path(os.environ["CYCLEMAP_DATA"]) if os.environ.get("CYCLEMAP_DATA") else None)
        if named is not None:
            if not named.is_dir():
                raise InvalidInput(f"measured data: {str(named)!r} is no folder; name one, or leave --data out")
            return cls(named)
        beside = Path(__file__).parents[3] / "shared" / "data"
        return cls(beside if beside.is_dir() else None)

    def file(self, name: str) -> Path | None:
        """Return the path of the file `name` in the folder; None where it is not there."""
        if self.path is None or not (self.path / name).is_file():
            return None
        return self.path / name

    def folder(self, name: str) -> Path | None:
        """Return the path of the sub-folder `name`; None where it is not there."""
        if self.path is None or not (self.path / name).is_dir():
            return None
        return self.path / name
