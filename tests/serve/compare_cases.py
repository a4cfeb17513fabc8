"""Two volumes from one view: `serve A B`, and two of a series."""
import os, shutil, struct, subprocess, zlib

import viewer_client as vc
from series_cases import BROKEN, as_shown, is_the_programs, show
from server_case import expect, is_alive, is_within, start

LOSSY = 255 * 10 ** (-45 / 20)  # of a picture at rest, as a JPEG


def pair(client, **wanted):
    """A view's two pictures, one below the other in one file."""
    return client.picture(pictures=2, **wanted)


def rows_of(file):
    """A PNG's header and its rows, without filters."""
    chunks, at = {b"IDAT": b""}, 8
    while at < len(file):
        length, kind = struct.unpack(">I4s", file[at:at + 8])
        chunks[kind] = chunks.get(kind, b"") + file[at + 8:at + 8 + length]
        at += length + 12
    width, height, depth, colours = struct.unpack(">IIBB", chunks[b"IHDR"][:10])
    each, data = depth // 8 * {2: 3, 6: 4}[colours], zlib.decompress(chunks[b"IDAT"])
    rows, above, line = [], bytes(width * each), width * each + 1
    for y in range(height):
        how, row = data[y * line], bytearray(data[y * line + 1:(y + 1) * line])
        for x in range(len(row)):
            left, up, corner = row[x - each] if x >= each else 0, above[x], above[x - each] if x >= each else 0
            nearest = min((left, up, corner), key=lambda v: abs(left + up - corner - v))
            row[x] = row[x] + (0, left, up, (left + up) // 2, nearest)[how] & 255
        rows.append(bytes(row))
        above = row
    return chunks[b"IHDR"], rows


def one_below_the_other(options, frames):
    """What `render` makes of volumes of the series, in one PNG. Returns its path."""
    rows = []
    for frame in frames:
        drawn = os.path.join(options.scratch, f"drawn_{frame}.png")
        subprocess.run([options.program, "render", os.path.join(options.scratch, f"step_{frame + 7}.nrrd"), "-o", drawn,
                        "--background", "black", *as_shown(options)], check=True, capture_output=True)
        with open(drawn, "rb") as file:
            header, more = rows_of(file.read())
        rows += more

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    path = os.path.join(options.scratch, "drawn_both.png")
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header[:4] + struct.pack(">I", len(rows)) + header[8:]) +
                   chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))) + chunk(b"IEND", b""))
    return path


def compared(options, server):
    client, watcher = server.client(), server.client()
    seq = show(client, 0, compare=2)
    beside = pair(client, seq=seq, at_rest=1)
    watched = watcher.text("state")["state"]
    expect((watched["frame"], watched["compare"], watched["difference"]) == (0, 2, 0), watched)
    expect(pair(watcher, at_rest=1).file == beside.file, "the watcher sees another picture")
    watcher.close()
    seq = show(client, 0, compare=2, difference=4)
    exact = pair(client, seq=seq, at_rest=1)
    seq = show(client, 1)
    alone = client.picture(seq=seq, at_rest=1)
    expect(alone.pictures == 1 and (beside.width, beside.height) == (160, 120), "not the size or number of pictures")
    turned_together(client)
    same_volume(client)
    values_of_both(client)
    wrong(client)
    failure(client)
    client.close()
    is_alive(server)
    drawn = one_below_the_other(options, (0, 2))
    for picture, limit, name in ((beside, LOSSY, "both.jpg"), (exact, 0, "both.png")):
        is_within(options, picture, name, limit, drawn)
    is_the_programs(options, alone, 1, LOSSY)


def turned_together(client):
    """While it is turned, too, a picture is never without the other one of its view; and views give way to newer ones."""
    shown = set()
    for k in range(8):
        for more in range(5):
            newest = client.view(moving=True, width=160, height=120, frame=0, compare=2, camera={"azimuth": 15.0 * k + more})
        while newest not in shown:
            shown.add(pair(client).seq)
    expect(len(shown) < 40, "no view gave way")
    last = show(client, 0, compare=2)
    pair(client, seq=last, at_rest=1)


def without_loading(client, seq, pictures):
    loads = []
    first = client.receive_until(lambda m: loads.append(m) if isinstance(m, dict) and m.get("status") == "loading" else
                                 isinstance(m, vc.Picture) and m.seq == seq and m.at_rest)
    expect(not loads and first.pictures == pictures, f"{first.pictures} pictures, and what is held is loaded again: {loads}")
    return first


