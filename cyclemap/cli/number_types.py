"""Numbers of the command line: click's ranges, in plain digits only."""

import math
from typing import Any

import click

from cyclemap.plain_text import plain_number, plain_whole

# Longer runs fill memory before they tell more.
MOST_CYCLES = 1_000_000


class Whole(click.IntRange):
    """A whole number of a range."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number; a usage error for other than plain digits."""
        return super().convert(_plain(self, plain_whole, value, param, ctx), param, ctx)


class Real(click.FloatRange):
    """A number of a range, which has no nan, or any where no range is given."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number; a usage error for other than plain digits."""
        found = super().convert(_plain(self, plain_number, value, param, ctx), param, ctx)
        if math.isnan(found) and (self.min is not None or self.max is not None):
            self.fail("nan is in no range", param, ctx)
        return found


def _plain(kind: Whole | Real, read: Any, value: Any, param: Any, ctx: Any) -> Any:
    try:
        return read(value) if isinstance(value, str) else value
    except ValueError as error:
        kind.fail(str(error), param, ctx)
