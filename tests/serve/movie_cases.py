"""Films that a running server makes."""
import glob, json, os, signal, subprocess

import viewer_client as vc
from server_case import expect, is_alive, told, until


def movie_folders(options):
    return glob.glob(os.path.join(options.scratch, "ringsplat-movie-*"))


def until_gone(what, there):
    until(what + " is still there", lambda: not there())


def movie_frame(client, number, index, count=3, **more):
    client.send({"type": "movie_frame", "id": number, "index": index, "count": count, "fps": 10, "width": 131,
                 "height": 97, "state": {"camera": {"azimuth": 30 * index}}, **more})


def movie_frame_done(client, number, index):
    done = client.text("movie_frame")
    expect((done["id"], done["index"]) == (number, index), done)


def movies(options, server):
    first, second = server.client(), server.client()
    expect(first.hello["ffmpeg"], "ffmpeg is not found")
    for index in range(3):
        movie_frame(first, 5, index)
        if index < 2:
            movie_frame_done(first, 5, index)
            expect(len(movie_folders(options)) == 1, "no folder")
            expect(os.stat(movie_folders(options)[0]).st_mode & 0o777 == 0o700, "others may look into the folder")
            movie_frame(second, 6, 0)
            told(second, 6)
    movie = first.receive_until(lambda m: isinstance(m, vc.Picture) and m.kind == 2, timeout=60)
    expect((movie.number, movie.format, movie.width, movie.height) == (5, 3, 132, 98), "another head")
    until_gone("the folder", lambda: movie_folders(options))
    check_movie(options, first, movie)

    def is_given_up(number, answer):
        """And another may be made."""
        answer()
        until_gone("the folder", lambda: movie_folders(options))
        movie_frame(second, number, 0)
        movie_frame_done(second, number, 0)
        second.send({"type": "cancel", "id": number})
        until_gone("the folder", lambda: movie_folders(options))

    for number, wrong in ((20, {"index": 2}), (21, {"index": 0, "count": 4, "fps": 0}), (22, {"index": 1, "count": 4}),
                          (23, {"index": 1, "fps": 11}), (24, {"index": 1, "width": 130}), (25, {"index": 1, "state": 7})):
        movie_frame(first, number, 0)
        movie_frame_done(first, number, 0)
        movie_frame(first, number, **wrong)
        is_given_up(number, lambda: told(first, number))
        movie_frame(first, number, 1)
        told(first, number)  # there is no such movie any more
    for count in (0, 10001, "3"):
        movie_frame(first, 30, 0, count=count)
        told(first, 30)
    movie_frame(first, 31, 0)
    movie_frame_done(first, 31, 0)
    movie_frame(first, 32, 0)  # instead of the other
    movie_frame_done(first, 32, 0)
    until_gone("the first of two folders", lambda: len(movie_folders(options)) > 1)
    movie_frame(first, 32, 1, state={})
    is_given_up(33, first.close)  # in the middle of a frame, perhaps
    movie_frame(second, 34, 0, count=1)  # a movie of one frame
    second.receive_until(lambda m: isinstance(m, vc.Picture) and m.kind == 2 and m.number == 34, timeout=60)
    second.close()
    is_alive(server)


def check_movie(options, client, movie):
    """What players get: the frames, in colours that they know, with the index before the pictures."""
    file, still, wanted = (os.path.join(options.scratch, name) for name in ("movie.mp4", "frame.png", "wanted.png"))
    with open(file, "wb") as f:
        f.write(movie.file)
    expect(0 < movie.file.find(b"moov") < movie.file.find(b"mdat"), "the index is not at the beginning")
    found = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", file], check=True,
                           capture_output=True).stdout
    stream = json.loads(found)["streams"][0]
    seen = {name: stream.get(name) for name in ("width", "height", "pix_fmt", "nb_read_frames", "r_frame_rate", "color_space")}
    expect(seen == {"width": 132, "height": 98, "pix_fmt": "yuv420p", "nb_read_frames": "3", "r_frame_rate": "10/1",
                    "color_space": "bt709"}, seen)
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", file, "-vf", "select=eq(n\\,2),format=rgb24,crop=131:97:0:0", "-frames:v", "1",
                    still], check=True)
    with open(wanted, "wb") as f:
        f.write(client.snapshot(7, 131, 97, state={"camera": {"azimuth": 60}}).file)
    subprocess.run([options.program, "compare", still, wanted, "--fail-above", "5"], check=True, stdout=subprocess.DEVNULL)


def fake_ffmpeg(options, script):
    folder = os.path.join(options.scratch, "bin")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "ffmpeg"), "w") as f:
        f.write("#!/bin/sh\n" + script)
    os.chmod(os.path.join(folder, "ffmpeg"), 0o755)


def process_of(options, name):
    """A process's number that the fake wrote, or None when it is gone."""
    try:
        with open(os.path.join(options.scratch, name)) as f:
            number = int(f.read())
        with open(f"/proc/{number}/stat") as f:
            return None if f.read().rsplit(")", 1)[1].split()[0] == "Z" else number
    except (OSError, ValueError):
        return None


def movie_failures(options, server):
    fake_ffmpeg(options, "exit 1\n")
    client = server.client()
    expect(client.hello["ffmpeg"], "ffmpeg is not found")
    movie_frame(client, 1, 0, count=1)
    expect("ffmpeg" in told(client, 1), "who failed?")
    until_gone("the folder", lambda: movie_folders(options))
    fake_ffmpeg(options, "exit 0\n")  # but makes nothing
    movie_frame(client, 2, 0, count=1)
    told(client, 2)
    fake_ffmpeg(options, f"/bin/sleep 1000 &\necho $! > {options.scratch}/child\necho $$ > {options.scratch}/parent\nwait\n")

    def hangs(who, number):
        movie_frame(who, number, 0, count=1)
        until_gone("nothing", lambda: not (process_of(options, "child") and process_of(options, "parent")))

    def all_gone():
        for name in ("parent", "child"):
            until_gone(f"ffmpeg's {name}", lambda: process_of(options, name))
        until_gone("the folder", lambda: movie_folders(options))

    hangs(client, 3)
    client.snapshot(4, 64, 64)  # does not wait for ffmpeg
    client.send({"type": "cancel", "id": 3})
    all_gone()
    hangs(client, 5)
    client.close()
    all_gone()
    is_alive(server)
    client = server.client()
    hangs(client, 6)
    os.kill(server.ranks()[0], signal.SIGTERM)
    client.text("end")
    expect(server.wait() == 0, "the job failed: " + server.errors)
    all_gone()


def no_ffmpeg(options, server):
    client = server.client()
    expect(client.hello["ffmpeg"] is False, "ffmpeg cannot be there")
    movie_frame(client, 9, 0)
    expect("ffmpeg" in told(client, 9), "no reason")
    expect(movie_folders(options) == [], "there is a folder")
    client.close()
    is_alive(server)
