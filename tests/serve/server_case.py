"""What the tests of a running `ringsplat serve` share."""
import time

import viewer_client as vc


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
    environment = [word for word in more if word.split("=")[0].isupper()]
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
