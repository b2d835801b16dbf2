"""What is refused, and in which words."""

from collections.abc import Callable
from typing import Any

import pytest

from cyclemap.errors import InvalidInput


def refused(
    call: Callable[..., Any],
    *values: Any,
    told: str | None = None,
    kind: type[Exception] = InvalidInput,
    **named: Any,
) -> None:
    """Assert that a call is refused in one line that matches `told`."""
    with pytest.raises(kind, match=told) as caught:
        call(*values, **named)
    assert "\n" not in str(caught.value)
