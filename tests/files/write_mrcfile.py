"""MRC by mrcfile: modes, axes, cells, stacks, extended headers; some fields as other programs write them."""
import gzip

import mrcfile
import numpy as np
from cases import FOLDER, case, voxels


def save(name, volume, expected=None, change=None, patch=None, **wanted):
    path = FOLDER / f"{name}.mrc"
    with mrcfile.new(path, overwrite=True) as file:
        file.set_data(volume)
        file.voxel_size = (1.5, 2.0, 2.5)
        if change:
            change(file)
    if patch:
        data = bytearray(path.read_bytes())
        patch(data)
        path.write_bytes(data)
    case(name, path.name, volume if expected is None else expected, **{"world": "lattice", "unit": "angstrom", "spacing": [1.5, 2, 2.5],
                                                                       "origin": [0, 0, 0], **wanted})


def fields(**values):
    def change(file):
        for name, value in values.items():
            file.header[name] = value
    return change


for kind in ("int8", "int16", "uint16", "float32"):
    save(f"mrc_{kind}", voxels(kind), frames=1, channels=1)
halves = voxels("float16")
save("mrc_float16", halves, halves.astype("float32"))
plain = voxels("int16")
save("mrc_big_endian", plain.astype(">i2"), plain)


def stamp(first):
    def patch(data):
        data[212:216] = bytes([first, first, 0, 0])
    return patch


save("mrc_no_stamp", plain, patch=stamp(0))
save("mrc_no_stamp_big", plain.astype(">i2"), plain, patch=stamp(0))
save("mrc_extended", plain, change=lambda file: file.set_extended_header(np.frombuffer(b"more" * 40, "V1")))
save("mrc_of_origin", plain, change=fields(origin=(10, 20, 30)), origin=[10, 20, 30])
save("mrc_of_start", plain, change=fields(nxstart=2, nystart=-3, nzstart=4), origin=[3, -6, 10])


def turned(file):
    # Columns along z, rows along x, sections along y; the cell's sizes stay those of x, y, z.
    file.header.mapc, file.header.mapr, file.header.maps = 3, 1, 2
    file.header.mx, file.header.my, file.header.mz = 5, 6, 7
    file.header.cella = (5 * 1.5, 6 * 2.0, 7 * 2.5)
    file.header.nxstart = 2


save("mrc_turned", plain, change=turned, spacing=[2.5, 1.5, 2], direction=[[0, 0, 1], [1, 0, 0], [0, 1, 0]], origin=[0, 0, 5])
save("mrc_sheared", plain, change=fields(cellb=(90, 90, 120)),
     direction=[[1, 0, 0], [-0.5, np.sqrt(0.75), 0], [0, 0, 1]])
save("mrc_unsized", plain, change=fields(cella=(0, 0, 0)), spacing=[1, 1, 1], unit="")
save("mrc_imod", voxels("int8"), voxels("int8").view("uint8"),
     patch=lambda data: data.__setitem__(slice(152, 160), b"IMOD\0\0\0\0"))
stack = np.stack([voxels("float32", seed=seed) for seed in (1, 2, 3)])
save("mrc_stack", stack, stack[1], frame=1, frames=3)
(FOLDER / "mrc_gzip.map.gz").write_bytes(gzip.compress((FOLDER / "mrc_float32.mrc").read_bytes()))
case("mrc_gzip", "mrc_gzip.map.gz", voxels("float32"), spacing=[1.5, 2, 2.5], unit="angstrom")
