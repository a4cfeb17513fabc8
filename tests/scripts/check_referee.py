#!/usr/bin/env python3
"""Checks the referee's scenes, that closed forms lie within certified bounds, and what it says of Ringsplat, in small pictures.

usage: check_referee.py FOLDER_OF_SCRIPTS SCRATCH BUILD

Exits with 77 where NumPy is missing.
"""
import os
import shutil
import subprocess
import sys
from pathlib import Path

SCRIPTS, SCRATCH, BUILD = (os.path.abspath(path) for path in sys.argv[1:4])
sys.dont_write_bytecode = True
sys.path.insert(0, SCRIPTS)
from studies.debian import restart_without  # noqa: E402

if missing := restart_without("numpy", in_environments=True):
    print(f"skipped: {missing} is missing")
    sys.exit(77)

import numpy  # noqa: E402
from referees.judge import errors  # noqa: E402
from referees.scene import Scene  # noqa: E402
from referees.scenes import all_scenes  # noqa: E402
from studies.output import read_csv  # noqa: E402

SIZE = 24
# What Ringsplat's RMSE is below, with each quality; None: it cannot draw the scene so.
MOST = {"curtain": (0.6, 40), "spikes": (1, 20), "perspective": (0.5, None)}


def referee(*words):
    environment = {**os.environ, "RINGSPLAT_BUILD": BUILD}
    return subprocess.run([os.path.join(SCRIPTS, "referee"), *map(str, words)], env=environment, capture_output=True, text=True)


def check_scenes(folder):
    ended = referee("--write-scenes", "--size", SIZE, "--folder", folder)
    assert ended.returncode == 0, ended.stderr
    assert len(all_scenes()) == 15 == len(list((folder / "scenes").iterdir()))
    for made in all_scenes():
        read = Scene(folder / "scenes" / made.name)
        assert numpy.array_equal(read.voxels, made.voxels, equal_nan=made.voxels.dtype.kind == "f"), made.name
        assert read.opacities == made.opacities and len(read.colours) == len(made.colours), made.name
        # Straightened, the camera looks at the lattice's middle from as far away as in the world.
        middle, eye = (numpy.array(read.dims) - 1) / 2 * read.spacing, numpy.array(made.camera["eye"])
        assert numpy.allclose(read.target, middle, atol=1e-9), made.name
        assert numpy.isclose(numpy.linalg.norm(read.eye - middle), numpy.linalg.norm(eye - made.camera["target"])), made.name


def check_errors():
    truth = numpy.zeros((2, 2, 4))
    off = truth.copy()
    off[0, 0] = (0.5, 0, 0, 0)
    assert errors(off, truth) == (255 * 0.5 / 4, 127.5)
    off[..., 3] = numpy.nan  # no opacity is given
    assert numpy.isclose(errors(off, truth)[0], 255 * 0.5 / 12**0.5)
    off[0, 0, 0] = numpy.nan
    assert errors(off, truth)[1] == 255


def check_judgement(folder):
    ended = referee("--scenes", *MOST, "--programs", "ringsplat", "--size", SIZE, "--folder", folder)
    assert ended.returncode == 0, ended.stderr
    rows = {(row["scene"], row["program"]): row for row in read_csv(folder / "errors.csv")}
    for scene, limits in MOST.items():
        for quality, most in zip(("best", "paper"), limits):
            row = rows.get((scene, f"Ringsplat {quality}"))
            assert (row is None) == (most is None), f"{scene}, {quality}: {ended.stderr}"
            assert most is None or float(row["rmse"]) < most, row
    assert rows["curtain", "Ringsplat best"]["source"] == "closed form" and rows["spikes", "Ringsplat best"]["source"] == "certified"
    assert referee("--scenes", "cow", "--folder", folder).returncode != 0


def main():
    shutil.rmtree(SCRATCH, ignore_errors=True)
    check_scenes(Path(SCRATCH))
    check_errors()
    check_judgement(Path(SCRATCH))
    print("15 scenes")


if __name__ == "__main__":
    main()
