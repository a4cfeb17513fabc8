"""The examples that draw openPMD series and show openPMD streams: blocks as they lie there, read by the ranks of a job."""

import json
import multiprocessing
import pathlib
import subprocess
import sys

import numpy as np
import pytest
import ringsplat as rs
from conftest import MPIEXEC, blob, program, same_library

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "serve"))
import viewer_client as vc  # noqa: E402

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


STREAM = EXAMPLE.with_name("openpmd_stream.py")
STEPS = 40


def stream(file, readers):
    """Writes steps of which each is so many times the first, as fast as readers take them."""
    parameters = {"RendezvousReaderCount": str(readers), "QueueLimit": "1", "QueueFullPolicy": "Block"}
    config = json.dumps({"adios2": {"engine": {"type": "sst", "parameters": parameters}}})
    series = io.Series(str(file), io.Access.create, config)
    for step in range(1, STEPS + 1):
        iteration = series.write_iterations()[step]
        iteration.time = 0.5 * step
        mesh = iteration.meshes["T"]
        mesh.axis_labels = ["z", "y", "x"]
        mesh.grid_spacing, mesh.grid_global_offset = [1.0, 1.0, 1.0], [0.0, 0.0, 0.0]
        component = mesh[io.Mesh_Record_Component.SCALAR]
        component.position = [0.0, 0.0, 0.0]
        data = step * blob(SHAPE, "float32")
        component.reset_dataset(io.Dataset(data.dtype, data.shape))
        for first, end in ((0, 7), (7, SHAPE[0])):
            component.store_chunk(data[first:end].copy(), [first, 0, 0], [end - first, *SHAPE[1:]])
        iteration.close()
    series.close()


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.skipif("sst" not in io.file_extensions, reason="openpmd-api was built without SST")
def test_a_stream_is_shown_and_held_while_it_is_written(ranks, tmp_path):
    if ranks > 1 and not (MPIEXEC and same_library()):
        pytest.skip("mpi4py uses another MPI than ringsplat")
    file = tmp_path / "run.sst"
    writer = multiprocessing.get_context("spawn").Process(target=stream, args=(file, ranks))
    writer.start()
    words = [sys.executable, "-B", STREAM, file, "T", "--tf=grey", "--share=0.5"]
    server = vc.Server([str(word) for word in ([MPIEXEC, "-n", str(ranks)] if ranks > 1 else []) + words])
    try:
        client = server.client()
        client.send({"type": "steer", "act": "pause"})
        client.picture(seq=client.view(width=64, height=64), at_rest=1)
        client.send({"type": "steer", "act": "pause"})
        run = client.receive_until(lambda m: isinstance(m, dict) and m["type"] == "run" and m["paused"])
        assert run["time"] == 0.5 * run["step"]
        assert run["histogram"]["high"] == pytest.approx(run["step"] * blob(SHAPE, "float32").max(), rel=1e-6)
        assert run["step"] < STEPS and writer.is_alive()
        client.send({"type": "steer", "act": "resume"})
        assert "ended" in client.text("end", 60)["message"]
        assert server.wait() == 0, server.errors
        writer.join(30)
        assert writer.exitcode == 0
    finally:
        server.kill()
        writer.kill()
