"""A simulation that is shown while it runs: examples/heat's heat_live, driven by a page's side of the protocol."""
import argparse, os, signal, subprocess, sys, time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "serve"))
import viewer_client as vc
from server_case import expect, until

ENDLESS = 10 ** 9
started = []


def start(options, ranks, steps=ENDLESS, share=0.2, aside=0):
    """`aside`: of the ranks so many draw, and the others do not."""
    environment = {"SHARE": str(share), "SET_ASIDE": str(aside)}
    started.append(vc.Server([options.mpiexec, "-n", str(ranks), options.heat, "32", str(steps)], environment))
    return started[-1]


def run(client, **wanted):
    """What is said of the simulation, once it has these members."""
    return client.receive_until(
        lambda m: isinstance(m, dict) and m["type"] == "run" and all(m[k] == v for k, v in wanted.items()))


def steer(client, act, **more):
    client.send({"type": "steer", "act": act, **more})


def held(client):
    """Holds the simulation; returns its step, of which pictures are."""
    steps = []
    while len(steps) < 5 or len(set(steps[-5:])) > 1:  # some are told before it is held
        steer(client, "pause")
        steps.append(run(client, paused=True)["step"])
        time.sleep(0.1)
    client.picture(seq=client.view(width=96, height=64), at_rest=1)
    return steps[-1]


def highest(client, step):
    """The highest value after a step that is held."""
    client.picture(seq=client.view(width=64 + step % 32, height=64), at_rest=1)
    steer(client, "pause")
    return run(client, step=step, paused=True)["histogram"]["high"]


def middle(client):
    """The value there, of the step that pictures are of: where ranks are set aside, the last that was asked for."""
    client.send({"type": "probe", "id": 7, "voxel": [16, 16, 16]})
    return client.text("probe")["value"]


def one_step(client, step):
    steer(client, "step")
    run(client, step=step + 1)
    return step + 1


def answered(options, aside):
    """Pictures come while it runs, what pages ask for beside views is answered, and it goes on."""
    server = start(options, 4, aside=aside)
    client = server.client()
    begin = time.monotonic()
    client.acknowledge(client.picture(seq=client.view()))
    print(f"first picture after {time.monotonic() - begin:.2f} s")
    first = run(client)["step"]
    for axis in range(3):
        client.snapshot(axis, 64, 64, slice=[axis, 16])
    while run(client)["step"] < 12:  # then heat has come to the middle, a cell a step
        pass
    if aside:
        until("no heat comes to the middle", lambda: middle(client) > 0)
    expect(middle(client) > 0, "no value")
    for azimuth in range(0, 90, 30):
        client.acknowledge(client.picture(seq=client.view(moving=True, camera={"azimuth": azimuth})))
    expect(run(client)["step"] > first, "no step was taken")
    server.kill()


def steered(options, aside):
    """It is held, takes single steps, and takes numbers, as its values prove."""
    server = start(options, 4, aside=aside)
    client = server.client()
    client.picture(seq=client.view())
    step = one_step(client, held(client))  # what the first step has heated cools in the next
    time.sleep(0.5)
    steer(client, "pause")
    expect(run(client)["step"] == step, "it went on while it was held")
    before = highest(client, step)
    steer(client, "set", parameter="heating", value=0)
    expect(run(client)["parameters"] == [{"name": "heating", "value": 0, "low": 0, "high": 10, "choices": []}], "another value")
    step = one_step(client, step)
    cooled = highest(client, step)
    expect(cooled < before, f"not heated, but {before} became {cooled}")
    steer(client, "set", parameter="heating", value=10)
    step = one_step(client, step)
    heated = highest(client, step)
    expect(10 <= heated <= cooled + 10.001, f"heated by 10, {cooled} became {heated}")
    for parameter, value, words in (("heating", 11, "must be from 0 to 10"), ("cooling", 1, "offers no cooling")):
        steer(client, "set", parameter=parameter, value=value)
        expect(words in client.text("error")["message"], parameter)
    steer(client, "jump")
    expect("act must be" in client.text("error")["message"], "jump")
    watcher = server.client()
    steer(watcher, "resume")
    watcher.close()
    steer(client, "pause")
    expect(run(client)["step"] == step, "a watcher let it go on")
    steer(client, "resume")
    until("it does not go on", lambda: run(client)["step"] > step + 5)
    server.kill()


