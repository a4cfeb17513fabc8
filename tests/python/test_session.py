"""Sessions in one process."""

import gc
import os
import signal
import threading
import time
import weakref

import numpy as np
import pytest
import ringsplat as rs
from conftest import blob
from sessions import add_random_blocks

SHAPE = (18, 21, 25)


def session_of(volume, seed=0, **options):
    session = rs.Session(**options)
    session.set_grid(volume.shape, volume.dtype)
    add_random_blocks(session, volume, seed)
    session.commit()
    return session


def same(session, volume, **options):
    return np.array_equal(
        np.asarray(session.render(size=56, **options)), np.asarray(rs.render(volume, size=56, **options))
    )


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dtype", ["float32", "uint8", "int16"])
def test_random_blocks_give_the_bits_of_the_whole_volume(seed, dtype):
    volume = blob(SHAPE, dtype)
    session = session_of(volume, seed)
    for options in (
        {},
        {"azimuth": 40, "elevation": 25},
        {"quality": "paper", "view": "top"},
        {"labels": True},
        {"undersample": 2},
    ):
        if options == {"labels": True} and dtype == "float32":
            continue
        assert same(session, volume, **options), options


@pytest.mark.parametrize(
    "layout",
    [
        (3, 2),
        dict(gps=3, renderers=2, bundle=4),
        dict(gps=2, renderers=2, roles="colocated"),
        dict(topology="mesh", mesh=(2, 2)),
    ],
)
def test_a_layout_changes_no_bit(layout):
    volume = blob(SHAPE)
    session = session_of(volume, layout=layout, threads=2)
    assert same(session, volume, azimuth=20)


def test_options_are_those_of_render():
    volume = blob(SHAPE)
    session = session_of(volume)
    assert same(
        session, volume, tf="grey", range=(0.2, 0.8), clip="2:20,:,3:", light=(1, 0, 1), projection="perspective"
    )
    images = session.render(size=56, azimuth=[0, 50], quality="draft")
    for image, expected in zip(images, rs.render(volume, size=56, azimuth=[0, 50], quality="draft")):
        assert np.array_equal(np.asarray(image), np.asarray(expected))
    assert (
        images[0].srgb().shape == (56, 56, 4) and images[0]._repr_png_() and images[0].settings["volume"] == "session"
    )
    low, high = session.range
    assert (low, high) == (volume.min(), volume.max())


def test_time_steps_come_by_another_array_or_in_place():
    first, second, third = (blob(SHAPE, seed=seed) * (1 + seed) for seed in range(3))
    session = rs.Session()
    session.set_grid(SHAPE, "float32")
    halves = [first[:9].copy(), first[9:].copy()]
    numbers = [session.add_block((0, 0, 0), halves[0]), session.add_block((9, 0, 0), halves[1])]
    session.commit()
    assert same(session, first)
    for number, place in zip(numbers, (slice(0, 9), slice(9, None))):
        session.update_block(number, np.asfortranarray(second[place]))
    session.commit()
    assert same(session, second)
    session.update_block(0, halves[0])
    session.update_block(1, halves[1])
    halves[0][:], halves[1][:] = third[:9], third[9:]
    assert same(session, second)
    session.commit()
    assert same(session, third)


def test_another_grid_begins_anew():
    session = session_of(blob(SHAPE))
    other = blob((9, 12, 7), "uint16")
    session.set_grid(dims=(7, 12, 9), dtype="uint16", spacing=(1, 2, 3), origin=(4, 5, 6))
    session.add_block((0, 0, 0), other)
    assert same(session, blob(SHAPE))
    session.commit()
    assert same(session, other) is False
    assert np.array_equal(
        np.asarray(session.render(size=40)), np.asarray(rs.render(other, size=40, spacing=(1, 2, 3), origin=(4, 5, 6)))
    )


