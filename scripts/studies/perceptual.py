"""Adds what an eye would see to a study's table: SSIM and FLIP of each picture against its truth.

    scripts/study settings -o study.csv --keep-images pictures
    scripts/study perceptual study.csv pictures -o study-perceptual.csv

ssim: structural similarity (Wang et al. 2004), 1 for equal pictures; by scikit-image, Gaussian windows, of the three channels.
flip: FLIP (Andersson et al. 2020), 0 for equal pictures; by its authors' package, at 67 pixels a degree.
Both look at the pictures as a display shows them: over black, 8-bit sRGB. Rows without pictures keep empty columns.

Both packages are on PyPI; `scripts/study accuracy` puts them into build/perceptual, whose bin/python runs this, too.
"""
from pathlib import Path

from .output import read_csv, write_csv
from .run import fail, parser


def read_picture(path):
    import numpy
    from skimage.io import imread

    if not path.is_file():
        fail(f"{path} is not there; hint: give the folder that scripts/study settings --keep-images wrote")
    picture = imread(path)
    if picture.ndim != 3 or picture.shape[2] < 3 or picture.dtype != numpy.uint8:
        fail(f"{path} is no 8-bit colour picture; hint: give the folder that scripts/study settings --keep-images wrote")
    return picture[:, :, :3]


def measure(picture, truth):
    """SSIM and mean FLIP of two pictures, height x width x 3 bytes."""
    import flip_evaluator
    import numpy
    from skimage.metrics import structural_similarity

    if picture.shape != truth.shape:
        fail(f"pictures of {picture.shape} and {truth.shape} cannot be compared; hint: they are of different studies")
    ssim = structural_similarity(picture, truth, channel_axis=2, gaussian_weights=True, sigma=1.5, use_sample_covariance=False)
    as_floats = [numpy.ascontiguousarray(p, dtype=numpy.float32) / 255 for p in (truth, picture)]
    _, flip, _ = flip_evaluator.evaluate(*as_floats, "LDR", applyMagma=False)
    return float(ssim), float(flip)


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("study", help="the study's CSV")
    arguments.add_argument("pictures", type=Path, help="the folder of its --keep-images")
    arguments.add_argument("-o", "--output", required=True, help="the CSV with two columns more")
    options = arguments.parse_args(words)
    try:
        import flip_evaluator  # noqa: F401
        import skimage  # noqa: F401
    except ImportError as missing:
        fail(f"this needs scikit-image and flip-evaluator ({missing.name} is missing); hint: python3 -m venv build/perceptual && "
             "build/perceptual/bin/pip install scikit-image flip-evaluator, then build/perceptual/bin/python scripts/study perceptual ...")
    rows = read_csv(options.study)
    measured = [row for row in rows if row.get("picture") and row.get("truth_picture")]
    if not measured:
        fail(f"{options.study} names no pictures; hint: scripts/study settings -o {options.study} --keep-images {options.pictures}")
    for row in rows:
        row["ssim"] = row["flip"] = ""
    for row in measured:
        values = measure(*(read_picture(options.pictures / row[name]) for name in ("picture", "truth_picture")))
        row["ssim"], row["flip"] = (f"{value:.6g}" for value in values)
    write_csv(options.output, rows)
    print(f"{options.output}: {len(measured)} of {len(rows)} rows measured")
