"""Tests of `ringsplat serve`: a real server, driven by viewer_client.py.

  check_server.py CASE --program RINGSPLAT --volume FILE [--ranks N --mpiexec MPIEXEC] [--scratch FOLDER]
"""
import argparse, os, shutil, signal, socket, struct, subprocess, sys, time

import viewer_client as vc
from access_cases import allowed, fake_browser, opens, packed_page, page, strangers
from channel_cases import SHOWN, channels, make_channels
from coarse_cases import coarse, coarse_ends, coarse_pyramid, coarse_stopped, gated, make_large, make_pyramid, parts
from compare_cases import compared, make_two, two_volumes
from error_cases import errors
from movie_cases import fake_ffmpeg, movie_failures, movies, no_ffmpeg
from series_cases import make_series, series, series_failures, series_quickly
from server_case import SAME_JPEG, check_rendered, expect, is_alive, start, told
from slice_cases import slices


def bad_messages(options, server):
    client = server.client()

    def complains(message):
        client.send(message)
        error = client.text("error")
        expect(error["message"], "no words")

    good = {"type": "view", "seq": 1, "width": 64, "height": 64}
    for message in ("", "nonsense", '{"type": 7}', "{" * 200, '{"type":"view","state":' + "[" * 30000 + "]" * 30000 + "}",
                    {"type": "ack", "picture": -1}, {"type": "probe", "id": 1}, {**good, "width": 100000}, {**good, "seq": 1e99},
                    {"type": "snapshot", "id": 1, "width": 64, "height": 64, "format": "../../etc/passwd"},
                    {**good, "state": {"camera": 7}}, {**good, "state": {"light": [0, 0, 0]}},
                    {**good, "state": {"transfer_function": {"name": 7}}}):
        complains(message)
    client.send_frame(2, os.urandom(5000))
    client.text("error")
    client.close()

    def ends_connection(opcode, payload):
        other = server.client()
        other.send_frame(opcode, payload)
        other.rest()

    ends_connection(1, b"x" * 70000)  # too large
    ends_connection(1, b"\xff\xfe\xfd")  # no UTF-8
    ends_connection(11, b"")  # no such opcode
    for rubbish in (os.urandom(3000), b"\x16\x03\x01" + os.urandom(100), b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 5000,
                    b"GET /" + b"x" * 100000, b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 99999999999\r\n\r\n"):
        try:
            vc.http(server.port, rubbish + b"\r\n\r\n")
        except (BrokenPipeError, ConnectionResetError):
            pass
    is_alive(server)


def crowd(options, server):
    before = vc.memory_of(server.ranks()[0])
    half_open = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(200)]
    for s in half_open[::2]:
        try:
            s.sendall(b"GET / HTT")
        except OSError:
            pass
    expect(vc.get(server.port).startswith(b"HTTP/1.1 200"), "strangers who say nothing keep the page from others")
    is_alive(server)
    clients, too_many = [], 0
    for _ in range(100):
        try:
            clients.append(vc.Client(server.port, server.token))
        except vc.Refused as error:
            too_many += 1
            expect(error.status == 503, f"status {error.status}")
    expect(len(clients) == 32 and too_many == 68, f"{len(clients)} came in")
    expect(vc.get(server.port).startswith(b"HTTP/1.1 200"), "pages keep the page from others")
    for client in clients:
        client.close()
    for s in half_open:
        s.close()
    time.sleep(0.5)
    is_alive(server)
    expect(vc.memory_of(server.ranks()[0]) < before + (200 << 20), "memory has grown")


def acknowledgement(options, server):
    """No third picture comes while nothing is said of two, whatever else there is to show."""
    client = server.client()

    def next_picture(timeout):
        return client.receive_until(lambda m: isinstance(m, vc.Picture), timeout, acknowledge=False)

    shown = []
    for k in range(30):
        client.view(moving=True, camera={"azimuth": k})
        if len(shown) < 2:
            shown.append(next_picture(20))
        time.sleep(0.02)
    try:
        next_picture(1)
        raise AssertionError("a third picture came")
    except TimeoutError:
        pass
    for picture in shown:
        client.acknowledge(picture)
    picture = client.picture(seq=client.seq, at_rest=1)
    expect(picture.level == picture.levels - 1, "not the best")
    client.close()


def slow_reader(options, server):
    """Acknowledges what it never reads."""
    rank_0 = server.ranks()[0]
    client = server.client(receive_buffer=4096)
    client.view(width=64, height=64)
    client.picture(at_rest=1)
    before = vc.memory_of(rank_0)
    number = 0
    try:
        for k in range(400):
            client.view(moving=True, width=1024, height=1024, camera={"azimuth": k})
            for _ in range(3):
                number += 1
                client.send({"type": "ack", "picture": number})
            if k % 20 == 0:
                client.send({"type": "snapshot", "id": k, "width": 1024, "height": 1024, "format": "exr"})
            time.sleep(0.01)
    except (BrokenPipeError, ConnectionResetError, TimeoutError):
        pass
    expect(vc.memory_of(rank_0) < before + (400 << 20), "memory has grown")
    client.close()
    is_alive(server)