def same_on_all_ranks(options, aside):
    """The same step has the same picture on one rank and on four."""
    servers, clients, steps = [], [], []
    for ranks in (1, 4):  # each is held before it is far ahead of the other
        servers.append(start(options, ranks, aside=aside if ranks > aside else 0))
        clients.append(servers[-1].client())
        steps.append(held(clients[-1]))
    for client, step in zip(clients, steps):
        while step < max(steps):
            step = one_step(client, step)
            for waiting in clients:  # who answers no ping for a minute is sent away
                steer(waiting, "pause")
                run(waiting, paused=True)
    files = []
    for client, server in zip(clients, servers):
        snapshot = client.snapshot(1, 200, 160, state={})
        files.append(os.path.join(options.scratch, f"live{len(files)}.png"))
        with open(files[-1], "wb") as file:
            file.write(snapshot.file)
        server.kill()
    subprocess.run([options.program, "compare", *files, "--fail-above", "0"], check=True, stdout=subprocess.DEVNULL)


def clients_come_and_go(options, aside):
    """Whatever clients do, it goes on: also when it is held and nobody is left."""
    server = start(options, 4, aside=aside)
    for k in range(12):
        client = server.client()
        client.send({"type": "drive"})
        client.view(moving=k % 2 == 0, width=64, height=64)
        if k % 3 == 0:
            client.picture()
        if k % 4 == 0:
            steer(client, "pause")
        client.close()
    time.sleep(1)  # until nobody is there
    client = server.client()
    step = run(client, paused=False)["step"]
    until("it does not go on", lambda: run(client)["step"] > step + 5)
    client.send("{")
    expect(client.text("error")["message"], "no words")
    server.kill()


def newcomer(options, aside):
    """A page's first picture does not wait until those of others are paid for, which here takes a minute or so."""
    server = start(options, 4, share=0.001, aside=aside)
    for _ in range(2):
        client = server.client()
        client.send({"type": "drive"})
        client.picture(seq=client.view())
        client.close()
    server.kill()


def ends(options, aside):
    """Pages are told that the simulation has ended, and that it was held is no reason not to end."""
    server = start(options, 4, steps=60, aside=aside)
    client = server.client()
    client.view()
    expect("has ended" in client.text("end", 60)["message"], "no word of the end")
    expect(server.wait() == 0, "not a good end")


def killed_rank(options, aside):
    """Nothing is left of a job whose rank is killed while it is held."""
    server = start(options, 4, aside=aside)
    client = server.client()
    client.picture(seq=client.view())
    held(client)
    ranks = vc.ranks_of(server.process.pid, "heat_live")
    expect(len(ranks) == 4, ranks)
    os.kill(ranks[2], signal.SIGKILL)
    expect(server.wait() != 0, "a good end")
    until("a rank is left", lambda: not any(os.path.exists(f"/proc/{rank}") for rank in ranks))


def unseen(options, aside):
    """Without a page it takes all its steps and ends well."""
    server = start(options, 4, steps=200, aside=aside)
    expect(server.wait() == 0, "not a good end")


def main():
    cases = [answered, steered, same_on_all_ranks, clients_come_and_go, newcomer, ends, killed_rank, unseen]
    arguments = argparse.ArgumentParser()
    for name in ("--heat", "--program", "--mpiexec", "--scratch"):
        arguments.add_argument(name)
    options = arguments.parse_args()
    os.makedirs(options.scratch, exist_ok=True)
    try:
        for aside in (0, 1, 3):
            for case in cases:
                print(f"{case.__name__}, {aside} set aside", flush=True)
                case(options, aside)
    finally:
        for server in started:  # a simulation without an end outlives a test that fails
            server.kill()


main()
