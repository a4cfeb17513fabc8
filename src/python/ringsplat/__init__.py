"""Volume rendering of NumPy arrays, xarray, files, and the blocks of MPI programs.

    import ringsplat as rs
    image = rs.render(volume, tf="mr-skin", azimuth=30)
    image.save("head.png")

render() makes one picture or several, Session draws a volume that lies in blocks, in one process or on the ranks of an
MPI communicator, and view() shows a volume in a notebook or a browser. Pictures have the bits of the program's.
"""

from . import _log  # first: what follows may log
from ._core import InputError, RunError, __version__
from ._image import Error, Image
from ._render import colour_maps, presets, render
from ._session import Session
from ._view import View, view

__all__ = [
    "Error",
    "Image",
    "InputError",
    "RunError",
    "Session",
    "View",
    "__version__",
    "colour_maps",
    "presets",
    "render",
    "view",
]

for _error in (InputError, RunError):
    _error.__module__ = __name__
