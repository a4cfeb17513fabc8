"""Volumes from Python: paths, and arrays with a place in the world."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, Sequence

import numpy as np

from . import _core
from ._core import InputError

TYPES = ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64")
_UNEVEN = 1e-4  # of a step, by which coordinates may lie apart
_LARGEST = 2**31 - 1
_EXACT = 2**53  # whole numbers up to here are doubles
_AXES = {  # the usual names of their coordinates
    "x": ("x", "lon", "longitude"),
    "y": ("y", "lat", "latitude"),
    "z": ("z", "lev", "level", "height", "depth", "altitude"),
}


@dataclass
class Volume:
    """What a picture is drawn of. Keeps the array alive."""

    name: str
    array: np.ndarray | None = None  # [z, y, x], of one of TYPES in native byte order
    spacing: tuple[float, float, float] = (1.0, 1.0, 1.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    direction: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    unit: str = ""
    quantity: str = ""
    words: list[str] = field(default_factory=list)

    def core(self) -> Any:
        if self.array is None:
            return None
        z, y, x = self.array.shape
        return self.grid([x, y, z], self.array.dtype.name, address_of(self.array), strides_of(self.array))

    def grid(self, dims: list[int], dtype: str, address: int = 0, strides: Sequence[int] = (0, 0, 0)) -> Any:
        place = (self.spacing, self.origin, self.direction, self.unit, self.quantity)
        return _core.ArrayVolume(address, dims, strides, dtype, *place)


def address_of(array: np.ndarray) -> int:
    """Of the array's first element."""
    return array.__array_interface__["data"][0]


def strides_of(array: np.ndarray) -> list[int]:
    """In bytes, of x, y and z."""
    z, y, x = array.strides
    return [x, y, z]


def _whole_numbers(array: np.ndarray) -> np.ndarray:
    """Of 64 bits, as the smallest type that has them all."""
    low, high = int(array.min()), int(array.max())
    for name in ("int32", "uint32"):
        if np.iinfo(name).min <= low and high <= np.iinfo(name).max:
            return array.astype(name)
    if -_EXACT <= low and high <= _EXACT:
        return array.astype("float64")
    raise InputError(
        f"the array has whole numbers from {low} to {high}, more than a volume can hold exactly; hint: "
        "scale them, or convert them to float64 and lose their last digits"
    )


def _renderable(array: np.ndarray) -> np.ndarray:
    """The same values as one of TYPES in native byte order; a copy only where it must be."""
    kind, size = array.dtype.kind, array.dtype.itemsize
    if kind == "b":
        return array.view(np.uint8)
    array = array.astype(array.dtype.newbyteorder("="), copy=False)
    if kind == "f" and size == 2:
        return array.astype(np.float32)
    if kind == "f" and size > 8:
        double = array.astype(np.float64)
        if not np.array_equal(double.astype(array.dtype), array, equal_nan=True):
            raise InputError(f"the array's {array.dtype} numbers have more digits than float64; hint: convert it")
        return double
    return _whole_numbers(array) if kind in "iu" and size == 8 else array


def as_array(volume: Any) -> np.ndarray:
    """Three axes, [z, y, x], of one of TYPES. Throws InputError or TypeError."""
    if isinstance(volume, np.ma.MaskedArray):
        raise InputError(
            "the array is masked, and a volume has a value at every voxel; hint: pass "
            "array.filled(value), or array.astype(float).filled(numpy.nan)"
        )
    if not isinstance(volume, np.ndarray) and not hasattr(volume, "__array__") and hasattr(volume, "__dlpack__"):
        volume = np.from_dlpack(volume)
    array = np.asarray(volume)
    if array.dtype.kind not in "biuf":
        raise TypeError(
            f"a volume has numbers, not {array.dtype}"
            + ("; hint: take its .real, .imag or abs()" if array.dtype.kind == "c" else "")
        )
    if array.ndim == 2:
        array = array[np.newaxis]
    if array.ndim != 3:
        raise InputError(
            f"the array has the shape {array.shape}; hint: a volume has the axes [z, y, x]: take one "
            "time point or component, as in array[0] or array[..., 0]"
        )
    if array.size == 0 or max(array.shape) > _LARGEST:
        raise InputError(f"the array has the shape {array.shape}; hint: every axis must have a size from 1 to 2^31 - 1")
    return _renderable(array)


def three(values: Any, name: str) -> tuple[float, float, float]:
    """(x, y, z), or one number for all three."""
    numbers = np.asarray(values, dtype=float).ravel()
    if numbers.size not in (1, 3):
        raise TypeError(f"{name} needs one number or (x, y, z), not {values!r}")
    x, y, z = np.broadcast_to(numbers, 3).tolist()
    return (x, y, z)


