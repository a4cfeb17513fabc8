#!/usr/bin/env python3
"""Tests of simulated runs:  check_simulation.py CASE --build FOLDER --scratch FOLDER"""
import argparse
import json
import os
import shutil
import subprocess
import sys

REPO = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
HEAD = os.path.join(REPO, "tests/data/head.nrrd")
PP5 = os.path.join(REPO, "mpi_configs/machines/pixel-planes-5.toml")
VIEW = ["--size", "256x256", "--fit", "sphere", "--elevation", "20", "--azimuth", "30", "--tf", "mr-soft"]


class Run:
    def __init__(self, build, scratch):
        self.build = build
        self.scratch = scratch

    def path(self, name):
        return os.path.join(self.scratch, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)

    def program(self, *arguments):
        subprocess.run([os.path.join(self.build, "ringsplat"), *arguments], check=True, stdout=subprocess.DEVNULL)

    def output(self, *arguments):
        return subprocess.run([os.path.join(self.build, "ringsplat"), *arguments], check=True, capture_output=True, text=True).stdout

    def attempt(self, layout, *arguments, machine=PP5, **monitors):
        """Simulates `layout` (TOML lines); returns what became of it. `monitors` is what simulate.sh takes from the environment."""
        config = self.write("job.toml", layout + f'\nmachine = "{machine}"\nquality = "paper"\n')
        environment = dict(os.environ, RINGSPLAT_BUILD=self.build)
        environment.update({f"RINGSPLAT_{name.upper()}": value for name, value in monitors.items()})
        return subprocess.run([os.path.join(REPO, "scripts/simulate.sh"), config, *arguments], env=environment,
                              capture_output=True, text=True)

    def simulate(self, *arguments, name="run", **more):
        """The frames of a simulation that must succeed."""
        stats = self.path(name + ".json")
        ended = self.attempt(*arguments, "--stats", stats, **more)
        if ended.returncode != 0:
            sys.exit(f"the simulation failed with {ended.returncode}:\n{ended.stdout}{ended.stderr}")
        with open(stats, encoding="utf-8") as file:
            return json.load(file)


def same(what, a, b):
    if a != b:
        sys.exit(f"{what}: {a} is not {b}")
    print(f"{what}: {a}")


def close(what, value, expected, relative):
    if not abs(value - expected) <= relative * abs(expected):
        sys.exit(f"{what}: {value} is not within {relative} of {expected}")
    print(f"{what}: {value}, expected {expected}")


def bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


def image(run):
    """Sixteen simulated ranks, as a ring and as a mesh, draw the picture that one process draws, bit for bit."""
    run.program("render", HEAD, "-o", run.path("alone.exr"), "--quality", "paper", *VIEW)
    layouts = {"ring": "gps = 12\nrenderers = 4", "mesh": 'topology = "mesh"\nmesh = "4x3"\nrenderers = 4',
               "colocated": 'gps = 16\nrenderers = 16\nroles = "colocated"'}
    for name, layout in layouts.items():
        picture = run.path(name + ".exr")
        run.simulate(layout, HEAD, "-o", picture, *VIEW)
        same(f"{name} draws the same bits", bytes_of(picture) == bytes_of(run.path("alone.exr")), True)


FREE_NETWORK = """name = "free network"
poll_interval = 1e-3
[gp]
visible_voxel = {visible}
transparent_voxel = {transparent}
slice = {slice}
[renderer]
splat = {splat}
pass = {a_pass}
slice = {payload}
composite = {composite}
[platform]
kind = "backbone"
bandwidth = 1e15
latency = 0
"""


def seconds(run):
    """On a machine whose network is free, a frame takes what the descriptions' formulas say."""
    run.program("synth", "ball", "-o", run.path("ball.nrrd"), "--dims", "24x24x24")
    view = ["--size", "128x128", "--count-only", "--frames-in-flight", "1"]

    gp_bound = FREE_NETWORK.format(visible=1e-3, transparent=1e-4, slice=0.5, splat=0, a_pass=0, payload=0, composite=0)
    # The GP is rank 0.
    for slow, factor in ((-1, 1), (0, 3), (1, 1)):
        machine = run.write("gp.toml", f"{gp_bound}[slow]\nrank = {slow}\nfactor = 3\n")
        frame, = run.simulate("gps = 1\nrenderers = 1", run.path("ball.nrrd"), *view, machine=machine)
        visible = frame["total"]["visible_voxels"]
        close(f"GP-bound frame, rank {slow} slow", frame["seconds"],
              factor * (24 * 0.5 + visible * 1e-3 + (24**3 - visible) * 1e-4), 1e-6)

    renderer_bound = FREE_NETWORK.format(visible=0, transparent=0, slice=0, splat=1e-3, a_pass=0.25, payload=2,
                                         composite=1e-4)
    frame, = run.simulate("gps = 3\nrenderers = 1", run.path("ball.nrrd"), *view,
                          machine=run.write("renderer.toml", renderer_bound))
    total = frame["total"]
    close("Renderer-bound frame", frame["seconds"],
          total["splats_sent"] * 1e-3 + total["passes"] * 0.25 + total["payloads_sent"] * 2 + total["samples"] * 1e-4,
          1e-6)
    same("pixels are composited", total["samples"] > 0, True)


