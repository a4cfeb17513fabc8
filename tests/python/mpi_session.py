"""Run by test_mpi.py under a launcher: mpi_session.py FOLDER. Every rank has some of a volume's blocks."""

import pathlib
import sys
import threading

import numpy as np
import ringsplat as rs

rs_is_without_mpi = "mpi4py" not in sys.modules
from mpi4py import MPI  # noqa: E402

from conftest import blob  # noqa: E402
from sessions import add_random_blocks  # noqa: E402
from test_live import client_of  # noqa: E402

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
    # What one rank gets wrong by itself, too, is raised on all by the next collective call.
    culprit = rank == ranks - 1
    itself = TypeError if culprit else rs.InputError
    for wrong, error, text in (
        (lambda: session.add_block((0, 0, 0), volume.astype("complex64")), itself, "complex64"),
        (lambda: session.add_block((0, 0, 0), volume.astype("float64")), itself, "float64"),
        (lambda: session.add_block((0, 0), volume), itself, "start"),
        (lambda: session.update_block(99, volume), rs.InputError, "no block 99"),
        (lambda: session.set_grid((-1, 2, 3), dtype), rs.InputError, "dims"),
        (lambda: session.set_grid((4, 4, 4), dtype, spacing=float("nan")), rs.InputError, "spacing"),
        (lambda: session.set_grid((4, 4, 4), "complex64"), itself, "complex64"),
    ):
        if culprit:
            wrong()
        refused(session.commit, error, text)
        assert session.range == (volume.min(), volume.max())
    if dtype == "uint8":
        session.close()
for wrong, error in (({"layout": dict(gp=1)}, itself), ({"layout": (99, 99)}, rs.InputError), ({"threads": "two"}, itself)):
    refused(lambda: rs.Session(comm=comm, **(wrong if culprit else {})), error, "")

# A picture that rank 0 cannot write is nobody's end.
with_file = rs.Session(comm=comm)
with_file.set_grid((8, 8, 8), "float32")
if rank == 0:
    with_file.add_block((0, 0, 0), blob((8, 8, 8)))
    (folder / "actions.toml").write_text('[lost]\nfile = "nowhere/x.png"\n[kept]\nfile = "kept-{step}.png"\nsize = 16\n')
with_file.commit()
comm.Barrier()
with_file.act(folder / "actions.toml", ranks)
comm.Barrier()
assert (folder / f"kept-{ranks:06}.png").exists()

# One rank draws what the others have, whose program a page steers meanwhile.
volume = blob((18, 21, 25), "float32")
apart = rs.Session(comm=comm, visualisation_ranks=1)
assert apart.visualises == (rank == 0)
apart.set_grid(volume.shape, "float32")
if rank > 0:
    add_random_blocks(apart, volume, 3, rank - 1, ranks - 1)
apart.commit()
image = apart.render(size=40)
assert (image is None) == (rank != 0)
if rank == 0:
    assert np.array_equal(np.asarray(image), np.asarray(rs.render(volume, size=40)))
url = apart.serve(tf="grey")
apart.offer("gain", 1.0, 0.0, 4.0)
if rank == 0:

    def turn_and_steer():
        client = client_of(url)
        for azimuth in (0, 40):
            client.acknowledge(client.picture(seq=client.view(width=64, height=64, camera={"azimuth": azimuth})))
        client.send({"type": "steer", "act": "set", "parameter": "gain", "value": 3})
        assert "has ended" in client.text("end", 60)["message"]

    page = threading.Thread(target=turn_and_steer)
    page.start()
    refused(apart.visualise, rs.InputError, "no block 99")
    apart.visualise()
else:
    step = 1
    apart.update_block(99, volume)

    def show_steps():
        global step
        while True:
            apart.show(step)
            step += 1

    refused(show_steps, rs.InputError, "no block 99")
    while apart.show(step)["gain"] != 3:
        step += 1
    refused(lambda: apart.range, rs.InputError, "does not draw")
    refused(apart.visualise, rs.InputError, "set aside")
apart.close()
if rank == 0:
    page.join()
refused(lambda: rs.Session(comm=comm, visualisation_ranks=ranks), rs.InputError, "cannot be set aside")

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
