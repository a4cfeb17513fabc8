#!/usr/bin/env python3
"""What ringsplat pyramid writes, read by zarr-python: read_pyramid.py FOLDER PROGRAM

FOLDER is make.py's, whose environment has the package. Exits with 77 where there is none.
"""
import os
import pathlib
import subprocess
import sys
import tempfile

folder, program = sys.argv[1:3]
venv = pathlib.Path(folder) / "venv"
if not (venv / "made").exists():
    sys.exit(77)
if pathlib.Path(sys.prefix) != venv:
    os.execv(venv / "bin/python", [str(venv / "bin/python"), "-B", *sys.argv])

import numpy as np  # noqa: E402
import zarr  # noqa: E402

for dtype in ("uint8", "int16", "float32", "float64"):
    with tempfile.TemporaryDirectory() as scratch:
        z, y, x = np.mgrid[0:70, 0:90, 0:150]
        volume = (50 + 40 * np.sin(x / 9) * np.cos(y / 11) + z / 4).astype(dtype)
        np.save(f"{scratch}/volume.npy", volume)
        subprocess.run([program, "pyramid", f"{scratch}/volume.npy", f"{scratch}/out.zarr", "--spacing", "1x2x3"],
                       check=True)
        store = zarr.open_group(f"{scratch}/out.zarr", mode="r")
        levels = store.attrs["multiscales"][0]["datasets"]
        assert [level["path"] for level in levels] == ["0", "1", "2"], levels
        assert levels[1]["coordinateTransformations"][0]["scale"] == [6, 4, 2], levels
        assert levels[1]["coordinateTransformations"][1]["translation"] == [1.5, 1, 0.5], levels
        assert store["0"].dtype == volume.dtype and np.array_equal(store["0"][:], volume)
        means = volume.reshape(35, 2, 45, 2, 75, 2).astype(float).mean((1, 3, 5))
        furthest = abs(store["1"][:].astype(float) - means).max()
        assert store["1"].shape == (35, 45, 75) and furthest < 1.6, furthest
        print(dtype, "largest difference of a half from means:", furthest)
