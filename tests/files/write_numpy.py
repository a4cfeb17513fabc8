"""NumPy: raw files, which test the comparison itself, and .npy."""
import numpy as np
from cases import FOLDER, case, voxels

for dtype in ("uint8", "int16", "float32"):
    volume = voxels(dtype)
    name = f"numpy_7x5x6_{dtype}.raw"
    volume.tofile(FOLDER / name)
    case(f"numpy_raw_{dtype}", name, volume, spacing=[1, 1, 1], world="lattice", frames=1, channels=1)


def save(name, array, **wanted):
    np.save(FOLDER / f"{name}.npy", array)
    case(name, f"{name}.npy", **wanted)


PLACE = {"spacing": [1, 1, 1], "origin": [0, 0, 0], "world": "lattice"}
for dtype in ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"):
    volume = voxels(dtype)
    save(f"numpy_{dtype}", volume, expected=volume, frames=1, channels=1, **PLACE)
    save(f"numpy_{dtype}_big", volume.astype(volume.dtype.newbyteorder(">")), expected=volume)
    save(f"numpy_{dtype}_fortran", np.asfortranarray(volume), expected=volume.T,
         direction=[[0, 0, 1], [0, 1, 0], [1, 0, 0]], **PLACE)
volume = voxels("float16")
save("numpy_float16", volume, expected=volume.astype("float32"))
mask = voxels() > 100
save("numpy_bool", mask, expected=mask.astype("uint8"))

series = np.stack([voxels("int16", seed=n) for n in (1, 2, 3)])
save("numpy_first", series, expected=series[0], frames=3, **PLACE)
save("numpy_last", series, expected=series[2], frame=2, frames=3, **PLACE)
vectors = np.stack([voxels("float32", seed=n) for n in (1, 2)], axis=-1)
save("numpy_component", vectors, expected=vectors[..., 1], channel="1", channels=2, **PLACE)
