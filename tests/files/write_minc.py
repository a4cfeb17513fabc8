"""MINC 2 by h5py, laid out as libminc does; nibabel says which values and places are in it."""
import h5py
import nibabel
import numpy as np
from cases import FOLDER, case, voxels

ANGLE = np.radians(20)
COSINES = {"xspace": [np.cos(ANGLE), np.sin(ANGLE), 0], "yspace": [-np.sin(ANGLE), np.cos(ANGLE), 0],
           "zspace": [0, 0, 1]}
STARTS = {"xspace": 10.0, "yspace": -20.0, "zspace": 30.0}
STEPS = {"xspace": 0.5, "yspace": -2.0, "zspace": 3.0}
TO_LPS = np.array([-1, -1, 1])


def write(file, order, stored, low, high, valid_range):
    """`low` and `high`: the real values of the valid range's ends, for the first dimensions or for all."""
    with h5py.File(FOLDER / file, "w") as out:
        for name, size in zip(order, stored.shape):
            dimension = out.create_dataset(f"minc-2.0/dimensions/{name}", data=np.int32(0))
            dimension.attrs["length"] = np.uint32(size)
            dimension.attrs["spacing"] = np.bytes_("regular__")
            if name in STEPS:
                dimension.attrs["step"], dimension.attrs["start"] = STEPS[name], STARTS[name]
                dimension.attrs["direction_cosines"] = np.array(COSINES[name])
                dimension.attrs["units"] = np.bytes_("mm")
        group = out.create_group("minc-2.0/image/0")
        image = group.create_dataset("image", data=stored, chunks=tuple(max(1, n // 2) for n in stored.shape))
        image.attrs["dimorder"] = np.bytes_(",".join(order))
        image.attrs["valid_range"] = np.array(valid_range, dtype="float64")
        image.attrs["complete"] = np.bytes_("true_")
        for name, values in (("image-min", low), ("image-max", high)):
            made = group.create_dataset(name, data=np.asarray(values, dtype="float64"))
            if np.ndim(values):
                made.attrs["dimorder"] = np.bytes_(",".join(order[: np.ndim(values)]))


def said(name, dtype="float32", frame=None):
    image = nibabel.load(FOLDER / f"{name}.mnc")
    data = np.asarray(image.dataobj)
    if frame is not None:
        data = data[frame]
    # nibabel's affine takes indices in the order of the file, whose last is the lattice's x.
    columns = image.affine[:3, 2::-1] * TO_LPS[:, None]
    lengths = np.linalg.norm(columns, axis=0)
    case(name if frame is None else f"{name}_{frame}", f"{name}.mnc", data.astype(dtype), frame=frame,
         spacing=list(lengths), origin=list(image.affine[:3, 3] * TO_LPS),
         direction=[list(column) for column in (columns / lengths).T], unit="mm", world="patient",
         frames=1 if frame is None else 3)


ZYX = ("zspace", "yspace", "xspace")
volume = voxels("int16")
slices = np.arange(volume.shape[0])
for order in (ZYX, ("yspace", "xspace", "zspace")):
    write(f"minc_{order[0]}.mnc", order, volume, -1.0 - slices, 10.0 + 3 * slices, (-200, 200))
    said(f"minc_{order[0]}")
write("minc_one_scale.mnc", ZYX, volume, 5.0, 6.0, (-32768, 32767))
said("minc_one_scale")
write("minc_as_stored.mnc", ZYX, voxels("uint8"), 0.0, 255.0, (0, 255))
said("minc_as_stored", "uint8")
write("minc_float.mnc", ZYX, voxels("float32"), -40.0 - slices, 60.0 + slices, (-40, 60))
said("minc_float")
series = np.stack([voxels("int16", seed=n) for n in (1, 2, 3)])
scales = np.arange(3)[:, None] * 10.0 + slices
write("minc_time.mnc", ("time", *ZYX), series, -scales, 100 + scales, (-200, 200))
said("minc_time", frame=0)
said("minc_time", frame=2)
