"""Zarr 2 and 3 by zarr-python, with the metadata of OME-Zarr 0.4 and 0.5 as ome-zarr-py writes them."""
import json

import numcodecs
import numpy as np
import zarr
from cases import FOLDER, case, voxels
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, GzipCodec, ShardingCodec, TransposeCodec, ZstdCodec

SHAPE, CHUNK = (9, 7, 5), (4, 3, 2)  # z, y, x
PLACE = {"spacing": [1, 1, 1], "origin": [0, 0, 0], "world": "lattice"}
AXES = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]


def write(name, volume, *, chunks=CHUNK, version=3, **how):
    made = zarr.create_array(str(FOLDER / f"{name}.zarr"), shape=volume.shape, dtype=volume.dtype, chunks=chunks,
                             zarr_format=version, **how)
    made[...] = volume
    return made


def array(name, volume, expected=None, *, more=PLACE, **how):
    write(name, volume, **how)
    case(name, f"{name}.zarr", volume if expected is None else expected, **more)


def edit(path, change):
    text = json.loads(path.read_text())
    change(text)
    path.write_text(json.dumps(text))


plain = voxels("uint16", SHAPE)
for kind in ("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"):
    array(f"zarr2_{kind}", voxels(kind, SHAPE), version=2, compressors=numcodecs.Blosc(shuffle=1))
    array(f"zarr3_{kind}", voxels(kind, SHAPE))
for version in (2, 3):
    halves, wide = voxels("float16", SHAPE), voxels("int64", SHAPE) * 10**12
    array(f"zarr{version}_float16", halves, halves.astype("float32"), version=version)
    array(f"zarr{version}_int64", wide, wide.astype("float64"), version=version)
    array(f"zarr{version}_uint64", abs(wide).astype("uint64"), abs(wide).astype("float64"), version=version)
    array(f"zarr{version}_bool", plain > 100, (plain > 100).astype("uint8"), version=version)

for name, codec in (("none", None), ("lz4", numcodecs.LZ4()), ("zlib", numcodecs.Zlib()), ("gzip", numcodecs.GZip()),
                    ("zstd", numcodecs.Zstd()), ("blosclz", numcodecs.Blosc("blosclz", shuffle=2)),
                    ("blosc_lz4", numcodecs.Blosc("lz4")), ("blosc_zstd", numcodecs.Blosc("zstd", shuffle=0))):
    array(f"zarr2_{name}", plain, version=2, compressors=codec)
array("zarr2_big", plain.astype(">u2"), plain, version=2)
array("zarr2_fortran", plain, version=2, order="F", compressors=None)
array("zarr2_slashes", plain, version=2, chunk_key_encoding={"name": "v2", "separator": "/"})
array("zarr2_one_chunk", plain, version=2, chunks=SHAPE)
array("zarr2_wide_chunk", plain, version=2, chunks=(16, 16, 16))

for name, codecs in (("none", None), ("gzip", GzipCodec()), ("blosc", BloscCodec(shuffle="bitshuffle")),
                     ("checked", (ZstdCodec(), Crc32cCodec())), ("crc", Crc32cCodec())):
    array(f"zarr3_{name}", plain, compressors=codecs)
array("zarr3_lz4", plain, compressors=zarr.codecs.numcodecs.LZ4() if hasattr(zarr.codecs, "numcodecs") else
      __import__("numcodecs.zarr3", fromlist=["LZ4"]).LZ4())
array("zarr3_big", plain, serializer=BytesCodec(endian="big"))
array("zarr3_transposed", plain, filters=TransposeCodec(order=(1, 2, 0)))
array("zarr3_keys_of_2", plain, chunk_key_encoding={"name": "v2", "separator": "."})
array("zarr3_dots", plain, chunk_key_encoding={"name": "default", "separator": "."})
for place in ("start", "end"):
    array(f"zarr3_shards_{place}", plain, chunks=(4, 3, 6), filters=None, compressors=None, serializer=ShardingCodec(
        chunk_shape=(2, 3, 2), codecs=[TransposeCodec(order=(2, 1, 0)), BytesCodec(), ZstdCodec()],
        index_location=place))
array("zarr3_shards", plain, shards=(8, 6, 4), compressors=BloscCodec())

# Chunks that are not there have the fill value.
for version, fill, dtype in ((2, 7, "uint16"), (3, 9, "uint16"), (2, np.nan, "float32"), (3, -np.inf, "float64"),
                             (3, np.float16(1.5), "float16")):
    volume = voxels(dtype, SHAPE)
    volume[:4, 3:6] = fill
    volume[8:] = fill
    name = f"zarr{version}_fill_{dtype}"
    array(name, volume, volume.astype("float32") if dtype == "float16" else volume, version=version, fill_value=fill,
          config={"write_empty_chunks": False})
    gone = FOLDER / f"{name}.zarr" / ("0.1.0" if version == 2 else "c/0/1/0")
    assert not gone.exists()
volume = voxels("float32", SHAPE)
volume[:4, :3, :2] = np.array([0x7FC00001], "uint32").view("float32")[0]
array("zarr3_fill_hex", volume, fill_value=0.0)
edit(FOLDER / "zarr3_fill_hex.zarr/zarr.json", lambda text: text.update(fill_value="0x7fc00001"))
(FOLDER / "zarr3_fill_hex.zarr/c/0/0/0").unlink()
volume = voxels("uint16", SHAPE)
volume[:4, :3, :2] = 3
array("zarr3_fill_in_shard", volume, shards=(8, 6, 4), fill_value=3, config={"write_empty_chunks": False})