def nine(values: Any) -> tuple[float, ...]:
    """A 3 x 3 matrix, row by row."""
    matrix = np.asarray(values, dtype=float)
    if matrix.shape != (3, 3):
        raise TypeError(f"direction needs 3 x 3 numbers, not the shape {matrix.shape}")
    return tuple(matrix.ravel().tolist())


def ascii_unit(unit: Any) -> str:
    """Units are in ASCII: micrometres are um."""
    return str(unit).replace("\u00b5", "u").replace("\u03bc", "u").encode("ascii", "ignore").decode()


def _axis_letter(data: Any, dim: Any) -> str:
    """x, y or z, where its name or the CF convention's attribute says so; else empty."""
    attribute = str(data.coords[dim].attrs.get("axis", "")).lower() if dim in data.coords else ""
    name = str(dim).lower()
    for letter, names in _AXES.items():
        if attribute == letter or (attribute not in _AXES and name in names):
            return letter
    return ""


def _step(data: Any, dim: Any) -> tuple[float, float]:
    """Spacing, negative where coordinates descend, and the first coordinate."""
    if dim not in data.coords:
        return 1.0, 0.0
    coordinate = data.coords[dim]
    if coordinate.dtype.kind not in "iuf":
        raise InputError(
            f"the coordinate {dim} has {coordinate.dtype} values, which are no places; hint: select one "
            f"with .isel({dim}=0), or give spacing="
        )
    places = np.asarray(coordinate.values, dtype=float)
    if places.size < 2:
        return 1.0, float(places[0])
    step = (places[-1] - places[0]) / (places.size - 1)
    even = places[0] + step * np.arange(places.size)
    if not (np.isfinite(step) and step != 0 and np.max(np.abs(places - even)) <= _UNEVEN * abs(step)):
        raise InputError(
            f"the coordinate {dim} is not evenly spaced; hint: interpolate onto even places with "
            f".interp({dim}=...), or give spacing= to take it as if it were"
        )
    return float(step), float(places[0])


def _from_xarray(data: Any, spacing: Any) -> Volume:
    if len(data.dims) not in (2, 3):
        raise InputError(
            f"the DataArray has the dimensions {tuple(data.dims)}; hint: a volume has three: select of the "
            "others with .isel(...)"
        )
    letters = {_axis_letter(data, dim): dim for dim in data.dims}
    if set(letters) == {"x", "y", "z"}:
        data = data.transpose(letters["z"], letters["y"], letters["x"])
    array = as_array(data.values)
    dims = list(data.dims)
    steps = [(1.0, 0.0)] * (3 - len(dims)) + [(1.0, 0.0) if spacing is not None else _step(data, dim) for dim in dims]
    array = array[tuple(slice(None, None, -1 if step < 0 else 1) for step, _ in steps)]
    lengths = array.shape
    origin = [first + min(step, 0.0) * (length - 1) for (step, first), length in zip(steps, lengths)]
    units = {
        str(data.coords[dim].attrs["units"]) for dim in dims if dim in data.coords and "units" in data.coords[dim].attrs
    }
    name = str(data.attrs.get("long_name", data.name or ""))
    of_values = str(data.attrs.get("units", ""))
    quantity = f"{name} ({of_values})" if name and of_values else name or of_values
    return Volume(
        str(data.name or "array"),
        array,
        three([abs(step) for step, _ in reversed(steps)], "spacing"),
        three(origin[::-1], "origin"),
        unit=ascii_unit(units.pop()) if len(units) == 1 else "",
        quantity=quantity,
    )


def volume_of(volume: Any, spacing: Any, origin: Any, direction: Any, unit: Any) -> Volume:
    """Throws InputError and TypeError for what is no volume."""
    if isinstance(volume, (str, os.PathLike)):
        for name, given in (("origin", origin), ("direction", direction), ("unit", unit)):
            if given is not None:
                raise TypeError(f"{name} is for arrays: a file says it itself")
        if "\0" in os.fspath(volume):
            raise InputError("the path has a NUL character; hint: check it")
        words = [] if spacing is None else ["--spacing=" + "x".join(repr(one) for one in three(spacing, "spacing"))]
        return Volume(os.fspath(volume), words=words)
    if all(hasattr(volume, name) for name in ("dims", "coords", "attrs")):  # xarray's
        if not hasattr(volume, "values") or callable(volume.values):
            raise TypeError("a Dataset has several arrays; hint: take one of them, as in dataset['temperature']")
        made = _from_xarray(volume, spacing)
    else:
        made = Volume("array", as_array(volume))
    if spacing is not None:
        made.spacing = three(spacing, "spacing")
    if origin is not None:
        made.origin = three(origin, "origin")
    if direction is not None:
        made.direction = nine(direction)
    if unit is not None:
        made.unit = ascii_unit(unit)
    return made
