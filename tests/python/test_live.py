"""A session that is shown in browsers while its program runs."""

import pathlib
import re
import sys
import threading
import urllib.request

import numpy as np
import pytest
import ringsplat as rs
from conftest import blob

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "serve"))
import viewer_client as vc

SHAPE = (16, 18, 20)


def served(volume, **options):
    session = rs.Session()
    session.set_grid(volume.shape, volume.dtype, unit="mm")
    session.add_block((0, 0, 0), volume)
    session.commit()
    return session, session.serve(**options)


def client_of(url):
    _, port, token = re.match(r"http://([^:]*):(\d+)/#(.*)", url).groups()
    client = vc.Client(int(port), token)
    client.hello = client.text("hello")
    return client


def run_of(client, **wanted):
    return client.receive_until(
        lambda m: isinstance(m, dict) and m["type"] == "run" and all(m[k] == v for k, v in wanted.items())
    )


def held_run(client, width):
    """What is said of the simulation once it is held and has been drawn."""
    client.send({"type": "steer", "act": "pause"})
    client.picture(seq=client.view(width=width, height=64), at_rest=1)
    client.send({"type": "steer", "act": "pause"})
    return run_of(client, paused=True)


def test_a_page_sees_each_step_and_changes_what_is_offered():
    volume = blob(SHAPE, "float32")
    session, url = served(volume, tf="grey", name="wave", share=0.5)
    session.offer("gain", 1.0, 0.0, 4.0)
    session.offer("field", 0, choices=["wave", "speed"])
    seen = {}

    def look():
        client = client_of(url)
        assert (client.hello["volume"]["name"], client.hello["volume"]["unit"]) == ("wave", "mm")
        assert client.hello["state"]["transfer_function"]["name"] == "grey"
        client.picture(seq=client.view(width=64, height=64))
        seen["held"] = held_run(client, 66)["step"]
        offered = held_run(client, 67)["parameters"]
        assert [one["choices"] for one in offered] == [[], ["wave", "speed"]]
        client.send({"type": "steer", "act": "set", "parameter": "gain", "value": 3})
        client.send({"type": "steer", "act": "set", "parameter": "field", "value": 0.5})
        assert "whole number" in client.text("error")["message"]
        client.send({"type": "steer", "act": "set", "parameter": "field", "value": 1})
        client.send({"type": "steer", "act": "step"})
        run_of(client, step=seen["held"] + 1, paused=True)
        seen["high"] = held_run(client, 68)["histogram"]["high"]
        client.send({"type": "steer", "act": "resume"})
        seen["end"] = client.text("end")["message"]

    thread = threading.Thread(target=look)
    thread.start()
    gains, start = [], volume.copy()
    while "high" not in seen and thread.is_alive():
        numbers = session.show(len(gains), 0.5 * len(gains))
        gains.append(numbers["gain"])
        np.multiply(start, gains[-1], out=volume)
    session.close()
    thread.join(20)
    assert set(gains) == {1.0, 3.0} and numbers["field"] == 1
    assert seen["high"] == pytest.approx(3 * start.max(), rel=1e-6)
    assert "ended" in seen["end"]


def test_the_page_may_be_shown_by_a_notebook():
    _, url = served(blob(SHAPE, "float32"))
    with urllib.request.urlopen(url.split("#")[0], timeout=10) as reply:
        assert "frame-ancestors http://localhost:*" in reply.headers["Content-Security-Policy"]


def test_what_is_wrong_is_said():
    volume = blob(SHAPE, "float32")
    session, url = served(volume)
    port = int(re.search(r":(\d+)/", url)[1])
    with pytest.raises(rs.InputError, match="cannot listen"):
        served(volume, port=port)
    with pytest.raises(rs.InputError, match="share 0 is not in"):
        served(volume, share=0)
    with pytest.raises(TypeError, match="one view"):
        served(volume, azimuth=[1, 2])
    with pytest.raises(TypeError, match="no option"):
        served(volume, colour="red")
    with pytest.raises(rs.InputError, match="no finite value"):
        served(np.full(SHAPE, np.nan, "float32"))
    fresh = rs.Session()
    with pytest.raises(rs.InputError, match="no volume yet"):
        fresh.serve()
    with pytest.raises(rs.InputError, match="call serve"):
        fresh.show(1)
    with pytest.raises(rs.InputError, match="call serve"):
        fresh.offer("gain", 1, 0, 2)
    assert session.show(1) == {}
