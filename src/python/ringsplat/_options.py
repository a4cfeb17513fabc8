"""The types of a picture's options, for editors and type checkers. Written by scripts/python_options.py."""
from __future__ import annotations

import os
from typing import Any, Literal, Sequence, TypedDict

from numpy.typing import ArrayLike


class PictureOptions(TypedDict, total=False):
    """Options of render(); a session's picture has all but those of files, errors and threads."""

    frame: int
    channel: int | str | Sequence[int | str]
    series: str
    memory: str
    mask: str | os.PathLike[str]
    dims: float | Sequence[float] | str
    type: str
    endian: Literal['little', 'big']
    offset: int
    clip: str | Sequence[slice | tuple[float | None, float | None] | None]
    slice: str
    background: str | tuple[float, float, float]
    annotate: bool
    view: Literal['front', 'back', 'left', 'right', 'top', 'bottom']
    azimuth: float | Sequence[float]
    elevation: float | Sequence[float]
    roll: float | Sequence[float]
    zoom: float | Sequence[float]
    fit: Literal['box', 'sphere']
    matrix: ArrayLike
    pan: tuple[float, float]
    projection: Literal['orthographic', 'perspective']
    fov: float
    distance: float
    eye: Sequence[float]
    target: Sequence[float]
    up: Sequence[float]
    size: int | tuple[int, int] | str
    no_opacity_correction: bool
    light: Sequence[float]
    tf: str | os.PathLike[str] | dict[str, Any] | Sequence[Sequence[float]]
    range: tuple[float, float] | str
    opacity: float
    colours: str
    log: bool
    labels: bool
    mode: Literal['composite', 'mip', 'minip', 'mean', 'sum', 'surface']
    isovalue: float
    interpolation: Literal['linear', 'nearest']
    quality: Literal['paper', 'draft', 'normal', 'best']
    engine: Literal['splats', 'sheets']
    slabs: Literal[1, 2, 3, 4]
    light_points: Literal[1, 2]
    shading: Literal['phong', 'none']
    ambient: float
    diffuse: float
    specular: float
    exponent: float
    values: bool
    radius: float
    kernel: Literal['qee', 'texture']
    phases: int
    qee_bits: int
    normalisation: Literal['none', 'constant', 'exact']
    region: int
    undersample: Literal[1, 2, 4]
    prefilter: bool
    image_plane: Literal['screen', 'slices']
    samples: float
    opaque_threshold: float
    payload: Literal['runs', 'words']
    precision: Literal['float', 'half', 'u8']
    error: Literal['method', 'field']
    error_pixels: int
    error_seed: int
    max_error: float
    threads_per_rank: int
