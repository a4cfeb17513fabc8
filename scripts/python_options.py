#!/usr/bin/env python3
"""Prints src/python/ringsplat/_options.py, the types of the picture's options for editors, from the program's table.

PYTHONPATH=build/release/python python3 scripts/python_options.py > src/python/ringsplat/_options.py
"""

from ringsplat._table import options_for

HEAD = '''"""The types of a picture's options, for editors and type checkers. Written by scripts/python_options.py."""
from __future__ import annotations

import os
from typing import Any, Literal, Sequence, TypedDict

from numpy.typing import ArrayLike


class PictureOptions(TypedDict, total=False):
    """Options of render(); a session's picture has all but those of files, errors and threads."""

'''


def text() -> str:
    return HEAD + "\n".join(f"    {option.name}: {option.annotation}" for option in options_for(session=False)) + "\n"


if __name__ == "__main__":
    print(text(), end="")
