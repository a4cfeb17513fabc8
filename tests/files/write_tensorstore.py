"""N5 by TensorStore: types, compression, sizes that no block divides, missing blocks, steps and units."""
import json

import numpy as np
import tensorstore
from cases import FOLDER, case, voxels

SHAPE, BLOCK = (9, 7, 5), (2, 3, 4)  # z, y, x; x, y, z
PLACE = {"spacing": [1, 1, 1], "origin": [0, 0, 0], "world": "lattice", "unit": ""}


def save(name, volume, block=BLOCK, compression={"type": "raw"}, expected=None, attributes={}, path=None, opened=None,
         **wanted):
    """TensorStore's axes are N5's: the fastest comes first."""
    store = tensorstore.open({
        "driver": "n5", "kvstore": {"driver": "file", "path": str(FOLDER / (path or name))}, "create": True,
        "metadata": {"dimensions": volume.shape[::-1], "blockSize": block, "dataType": volume.dtype.name,
                     "compression": compression, **attributes}}).result()
    store[...].write(volume.T).result()
    case(name, opened or name, volume if expected is None else expected, **{**PLACE, **wanted})


for dtype in ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"):
    save(f"n5_{dtype}", voxels(dtype, SHAPE), frames=1, channels=1)
wide = voxels("int64", SHAPE) * 10**12
save("n5_int64", wide, expected=wide.astype("float64"))
plain = voxels("uint16", SHAPE)
for kind, how in (("gzip", {"type": "gzip", "level": 5}), ("zlib", {"type": "gzip", "useZlib": True}), ("zstd", {"type": "zstd"}),
                  ("xz", {"type": "xz"}), ("blosc", {"type": "blosc", "cname": "lz4", "clevel": 5, "shuffle": 1})):
    save(f"n5_{kind}", plain, compression=how)
save("n5_one_block", plain, block=SHAPE[::-1])
save("n5_wide_block", plain, block=(16, 16, 16))
save("n5_steps", plain, attributes={"resolution": [4, 5, 40], "units": ["nm", "nm", "nm"]}, spacing=[0.004, 0.005, 0.04],
     unit="um")
save("n5_pixels", plain, attributes={"pixelResolution": {"unit": "um", "dimensions": [0.5, 2, 3.25]}},
     spacing=[0.5, 2, 3.25], unit="um")
film = np.stack([voxels("uint16", SHAPE, seed) for seed in range(3)])
save("n5_film", film, block=(*BLOCK, 2), expected=film[2], frame=2, frames=3)
save("n5_channels", np.moveaxis(film, 0, 1), block=(2, 3, 2, 4), attributes={"axes": ["x", "y", "c", "z"]},
     expected=film[1], channel="1", channels=3)
gaps = voxels("uint16", SHAPE)
gaps[:4, :3, :2] = 0
save("n5_gaps", gaps)
assert not (FOLDER / "n5_gaps/0/0/0").exists() and (FOLDER / "n5_gaps/1/0/0").exists()

# The only array of a group.
(FOLDER / "group.n5").mkdir()
(FOLDER / "group.n5/attributes.json").write_text(json.dumps({"n5": "2.5.1"}))
save("n5_group", plain, path="group.n5/raw", opened="group.n5")

# Blocks that are whole where the array ends, by hand.
folder = FOLDER / "n5_whole_blocks"
folder.mkdir()
(folder / "attributes.json").write_text(json.dumps({
    "dimensions": [5, 7, 9], "blockSize": [4, 7, 9], "dataType": "uint16", "compression": {"type": "raw"}}))
for x in (0, 1):
    block = np.zeros((9, 7, 4), ">u2")
    part = plain[..., 4 * x:4 * x + 4]
    block[..., :part.shape[2]] = part
    file = folder / str(x) / "0/0"
    file.parent.mkdir(parents=True)
    file.write_bytes(np.array([0, 3], ">u2").tobytes() + np.array([4, 7, 9], ">u4").tobytes() + block.tobytes())
case("n5_whole_blocks", "n5_whole_blocks", plain, **PLACE)
