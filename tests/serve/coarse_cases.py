"""The viewer while a large volume is loaded: `serve --coarse-above 0`. Slice 1, which coarse data leaves out, is read in
three passes, of the volume and its levels at half and a quarter. Each waits for a gate (faults/fault_at_read.cpp), and
whatever happens happens between two of them."""
import glob, os, signal, subprocess, time

import viewer_client as vc
from server_case import check_rendered, expect, is_alive, told

SLICE_BYTES = 64 * 64 * 2


def write_function(options, volume):
    """One that does not depend on what is read first."""
    subprocess.run([options.program, "render", volume, "-o", os.path.join(options.scratch, "first.png"), "--size", "16",
                    "--tf", "mr-soft", "--tf-out", os.path.join(options.scratch, "tf.json")], check=True, capture_output=True)


def make_large(options):
    subprocess.run([options.program, "synth", "shell", "-o", os.path.join(options.scratch, "large.raw"), "--dims", "64x64x64",
                    "--type", "uint16"], check=True, capture_output=True)
    volume, = glob.glob(os.path.join(options.scratch, "large_*.raw"))
    write_function(options, volume)
    return volume


def gated(scratch, faults):
    """What the server finds in its environment."""
    preloaded = ":".join(filter(None, [os.environ.get("LD_PRELOAD"), faults]))  # a sanitizer's comes first
    return f"LD_PRELOAD={preloaded}", "FAULT=wait", f"FAULT_AT={SLICE_BYTES}", f"FAULT_GATE={scratch}/gate_"


def open_gates(scratch, *numbers):
    for number in numbers:
        open(os.path.join(scratch, f"gate_{number}"), "w").close()


def is_loading(message):
    return isinstance(message, dict) and message["type"] == "loading"


def coarse_picture(options, client, gate, azimuth):
    """That of a view which came while a pass waited."""
    seq = client.view(width=160, height=120, camera={"azimuth": azimuth, "elevation": 20})
    client.send({"type": "what", "id": gate})
    told(client, gate)  # the view was taken before
    open_gates(options.scratch, gate)
    picture = client.picture(seq=seq)
    expect("of the voxels" in client.hello["levels"][picture.level], f"level {picture.level} while the volume is loaded")
    expect(not picture.at_rest, "nothing finer will come")
    return picture


def is_the_programs(options, snapshot):
    check_rendered(options, snapshot, "seen.png", 0, options.volume, "--quality", "best", "--size", "160x120", "--azimuth", "30",
                   "--elevation", "20", "--fit", "sphere", "--tf", os.path.join(options.scratch, "tf.json"))


def coarse(options, server):
    client = server.client()
    expect(client.receive_until(is_loading)["part"] < 1, "all is loaded")
    first = coarse_picture(options, client, 1, 30)
    client.send({"type": "snapshot", "id": 5, "width": 160, "height": 120, "format": "png", "state": {"camera": {"azimuth": 30, "elevation": 20}}})
    turned = coarse_picture(options, client, 2, 70)
    expect(first.file != turned.file, "the volume did not turn")
    open_gates(options.scratch, *range(3, 12))
    client.receive_until(lambda m: is_loading(m) and m["part"] == 1)
    seen = {}
    while len(seen) < 2:  # they come in any order
        picture = client.receive_until(lambda m: isinstance(m, vc.Picture) and (m.kind == 1 or m.at_rest))
        seen[picture.kind] = picture
    expect((seen[0].seq, seen[0].level + 1) == (turned.seq, seen[0].levels), "the view that was shown is not drawn again")
    is_the_programs(options, seen[1])
    later = server.client()
    expect(later.hello["state"] == client.hello["state"], "the first scene has changed")
    client.close()
    later.close()
    is_alive(server)


