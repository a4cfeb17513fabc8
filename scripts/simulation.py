"""What the scripts that simulate share: running scripts/simulate.sh, and the volumes of Neumann 1992, section 4."""
import gzip
import json
import os
import re
import subprocess
import sys
import tempfile

REPO = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
BUILD = os.environ.get("RINGSPLAT_BUILD", os.path.join(REPO, "build/release"))
HEAD = os.path.join(REPO, "tests/data/head.nrrd")
MACHINES = os.path.join(REPO, "mpi_configs/machines")
PIXEL_PLANES_5 = os.path.join(MACHINES, "pixel-planes-5.toml")
# As the paper ran: Renderers have regions of 128 pixels, splats are six words, nothing of the next frame is under way.
PAPER = {"machine": PIXEL_PLANES_5, "region": 128, "payload": "words", "frames-in-flight": 1}


def build():
    """Builds what a simulation needs, once, so that every run can start at once."""
    if "RINGSPLAT_BUILD" in os.environ:
        return
    command = f'source "{REPO}/scripts/lib.sh"; build_ringsplat ringsplat_cli ringsplat_smpi ringsplat_platform'
    if subprocess.run(["bash", "-c", command]).returncode != 0:
        sys.exit("ringsplat: the program could not be built")
    os.environ["RINGSPLAT_BUILD"] = BUILD


def program(*arguments):
    subprocess.run([os.path.join(BUILD, "ringsplat"), *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def simulate(settings, *arguments, monitors=None):
    """Simulates a run; returns the frames of its --stats. `settings` is what a configuration says, as a dictionary, `monitors` what
    scripts/simulate.sh takes from the environment: links, transfers, uncontended, ranks, map_by."""
    with tempfile.TemporaryDirectory() as work:
        config, stats = os.path.join(work, "config.toml"), os.path.join(work, "stats.json")
        with open(config, "w", encoding="utf-8") as file:
            for key, value in {"quality": "paper", **settings}.items():
                file.write(f"{key} = {json.dumps(value)}\n")
        environment = dict(os.environ, **{f"RINGSPLAT_{name.upper()}": value for name, value in (monitors or {}).items()})
        ended = subprocess.run([os.path.join(REPO, "scripts/simulate.sh"), config, *map(str, arguments), "--stats", stats],
                               env=environment, capture_output=True, text=True)
        if ended.returncode != 0:
            sys.exit(f"a simulation of {settings} failed:\n{ended.stdout}{ended.stderr}")
        with open(stats, encoding="utf-8") as file:
            return json.load(file)


def step_function(path, first_visible, opacity=0.3):
    """A transfer function of 8-bit values that shows those from `first_visible` on."""
    points = [0, 0 if first_visible > 0 else opacity, 0.5, 0]
    if first_visible > 0:
        points += [first_visible - 1, 0, 0.5, 0, first_visible, opacity, 0.5, 0]
    points += [255, opacity, 0.5, 0]
    with open(path, "w", encoding="utf-8") as file:
        json.dump([{"Name": "step", "ColorSpace": "RGB", "NanColor": [1, 0, 0],
                    "RGBPoints": [0, 0.5, 0.5, 0.5, 255, 1, 1, 1], "Points": points}], file)
    return path


def every_other_voxel(source, target):
    """Undersamples a gzipped uint8 NRRD by two along every axis (Neumann 1992, section 4.4)."""
    with open(source, "rb") as file:
        header, _, data = file.read().partition(b"\n\n")
    text = header.decode()
    voxels = gzip.decompress(data)
    x, y, z = (int(n) for n in re.search(r"sizes: (\d+) (\d+) (\d+)", text).groups())
    rows = (voxels[(k * y + j) * x:(k * y + j + 1) * x:2] for k in range(0, z, 2) for j in range(0, y, 2))
    directions = re.search(r"space directions: (.*)", text).group(1)
    doubled = re.sub(r"[-+.\de]+", lambda n: repr(2 * float(n.group())), directions)
    text = text.replace(directions, doubled).replace(f"sizes: {x} {y} {z}", f"sizes: {-(-x // 2)} {-(-y // 2)} {-(-z // 2)}")
    with open(target, "wb") as file:
        file.write(text.replace("encoding: gzip", "encoding: raw").encode() + b"\n\n" + b"".join(rows))
    return target


class PaperVolumes:
    """The four volumes of section 4, or ones with as many visible voxels, each as the program's arguments."""

    def __init__(self, folder):
        def path(name):
            return os.path.join(folder, name)

        program("synth", "constant", "-o", path("full.nrrd"), "--dims", "128x128x128")
        self.full = [path("full.nrrd"), "--fit", "sphere", "--tf", step_function(path("all.json"), 0)]

        # Turned as one looks at things, and as large as the image.
        turned = ["--azimuth", "30", "--elevation", "20", "--fit", "sphere", "--zoom", "1.5"]
        program("render", HEAD, "-o", path("head.png"), "--quality", "paper", "--size", "64", "--tf", "mr-soft", "--tf-out", path("soft.json"))
        self.head = [HEAD, "--tf", path("soft.json"), *turned]
        self.undersampled = [every_other_voxel(HEAD, path("half.nrrd")), "--tf", path("soft.json"), *turned]

        dims = "128x128x128"
        program("synth", "shell", "-o", path("shell.raw"), "--dims", dims)
        shell = next(name for name in os.listdir(folder) if name.startswith("shell"))
        self.isosurface = [path(shell), "--tf", step_function(path("iso.json"), threshold_for(path(shell), 238637)), *turned]


def threshold_for(path, visible):
    """The 8-bit value from which on a raw volume has about `visible` voxels."""
    with open(path, "rb") as file:
        voxels = file.read()
    best, above = (len(voxels), 0), 0
    for value in range(255, 0, -1):
        above += voxels.count(bytes([value]))
        best = min(best, (abs(above - visible), value))
    return best[1]


def nodes(frame, role):
    return [node for node in frame["nodes"] if node["node"].startswith(role)]
