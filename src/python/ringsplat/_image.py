"""Pictures."""

from __future__ import annotations

import json
import os
from typing import Any, Callable, Optional

import numpy as np

from . import _core

Error = _core.MeasuredError
Error.__module__ = "ringsplat"


class Image:
    """A picture of a volume.

    numpy.asarray(image) is its array: float32, (height, width, 4), rows from the top; linear light red, green, blue,
    multiplied by the opacity, and the opacity. It is read-only, costs no copy, and has neither the background nor the
    annotations that were asked for: those are in srgb(), in files and in notebooks.
    """

    def __init__(self, picture: Any, measure: Optional[Callable[[Any, str, int, int], Error]]) -> None:
        self._picture = picture
        self._measure = measure

    @property
    def width(self) -> int:
        """In pixels."""
        return self._picture.width

    @property
    def height(self) -> int:
        """In pixels."""
        return self._picture.height

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of the array: (height, width, 4)."""
        return (self.height, self.width, 4)

    @property
    def dtype(self) -> np.dtype:
        """Of the array: float32."""
        return np.dtype(np.float32)

    @property
    def depth(self) -> Optional[np.ndarray]:
        """Of a picture with the option `depth`: float32, (height, width), in world lengths; infinite where nothing is."""
        depth = self._picture.depth()
        return depth if depth.size else None

    @property
    def seconds(self) -> float:
        """From when the picture was asked for to when it was drawn; without loading."""
        return self._picture.seconds

    @property
    def settings(self) -> dict[str, Any]:
        """All that decides the picture, as the program writes it into its files."""
        return json.loads(self._picture.settings)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> np.ndarray:
        return np.array(self._picture.pixels(), dtype, copy=copy)

    def srgb(self) -> np.ndarray:
        """For displays: uint8, (height, width, 4) with straight alpha, or (height, width, 3) over a background."""
        return np.frombuffer(self._picture.display(), np.uint8).reshape(self.height, self.width, -1)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a .png, .exr (linear float), .tif, .tga or .jpg (which needs a background), as the program does. An
        existing file is replaced when the new one is whole."""
        self._picture.save(os.fspath(path))

    def error(self, truth: Optional[str] = None, pixels: int = 4096, seed: int = 1) -> Error:
        """How far the picture is from the true one, in double precision, at a sample of its pixels.

        truth: "field" is what the interpolated volume looks like, "method" what the method would draw without
        roundings; without it the error that the options had measured, or against the method. `pixels` are evaluated,
        drawn by `seed`. The result has rms, its 95 % interval, max and mean, in 1/255. A volume in memory is read again
        and must still hold the same values.
        """
        if truth is None and self._picture.error is not None:
            return self._picture.error
        if self._measure is None:
            raise _core.InputError(
                "a session's picture has no volume here to be measured with; hint: render the whole "
                "volume with ringsplat.render"
            )
        return self._measure(self._picture, truth or "method", pixels, seed)

    def _repr_png_(self) -> bytes:
        return self._picture.png()

    def __repr__(self) -> str:
        return f"<ringsplat.Image {self.width} x {self.height}, {self.seconds:.3g} s>"
