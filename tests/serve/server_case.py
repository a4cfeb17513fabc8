"""What the tests of a running `ringsplat serve` share."""
import os, subprocess, time

import viewer_client as vc


SAME_JPEG = 255 * 10 ** (-45 / 20)  # 45 dB


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def until(what, condition, seconds=20):
    """Waits for a condition."""
    end = vc.deadline(seconds)
    while not condition():
        expect(time.monotonic() < end, what)
        time.sleep(0.05)


def start(options, *more):
    """Among `more` may be what the server finds in its environment, as NAME=VALUE."""
    environment = [word for word in more if "=" in word and word.split("=")[0].isupper()]
    command = [options.program, "serve", options.volume, *(word for word in more if word not in environment)]
    if environment:
        command = ["env", *environment] + command
    if options.ranks:
        command = [options.mpiexec, "-n", str(options.ranks)] + command
    return vc.Server(command)


def refused(server, status, **how):
    try:
        vc.Client(server.port, server.token, **how)
    except vc.Refused as error:
        expect(error.status == status, f"{how}: status {error.status}, not {status}")
        return
    raise AssertionError(f"{how}: was let in")


def is_alive(server):
    """Somebody new sees the volume."""
    client = server.client()
    client.send({"type": "drive"})
    seq = client.view()
    client.picture(seq=seq, at_rest=1)
    client.close()


def told(client, number):
    """The error that answers the message of that number."""
    error = client.receive_until(lambda m: isinstance(m, dict) and m["type"] == "error")
    expect(error.get("id") == number, error)
    return error["message"]


def check_rendered(options, picture, name, limit, volume, *words):
    """A picture's file is within `limit` the one that `render` writes."""
    drawn = os.path.join(options.scratch, "drawn_" + os.path.splitext(name)[0] + (".exr" if name.endswith(".exr") else ".png"))
    subprocess.run([options.program, "render", volume, "-o", drawn, "--background", "black", *words], check=True, capture_output=True)
    is_within(options, picture, name, limit, drawn)


def is_within(options, picture, name, limit, drawn):
    seen = os.path.join(options.scratch, "seen_" + name)
    with open(seen, "wb") as file:
        file.write(picture.file)
    compared = subprocess.run([options.program, "compare", seen, drawn, "--fail-above", str(limit)], capture_output=True, text=True)
    expect(compared.returncode == 0, f"{drawn}: {compared.stdout}")
