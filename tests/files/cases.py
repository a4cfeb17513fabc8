"""What the writers share: a case is a file that a library wrote and the voxels that must come out of it."""
import json
import pathlib
import sys

import numpy as np

FOLDER = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(".")


def voxels(dtype=np.uint8, shape=(6, 5, 7), seed=1):
    """A volume a[z, y, x] in which no two neighbours are alike and no axis can be mistaken for another."""
    z, y, x = np.indices(shape)
    values = (17 * x + 5 * y * y + 3 * z * (x + 1) + seed) % 251
    if np.issubdtype(dtype, np.floating):
        return (values * 0.37 - 40).astype(dtype)
    if np.issubdtype(dtype, np.signedinteger):
        return (values - 120).astype(dtype)
    return values.astype(dtype)


def case(name, file, expected, *, spacing=None, origin=None, direction=None, unit=None, world=None, frames=None,
         channels=None, of_channels=None, frame=None, channel=None, series=None, part=""):
    """Says that `file` (below FOLDER; `part` is added behind a colon) holds `expected[z, y, x]`.

    Lengths are in `unit`, in the order x, y, z; `direction` lists the world directions of the lattice's x, y and z.
    What is None is not compared. `of_channels`: of each channel name, colour, window, hidden. `frame`, `channel` and `series` are the choices to open it with.
    """
    expected = np.ascontiguousarray(expected)
    assert expected.ndim == 3, name
    (FOLDER / f"{name}.expected").write_bytes(expected.astype(expected.dtype.newbyteorder("<")).tobytes())
    wanted = {
        "file": str(file) + (":" + part if part else ""),
        "voxels": f"{name}.expected",
        "type": expected.dtype.name,
        "dims": list(expected.shape[::-1]),
        "spacing": spacing,
        "origin": origin,
        "direction": direction,
        "unit": unit,
        "world": world,
        "frames": frames,
        "channels": channels,
        "of_channels": of_channels,
        "frame": frame,
        "channel": channel,
        "series": series,
    }
    text = json.dumps({key: value for key, value in wanted.items() if value is not None}, default=float)
    (FOLDER / f"{name}.json").write_text(text)