def determinism(run):
    """The same command takes the same simulated second, to the last digit."""
    layout = "gps = 12\nrenderers = 4"
    runs = [run.simulate(layout, HEAD, "--count-only", "--orbit", "2", *VIEW, name=name) for name in ("one", "two")]
    for frame, again in zip(*runs):
        same(f"frame {frame['frame']}", frame["seconds"], again["seconds"])
        nodes = [[n["seconds"] for n in f["nodes"]] for f in (frame, again)]
        same("its nodes spend the same seconds", nodes[0] == nodes[1], True)


def count_only(run):
    """A run that only counts sends the same bytes and takes the same time as one that draws."""
    layout = "gps = 6\nrenderers = 4"
    drawn, = run.simulate(layout, HEAD, "-o", run.path("drawn.exr"), *VIEW)
    counted, = run.simulate(layout, HEAD, "--count-only", *VIEW)
    for key in ("splats_sent", "splats_drawn", "payload_bytes_received", "passes", "tile_bytes"):
        expected = drawn["total"][key]
        if key == "splats_drawn":
            expected += drawn["total"]["splats_clipped"]
        same(key, counted["total"][key], expected)
    same("seconds", counted["seconds"], drawn["seconds"])
    weighted, = run.simulate(layout, HEAD, "--count-only", "--voxel-weight", "8", *VIEW)
    same("splats with a weight of 8", weighted["total"]["splats_sent"], 8 * drawn["total"]["splats_sent"])



def sheets(run):
    """Sheets take what the description says, and a run that only counts takes the same time as one that draws."""
    run.program("synth", "ball", "-o", run.path("ball.nrrd"), "--dims", "40x40x24")
    free = FREE_NETWORK.format(visible=0, transparent=0, slice=0.5, splat=0, a_pass=0, payload=0, composite=0)
    costs = {"look": 1e-3, "copy": 2e-3, "place": 0, "slice": 0, "sample": 0, "table": 0}

    def machine(name, **sheet_costs):
        lines = "".join(f"{key} = {value}\n" for key, value in {**costs, **sheet_costs}.items())
        return run.write(name, free + "[sheets]\n" + lines)

    view = ["--quality", "best", "--size", "128x128", "--elevation", "90", "--frames-in-flight", "1"]
    frame, = run.simulate("gps = 1\nrenderers = 1", run.path("ball.nrrd"), "--count-only", *view, machine=machine("gp.toml"))
    close("GP-bound frame of sheets", frame["nodes"][0]["seconds"]["computing"],
          24 * (0.5 + 25e-3) + frame["total"]["splats_sent"] * 2e-3, 1e-6)
    renderer_bound = machine("renderer.toml", look=0, copy=0, place=1e-2, slice=3, sample=1e-3, table=5)
    frame, = run.simulate("gps = 1\nrenderers = 1", run.path("ball.nrrd"), "--count-only", *view, machine=renderer_bound)
    total = frame["total"]
    close("a Renderer of sheets", frame["nodes"][1]["seconds"]["drawing"],
          5 + total["payloads_sent"] * 3 + total["splats_sent"] * 1e-2 + total["samples"] * 1e-3, 1e-6)

    layout = 'gps = 3\nrenderers = 3\nroles = "colocated"'
    view = ["--quality", "best", "--opaque-threshold", "0", *VIEW]
    drawn, = run.simulate(layout, HEAD, "-o", run.path("sheets.exr"), *view)
    counted, = run.simulate(layout, HEAD, "--count-only", *view)
    for key in ("samples", "splats_sent", "payload_bytes_received"):
        same(key, counted["total"][key], drawn["total"][key])
    same("it paints something", drawn["total"]["samples"] > 0, True)
    close("seconds", counted["seconds"], drawn["seconds"], 0.02)


