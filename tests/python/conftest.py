"""What the tests share: volumes, the program, and pictures that it has made."""

import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pytest

PROGRAM = os.environ["RINGSPLAT_PROGRAM"]
MPIEXEC = os.environ.get("RINGSPLAT_MPIEXEC") or shutil.which("mpirun")
HEAD = pathlib.Path(__file__).resolve().parents[1] / "data" / "head.nrrd"


def blob(shape, dtype=np.float32, seed=0):
    """A few soft bodies, so that every view and every slice shows something."""
    z, y, x = np.meshgrid(*(np.linspace(-1, 1, size) for size in shape), indexing="ij")
    values = np.exp(-4 * (x * x + 2 * y * y + z * z)) + 0.5 * np.exp(-40 * ((x - 0.4) ** 2 + y * y + (z + 0.3) ** 2))
    values += 0.02 * np.random.default_rng(seed).random(shape)
    if np.dtype(dtype).kind in "iu":
        values = values * 100
    return values.astype(dtype)


def same_library():
    """Whether mpi4py and the package use one MPI."""
    try:
        from ringsplat import _mpi
    except ImportError:
        return False
    code = "from mpi4py import MPI; print(MPI.Get_library_version())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    return done.returncode == 0 and done.stdout.startswith(_mpi.library())


def program(*words, check=True):
    """Runs the command line in one process."""
    return subprocess.run([PROGRAM, *map(str, words)], check=check, capture_output=True, text=True)


@pytest.fixture
def exr_of(tmp_path):
    """The bytes of the .exr that the program writes of a volume's file."""

    def make(volume, *words):
        out = tmp_path / "program.exr"
        program("render", volume, "-o", out, *words)
        return out.read_bytes()

    return make


@pytest.fixture
def npy(tmp_path):
    """An array's file, which says nothing but its values."""

    def write(array):
        path = tmp_path / "array.npy"
        np.save(path, array)
        return path

    return write


def saved(image, path):
    """The bytes of a picture's file."""
    image.save(path)
    return path.read_bytes()
