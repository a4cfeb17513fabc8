"""Pictures of whole volumes, and names that their options know."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _core, _progress
from ._image import Image
from ._table import command_line, document
from ._volume import volume_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import PictureOptions


def render(
    volume: Any,
    *,
    spacing: Any = None,
    origin: Any = None,
    direction: Any = None,
    unit: Any = None,
    progress: bool = False,
    **options: "Unpack[PictureOptions]",
) -> "Image | list[Image]":
    """Renders a volume in this process; the picture has the bits of the program's for the same volume in a file.

    volume : array, xarray.DataArray or path
        An array [z, y, x] of any strides, of bool, whole or floating-point numbers. Of a DataArray the coordinates say
        spacing and origin, its attributes units and names. A path is read as the program reads it: NRRD, MetaImage,
        NIfTI, DICOM, TIFF, VTK, HDF5 ("file.h5:/dataset"), Zarr, MRC, NumPy, raw.
    spacing : float or (x, y, z)
        Distances between voxels; 1 for arrays. For a path, instead of the file's.
    origin : (x, y, z)
        World position of voxel [0, 0, 0] of an array.
    direction : 3 x 3 numbers
        World directions of an array's axes x, y, z, in columns.
    unit : str
        Of an array's spacing, such as "mm", for annotations.
    progress : bool
        Shows bars by tqdm where it is installed.

    All others are options of `ringsplat render`; what is in brackets is taken without them. With a list of angles
    (azimuth, elevation, roll, zoom) as many pictures are returned, fitted alike as those of --path.

    Long work lets other threads run, and ends at Ctrl-C. Raises InputError for a volume that cannot be read or options
    that contradict each other, RunError where something fails while running.
    """
    source = volume_of(volume, spacing, origin, direction, unit)
    with command_line(options) as (words, views), _progress.told(progress) as told:
        words = source.words + words
        pictures = _core.render(words, views or [], source.core(), source.name, told)

    def measure(picture: Any, truth: str, pixels: int, seed: int) -> Any:
        return _core.measure(picture, words, source.core(), source.name, truth, pixels, seed)

    images = [Image(picture, measure) for picture in pictures]
    return images if views is not None else images[0]


def presets() -> dict[str, str]:
    """Transfer functions that `tf` knows by name, and what each is for."""
    return dict(_core.presets())


def colour_maps() -> dict[str, str]:
    """Colour maps that `colours` knows by name, and what each is for."""
    return dict(_core.colour_maps())


document(render, session=False)