def waiting(run):
    """Ranks that wait get their core back late where there are more ranks than cores, and only there."""
    machine = FREE_NETWORK.format(visible=1e-6, transparent=0, slice=0, splat=1e-6, a_pass=0, payload=0, composite=0) + "hosts = 1\ncores = 2\n"
    view = [*VIEW, "--count-only", "--frames-in-flight", "1"]
    taken = {}
    for renderers in (1, 2):
        for wake in (0, 1e-2):
            described = run.write(f"wake{wake}.toml", machine + f"[message]\nwake = {wake}\n")
            frame, = run.simulate(f"gps = 1\nrenderers = {renderers}", HEAD, *view, machine=described)
            taken[renderers, wake] = frame["seconds"]
    same("a core for each rank", taken[1, 1e-2], taken[1, 0])
    same("three ranks on two cores wait longer", taken[2, 1e-2] > taken[2, 0] + 1e-2, True)


def roles(run):
    """The program chooses roles by the described machine's costs, hardly worse than the best of all."""
    machine = os.path.join(REPO, "mpi_configs/machines/infiniband-fat-tree.toml")
    view = [*VIEW, "--count-only", "--frames-in-flight", "1", "--shading", "none"]
    for quality in ("paper", "best"):
        chosen, = run.simulate('gps = "auto"', HEAD, *view, "--quality", quality, machine=machine, ranks="8")
        layout = chosen["layout"]
        same("ranks", layout["ranks"], 8)
        others = [f"gps = {8 - r}\nrenderers = {r}" for r in range(1, 8)] + ['gps = 8\nrenderers = 8\nroles = "colocated"']
        best = min(run.simulate(other, HEAD, *view, "--quality", quality, machine=machine)[0]["seconds"] for other in others)
        print(f"{quality}: {layout['gps']} + {layout['renderers']} {layout['roles']}")
        same(f"{chosen['seconds']} s are at most 1.15 times the best, {best} s", chosen["seconds"] <= 1.15 * best, True)


def forecast(run):
    """What is foreseen is what is simulated, where ranks share cores and where they do not, and what is chosen is hardly worse than the best."""
    two = os.path.join(REPO, "mpi_configs/machines/two-core.toml")
    with open(two, encoding="utf-8") as file:
        eight = run.write("eight-core.toml", file.read().replace("cores = 2", "cores = 8"))
    layouts = {"4 colocated ranks": 'gps = 4\nrenderers = 4\nroles = "colocated"', "1 GP + 3 Renderers": "gps = 1\nrenderers = 3",
               "2 GPs + 2 Renderers": "gps = 2\nrenderers = 2"}
    alone = ["--frames-in-flight", "1"]
    for quality in ("paper", "best"):
        picture = [HEAD, "--quality", quality]
        for machine in (two, eight):
            said = json.loads(run.output("info", *picture, "--ranks", "4", "--machine", machine, "--json"))["prediction"]
            foreseen = {layout["layout"]: layout["seconds"] for layout in said["layouts"]}
            taken = {name: run.simulate(layout, *picture, *alone, "--count-only", machine=machine)[0]["seconds"]
                     for name, layout in layouts.items()}
            for name, seconds in taken.items():
                close(f"{quality}, {os.path.basename(machine)}, {name}", foreseen[name], seconds, 0.15)
            chosen, = run.simulate('gps = "auto"\nbundle = 1', *picture, *alone, "--count-only", machine=machine, ranks="4")
            print(f"chosen: {chosen['layout']}")
            best = min(taken.values())
            same(f"{chosen['seconds']} s are at most 1.15 times the best, {best} s", chosen["seconds"] <= 1.15 * best, True)
    machine, picture = os.path.join(REPO, "mpi_configs/machines/infiniband-fat-tree.toml"), [HEAD, "--quality", "best", "--layers", "16"]
    said = json.loads(run.output("info", *picture, "--ranks", "16", "--machine", machine, "--json"))["prediction"]
    foreseen, = (layout["seconds"] for layout in said["layouts"] if layout["layout"] == "16 colocated ranks")
    taken, = run.simulate('gps = 16\nrenderers = 16\nroles = "colocated"', *picture, *alone, machine=machine)
    close("layers", foreseen, taken["seconds"], 0.25)


