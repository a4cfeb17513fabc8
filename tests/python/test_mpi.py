"""Sessions on the ranks of an mpi4py communicator, which have the program's bits."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest
import ringsplat as rs
from conftest import MPIEXEC, blob, program, same_library

HERE = pathlib.Path(__file__).resolve().parent
pytest.importorskip("ringsplat._mpi", reason="built without MPI")


@pytest.mark.skipif(not MPIEXEC or not same_library(), reason="mpi4py uses another MPI than ringsplat")
@pytest.mark.parametrize("ranks", [2, 3, 4])
def test_blocks_on_ranks_give_the_bits_of_one_process(ranks, tmp_path, exr_of, npy):
    done = subprocess.run(
        [MPIEXEC, "-n", str(ranks), sys.executable, "-B", HERE / "mpi_session.py", tmp_path],
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    # A launcher may join ranks' lines.
    assert all(f"rank {rank} is done" in done.stdout for rank in range(ranks)), done.stdout
    for dtype in ("float32", "uint8"):
        file = npy(blob((18, 21, 25), dtype))
        for seed in range(2):
            options = dict(size=56, spacing=(1, 1, 1.5), azimuth=20 * seed, quality="paper" if seed == 1 else "best")
            assert np.array_equal(np.load(tmp_path / f"{dtype}-{seed}.npy"), np.asarray(rs.render(file, **options)))
    # The settings in the files name another volume.
    (tmp_path / "theirs.exr").write_bytes(
        exr_of(file, "--size", 56, "--spacing", "1x1x1.5", "--azimuth", 20, "--quality", "paper")
    )
    program("compare", tmp_path / "theirs.exr", tmp_path / "uint8-1.exr", "--fail-above", 0)


def test_a_process_alone_is_a_communicator_too():
    code = (
        "from mpi4py import MPI; import numpy, ringsplat as rs; s = rs.Session(comm=MPI.COMM_WORLD); s.set_grid((4, 4, 4)); "
        "s.add_block((0, 0, 0), numpy.ones((4, 4, 4), 'f4').cumsum(0, dtype='f4')); s.commit(); print(s.render(size=8).shape)"
    )
    if not same_library():
        pytest.skip("mpi4py uses another MPI than ringsplat")
    assert (
        subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip()
        == "(8, 8, 4)"
    )


def test_what_is_no_communicator_is_refused():
    pytest.importorskip("mpi4py")
    code = "import ringsplat as rs\ntry:\n  rs.Session(comm=3)\nexcept TypeError as e:\n  print(e)"
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert "communicator" in out


def test_the_module_for_mpi_leaves_the_exceptions_as_they_are(tmp_path):
    with pytest.raises(rs.RunError, match="cannot be written"):
        rs.render(blob((4, 5, 6)), size=16).save(tmp_path / "no" / "such" / "a.png")


def test_another_mpi_than_mpi4pys_is_refused():
    code = (
        "from mpi4py import MPI; import ringsplat as rs\n"
        "MPI.Get_library_version = lambda: 'MPICH Version:\\t4.0.2\\nMPICH Release date: ...'\n"
        "try:\n  rs.Session(comm=MPI.COMM_WORLD)\nexcept rs.InputError as e:\n  print(e)"
    )
    if not same_library():
        pytest.skip("mpi4py uses another MPI than ringsplat")
    said = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert "mpi4py uses MPICH Version" in said and "ringsplat was built for" in said and "hint" in said


def test_without_the_module_for_mpi_it_says_how_to_build_it():
    code = (
        "import sys; sys.modules['ringsplat._mpi'] = None\n"
        "from mpi4py import MPI; import ringsplat as rs\n"
        "try:\n  rs.Session(comm=MPI.COMM_WORLD)\nexcept ImportError as e:\n  print(e)"
    )
    if not same_library():
        pytest.skip("mpi4py cannot be loaded")
    said = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert "RINGSPLAT_PYTHON_MPI=ON" in said
