"""The viewer with a series of volumes: `serve PATTERN --frames all`."""
import os, subprocess

import viewer_client as vc
from server_case import SAME_JPEG, check_rendered, expect, is_alive

SHAPES = ("gaussians", "shell", "ball", "box", "gaussians", "shell")
BROKEN = 4


def make_series(options):
    """Files of one grid, every second compressed; the one numbered BROKEN ends too early. Returns their pattern. A
    preset depends on its volume's histogram: the first one's goes into a file."""
    for number, shape in enumerate(SHAPES):
        path = os.path.join(options.scratch, f"step_{number + 7}.nrrd")
        more = [] if number % 2 else ["--no-compression"]
        subprocess.run([options.program, "synth", shape, "-o", path, "--dims", "48x40x44", *more], check=True,
                       capture_output=True)
        if number == BROKEN:
            os.truncate(path, os.path.getsize(path) // 2)
    subprocess.run([options.program, "render", os.path.join(options.scratch, "step_7.nrrd"), "-o",
                    os.path.join(options.scratch, "first.png"), "--tf", "mr-soft", "--size", "16", "--tf-out",
                    os.path.join(options.scratch, "tf.json")], check=True, capture_output=True)
    return os.path.join(options.scratch, "step_*.nrrd")


def is_frame(frame, status):
    return lambda m: isinstance(m, dict) and m["type"] == "frame" and (m["frame"], m["status"]) == (frame, status)


def as_shown(options):
    """The words with which `render` draws what show() asks for, with the transfer function of the first."""
    return ("--quality", "best", "--size", "160x120", "--azimuth", "30", "--fit", "sphere", "--tf",
            os.path.join(options.scratch, "tf.json"))


def is_the_programs(options, picture, number, limit):
    """The same as `render` of the volume by itself."""
    volume = os.path.join(options.scratch, f"step_{number + 7}.nrrd")
    check_rendered(options, picture, "seen.png" if limit == 0 else "seen.jpg", limit, volume, *as_shown(options))


def show(client, frame, **more):
    return client.view(width=160, height=120, frame=frame, camera={"azimuth": 30}, **more)


def series(options, server):
    client = server.client()
    expect(client.hello["frames"] == [f"step_{k + 7}.nrrd" for k in range(len(SHAPES))], client.hello["frames"])
    watcher = server.client()
    seen = []  # compared when the pages have gone: who answers no ping for a minute is sent away
    for frame in (0, 1, 2, 3, 2, 5, 0):
        seq = show(client, frame)
        if frame == 5:
            watcher.receive_until(is_frame(5, "shown"))
        watcher.receive_until(lambda m: isinstance(m, dict) and m["type"] == "state" and m["state"]["frame"] == frame)
        seen.append((client.picture(seq=seq, at_rest=1), frame, SAME_JPEG))
        watcher.picture(at_rest=1)
    watcher.close()
    seen += requests(client)
    bounds(client)
    client.close()
    is_alive(server)
    for picture, frame, limit in seen:
        is_the_programs(options, picture, frame, limit)


def requests(client):
    """Files and probes are of the frame that they say, whatever is shown. Returns pictures to be compared."""
    show(client, 1)
    client.picture(at_rest=1)
    for number, frame in ((5, 3), (6, 2)):
        client.send({"type": "snapshot", "id": number, "width": 160, "height": 120, "format": "png",
                     "state": {"camera": {"azimuth": 30}, "frame": frame}})
    seen = []
    for number, frame in ((5, 3), (6, 2)):
        snapshot = client.receive_until(lambda m: isinstance(m, vc.Picture) and m.kind == 1)
        expect(snapshot.number == number, "not the snapshot that was asked for first")
        seen.append((snapshot, frame, 0))
    values = {}
    for frame in (1, 2):
        show(client, frame)
        values[frame] = client.probe(frame, 80, 60)
        expect(values[frame]["hit"], values[frame])
    expect(values[1] != {**values[2], "id": 1}, "the same value in both frames")
    return seen


def bounds(client):
    for frame in (-1, len(SHAPES), "1", None, 10 ** 30):
        client.send({"type": "view", "seq": 1, "width": 64, "height": 64, "state": {"frame": frame}})
        expect(client.text("error")["message"], "no words")


def series_quickly(options, server):
    """A slider that is dragged loads the newest, not all, and ends in the last."""
    client = server.client()
    show(client, 0)
    client.picture(at_rest=1)
    for _ in range(10):
        for frame in (1, 2, 3, 2):
            show(client, frame, moving=True)
    last = show(client, 3)
    loads, picture = 0, None
    while not (isinstance(picture, vc.Picture) and picture.seq == last and picture.at_rest):
        picture = client.receive()
        loads += isinstance(picture, dict) and picture["type"] == "frame" and picture["status"] == "shown"
        if isinstance(picture, vc.Picture):
            client.acknowledge(picture)
    expect(1 <= loads < 30, f"{loads} volumes were loaded for 41 views")
    is_the_programs(options, picture, 3, SAME_JPEG)
    client.close()


def series_failures(options, server):
    """A volume that cannot be loaded is told, and the one before is still there."""
    client = server.client()
    show(client, 1)
    client.picture(at_rest=1)
    show(client, BROKEN)
    client.receive_until(is_frame(BROKEN, "loading"))
    client.receive_until(is_frame(BROKEN, "failed"))
    expect(f"step_{BROKEN + 7}.nrrd" in client.text("error")["message"], "the error does not name the file")
    client.receive_until(is_frame(1, "shown"))
    client.send({"type": "snapshot", "id": 9, "width": 64, "height": 48, "format": "png", "state": {"frame": BROKEN}})
    error = client.receive_until(lambda m: isinstance(m, dict) and m["type"] == "error" and "id" in m)
    expect(error["id"] == 9, error)
    seq = show(client, 2)
    is_the_programs(options, client.picture(seq=seq, at_rest=1), 2, SAME_JPEG)
    client.close()
    is_alive(server)
