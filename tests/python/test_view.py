"""The viewer from Python."""

import http.client
import os
import subprocess
import sys
import time
import urllib.request

import numpy as np
import pytest
import ringsplat as rs
from conftest import HEAD, blob


def policy_of(url):
    with urllib.request.urlopen(url.split("#")[0], timeout=10) as reply:
        assert "ringsplat" in reply.read().decode().lower()
        return reply.headers["Content-Security-Policy"]


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_a_page_is_served_until_it_is_closed():
    with rs.view(blob((8, 9, 10)), spacing=(1, 2, 3), tf="grey") as view:
        assert view.url.startswith("http://127.0.0.1:") and not view.closed
        assert "frame-ancestors http://localhost:* http://127.0.0.1:*" in policy_of(view.url)
        frame = view._repr_html_()
        assert frame.startswith("<iframe") and view.url in frame
        pid = view._process.pid
    assert view.closed and not alive(pid)
    view.close()
    with pytest.raises(OSError):
        policy_of(view.url)


def test_frames_are_allowed_only_where_it_is_said(tmp_path):
    with rs.view(HEAD, frame_origins=["https://hub.example.org"]) as view:
        assert "frame-ancestors https://hub.example.org;" in policy_of(view.url)
    with rs.view(HEAD, frame_origins=[]) as view:
        assert "frame-ancestors 'none';" in policy_of(view.url)
    with pytest.raises(rs.InputError, match="allow-frame"):
        rs.view(HEAD, frame_origins=["*; script-src *"])


def test_a_page_goes_through_a_jupyter_server():
    with rs.view(HEAD, through="https://hub.example.org/user/anna/") as view:
        page, token = view.url.split("#")
        port = page.split("/")[-2]
        assert page == f"https://hub.example.org/user/anna/proxy/{port}/" and token
        for host, status in (("hub.example.org", 200), ("example.org", 421)):
            connection = http.client.HTTPConnection("127.0.0.1", int(port), timeout=10)
            connection.request("GET", "/", headers={"Host": host})
            reply = connection.getresponse()
            assert reply.status == status
            assert status != 200 or "https://hub.example.org" in reply.headers["Content-Security-Policy"]


@pytest.mark.parametrize(
    "options, error, text",
    [
        (dict(tf="mr-skn"), rs.InputError, "mr-skin"),
        (dict(azimut=1), TypeError, "azimuth"),
        (dict(max_error=1), rs.InputError, "max-error"),
        (dict(port=99999), rs.InputError, "port"),
    ],
)
def test_errors_of_the_viewer_are_raised(options, error, text):
    with pytest.raises(error, match=text):
        rs.view(blob((4, 4, 4)), **options)


def test_the_viewer_ends_with_python_and_leaves_no_file(tmp_path):
    code = (
        "import numpy, ringsplat; view = ringsplat.view(numpy.arange(64.0).reshape(4, 4, 4)); "
        "print(view._process.pid, flush=True)"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, env=environment)
    pid = int(done.stdout)
    deadline = time.monotonic() + 10
    while alive(pid) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not alive(pid) and list(tmp_path.iterdir()) == []


def test_the_viewer_reads_the_array_as_it_lies_in_the_world(tmp_path):
    from ringsplat import _core
    from ringsplat._volume import volume_of

    array = blob((8, 9, 10), "int16")[:, ::-1]
    place = dict(spacing=(1, 2, 3), origin=(4, 5, 6), direction=[[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    volume = volume_of(array, place["spacing"], place["origin"], place["direction"], None)
    _core.write_volume(volume.core(), str(tmp_path / "a.nrrd"))
    assert np.array_equal(
        np.asarray(rs.render(tmp_path / "a.nrrd", size=40)), np.asarray(rs.render(array, size=40, **place))
    )
