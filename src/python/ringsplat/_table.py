"""The command line's options of a picture, as Python's: names, types, words."""

from __future__ import annotations

import contextlib
import inspect
import json
import os
import tempfile
from dataclasses import dataclass
from typing import Any, Iterator, Mapping

import numpy as np

from . import _core
from ._forms import annotation_of, words_of

# Several of them make several pictures.
ANGLES = ("azimuth", "elevation", "roll", "zoom")


@dataclass(frozen=True)
class Option:
    name: str  # with underscores
    form: str  # the command line's
    default: str
    help: str
    group: str
    values: int  # words that follow the name
    session: bool  # a session has it, too

    @property
    def flag(self) -> str:
        return "--" + self.name.replace("_", "-")

    @property
    def annotation(self) -> str:
        one = annotation_of(self.form, self.values)
        return f"{one} | Sequence[float]" if self.name in ANGLES else one


OPTIONS: dict[str, Option] = {}
for _entry in json.loads(_core.picture_options_json()):
    _name = _entry["name"].replace("-", "_")
    OPTIONS[_name] = Option(**{**_entry, "name": _name})


def options_for(session: bool) -> list[Option]:
    """Those that a picture of a volume, or of a session, has; spacing is an argument of its own in Python."""
    return [o for o in OPTIONS.values() if o.name != "spacing" and (o.session or not session)]


def document(function: Any, session: bool) -> None:
    """Adds all options to a function's docstring, below the command line's headings, and to its signature in place of
    **options."""
    groups: dict[str, list[str]] = {}
    for option in options_for(session):
        default = f" [{option.default}]" if option.default else ""
        groups.setdefault(option.group, []).append(
            f"    {option.name} : {option.annotation}{default}\n        {option.help}."
        )
    described = "\n\n".join(f"{group}\n" + "\n".join(lines) for group, lines in groups.items())
    function.__doc__ = inspect.cleandoc(function.__doc__) + "\n\n" + described + "\n"
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
    more = [
        inspect.Parameter(o.name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=o.annotation)
        for o in options_for(session)
    ]
    function.__signature__ = signature.replace(parameters=own + more)


def _views_of(options: dict[str, Any]) -> tuple[dict[str, Any], list[list[float | None]] | None]:
    """Takes lists of angles out of the options: one entry a view, or None where there is but one."""
    lists = {name: np.asarray(options[name], dtype=float) for name in ANGLES if np.ndim(options.get(name, 0)) > 0}
    if not lists:
        return options, None
    counts = {values.size for values in lists.values()}
    if len(counts) != 1 or any(values.ndim != 1 for values in lists.values()):
        sizes = ", ".join(f"{name} {values.shape}" for name, values in lists.items())
        raise TypeError(f"lists of angles must have one length, not {sizes}")
    count = counts.pop()
    if count == 0:
        raise TypeError("a list of angles is empty: no picture was asked for")
    views = [[float(lists[name][k]) if name in lists else None for name in ANGLES] for k in range(count)]
    first = {name: float(values[0]) for name, values in lists.items()}
    return {**options, **first}, views


def _paraview(points: Any) -> Any:
    """ParaView's JSON of a transfer function; `points` are such JSON or rows (value, red, green, blue, opacity)."""
    if isinstance(points, (dict, list)) and (isinstance(points, dict) or (points and isinstance(points[0], dict))):
        return points if isinstance(points, list) else [points]
    rows = np.asarray(points, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != 5:
        raise TypeError("tf needs a name, a file, ParaView's JSON, or rows of (value, red, green, blue, opacity)")
    return [
        {
            "Name": "python",
            "ColorSpace": "RGB",
            "RGBPoints": rows[:, :4].ravel().tolist(),
            "Points": [number for value, *_, opacity in rows.tolist() for number in (value, opacity, 0.5, 0.0)],
        }
    ]


@contextlib.contextmanager
def _with_tf_file(options: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Puts a transfer function that is neither name nor path into a file for as long as it is read."""
    tf = options.get("tf")
    if tf is None or isinstance(tf, (str, os.PathLike)):
        yield options
        return
    with tempfile.NamedTemporaryFile("w", prefix="ringsplat-", suffix=".json") as file:
        json.dump(_paraview(tf), file)
        file.flush()
        yield {**options, "tf": file.name}


def _words(options: dict[str, Any]) -> list[str]:
    words = []
    for name, value in options.items():
        option = OPTIONS[name]
        if option.values == 0:
            words += [option.flag] if value else []
            continue
        try:
            first, *rest = words_of(option.form, value)
        except (TypeError, ValueError) as error:
            raise TypeError(f"{name}={value!r}: {error}") from None
        words += [f"{option.flag}={first}", *rest]
    return words


@contextlib.contextmanager
def command_line(options: Mapping[str, Any], session: bool = False) -> Iterator[tuple[list[str], Any]]:
    """Words of a command line that say the same as the options, and the views (None: one). TypeError for an unknown
    option or a value of another type."""
    known = [option.name for option in options_for(session)]
    for name in options:
        if name not in known:
            hint = _core.likely_option(name, known) or "help(ringsplat.render) lists the options"
            what = "a session's picture" if session else "a picture"
            raise TypeError(f"{name} is no option of {what}; {hint}")
    with _with_tf_file(options) as plain:
        one, views = _views_of({name: value for name, value in plain.items() if value is not None})
        yield _words(one), views
