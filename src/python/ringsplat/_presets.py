"""Names that options know."""

from __future__ import annotations

from . import _core


def presets() -> dict[str, str]:
    """Transfer functions that `tf` knows by name, and what each is for."""
    return dict(_core.presets())


def colour_maps() -> dict[str, str]:
    """Colour maps that `colours` knows by name, and what each is for."""
    return dict(_core.colour_maps())
