#!/usr/bin/env python3
"""Adds what an eye would see to a study's table: SSIM and FLIP of each picture against its truth.

    ringsplat study -o study.csv --keep-images pictures
    scripts/perceptual.py study.csv pictures -o study-perceptual.csv

ssim: structural similarity (Wang et al. 2004), 1 for equal pictures; by scikit-image, Gaussian windows, of the three channels.
flip: FLIP (Andersson et al. 2020), 0 for equal pictures; by its authors' package, at 67 pixels a degree.
Both look at the pictures as a display shows them: over black, 8-bit sRGB. Rows without pictures keep empty columns.

Both packages are on PyPI. In an environment of their own:

    python3 -m venv build/perceptual && build/perceptual/bin/pip install scikit-image flip-evaluator
    build/perceptual/bin/python scripts/perceptual.py study.csv pictures -o study-perceptual.csv
"""

import argparse
import csv
import pathlib
import sys

try:
    import flip_evaluator
    import numpy
    from skimage.io import imread
    from skimage.metrics import structural_similarity
except ImportError as missing:
    sys.exit(
        f"this needs scikit-image and flip-evaluator ({missing.name} is missing); hint: "
        "python3 -m venv build/perceptual && build/perceptual/bin/pip install scikit-image flip-evaluator, "
        "then build/perceptual/bin/python scripts/perceptual.py ..."
    )


def read_picture(path):
    if not path.is_file():
        sys.exit(f"{path} is not there; hint: give the folder that ringsplat study --keep-images wrote")
    picture = imread(path)
    if picture.ndim != 3 or picture.shape[2] < 3 or picture.dtype != numpy.uint8:
        sys.exit(f"{path} is no 8-bit colour picture; hint: give the folder that ringsplat study --keep-images wrote")
    return picture[:, :, :3]


def measure(picture, truth):
    """SSIM and mean FLIP of two pictures, height x width x 3 bytes."""
    if picture.shape != truth.shape:
        sys.exit(f"pictures of {picture.shape} and {truth.shape} cannot be compared; hint: they are of different studies")
    ssim = structural_similarity(picture, truth, channel_axis=2, gaussian_weights=True, sigma=1.5, use_sample_covariance=False)
    as_floats = [numpy.ascontiguousarray(p, dtype=numpy.float32) / 255 for p in (truth, picture)]
    _, flip, _ = flip_evaluator.evaluate(*as_floats, "LDR", applyMagma=False)
    return float(ssim), float(flip)


def add_columns(rows, folder):
    measured = 0
    for row in rows:
        row["ssim"] = row["flip"] = ""
        if row["picture"] and row["truth_picture"]:
            ssim, flip = measure(read_picture(folder / row["picture"]), read_picture(folder / row["truth_picture"]))
            row["ssim"], row["flip"] = f"{ssim:.6g}", f"{flip:.6g}"
            measured += 1
    return measured


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=pathlib.Path, help="the study's CSV")
    parser.add_argument("pictures", type=pathlib.Path, help="the folder of its --keep-images")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="the CSV with two columns more")
    options = parser.parse_args()
    with open(options.study, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows or "picture" not in rows[0]:
        sys.exit(f"{options.study} names no pictures; hint: ringsplat study -o {options.study} --keep-images {options.pictures}")
    measured = add_columns(rows, options.pictures)
    if measured == 0:
        sys.exit(f"{options.study} names no pictures; hint: ringsplat study -o {options.study} --keep-images {options.pictures}")
    part = options.output.with_name(options.output.name + ".part")
    with open(part, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    part.rename(options.output)
    print(f"{options.output}: {measured} of {len(rows)} rows measured")


if __name__ == "__main__":
    main()