def flood(options, server):
    """Far more messages than a hand makes."""
    client = server.client()
    text = '{"type":"ack","picture":999}'
    for _ in range(3000):
        client.send(text)
    is_alive(server)
    client.close()


def quick_views(options, server):
    client = server.client()
    for k in range(10):
        client.view(camera={"azimuth": 10 * k})
    picture = client.picture(seq=10, at_rest=1)
    expect(picture.level == picture.levels - 1 and picture.rmse == 0, "not the best")
    expect((picture.width, picture.height) == (128, 128), "not the whole size")
    # The same view again: the page waits for its number.
    seq = client.view(camera={"azimuth": 90})
    client.picture(seq=seq, at_rest=1)
    # A view that moves and then stays refines without another word.
    seq = client.view(moving=True, camera={"azimuth": 95})
    first = client.picture(seq=seq)
    last = first if first.at_rest else client.picture(seq=seq, at_rest=1)
    expect(last.level == last.levels - 1, "not refined")
    # Coarse levels now know what they err.
    seq = client.view(camera={"azimuth": 80})
    pictures = []
    client.receive_until(lambda m: isinstance(m, vc.Picture) and (pictures.append(m) or True) and m.at_rest and m.seq == seq)
    expect(all(p.rmse >= 0 for p in pictures if p.level == last.level), "no error is told")
    client.close()


def watchers(options, server):
    first, second = server.client(), server.client()
    expect(first.hello["driver"] and not second.hello["driver"] and second.hello["viewers"] == 2, "who drives")
    first.view(camera={"azimuth": 33})
    shown = first.picture(at_rest=1)
    state = second.text("state")["state"]
    expect(state["camera"]["azimuth"] == 33, "the watcher is not told of the view")
    watched = second.picture(at_rest=1)
    expect(watched.file == shown.file, "the watcher sees another picture")
    second.view(camera={"azimuth": 77})
    second.send({"type": "drive"})
    second.receive_until(lambda m: isinstance(m, dict) and m["type"] == "driver" and m["you"])
    first.receive_until(lambda m: isinstance(m, dict) and m["type"] == "driver" and not m["you"])
    second.view(camera={"azimuth": 55})
    expect(first.text("state")["state"]["camera"]["azimuth"] == 55, "what a watcher sends must not count")
    second.picture(seq=second.seq, at_rest=1)
    second.close()
    first.receive_until(lambda m: isinstance(m, dict) and m["type"] == "driver" and m["you"] and m["viewers"] == 1)
    # Who comes back goes on.
    third = server.client()
    third.text("state")
    third.picture()
    third.close()
    first.close()


