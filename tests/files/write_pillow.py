"""Pillow: folders of numbered PNG files, of 8 and 16 bits, grey and coloured."""
import numpy as np
from cases import FOLDER, case, voxels
from PIL import Image

PLACE = {"spacing": [1, 1, 1], "world": "microscope", "unit": ""}


def stack(name, slices, expected, first=8, **wanted):
    """Slices are numbered without leading zeros, beside a text."""
    folder = FOLDER / name
    folder.mkdir()
    (folder / "readme.txt").write_text("slices")
    for number, pixels in enumerate(slices, first):
        image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)
        image.save(folder / f"slice{number}.png")
    case(name, name, expected, **{**PLACE, **wanted})


for dtype in ("uint8", "uint16"):
    volume = voxels(dtype) if dtype == "uint8" else voxels(dtype) * 257
    stack(f"png_{dtype}", volume, volume, channels=1)
colours = np.stack([voxels("uint8", seed=n) for n in (1, 40, 90)], axis=-1)
luminance = ((colours.astype(int) @ np.array([2126, 7152, 722]) + 5000) // 10000).astype("uint8")
stack("png_luminance", colours, luminance, channels=3)
stack("png_green", colours, colours[..., 1], channel="g", channels=3)
grey = voxels("uint8")
stack("png_grey_and_alpha", [Image.merge("LA", (Image.fromarray(a), Image.fromarray(255 - a))) for a in grey], grey,
      channels=2)
