"""The options' forms: what the command line shows for a value, as a Python type and as words of a command line."""

from __future__ import annotations

import os
import re
from typing import Any

import numpy as np


def _number(value: Any) -> str:
    """Every digit of a number, so that it is the same when it is read again."""
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"needs a number, not {value}")
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float(value))


def _numbers(value: Any) -> list[str]:
    return [_number(one) for one in np.asarray(value, dtype=object).ravel()]


def _one(value: Any) -> list[str]:
    return [_number(value)]


def _text(value: Any) -> list[str]:
    return [str(value)]


def _list(value: Any) -> list[str]:
    """One or several, as numbers or texts, in one word."""
    several = isinstance(value, (list, tuple, np.ndarray))
    return [",".join(str(one) for one in value) if several else str(value)]


def _joined(between: str, counts: tuple[int, ...]):
    """Several numbers in one word, or a text that is such a word."""

    def words(value: Any) -> list[str]:
        if isinstance(value, str):
            return [value]
        numbers = _numbers(value)
        if len(numbers) not in counts:
            raise TypeError(f"needs {' or '.join(map(str, counts))} numbers, not {len(numbers)}")
        return [between.join(numbers)]

    return words


def _clip_part(part: Any) -> str:
    """Of one axis: None, a slice, a (first, end), or a text."""
    if part is None or isinstance(part, str):
        return part or ""
    if isinstance(part, slice):
        if part.step not in (None, 1):
            raise TypeError("needs slices without a step")
        part = (part.start, part.stop)
    first, end = part
    return f"{'' if first is None else _number(first)}:{'' if end is None else _number(end)}"


def _clip(value: Any) -> list[str]:
    if isinstance(value, str):
        return [value]
    if len(value) != 3:
        raise TypeError("needs a part for x, y and z")
    return [",".join(_clip_part(part) for part in value)]


def _planes(value: Any) -> list[str]:
    """One plane as four numbers, or several such."""
    several = not isinstance(value, str) and np.ndim(value) == 2
    words = _joined(",", (4,))
    return [":".join(words(plane)[0] for plane in value)] if several else words(value)


def _path(value: Any) -> list[str]:
    return [os.fspath(value) if isinstance(value, os.PathLike) else str(value)]


# What the command line calls a value: the Python types, and its words.
FORMS = {
    **dict.fromkeys(("FLOAT", "DEGREES", "RADII", "RMSE", "F", "OPACITY"), ("float", _one)),
    **dict.fromkeys(("INT", "UINT", "N", "T", "BYTES"), ("int", _one)),
    **dict.fromkeys(("NAME", "TYPE", "SIZE", "AXIS=PLACE|plane:NX,NY,NZ,D"), ("str", _text)),
    "N|NAME,...|all": ("int | str | Sequence[int | str]", _list),
    "SIDE": ("Literal['front', 'back', 'left', 'right', 'top', 'bottom']", _text),
    "WxH": ("int | tuple[int, int] | str", _joined("x", (1, 2))),
    "XxYxZ": ("float | Sequence[float] | str", _joined("x", (1, 3))),
    **dict.fromkeys(("LO:HI", "G0:G1"), ("tuple[float, float] | str", _joined(":", (2,)))),
    "COLOUR": ("str | tuple[float, float, float]", _joined(",", (3,))),
    "X0:X1,Y0:Y1,Z0:Z1": ("str | Sequence[slice | tuple[float | None, float | None] | None]", _clip),
    "NX,NY,NZ,D[:...]": ("str | Sequence[float] | Sequence[Sequence[float]]", _planes),
    "X Y Z": ("Sequence[float]", _numbers),
    "RIGHT DOWN": ("tuple[float, float]", _numbers),
    "M11 ... M34": ("ArrayLike", _numbers),
    "FILE[=LABELS]": ("str | os.PathLike[str]", _path),
    "NAME|FILE": ("str | os.PathLike[str] | dict[str, Any] | Sequence[Sequence[float]]", _path),
}


def annotation_of(form: str, values: int) -> str:
    """The Python type of an option's value, as text. Throws KeyError for a form that nobody has described."""
    if values == 0:
        return "bool"
    if form in FORMS:
        return FORMS[form][0]
    words = form.split("|")
    if all(re.fullmatch(r"\d+", word) for word in words):
        return f"Literal[{', '.join(words)}]"
    if all(re.fullmatch(r"[\d.]+", word) for word in words):
        return "float"
    if len(words) > 1 and all(re.fullmatch(r"[a-z0-9]+", word) for word in words):
        return f"Literal[{', '.join(map(repr, words))}]"
    raise KeyError(f"no Python type for an option's value {form!r}")


def words_of(form: str, value: Any) -> list[str]:
    """A value as words of a command line. Throws TypeError."""
    if form in FORMS:
        return FORMS[form][1](value)
    return _one(value) if isinstance(value, (float, np.floating)) else _text(value)
