"""Text from outside: how it is shown, and which of it is a number."""

import json
import math
import re
import unicodedata

from cyclemap.errors import InvalidInput

# Python's own `float` and `int` take underscores and the digits of every script, too.
_NUMBER = re.compile(
    r"[+-]?(?:(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|nan|inf(?:inity)?)", re.ASCII | re.IGNORECASE
)
_WHOLE = re.compile(r"[+-]?\d+", re.ASCII)
# A hyphen that stands for a minus: before a number that nothing precedes, or between two terms.
_HYPHEN_MINUS = re.compile(r"(?<![\w°.)\]])-(?=\.?\d)|(?<= )-(?= )")
_POWER = re.compile(r"10\^(\d+)")
_RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
# Control and format characters, separators of lines and paragraphs, halves of pairs: nothing of
# them can be seen.
_UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")


def printable(text: str) -> str:
    r"""Return `text` with what a terminal would obey, or nobody can see, written as escapes; lines
    and tabs stay.

    >>> printable("\x1b[31mred\u202e")
    '\\x1b[31mred\\u202e'
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        sign
        if sign in "\n\t" or unicodedata.category(sign) not in _UNSEEN
        else sign.encode("unicode_escape").decode()
        for sign in text
    )


def typeset(text: str) -> str:
    """Return `text` as print has it: minus signs for the hyphens of numbers and terms, ± for +-,
    raised powers of ten.

    >>> typeset("-1.5 +- 1, f(x) - x, 10^12 at 3-4, run-2")
    '−1.5 ± 1, f(x) − x, 10¹² at 3-4, run-2'
    """
    raised = _POWER.sub(
        lambda power: f"10{power[1].translate(_RAISED)}", text.replace(" +- ", " ± ")
    )
    return _HYPHEN_MINUS.sub("−", raised)


def plain_number(text: str) -> float:
    """Return the number that `text` says in plain digits, with a point and a power of ten;
    ValueError otherwise.

    >>> plain_number(" -2.5e-3 ")
    -0.0025
    >>> plain_number("1_0")
    Traceback (most recent call last):
    ...
    ValueError: '1_0' is not a number in plain digits
    """
    if not _NUMBER.fullmatch(text.strip()):
        raise ValueError(f"{text!r} is not a number in plain digits")
    return float(text)


def number_or_nan(text: str) -> float:
    """Return the number that `text` says in plain digits, nan where it says none.

    >>> number_or_nan("0.5"), number_or_nan("half")
    (0.5, nan)
    """
    return float(text) if _NUMBER.fullmatch(text.strip()) else math.nan


def plain_whole(text: str) -> int:
    """Return the whole number that `text` says in plain digits; ValueError otherwise.

    >>> plain_whole("12")
    12
    """
    if not _WHOLE.fullmatch(text.strip()):
        raise ValueError(f"{text!r} is not a whole number in plain digits")
    return int(text)


def key_and_value(option: str, pair: str, form: str = "key=value") -> tuple[str, str]:
    """Return both words of a text such as `side = 2`; InvalidInput names the option that it was
    given to, and the form.

    >>> key_and_value("--set", "side = 2")
    ('side', '2')
    """
    key, _, value = (word.strip() for word in pair.partition("="))
    if not (key and value):
        raise InvalidInput(f"{option} {pair!r} is not of the form {form}")
    return key, value


def json_value(text: str | bytes) -> object:
    """Return what a JSON text says; ValueError where it is none, names a key twice, or nests
    thousands deep.
    """
    try:
        return json.loads(text, object_pairs_hook=_without_twins)
    except RecursionError as error:
        raise ValueError("lists or objects are nested too deeply") from error


def _without_twins(pairs: list[tuple[str, object]]) -> dict[str, object]:
    table = dict(pairs)
    if len(table) < len(pairs):
        twice = next(key for key, _ in pairs if sum(key == other for other, _ in pairs) > 1)
        raise ValueError(f"the key {twice!r} is there twice; keep one")
    return table


def install_words(extra: str) -> str:
    """Return how to install the libraries of an extra, where cyclemap comes from a checkout and no
    index has it.

    >>> install_words("outlines")
    "python -m pip install '.[outlines]' in the checkout of cyclemap"
    """
    return f"python -m pip install '.[{extra}]' in the checkout of cyclemap"