film = np.stack([voxels("uint16", SHAPE, seed) for seed in range(3)])
array("zarr3_film", film, film[2], chunks=(2, *CHUNK), more={"frames": 3, "frame": 2})
array("zarr2_film", film, film[0], chunks=(2, *CHUNK), more={"frames": 3}, version=2)
array("zarr3_named", np.moveaxis(film, 0, 1), film[1], chunks=(4, 2, 3, 2), dimension_names=["z", "time", "y", "x"],
      more={"frames": 3, "frame": 1})
write("zarr2_named", np.moveaxis(film, 0, 3), chunks=(4, 3, 2, 2), version=2, attributes={
    "_ARRAY_DIMENSIONS": ["z", "y", "x", "c"]})
case("zarr2_named", "zarr2_named.zarr", film[1], channels=3, channel="1")
colours = np.stack([voxels("uint8", SHAPE, 30 * seed) for seed in range(3)], axis=-1)
luminance = (colours.astype("int64") @ [2126, 7152, 722] + 5000) // 10000
array("zarr3_colours", colours, luminance.astype("uint8"), chunks=(*CHUNK, 2), more={"channels": 3})
array("zarr3_flat", plain[0], plain[:1], chunks=(3, 2))
turned = np.ascontiguousarray(plain.transpose(2, 1, 0))
array("zarr3_x_first", turned, turned, chunks=CHUNK, dimension_names=["x", "y", "z"],
      more={"direction": [[0, 0, 1], [0, 1, 0], [1, 0, 0]]})

# OME-Zarr.
TYPES = {"t": ("time", "second"), "c": ("channel", None), "z": ("space", "micrometer"), "y": ("space", "micrometer"),
         "x": ("space", "micrometer")}


def axes_of(names, unit=None):
    axes = []
    for name in names:
        kind, of_kind = TYPES[name]
        axes.append({"name": name, "type": kind})
        if of_kind:
            axes[-1]["unit"] = unit if unit and kind == "space" else of_kind
    return axes


def image(group, whole, names, version, *, chunks, unit=None, all_levels=None, path="{}", **more):
    """Two levels in a group, the second one half as large along y and x."""
    small = whole[..., ::2, ::2]
    levels = []
    for level, volume in enumerate((whole, small)):
        made = group.create_array(path.format(level), shape=volume.shape, dtype=volume.dtype, chunks=chunks)
        made[...] = volume
        scale = [{"t": 1, "c": 1, "z": 0.5, "y": 0.2 * 2**level, "x": 0.1 * 2**level}[name] for name in names]
        shift = [{"t": 0, "c": 0, "z": 0, "y": 0.1 * level, "x": 0.05 * level}[name] for name in names]
        levels.append({"path": path.format(level), "coordinateTransformations": [
            {"type": "scale", "scale": scale}, {"type": "translation", "translation": shift}]})
    multiscale = {"axes": axes_of(names, unit), "datasets": levels, "name": "image"}
    if all_levels:
        multiscale["coordinateTransformations"] = [{"type": "scale", "scale": all_levels}]
    if version == "0.4":
        group.attrs.update({"multiscales": [{**multiscale, "version": version}], **more})
    else:
        group.attrs["ome"] = {"version": version, "multiscales": [multiscale], **more}
    return small


def store(name, version):
    return zarr.create_group(str(FOLDER / f"{name}.zarr"), zarr_format=2 if version == "0.4" else 3)


def ome(name, expected, file=None, **what):
    case(name, file or f"{name}.zarr", expected, **{"world": "microscope", "direction": AXES, "unit": "um",
                                                    "spacing": [0.1, 0.2, 0.5], "origin": [0, 0, 0], **what})


for version in ("0.4", "0.5"):
    name = "ome_zarr_" + version.replace(".", "")
    whole = np.array([[voxels("uint16", SHAPE, 31 * t + 7 * c) for c in range(3)] for t in range(2)])
    channels = {"omero": {"channels": [
        {"label": "DAPI", "color": "0000FF", "active": True, "window": {"start": 10, "end": 200, "min": 0, "max": 65535}},
        {"label": "GFP", "color": "00FF00", "active": False, "window": {"start": 0, "end": 65535, "min": 0, "max": 65535}},
        {"label": "m\u00b5"}]}}
    small = image(store(name, version), whole, "tczyx", version, chunks=(1, 2, *CHUNK), **channels)
    ome(name, whole[0, 0], frames=2, channels=3, of_channels=[
        ["DAPI", [0, 0, 1], [10, 200], False], ["GFP", [0, 1, 0], None, True], ["m\u00b5", None, None, False]])
    ome(f"{name}_gfp", whole[1, 1], f"{name}.zarr", frame=1, channel="gfp")
    ome(f"{name}_2", whole[1, 2], f"{name}.zarr/0", frame=1, channel="2")
    ome(f"{name}_level", small[0, 0], f"{name}.zarr/1/", spacing=[0.2, 0.4, 0.5], origin=[0.05, 0, -0.1])
    name += "_zyx"
    small = image(store(name, version), plain, "zyx", version, chunks=CHUNK, unit="nanometer", all_levels=[10, 10, 10],
                  path="scale{}/image")
    ome(name, plain, spacing=[0.001, 0.002, 0.005])
    ome(f"{name}_level", small, f"{name}.zarr/scale1/image", spacing=[0.002, 0.004, 0.005], origin=[0.0005, 0, -0.001])
    name = name.replace("zyx", "yx")
    image(store(name, version), plain[0], "yx", version, chunks=CHUNK[1:], unit="furlong")
    ome(name, plain[:1], unit="", spacing=[0.1, 0.2, 1])
    name = name.replace("_yx", "_series")
    root = store(name, version)
    root.attrs["bioformats2raw.layout"] = 3
    image(root.create_group("0"), plain, "zyx", version, chunks=CHUNK)
    ome(name, plain)