def same_volume(client):
    """What is held is not loaded again, also where the two change places; a volume is not compared with itself."""
    for frame, other, pictures in ((2, 0, 2), (0, 0, 1)):
        without_loading(client, show(client, frame, compare=other), pictures)


def values_of_both(client):
    """A pixel of either picture is of its volume, as if that were shown alone."""
    show(client, 1, compare=2)
    asked = {}
    for number, more in ((1, {}), (2, {"compared": True})):
        client.send({"type": "probe", "id": number, "x": 80, "y": 60, **more})
        asked[number] = client.text("probe")
        expect(asked[number]["id"] == number and asked[number]["hit"], asked)
    show(client, 2)
    client.send({"type": "probe", "id": 2, "x": 80, "y": 60})
    expect(client.text("probe") == asked[2] and asked[1]["value"] != asked[2]["value"], asked)


def wrong(client):
    for state, words in (({"compare": -1}, "compare must be a number"), ({"compare": 6}, "compare must be a number"),
                         ({"compare": "1"}, "compare must be a number"), ({"compare": 0.5}, "compare must be a whole number"),
                         ({"compare": 1, "difference": 2}, "difference must be 0, 1, 4 or 16"),
                         ({"difference": -1}, "difference must be a number")):
        client.send({"type": "view", "seq": 1, "width": 64, "height": 64, "state": state})
        message = client.text("error")["message"]
        expect(words in message, f"{state}: {message}")


def failure(client):
    """One of the two cannot be loaded: it alone is told of."""
    show(client, 1, compare=BROKEN)
    failed = client.receive_until(lambda m: isinstance(m, dict) and m["type"] == "frame" and m["status"] == "failed")
    expect(failed["frame"] == BROKEN, failed)
    expect(f"step_{BROKEN + 7}.nrrd" in client.text("error")["message"], "the error does not name the file")
    seq = show(client, 1)
    client.picture(seq=seq, at_rest=1)


def make_two(options):
    """Two of the same name in two folders and one on another grid. Returns the first."""
    for name, shape, dims in (("a/density", "shell", "24x20x28"), ("b/density", "ball", "24x20x28"), ("other", "ball", "8x8x8")):
        path = os.path.join(options.scratch, f"{name}.nrrd")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        subprocess.run([options.program, "synth", shape, "-o", path, "--dims", dims], check=True, capture_output=True)
    return os.path.join(options.scratch, "a", "density.nrrd")


def two_volumes(options, server):
    """Volumes that are named one by one are a series, those of the same name by their paths; all on one grid."""
    client = server.client()
    same = [os.path.join(options.scratch, folder, "density.nrrd") for folder in "ab"]
    expect(client.hello["frames"] == same, client.hello["frames"])
    expect(client.hello["state"]["compare"] == 1, "the first scene is not of both")
    without_loading(client, client.view(), 2)
    first, second = [client.picture(seq=client.view(frame=frame, compare=None), at_rest=1) for frame in (0, 1)]
    expect(first.file != second.file, "the same picture twice")
    client.close()
    broken = shutil.copy(same[1], os.path.join(options.scratch, "broken.nrrd"))
    os.truncate(broken, os.path.getsize(broken) - 100)
    without_the_second(start(options, broken), broken)
    # What cannot be shown is refused at once, not when somebody looks at it.
    for more, words in ((["--frames", "all"], "--frames"), ([same[1][:-1]], f"cannot open {same[1][:-1]}: No such file"),
                        (["step_*.nrrd"], "step_*.nrrd is no file, but a pattern for several"),
                        ([os.path.join(options.scratch, "other.nrrd")], "must lie on one grid")):
        refused = subprocess.run([options.program, "serve", *same, *more], capture_output=True, text=True, timeout=60)
        expect(refused.returncode == 2 and words in refused.stderr, refused.stderr)


def without_the_second(server, broken):
    """The second's values turn out to be broken at the start: the first is shown, the other told of."""
    client = server.client()
    client.view()
    expect(broken in client.text("error")["message"], "the error does not name the file")
    client.picture(seq=client.view(compare=None), at_rest=1)
    client.close()
    server.stop()