def test_errors_leave_the_session_usable():
    volume = blob(SHAPE)
    session = rs.Session()
    with pytest.raises(rs.InputError, match="set_grid"):
        session.add_block((0, 0, 0), volume)
    with pytest.raises(rs.InputError):
        session.render()
    session.set_grid(SHAPE, "float32")
    half = volume[:9]
    session.add_block((0, 0, 0), half)
    with pytest.raises(rs.InputError, match="(?i)hole|no block|cover"):
        session.commit()
    session.add_block((8, 0, 0), volume[8:])
    with pytest.raises(rs.InputError, match="(?i)overlap"):
        session.commit()
    session.clear_blocks()
    session.add_block((0, 0, 0), volume)
    session.commit()
    for options, error, text in (
        (dict(azimut=1), TypeError, "azimuth"),
        (dict(frame=1), TypeError, "session"),
        (dict(range=(2, 1)), rs.InputError, "ascend"),
        (dict(clip="0:999,:,:"), rs.InputError, "volume"),
        (dict(azimuth=[]), TypeError, "empty"),
    ):
        with pytest.raises(error, match=text):
            session.render(**options)
    assert same(session, volume)
    with pytest.raises(rs.InputError, match="measured"):
        session.render(size=16).error()


@pytest.mark.parametrize(
    "call, error, text",
    [
        (lambda s: s.set_grid((2, 2)), rs.InputError, "three"),
        (lambda s: s.set_grid(), TypeError, "shape"),
        (lambda s: s.set_grid((2, 2, 2), "complex64"), TypeError, "complex64"),
        (lambda s: s.set_grid((2, 2, 2), ">f4"), TypeError, "native"),
        (lambda s: s.set_grid((2, 2, 2), spacing=float("nan")), rs.InputError, "spacing"),
        (lambda s: s.add_block((0, 0, 0), np.zeros((4, 4, 4))), TypeError, "float64"),
        (lambda s: s.add_block((0, 0), np.zeros((4, 4, 4), np.float32)), TypeError, "start"),
        (lambda s: s.add_block((0, 0, 0), np.zeros((4, 4), np.float32)), rs.InputError, "axes"),
        (lambda s: s.update_block(3, np.zeros((4, 4, 4), np.float32)), rs.InputError, "block 3"),
        (lambda s: rs.Session(layout=dict(gpus=3)), TypeError, "gpus"),
        (lambda s: rs.Session(layout=(0, 1)), rs.InputError, ""),
        (lambda s: rs.Session(comm="world"), Exception, "communicator|mpi4py"),
        (lambda s: rs.Session(threads=10**6), rs.InputError, "threads"),
    ],
)
def test_wrong_arguments_are_named(call, error, text):
    session = rs.Session()
    session.set_grid((4, 4, 4), "float32")
    with pytest.raises(error, match=text or None):
        result = call(session)
        if isinstance(result, rs.Session):
            result.set_grid((2, 2, 2), "float32")
            result.add_block((0, 0, 0), blob((2, 2, 2)))
            result.commit()
            result.render(size=8)


def test_arrays_are_kept_until_they_are_replaced():
    class Array(np.ndarray):
        """Unlike ndarray it can be referred to weakly."""

    session = rs.Session()
    session.set_grid((4, 4, 4), "float32")
    array = blob((4, 4, 4)).view(Array)
    seen = weakref.ref(array.base if isinstance(array.base, Array) else array)
    session.add_block((0, 0, 0), array)
    del array
    gc.collect()
    session.commit()
    assert np.asarray(session.render(size=16)).max() > 0
    session.set_grid((2, 2, 2), "float32")
    gc.collect()
    assert seen() is None


def test_a_closed_session_says_so():
    with session_of(blob((4, 5, 6))) as session:
        pass
    with pytest.raises(rs.InputError, match="closed"):
        session.render()


def test_ctrl_c_ends_a_sessions_picture():
    session = session_of(blob((96, 96, 96)))
    timer = threading.Timer(1, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        session.render(azimuth=np.linspace(0, 360, 5000))
    timer.join()
    time.sleep(0)
    assert same(session, blob((96, 96, 96)))


def test_many_steps_leak_nothing():
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    volume = blob((16, 16, 16))
    session = session_of(volume)

    def steps(count):
        for step in range(count):
            session.update_block(0, session._blocks[0].copy())
            session.commit()
            session.render(size=32, quality="draft", azimuth=step)

    steps(100)
    before = resident()
    steps(300)
    assert resident() - before < 300 * 16 * 1024
