"""The example that draws openPMD series: blocks as they lie in the file, read by the ranks of a job."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest
import ringsplat as rs
from conftest import MPIEXEC, blob, program, same_library

io = pytest.importorskip("openpmd_api")
EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/python/openpmd_series.py"
SHAPE = (18, 21, 25)  # z, y, x


def write(file, labels=("z", "y", "x"), bounds=(0, 5, 11, 18)):
    """Two iterations of two components, each stored in chunks along the first axis."""
    axes = ["zyx".index(label) for label in labels]
    series = io.Series(str(file), io.Access.create)
    for number in (10, 20):
        mesh = series.iterations[number].meshes["E"]
        mesh.geometry = io.Geometry.cartesian
        mesh.axis_labels = list(labels)
        mesh.grid_spacing = [float((1.5, 1, 1)[axis]) for axis in axes]
        mesh.grid_global_offset = [0.0, 0.0, 0.0]
        mesh.grid_unit_SI = 2.0
        for name, seed in (("x", number), ("y", number + 1)):
            data = np.ascontiguousarray(blob(SHAPE, seed=seed).transpose(axes))
            component = mesh[name]
            component.position = [0.0, 0.0, 0.0]
            component.reset_dataset(io.Dataset(data.dtype, data.shape))
            for first, end in zip(bounds, bounds[1:]):
                component.store_chunk(data[first:end].copy(), [first, 0, 0], [end - first, *data.shape[1:]])
                series.flush()
    series.close()


def draw(ranks, file, out, *options, name="E/y"):
    words = [sys.executable, "-B", EXAMPLE, file, name, out, "--size=56", *options]
    if ranks > 1:
        words = [MPIEXEC, "-n", str(ranks), *words]
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=240)


def expected(number, folder, **options):
    path = folder / "expected.exr"
    rs.render(blob(SHAPE, seed=number + 1), spacing=(2, 2, 3), unit="m", size=56, **options).save(path)
    return path


@pytest.mark.parametrize("ranks", [1, 2, 5])
@pytest.mark.parametrize("kind, labels", [("bp", "zyx"), ("h5", "xyz")])
def test_each_iteration_is_drawn_as_its_array(kind, labels, ranks, tmp_path):
    if ranks > 1 and not (MPIEXEC and same_library()):
        pytest.skip("mpi4py uses another MPI than ringsplat")
    if kind not in io.file_extensions:
        pytest.skip(f"openpmd-api was built without .{kind}")
    end = SHAPE["zyx".index(labels[0])]
    write(tmp_path / f"run.{kind}", labels, (0, 5, 11, end))
    done = draw(ranks, tmp_path / f"run.{kind}", tmp_path / "e-%T.exr", "--azimuth=30")
    assert done.returncode == 0, done.stdout + done.stderr
    for number in (10, 20):
        program("compare", expected(number, tmp_path, azimuth=30), tmp_path / f"e-{number}.exr", "--fail-above", 0)


def test_what_is_not_there_is_named(tmp_path):
    write(tmp_path / "run.json")
    done = draw(1, tmp_path / "run.json", tmp_path / "out.png", name="rho")
    assert done.returncode == 1 and "no mesh rho; it has: E" in done.stderr
    assert not (tmp_path / "out.png").exists()
