"""HDF5 by h5py: layouts, filters, types, axes; and VTKHDF's ImageData, whose files h5py writes as VTK's text says."""
import h5py
import numpy as np

from cases import FOLDER, case, voxels

SHAPE = (12, 9, 10)  # z, y, x


def dataset(name, volume, expected=None, *, attributes=None, labels=None, more=None, **keywords):
    """One file with the dataset /scan/volume, and its case."""
    with h5py.File(FOLDER / f"{name}.h5", "w") as file:
        made = file.create_dataset("scan/volume", data=volume, **keywords)
        for key, value in (attributes or {}).items():
            made.attrs[key] = value
        for k, label in enumerate(labels or ""):
            made.dims[k].label = label
    case(f"h5py_{name}", f"{name}.h5", volume if expected is None else expected, **(more or {}))


for kind in ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"):
    dataset(kind, voxels(kind, SHAPE), chunks=(5, 4, 3), compression="gzip", shuffle=True,
            more={"spacing": [1, 1, 1], "world": "lattice", "frames": 1, "channels": 1})
plain = voxels("int16", SHAPE)
dataset("contiguous", plain)
dataset("big_endian", plain.astype(">i2"), plain, chunks=(5, 4, 3))
dataset("fletcher", plain, chunks=(4, 4, 4), fletcher32=True)
dataset("scale_offset", plain, chunks=(4, 4, 4), scaleoffset=0)
dataset("older", plain, chunks=(12, 9, 10), maxshape=(None, None, None))
dataset("half", voxels("float32", SHAPE).astype("float16"), voxels("float32", SHAPE).astype("float16").astype("float32"))
wide = voxels("int64", SHAPE) * 10**12
dataset("int64", wide, wide.astype("float64"), chunks=(5, 4, 3))
dataset("bool", plain > 0, (plain > 0).astype("int8"), chunks=(5, 4, 3))
dataset("long_chunk", plain, chunks=(12, 3, 3), compression="gzip")
dataset("flat", plain[0], plain[:1])
dataset("micrometres", plain, attributes={"element_size_um": [2.0, 0.5, 0.25]},
        more={"spacing": [0.25, 0.5, 2], "unit": "um", "world": "microscope"})

film = np.stack([voxels("uint16", SHAPE, seed) for seed in range(3)])
dataset("film", film, film[0], more={"frames": 3}, chunks=(1, 5, 9, 10), compression="gzip")
dataset("film_2", film, film[2], more={"frames": 3, "frame": 2})
dataset("labelled", np.moveaxis(film, 0, 1), film[1], labels=["z", "t", "y", "x"], more={"frames": 3, "frame": 1})
vectors = np.stack([voxels("float32", SHAPE, seed) for seed in range(3)], axis=-1)
dataset("vectors", vectors, vectors[..., 1], more={"channels": 3, "channel": "1"})
colours = np.stack([voxels("uint8", SHAPE, 30 * seed) for seed in range(3)], axis=-1)
dataset("colours", colours, colours[..., 2], more={"channels": 3, "channel": "b"}, chunks=(5, 4, 3, 3))

with h5py.File(FOLDER / "several.h5", "w") as file:
    file["a/low"] = plain
    file["a/high"] = film[0]
case("h5py_several", "several.h5", film[0], part="/a/high")
case("h5py_relative", "several.h5", plain, part="a/low")

with h5py.File(FOLDER / "latest.h5", "w", libver="latest") as file:
    file.create_dataset("v", data=plain, chunks=(5, 4, 3), compression="gzip", maxshape=(None, 9, 10))
case("h5py_latest", "latest.h5", plain)


def vtkhdf(name, points=None, cells=None, steps=0, **more):
    """VTK's file formats, "VTKHDF", ImageData."""
    with h5py.File(FOLDER / f"{name}.vtkhdf", "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", b"ImageData", dtype=h5py.string_dtype("ascii", 9))
        nz, ny, nx = SHAPE
        end = 0 if cells is None else 1
        root.attrs["WholeExtent"] = (2, 1 + nx + end, 0, ny - 1 + end, 0, nz - 1 + end)
        root.attrs["Origin"] = (10.0, 20.0, 30.0)
        root.attrs["Spacing"] = (1.0, 2.0, 3.0)
        # Row by row: the lattice's x is the world's y.
        root.attrs["Direction"] = (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        for group, data in (("PointData", points), ("CellData", cells)):
            if data is not None:
                root.create_group(group).create_dataset("density", data=data, chunks=True)
        if steps:
            root.create_group("Steps").attrs["NSteps"] = steps
    case(f"vtkhdf_{name}", f"{name}.vtkhdf", **more)


turned = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
vtkhdf("points", points=plain, expected=plain, spacing=[1, 2, 3], origin=[10, 22, 30], direction=turned)
# The cells' middles: half a spacing along every axis of the lattice.
vtkhdf("cells", cells=plain, expected=plain, spacing=[1, 2, 3], origin=[9, 22.5, 31.5], direction=turned)
vtkhdf("steps", points=film, steps=3, expected=film[1], frame=1, frames=3, origin=[10, 22, 30])
vtkhdf("vectors", points=vectors, expected=vectors[..., 2], channel="2", channels=3)
