"""The programs that are judged: how each draws SCENE into PICTURE, and whether it is there. A row here and a driver add another."""
import shutil
import subprocess
import sys
from dataclasses import dataclass

from studies.run import PROGRAM, REPO, on_ranks, say

KEPT = REPO / "build/referee"
DRIVERS = REPO / "scripts/referees/drivers"
PYPI, PACKAGES = KEPT / "venv/bin/python", ("vtk>=9.4,<10", "yt>=4.4,<5", "numpy")
DEBIAN = "apt-get install --no-install-recommends paraview python3-paraview xvfb xauth libegl1 libgl1-mesa-dri"


@dataclass
class Program:
    name: str
    command: list  # SCENE and PICTURE follow, then the options
    options: tuple = ()
    missing: str = ""  # what to do where the command is not there

    def draw(self, scene, picture, environment):
        """Whether there is a picture then; says why not."""
        picture.unlink(missing_ok=True)
        environment = {**environment, "PYTHONPATH": str(REPO / "scripts"), "PYTHONDONTWRITEBYTECODE": "1", "RINGSPLAT": str(PROGRAM)}
        command = [*self.command, scene, picture, *self.options]
        ended = subprocess.run([str(word) for word in command], env=environment, capture_output=True, text=True, timeout=600)
        if ended.returncode or not picture.exists():
            say(f"{self.name} draws no {scene.name}: {ended.stderr.strip()[-300:]}")
            return False
        say(f"{scene.name} by {self.name}, {ended.stdout.strip().splitlines()[0]}")
        return True


def python(driver, *options, name, interpreter=sys.executable, missing=""):
    return Program(name, [interpreter, DRIVERS / driver], options, missing)


def paraview(name, ranks):
    ready = shutil.which("pvbatch") and shutil.which("Xvfb")
    return Program(name, on_ranks(ranks, "pvbatch", "--sym", DRIVERS / "paraview_view.py"), missing="" if ready else DEBIAN)


def all_programs():
    wheels = {"interpreter": PYPI, "missing": "" if PYPI.exists() else "scripts/referee --install"}
    return [
        python("ringsplat.py", "--quality", "best", name="Ringsplat best"),
        python("ringsplat.py", "--quality", "paper", name="Ringsplat paper"),
        python("vtk_casters.py", "fixed", 2, name="VTK fixed-point", **wheels),
        python("vtk_casters.py", "gpu", 2, name="VTK GPU", **wheels),
        python("vtk_casters.py", "gpu", 10, name="VTK GPU fine", **wheels),
        python("yt_caster.py", name="yt", **wheels),
        paraview("ParaView 1 rank", 1),
        paraview("ParaView 2 ranks", 2),
    ]


def install():
    """Other programs' wheels, below build/."""
    subprocess.run([sys.executable, "-m", "venv", PYPI.parents[1]], check=True)
    subprocess.run([PYPI, "-m", "pip", "install", "-q", *PACKAGES], check=True)
