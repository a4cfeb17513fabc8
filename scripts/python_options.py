#!/usr/bin/env python3
"""Writes the package's _options.py, the types of the picture's options for editors, from the program's table, as the build
does: PYTHONPATH=build/release/python python3 scripts/python_options.py FILE
"""

import pathlib
import sys

from ringsplat._table import options_for

HEAD = '''"""The types of a picture's options, for editors and type checkers. Written by scripts/python_options.py."""
from __future__ import annotations

import os
from typing import Any, Literal, Sequence, TypedDict

from numpy.typing import ArrayLike


class PictureOptions(TypedDict, total=False):
    """Options of render(); a session's picture has all but those of files, errors and threads."""

'''

if __name__ == "__main__":
    lines = [f"    {option.name}: {option.annotation}\n" for option in options_for(session=False)]
    pathlib.Path(sys.argv[1]).write_text(HEAD + "".join(lines))