def probes(options, server):
    client = server.client()
    client.send({"type": "probe", "id": 1, "x": 5, "y": 5})
    client.text("error")  # no view yet
    client.view(width=200, height=200)
    client.picture(at_rest=1)
    found = client.probe(2, 100, 100)
    dims = client.hello["volume"]["dims"]
    # Seen from the front: straight through the volume's middle, in its front half.
    expect(found["hit"] and abs(found["voxel"][0] - dims[0] / 2) < 2 and abs(found["voxel"][2] - dims[2] / 2) < 2, found)
    expect(client.hello["volume"]["range"][0] < found["value"] <= client.hello["volume"]["range"][1], found)

    def shown(number, x, y, **state):
        client.picture(seq=client.view(width=200, height=200, **state), at_rest=1)
        return client.probe(number, x, y)

    # The head's rows go from back to front.
    behind = shown(3, 100, 100, clip=[[0, dims[0]], [0, dims[1] // 2], [0, dims[2]]])
    expect(behind["hit"] and behind["voxel"][1] < dims[1] // 2 < found["voxel"][1], "the clip box does not count")
    expect(shown(6, 100, 100, clip_planes=[[0, 1, 0, 0]])["voxel"][1] < dims[1] / 2 + 1, "clip planes do not count")
    expect(not shown(4, 1, 1)["hit"], "there is nothing in the corner")
    client.send({"type": "probe", "id": 5, "x": 300, "y": 1})
    client.text("error")
    client.close()


def same_as_program(options, server):
    """The picture at rest and the one that `render --quality best` writes: 45 dB or more."""
    client = server.client()
    client.view(width=256, height=192, camera={"azimuth": 30, "elevation": 20})
    picture = client.picture(at_rest=1)
    snapshot = client.snapshot(7, 256, 192, state={"camera": {"azimuth": 30, "elevation": 20}})
    exr = client.snapshot(8, 40, 30, "exr")
    client.close()
    expect(snapshot.file[:4] == b"\x89PNG", "no PNG")
    expect(exr.file[:4] == b"\x76\x2f\x31\x01" and (exr.width, exr.height) == (40, 30), "no EXR")
    for name, seen, limit in (("seen.jpg", picture, SAME_JPEG), ("snapshot.png", snapshot, 0)):
        check_rendered(options, seen, name, limit, options.volume, "--quality", "best", "--size", "256x192", "--fit", "sphere",
                       "--azimuth", "30", "--elevation", "20")


def sums(options, server):
    """The first function of --mode sum is over the lengths of the volume's rays."""
    hello = server.client().hello
    expect(hello["state"]["mode"] == "sum" and hello["state"]["transfer_function"] == hello["modes"]["sum"], hello["state"])


def make_labels(options):
    """Five labels in a cube's octants; so large that the viewer has reduced levels of it."""
    path, side = os.path.join(options.scratch, "labels_72x72x72_uint8.raw"), 72
    known = (0, 2, 41, 17, 3, 77, 10, 2)
    with open(path, "wb") as file:
        for z in range(side):
            for y in range(side):
                file.write(bytes(known[(x > 30) + 2 * (y > 40) + 4 * (z > 24)] if min(x, y, z) > 5 else 0 for x in range(side)))
    return path


def labels(options, server):
    expect([one["value"] for one in server.client().hello["volume"]["labels"]] == [2, 3, 10, 17, 41, 77], "other labels")
    same_as_program(options, server)


def make_ct(options):
    """Air, soft tissue and bone in layers, each of many values."""
    path, side = os.path.join(options.scratch, "ct_24x24x24_int16.raw"), 24
    with open(path, "wb") as file:
        for z in range(side):
            file.write(struct.pack(f"<{side * side}h", *((-1000, 20, 1200)[3 * z // side] + (7 * i + 5 * z) % 100
                                                         for i in range(side * side))))
    return path


def hounsfield(options, server):
    offered = [one["name"] for one in server.client().hello["presets"]]
    expect({"ct-bone", "ct-skin", "ct-soft", "mr-soft"} <= set(offered), offered)


def ends(options, server):
    client = server.client()
    client.view()
    client.picture(at_rest=1)
    os.kill(server.ranks()[0], signal.SIGTERM)
    end = client.text("end")
    expect(end["message"], "no reason")
    client.rest()
    expect(server.wait() == 0, "the job failed: " + server.errors)


def killed_rank(options, server):
    client = server.client()
    client.view()
    client.picture(at_rest=1)
    os.kill(server.ranks()[-1], signal.SIGKILL)
    expect(client.text("end")["message"], "no reason")
    expect(server.wait() != 0, "a rank's death must fail the job")


def idle(options, server):
    """Without views ranks sleep: far less than a busy wait's, by the kernel's own count."""
    def spent(seconds):
        before = [vc.processor_seconds(r) for r in server.ranks()]
        time.sleep(seconds)
        return max(vc.processor_seconds(r) - b for r, b in zip(server.ranks(), before)) / seconds

    client = server.client()
    client.view()
    client.picture(at_rest=1)
    for who in ("with a client", "without"):
        time.sleep(3)
        share = spent(4)
        print(f"{who}: {100 * share:.1f} % of a core", flush=True)
        expect(share < 0.1, f"{who}: {100 * share:.1f} % of a core")
        client.close()
    is_alive(server)


def errors_have_numbers(options, server):
    client = server.client()
    picture = {"type": "snapshot", "id": 11, "width": 64, "height": 64, "format": "png"}
    client.send({"type": "probe", "id": 10, "x": 5, "y": 5})
    told(client, 10)  # no view yet
    for wrong in ({"format": "gif"}, {"width": -1}, {"state": {"camera": {"zoom": 0}}}, {"state": 7}):
        client.send({**picture, **wrong})
        told(client, 11)
    client.send({"type": "movie_frame", "id": 4294967295, "index": 0, "count": 0})
    told(client, 4294967295)
    client.send({"type": "what", "id": 12})
    told(client, 12)
    for number in (-1, 1.5, 4294967296, "11", None):
        client.send({**picture, "id": number, "format": "gif"})
        told(client, None)
    client.send({"type": "view", "seq": 1, "width": 0, "height": 0})
    told(client, None)
    for number in range(20):  # more than may wait
        client.send({**picture, "id": number, "width": 512, "height": 512})
    answers = set()
    while len(answers) < 20:
        answer = client.receive()
        if isinstance(answer, vc.Picture):
            answers.add(answer.number)
        elif answer["type"] == "error":
            answers.add(answer["id"])
    expect(answers == set(range(20)), answers)
    client.view(width=64, height=64)
    client.picture(at_rest=1)
    for number in range(30):  # a newer probe takes the place of one that has not begun
        client.send({"type": "probe", "id": number, "x": 32, "y": 32})
    answers = set()
    while len(answers) < 30:
        answer = client.receive()
        if isinstance(answer, dict) and answer["type"] in ("probe", "error"):
            answers.add(answer["id"])
    client.close()


def returning(options, server):
    """A page that is loaded anew counts its views from 1 again, and may show the same."""
    first = None
    for _ in range(3):
        client = server.client()
        expect(client.hello["driver"], "nobody else is here")
        expect(client.view(camera={"azimuth": 20}) == 1, "not the first view")
        picture = client.picture(seq=1, at_rest=1)
        expect(first in (None, picture.file), "another picture")
        first = picture.file
        client.close()


AT_ONCE = ("--coarse-above", "0", "--tf", "{scratch}/tf.json")
COARSE = (*AT_ONCE, *gated("{scratch}", "{faults}"))
SERIES = ("--frames", "all", "--tf", "mr-soft")
CASES = {"page": (page,), "packed_page": (packed_page,), "strangers": (strangers,),
         "allowed": (allowed, "--allow-host", "node7:9999", "--allow-origin", "https://hub.example.org"),
         "opens": (opens, "--open", "XDG_RUNTIME_DIR={scratch}/own", "PATH={scratch}/bin:/usr/bin:/bin"),
         "bad_messages": (bad_messages,), "crowd": (crowd,), "acknowledgement": (acknowledgement,),
         "slow_reader": (slow_reader,), "flood": (flood,), "quick_views": (quick_views,), "watchers": (watchers,), "probes": (probes,),
         "same_as_program": (same_as_program,), "labels": (labels, "--coarse-above", "0"), "hounsfield": (hounsfield,), "sums": (sums, "--mode", "sum"), "ends": (ends,), "killed_rank": (killed_rank,), "idle": (idle,),
         "errors_have_numbers": (errors_have_numbers,), "returning": (returning,), "movies": (movies, "TMPDIR={scratch}"),
         "movie_failures": (movie_failures, "TMPDIR={scratch}", "PATH={scratch}/bin"),
         "series": (series, *SERIES), "series_quickly": (series_quickly, *SERIES),
         "series_failures": (series_failures, *SERIES), "compared": (compared, *SERIES),
         "two_volumes": (two_volumes, "{scratch}/b/density.nrrd"),
         "coarse": (coarse, *COARSE), "coarse_ends": (coarse_ends, *COARSE), "coarse_stopped": (coarse_stopped, *COARSE),
         "coarse_pyramid": (coarse_pyramid, *AT_ONCE), "parts": (parts, "--memory", "1M", "--tf", "{scratch}/tf.json"),
         "channels": (channels, "--channel", SHOWN), "slices": (slices,), "errors": (errors,),
         "no_ffmpeg": (no_ffmpeg, "TMPDIR={scratch}", "PATH={scratch}/empty")}
SKIPPED = 77  # CTest's SKIP_RETURN_CODE

if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("case", choices=CASES)
    parser.add_argument("--program", required=True)
    parser.add_argument("--volume", required=True)
    parser.add_argument("--ranks", type=int, default=0)
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--scratch", default=".")
    parser.add_argument("--faults", help="what is preloaded to make files do as a test wants")
    given = parser.parse_args()
    test, *more = CASES[given.case]
    if given.case == "movies" and not (shutil.which("ffmpeg") and shutil.which("ffprobe")):
        print("skipped: install ffmpeg")
        sys.exit(SKIPPED)
    given.scratch = os.path.join(os.path.abspath(given.scratch), given.case)
    shutil.rmtree(given.scratch, ignore_errors=True)
    os.makedirs(given.scratch)
    fake_ffmpeg(given, "exit 1\n")
    fake_browser(given)
    if "--frames" in more:
        given.volume = make_series(given)
    made = {"labels": make_labels, "hounsfield": make_ct, "channels": make_channels,
            **dict.fromkeys(("coarse", "coarse_ends", "coarse_stopped"), make_large),
            "coarse_pyramid": make_pyramid, "parts": make_pyramid, "two_volumes": make_two}
    if given.case in made:
        given.volume = made[given.case](given)
    running = start(given, *(word.format(scratch=given.scratch, faults=given.faults) for word in more))
    try:
        test(given, running)
        may_be_gone = ("ends", "errors", "coarse_ends", "coarse_stopped", "parts", "killed_rank", "movie_failures", "opens")
        expect(running.process.poll() is None or given.case in may_be_gone, "the server is gone")
        if running.process.poll() is None:
            expect(running.stop() == 0, "the job failed: " + running.errors)
    except BaseException:
        print(running.errors, file=sys.stderr)
        raise
    finally:
        running.kill()
