"""What the studies that simulate share: running scripts/simulate.sh, and the volumes of Neumann 1992, section 4."""
import json
import os
import tempfile

from .run import BUILD, HEAD, MACHINES, REPO, output_of, program, read_frames
from .volumes import every_other_voxel, step_function, threshold_for

PIXEL_PLANES_5 = str(MACHINES / "pixel-planes-5.toml")
# As the paper ran: Renderers have regions of 128 pixels, nothing of the next frame is under way.
PAPER = {"machine": PIXEL_PLANES_5, "region": 128, "frames-in-flight": 1}
COUNTED = ("--count-only", "--shading", "none")


def run_simulation(config, *arguments, monitors=None):
    """What scripts/simulate.sh printed; `monitors` is what it takes from the environment: ranks, map_by, other."""
    environment = {f"RINGSPLAT_{name.upper()}": str(value) for name, value in (monitors or {}).items()}
    return output_of(REPO / "scripts/simulate.sh", config, *arguments, env={**os.environ, "RINGSPLAT_BUILD": str(BUILD), **environment})


def simulate(settings, *arguments, monitors=None):
    """Simulates a run; returns the frames of its --stats. `settings` is what a configuration says, as a dictionary."""
    with tempfile.TemporaryDirectory() as work:
        config, stats = os.path.join(work, "config.toml"), os.path.join(work, "stats.json")
        with open(config, "w", encoding="utf-8") as file:
            for key, value in {"quality": "paper", **settings}.items():
                file.write(f"{key} = {json.dumps(value)}\n")
        run_simulation(config, *arguments, "--stats", stats, monitors=monitors)
        return read_frames(stats)


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

        program("synth", "shell", "-o", path("shell.raw"), "--dims", "128x128x128")
        shell = path(next(name for name in os.listdir(folder) if name.startswith("shell")))
        self.isosurface = [shell, "--tf", step_function(path("iso.json"), threshold_for(shell, 238637)), *turned]