def coarse_ends(options, server):
    """What goes wrong behind the coarse data is told and ends the job."""
    client = server.client()
    coarse_picture(options, client, 1, 30)
    os.truncate(options.volume, os.path.getsize(options.volume) // 2)
    open_gates(options.scratch, *range(2, 12))
    expect(os.path.basename(options.volume) in client.text("end")["message"], "the error does not name the file")
    expect(server.wait() != 0, "half a volume counts as a whole one")


def coarse_stopped(options, server):
    client = server.client()
    coarse_picture(options, client, 1, 30)
    os.kill(server.ranks()[0], signal.SIGTERM)
    expect(client.text("end")["message"], "no reason")
    open_gates(options.scratch, 2)  # the pass that waits ends, no other begins
    expect(server.wait() == 0, "the job failed: " + server.errors)


def make_pyramid(options):
    path, pyramid = (os.path.join(options.scratch, name) for name in ("large.nrrd", "large.zarr"))
    subprocess.run([options.program, "synth", "shell", "-o", path, "--dims", "128x129x130", "--spacing", "0.7x0.9x1.1"],
                   check=True, capture_output=True)
    subprocess.run([options.program, "pyramid", path, pyramid], check=True, capture_output=True)
    write_function(options, path)
    return pyramid


def coarse_pyramid(options, server):
    """The next level was shown, and then the whole."""
    client = server.client()
    client.receive_until(lambda m: is_loading(m) and m["part"] == 1)
    snapshot = client.snapshot(5, 160, 120, state={"camera": {"azimuth": 30, "elevation": 20}})
    is_the_programs(options, snapshot)
    client.close()


def opened_again(server, number):
    """A client of the part of that number, which is not there at once."""
    end = vc.deadline(30)
    while time.monotonic() < end:
        try:
            client = server.client()
        except (OSError, vc.Closed, vc.Refused):
            time.sleep(0.1)
            continue
        expect(client.hello["part"] == number, client.hello["part"])
        return client
    raise AssertionError(f"part {number} does not come")


def parts(options, server):
    """What a view shows is read at the finest level, of which the whole does not fit; and back."""
    spacing, camera = (0.7, 0.9, 1.1), {"azimuth": 0, "elevation": 0, "zoom": 4}
    client = server.client()
    whole = client.hello
    expect((whole["volume"]["dims"], whole["finer"], whole["is_part"]) == ([64, 65, 65], True, False), whole["volume"]["dims"])
    client.send({"type": "part", "seen": True, "width": 160, "height": 120, "state": {"camera": camera, "clip": [[0, 64], [0, 30], [0, 65]]}})
    expect(client.text("opening"), "not told")
    client.rest()
    client = opened_again(server, 1)
    part, state = client.hello["volume"], client.hello["state"]
    expect((client.hello["finer"], client.hello["is_part"]) == (False, True), client.hello)
    expect(part["dims"][1] == 60 and 90 < part["dims"][0] < 110 and 44 < part["dims"][2] < 58, part["dims"])
    expect(all(abs(a - b) < 1e-6 for a, b in zip(part["spacing"], spacing)), part["spacing"])
    expect((state["camera"]["zoom"], state["clip"]) == (1, None), state)
    first = [round((part["origin"][k] + 0.5 * spacing[k] - whole["volume"]["origin"][k]) / spacing[k]) for k in range(3)]
    crop = ",".join(f"{f}:{f + n}" for f, n in zip(first, part["dims"]))
    check_rendered(options, client.snapshot(5, 160, 120), "part.png", 0.01, options.volume, "--quality", "best", "--size", "160x120",
                   "--azimuth", "0", "--elevation", "0", "--fit", "sphere", "--tf", os.path.join(options.scratch, "tf.json"), "--crop", crop)
    client.send({"type": "part", "seen": False, "width": 160, "height": 120, "state": {}})
    client.rest()
    client = opened_again(server, 2)
    expect((client.hello["volume"]["dims"], client.hello["is_part"]) == ([64, 65, 65], False), "not the whole")
    client.send({"type": "part", "id": 9, "seen": True, "width": 160, "height": 120, "state": {"camera": {"pan": [90, 0]}}})
    expect("nothing of the volume" in told(client, 9), "an empty part is opened")
    client.send({"type": "part", "id": 10, "seen": True, "width": 160, "height": 120, "state": {"clip_planes": [[1, 0, 0, 100]]}})
    expect("nothing of the volume" in told(client, 10), "what is cut away is opened")
    client.send({"type": "part", "id": 11, "seen": False, "width": 160, "height": 120, "state": {}})
    expect("all is shown already" in told(client, 11), "the same is opened again")
    client.send({"type": "part", "id": 12, "seen": True, "width": 160, "height": 120, "state": {"camera": {"fov": 60, "distance": 0.01}}})
    expect("inside the volume" in told(client, 12), "what cannot be drawn is opened")
    client.send({"type": "part", "seen": True, "width": 160, "height": 120, "state": {"camera": {"zoom": 5}}})
    client.text("opening")
    expect(server.stop() in (0, 143, -15), "the job goes on")
