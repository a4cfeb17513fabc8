"""TIFF by tifffile: OME-TIFF, ImageJ hyperstacks, colours, tiles, compression, BigTIFF, pyramids, palettes."""
import numpy as np
import tifffile
from cases import FOLDER, case, voxels

# Columns run to the right, rows downwards, slices away from the viewer.
AXES = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]


def series(frames, channels, dtype="uint16"):
    """A volume a[t, c, z, y, x] of which no two parts are alike."""
    return np.array([[voxels(dtype, seed=1 + 31 * t + 7 * c) for c in range(channels)] for t in range(frames)])


def stack(name, expected, **what):
    case(name, f"{name}.tif", expected, world="microscope", direction=AXES, **what)


def plain(name, volume, expected=None, **how):
    tifffile.imwrite(FOLDER / f"{name}.tif", volume, metadata=None, **how)
    stack(name, volume if expected is None else expected, spacing=[1, 1, 1], frames=1)


def ome(name, axes, **how):
    """Two time points and three channels, their pages in the order of `axes`; each case takes one of them."""
    whole = series(2, 3)
    pages = np.transpose(whole, ["TCZYX".index(axis) for axis in axes])
    metadata = {"axes": axes, "PhysicalSizeX": 0.2, "PhysicalSizeY": 0.3, "PhysicalSizeZ": 1500,
                "PhysicalSizeZUnit": "nm",
                "Channel": {"Name": ["DAPI", "GFP", "m\u00b5 <>"], "Color": [65535, 16711935, -1]}}
    for frame, channel, wanted in ((0, 0, "DAPI"), (1, 1, "gfp"), (1, 2, "2")):
        one = f"{name}_{frame}{channel}"
        tifffile.imwrite(FOLDER / f"{one}.tif", pages, ome=True, metadata=metadata, **how)
        stack(one, whole[frame, channel], spacing=[0.2, 0.3, 1.5], unit="um", frames=2, channels=3, frame=frame,
              channel=wanted, of_channels=[["DAPI", [0, 0, 1], None, False], ["GFP", [0, 1, 0], None, False],
                                           ["m\u00b5 <>", [1, 1, 1], None, False]])


def image_j(name, **how):
    whole = series(2, 3)
    luts = [np.outer(np.eye(3)[k], np.arange(256)).astype("uint8") for k in range(3)]
    for frame, channel in ((0, 1), (1, 2)):
        one = f"{name}_{frame}{channel}"
        tifffile.imwrite(FOLDER / f"{one}.tif", np.moveaxis(whole, 1, 2), imagej=True, resolution=(5, 4),
                         metadata={"axes": "TZCYX", "spacing": 0.5, "unit": "um", "LUTs": luts,
                                   "Ranges": (3.0, 200.5, 0.0, 65535.0, 7.0, 90.0)}, **how)
        stack(one, whole[frame, channel], spacing=[0.2, 0.25, 0.5], unit="um", frames=2, channels=3, frame=frame,
              channel=str(channel), of_channels=[["", [1, 0, 0], [3, 200.5], False], ["", [0, 1, 0], None, False],
                                                 ["", [0, 0, 1], [7, 90], False]])


def luminance(colours):
    red, green, blue = (colours[..., k].astype(np.int64) for k in range(3))
    return ((2126 * red + 7152 * green + 722 * blue + 5000) // 10000).astype(colours.dtype)


def colours(name, dtype, samples, planar=False):
    whole = np.stack([voxels(dtype, seed=11 * k + 1) for k in range(samples)], axis=-1)
    stored = np.moveaxis(whole, -1, 1) if planar else whole
    for channel, expected in ((None, luminance(whole)), ("g", whole[..., 1]), ("2", whole[..., 2])):
        one = f"{name}_{channel or 'luminance'}"
        tifffile.imwrite(FOLDER / f"{one}.tif", stored, photometric="rgb", metadata=None,
                         extrasamples=["unassalpha"] if samples == 4 else None,
                         planarconfig="separate" if planar else "contig")
        stack(one, expected, channels=samples, channel=channel)


def pyramid(name):
    volume = voxels("uint16", (6, 32, 48))
    with tifffile.TiffWriter(FOLDER / f"{name}.tif", ome=True) as file:
        file.write(volume, subifds=1, tile=(16, 16), metadata={"axes": "ZYX", "PhysicalSizeX": 2.0})
        file.write(volume[:, ::2, ::2], subfiletype=1, tile=(16, 16))
    stack(name, volume, spacing=[2, 2, 2], unit="um")
    name += "_in_the_chain"
    with tifffile.TiffWriter(FOLDER / f"{name}.tif") as file:
        for page in volume:
            file.write(page, metadata=None)
            file.write(page[::2, ::2], subfiletype=1, metadata=None)
    stack(name, volume, spacing=[1, 1, 1])


for dtype in ("uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"):
    plain(f"tiff_{dtype}", voxels(dtype), photometric="minisblack")
plain("tiff_big_endian", voxels("int16"), byteorder=">", photometric="minisblack")
plain("tiff_bigtiff", voxels("uint16"), bigtiff=True, photometric="minisblack")
plain("tiff_deflate", voxels("uint16"), compression="zlib", photometric="minisblack")
plain("tiff_tiles", voxels("uint16", (3, 40, 50)), tile=(16, 32), photometric="minisblack")
plain("tiff_strips", voxels("uint16", (3, 40, 50)), rowsperstrip=7, photometric="minisblack")
plain("tiff_tiles_deflate_float", voxels("float32", (3, 40, 50)), tile=(16, 16), compression="zlib",
      photometric="minisblack")
palette = np.random.default_rng(1).integers(0, 65536, (3, 256)).astype("uint16")
plain("tiff_palette", voxels("uint8"), photometric="palette", colormap=palette)
for order in ("TCZYX", "TZCYX", "CTZYX", "CZTYX", "ZTCYX", "ZCTYX"):
    ome(f"ome_{order}", order)
ome("ome_deflate", "TCZYX", compression="zlib")
ome("ome_bigtiff", "TZCYX", bigtiff=True)
image_j("imagej")
image_j("imagej_behind_one_page", truncate=True)
colours("tiff_rgb8", "uint8", 3)
colours("tiff_rgb16", "uint16", 3)
colours("tiff_rgba8", "uint8", 4)
colours("tiff_rgb8_planes", "uint8", 3, planar=True)
pyramid("ome_pyramid")
