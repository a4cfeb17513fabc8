"""Run by test_mpi.py under a launcher: mpi_session.py FOLDER. Every rank has some of a volume's blocks."""

import pathlib
import sys

import numpy as np
import ringsplat as rs

rs_is_without_mpi = "mpi4py" not in sys.modules
from mpi4py import MPI  # noqa: E402

from conftest import blob  # noqa: E402
from sessions import add_random_blocks  # noqa: E402

assert rs_is_without_mpi
folder = pathlib.Path(sys.argv[1])
comm = MPI.COMM_WORLD
rank, ranks = comm.rank, comm.size


def refused(work, error, text):
    """All ranks are told the same."""
    try:
        work()
    except error as problem:
        assert text in str(problem), (rank, problem)
    else:
        raise AssertionError(f"rank {rank}: {text} was not refused")


LAYOUTS = {"float32": None, "uint8": (ranks - 1, 1)}
for dtype, layout in LAYOUTS.items():
    volume = blob((18, 21, 25), dtype)
    session = rs.Session(comm=comm, layout=layout)
    assert (session.rank, session.ranks) == (rank, ranks)
    session.set_grid(volume.shape, dtype, spacing=(1, 1, 1.5))
    for seed in range(2):
        session.clear_blocks()
        add_random_blocks(session, volume, seed, rank, ranks)
        session.commit()
        image = session.render(size=56, azimuth=20 * seed, quality="paper" if seed == 1 else "best")
        assert (image is None) == (rank != 0)
        if rank == 0:
            image.save(folder / f"{dtype}-{seed}.exr")
            np.save(folder / f"{dtype}-{seed}.npy", image)
    refused(lambda: session.render(azimut=1), TypeError if rank == 0 else rs.InputError, "azimuth")
    refused(lambda: session.render(range=(2, 1)), rs.InputError, "ascend")
    if rank == ranks - 1:
        session.add_block((0, 0, 0), volume[:1])
    refused(session.commit, rs.InputError, "verlap")
    images = session.render(size=56, azimuth=[40.0, 0.0])
    assert images is None or len(images) == 2
    assert session.range == (volume.min(), volume.max())
    if dtype == "uint8":
        session.close()

# The communicator is as it was, and its messages are its own.
assert comm.allreduce(1) == ranks and comm.Get_errhandler() is not None
assert np.asarray(rs.render(blob((8, 8, 8)), size=16)).max() > 0  # each rank by itself
with_self = rs.Session(comm=MPI.COMM_SELF)
with_self.set_grid((8, 8, 8), "float32")
with_self.add_block((0, 0, 0), blob((8, 8, 8)))
with_self.commit()
assert np.array_equal(np.asarray(with_self.render(size=16)), np.asarray(rs.render(blob((8, 8, 8)), size=16)))
refused(lambda: rs.Session(comm=MPI.COMM_NULL), rs.InputError, "communicator")
print(f"rank {rank} is done")
