"""Long work lets other threads run, ends at Ctrl-C, shows progress and leaks nothing."""

import os
import signal
import subprocess
import sys
import threading
import time
import tracemalloc

import numpy as np
import pytest
import ringsplat as rs
from conftest import blob

SMALL = blob((16, 16, 16))


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def interrupt(work, wait):
    """Does work that would take far longer than a test may, sends SIGINT after a while, and prints how long it went on."""
    sent = []

    def send():
        time.sleep(wait)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        thread.join()
    print(f"ended {time.monotonic() - sent[0]:.3f} s after SIGINT")


@pytest.fixture(scope="module")
def large():
    return blob((160, 160, 160))


def test_ctrl_c_ends_rendering(large):
    views = np.linspace(0, 360, 2000)
    interrupt(lambda: rs.render(large, azimuth=views), 1.5)
    assert np.asarray(rs.render(SMALL, size=16)).max() > 0


def test_ctrl_c_ends_loading():
    tall = np.broadcast_to(blob((1, 256, 256)), (1500, 256, 256))
    interrupt(lambda: [rs.render(tall, size=16) for _ in range(100)], 0.3)
    assert np.asarray(rs.render(SMALL, size=16)).max() > 0


@pytest.mark.parametrize("truth, quality", [("field", "best"), ("method", "best"), ("method", "paper")])
def test_ctrl_c_ends_the_measurement_of_an_error(large, truth, quality):
    image = rs.render(large, size=512, quality=quality)
    work = lambda: [image.error(truth, pixels=10**6, seed=seed) for seed in range(100)]  # noqa: E731
    interrupt(work, 1.5)
    assert np.isfinite(image.error(truth, pixels=50).rms)


def test_an_exception_of_a_signals_handler_comes_through(large):
    def stop(*_):
        raise TimeoutError("enough")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, 0.5)
    try:
        with pytest.raises(TimeoutError, match="enough"):
            rs.render(large, azimuth=np.linspace(0, 360, 2000))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_other_threads_run_meanwhile_and_may_render_too(large):
    turns, done = [], threading.Event()

    def count():
        while not done.is_set():
            turns.append(1)
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    images = []
    others = [
        threading.Thread(target=lambda k=k: images.append((k, rs.render(SMALL, size=40, azimuth=10.0 * k))))
        for k in range(4)
    ]
    for other in others:
        other.start()
    rs.render(large, size=128)
    turns_meanwhile = len(turns)
    for other in others:
        other.join()
    done.set()
    thread.join()
    assert turns_meanwhile > 10
    for k, image in images:
        assert np.array_equal(np.asarray(image), np.asarray(rs.render(SMALL, size=40, azimuth=10.0 * k)))


def test_progress_is_shown_by_tqdm(capsys):
    rs.render(SMALL, size=32, azimuth=range(5), progress=True)
    shown = capsys.readouterr().err
    assert "loading" in shown and "rendering" in shown and "100%" in shown
    rs.render(SMALL, size=32)
    assert capsys.readouterr() == ("", "")


def test_without_tqdm_nothing_is_shown():
    code = (
        "import sys; sys.modules['tqdm'] = None\nimport numpy, ringsplat\n"
        "ringsplat.render(numpy.eye(8)[None].repeat(8, 0), size=16, progress=True)"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert "%" not in done.stdout + done.stderr


def test_what_the_renderer_says_goes_to_logging(caplog):
    with caplog.at_level("INFO", logger="ringsplat"):
        rs.render(SMALL, size=16)
        rs.render(SMALL, size=16, range=(100, 200))
    levels = {record.levelname: record.getMessage() for record in caplog.records}
    assert "--tf auto" in levels["INFO"] and "picture is empty" in levels["WARNING"]


def test_many_pictures_leak_nothing():
    def work(times):
        for k in range(times):
            image = rs.render(SMALL, size=32, azimuth=k, quality="draft")
            image.srgb(), np.asarray(image), image.settings, image._repr_png_()
            with pytest.raises(rs.InputError):
                rs.render(SMALL, tf="no-such")

    work(50)
    tracemalloc.start()
    work(20)
    python_before, memory_before = tracemalloc.get_traced_memory()[0], resident_bytes()
    work(200)
    python_after, memory_after = tracemalloc.get_traced_memory()[0], resident_bytes()
    tracemalloc.stop()
    assert python_after - python_before < 100_000
    assert memory_after - memory_before < 200 * 16 * 1024  # a picture of 16 KiB each time


def test_the_callers_floating_point_environment_stays():
    tiny = np.float32(1e-40)
    assert tiny * np.float32(1.0) > 0
    rs.render(SMALL, size=16)
    assert np.array([1e-40], np.float32)[0] * np.float32(1.0) > 0
    assert (np.full(64, 1e-40, np.float32) * np.float32(0.5) > 0).all()
