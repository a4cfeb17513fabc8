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


of_one_mpi = pytest.mark.skipif(not same_library(), reason="mpi4py uses another MPI than ringsplat")


@of_one_mpi
@pytest.mark.skipif(not MPIEXEC, reason="there is no launcher")
@pytest.mark.parametrize("ranks", [2, 4])
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


def printed_by(code):
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout


def said_of_a_session(before, comm="MPI.COMM_WORLD"):
    """The error of a session on a communicator, in a Python of its own."""
    return printed_by(
        "from mpi4py import MPI; import ringsplat as rs, sys\n"
        f"{before}\ntry:\n  rs.Session(comm={comm})\nexcept (TypeError, ImportError, rs.InputError) as e:\n  print(e)"
    )


@of_one_mpi
def test_a_process_alone_is_a_communicator_too():
    code = (
        "from mpi4py import MPI; import numpy, ringsplat as rs; s = rs.Session(comm=MPI.COMM_WORLD); s.set_grid((4, 4, 4)); "
        "s.add_block((0, 0, 0), numpy.ones((4, 4, 4), 'f4').cumsum(0, dtype='f4')); s.commit(); print(s.render(size=8).shape)"
    )
    assert printed_by(code).strip() == "(8, 8, 4)"


def test_the_module_for_mpi_leaves_the_exceptions_as_they_are(tmp_path):
    with pytest.raises(rs.RunError, match="cannot be written"):
        rs.render(blob((4, 5, 6)), size=16).save(tmp_path / "no" / "such" / "a.png")


@of_one_mpi
def test_what_is_no_communicator_or_another_mpis_is_refused_and_a_missing_module_named():
    assert "communicator" in said_of_a_session("", comm="3")
    other = said_of_a_session("MPI.Get_library_version = lambda: 'MPICH Version:\\t4.0.2\\nMPICH Release date: ...'")
    assert "mpi4py uses MPICH Version" in other and "ringsplat was built for" in other and "hint" in other
    assert "RINGSPLAT_PYTHON_MPI=ON" in said_of_a_session("sys.modules['ringsplat._mpi'] = None")