def bundles(run):
    """Bundles of slices draw the same bits, count what they draw, and save latency where it is high; the program chooses them then."""
    machine = os.path.join(REPO, "mpi_configs/machines/ethernet-cluster.toml")
    layout = "gps = 6\nrenderers = 4\n"
    run.program("render", HEAD, "-o", run.path("alone.exr"), "--quality", "paper", *VIEW)
    drawn, = run.simulate(layout + "bundle = 4", HEAD, "-o", run.path("drawn.exr"), *VIEW, machine=machine)
    same("bundles draw the same bits", bytes_of(run.path("drawn.exr")) == bytes_of(run.path("alone.exr")), True)
    # What a hidden voxel is depends on when news come.
    for quality in ("paper", "best"):
        view = [*VIEW, "--opaque-threshold", "0", "--quality", quality, "--frames-in-flight", "1"]
        frames = {}
        for bundle in (1, 4):
            drawn, = run.simulate(layout + f"bundle = {bundle}", HEAD, "-o", run.path("picture.exr"), *view, machine=machine)
            counted, = run.simulate(layout + f"bundle = {bundle}", HEAD, "--count-only", *view, machine=machine)
            for key in ("splats_sent", "payload_bytes_received", "payloads_sent", "tokens_passed", "slices", "passes"):
                same(f"{quality}, bundles of {bundle}, {key}", counted["total"][key], drawn["total"][key])
            # A run that counts adds whole windows of kernels.
            close("samples", counted["total"]["samples"], drawn["total"]["samples"], 0.1 if quality == "paper" else 0)
            close("seconds", counted["seconds"], drawn["seconds"], 0.02)
            frames[bundle] = counted
        one, four = frames[1], frames[4]
        steps = -(-one["traversal"]["slices"] // 4)
        same("slices", four["traversal"]["slices"], one["traversal"]["slices"])
        same("tokens", four["total"]["tokens_passed"], (steps - 1) * four["total"]["tokens_issued"])
        for key in ("splats_sent", "slices", "passes", "samples"):
            same(key, four["total"][key], one["total"][key])

        def drawing(frame):
            return sum(node["seconds"].get("drawing", 0) for node in frame["nodes"])

        close("drawing costs the same", drawing(four), drawing(one), 1e-6)
        same(f"bundles are faster: {four['seconds']} s, {one['seconds']} s", four["seconds"] < 0.9 * one["seconds"], True)
        chosen, = run.simulate('gps = "auto"\n', HEAD, "--count-only", *view, machine=machine, ranks="10")
        print(f"chosen: {chosen['layout']}")
        same("bundles are chosen", chosen["layout"]["bundle"] > 1, True)
        same(f"it is no worse: {chosen['seconds']} s", chosen["seconds"] <= 1.15 * four["seconds"], True)
        given, = run.simulate(layout + 'bundle = "auto"', HEAD, "--count-only", *view, machine=machine)
        same("roles that are given stay", (given["layout"]["gps"], given["layout"]["renderers"]), (6, 4))
        same("their bundles are chosen", given["layout"]["bundle"] > 1, True)


def bad_input(run):
    """What is wrong is said, by file and field, and ends the simulation with 2."""
    bad = run.write("bad.toml", open(PP5, encoding="utf-8").read().replace("splat = ", "splats = "))
    machine_without_mesh = os.path.join(REPO, "mpi_configs/machines/pixel-planes-5-mesh.toml")
    cases = [(dict(machine=bad), "bad.toml: renderer.splats"), (dict(machine=run.path("none.toml")), "none.toml"),
             (dict(machine=machine_without_mesh), "mesh")]
    for machine, words in cases:
        ended = run.attempt("gps = 2\nrenderers = 1", HEAD, "--count-only", **machine)
        same(f"exit code when {words} is wrong", ended.returncode, 2)
        same("it is named", words in ended.stderr, True)
    ended = run.attempt("gps = 2\nrenderers = 1", HEAD, "--count-only", "--gps", "auto")
    same("exit code when nobody says how many ranks choose their roles", ended.returncode, 2)
    same("it is named", "RINGSPLAT_RANKS" in ended.stderr, True)
    # Without a machine's costs the program refuses to choose.
    environment = dict(os.environ, RINGSPLAT_MACHINE=PP5, RINGSPLAT_RANKS="3", RINGSPLAT_GPS="2", RINGSPLAT_RENDERERS="1")
    ended = subprocess.run(
        ["smpirun", "-quiet", "-np", "3", "-platform", os.path.join(run.build, "ringsplat_platform.so"), "-hostfile",
         run.write("hosts", "n0\nn1\nn2\n"), "--log=root.thresh:critical", os.path.join(run.build, "ringsplat_smpi.so"), "render", HEAD,
         "--count-only", "--gps", "auto"], env=environment, capture_output=True, text=True)
    same("exit code of the program", ended.returncode, 2)
    same("it says why", "by this machine's clock" in ended.stderr, True)


def main():
    cases = {f.__name__: f for f in (image, seconds, determinism, count_only, sheets, waiting, roles, forecast, bundles, bad_input)}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", choices=cases)
    parser.add_argument("--build", required=True)
    parser.add_argument("--scratch", required=True)
    arguments = parser.parse_args()
    shutil.rmtree(arguments.scratch, ignore_errors=True)
    os.makedirs(arguments.scratch)
    cases[arguments.case](Run(os.path.abspath(arguments.build), os.path.abspath(arguments.scratch)))


if __name__ == "__main__":
    main()
