#!/usr/bin/env python3
"""Sort-last compositing (IceT) beside the ring:  scripts/sort_last_study.py -o FOLDER [--most-ranks 1024] [--only STUDY,...]

Writes FOLDER/sort_last.csv, a row for each run as it comes; scripts/plot_sort_last.py draws it. Studies:

    real     the head at 512x512 on 1 to 8 ranks of this machine, the median of some frames; nothing else should run
    strong   simulated: a ball of 32 % of 1024³ voxels at 1024² on ever more ranks of two networks
    pictures the same on 64 ranks with smaller and larger pictures
    slices   1024 slices of fewer and fewer voxels on 64 ranks

Both draw splats with the same painter. Sort-last: sections with as many slices each or with the same cost, binary swap and radix-k. The
ring: what the program chooses on simulated ranks; on real ones as many GPs as Renderers on ranks of their own, three of four ranks
GPs, and every rank both. What IceT itself costs a byte and
a pixel is measured on two real ranks first (IceT's own clocks). `real` counts what all ranks send, and their largest memory.
"""
import argparse
import csv
import hashlib
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile

import simulation
from simulation import BUILD, HEAD, MACHINES, REPO, program, simulate, step_function, threshold_for

FIELDS = ["study", "machine", "program", "setting", "ranks", "picture", "voxels_a_slice", "seconds", "painting_mean", "painting_most", "bytes", "messages",
          "memory_most", "memory_sum", "hash"]
NETWORKS = ["infiniband-fat-tree.toml", "ethernet-cluster.toml"]
STRATEGIES = [("radixk", True), ("radixk", False), ("bswap", True), ("bswap", False)]
# Pixels of a simulated picture that are drawn: each stands for a square of the true one's, and links are as much slower.
DRAWN = 128
REAL_FRAMES = 9


def run(command):
    ended = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if ended.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}:\n{ended.stdout}{ended.stderr}")
    return ended.stdout


def on_ranks(ranks, *command):
    """Real ranks, as scripts/lib.sh starts them."""
    return run(["bash", "-c", f'source "{REPO}/scripts/lib.sh"; run_ranks "$@"', "run_ranks", ranks, *command])


def real_rings(ranks):
    """Layouts of so many ranks, of which a user would take the fastest."""
    yield f"{ranks // 2}+{ranks - ranks // 2}", {"gps": ranks // 2, "renderers": ranks - ranks // 2}
    yield f"{ranks * 3 // 4}+{ranks - ranks * 3 // 4}", {"gps": ranks * 3 // 4, "renderers": ranks - ranks * 3 // 4}
    yield "colocated", {"gps": ranks, "renderers": ranks, "roles": "colocated"}


def slower(machine, weight, target):
    """A machine whose links take `weight` times as long for a byte."""
    with open(machine, encoding="utf-8") as file:
        text = re.sub(r"(?m)^(\w*bandwidth) = (\S+)", lambda field: f"{field[1]} = {float(field[2]) / weight!r}", file.read())
    with open(target, "w", encoding="utf-8") as file:
        file.write(re.sub(r"(?m)^packet_bytes = (\d+)", lambda field: f"packet_bytes = {max(1, int(field[1]) // weight)}", text))
    return target


class Study:
    def __init__(self, folder, output, most_ranks):
        self.folder, self.output, self.most_ranks = folder, output, most_ranks
        self.rows = []
        self.icet = None

    def path(self, name):
        return os.path.join(self.folder, name)

    def note(self, **row):
        self.rows.append(row)
        print(*(f"{row.get(key, ''):.4g}" if isinstance(row.get(key), float) else row.get(key, "-") for key in FIELDS), flush=True)
        target = os.path.join(self.output, "sort_last.csv")
        with open(target + ".part", "w", newline="", encoding="utf-8") as file:
            out = csv.DictWriter(file, FIELDS)
            out.writeheader()
            out.writerows(self.rows)
        os.replace(target + ".part", target)

    # Real ranks

    def head(self):
        curve = self.path("soft.json")
        if not os.path.exists(curve):
            program("render", HEAD, "-o", self.path("x.exr"), "--quality", "paper", "--size", 16, "--tf", "mr-soft", "--tf-out", curve)
        return [HEAD, "--tf", curve, "--size", 512]

    def sections(self, ranks, strategy, even):
        arguments = [*self.head(), "--azimuth", 30, "--elevation", 75, "--strategy", strategy, "--frames", REAL_FRAMES, *(["--even"] if even else [])]
        return [json.loads(line) for line in on_ranks(ranks, os.path.join(BUILD, "sort_last"), *arguments).splitlines()]

    def costs_of_icet(self):
        """Seconds a received byte and a looked-at pixel of an own picture, once measured."""
        if self.icet is None:
            frames = self.sections(2, "bswap", True)[1:]
            self.icet = [statistics.median(f["blending"] / f["bytes"] for f in frames), statistics.median(f["compressing"] / f["pixels"] for f in frames)]
            print(f"IceT takes {1e9 * self.icet[0]:.3f} ns a byte and {1e9 * self.icet[1]:.3f} ns a pixel", file=sys.stderr, flush=True)
        return self.icet

    def real(self):
        for ranks in (1, 2, 3, 4, 6, 8):
            common = {"study": "real", "machine": "here", "ranks": ranks, "picture": 512, "voxels_a_slice": 128 * 128}
            for strategy, even in STRATEGIES:
                frames = self.sections(ranks, strategy, even)[1:]
                middle = {key: statistics.median(f[key] for f in frames)
                          for key in ("seconds", "painting_mean", "painting_most", "bytes", "messages", "memory_most", "memory_sum")}
                self.note(**common, program="sort-last", setting=strategy + (", even" if even else ""), **middle, hash=frames[-1]["picture"])
            for setting, layout in real_rings(ranks):
                if min(layout["gps"], layout["renderers"]) > 0:
                    self.note(**common, program="ring", setting=setting, **self.real_ring(layout))

    def real_ring(self, layout):
        stats, views, picture = self.path("ring.json"), self.path("views.txt"), self.path("ring.exr")
        with open(views, "w", encoding="utf-8") as file:
            file.write("30 75\n" * REAL_FRAMES)
        options = [word for key, value in layout.items() for word in (f"--{key}", value)]
        command = [layout["gps"] if "roles" in layout else layout["gps"] + layout["renderers"], os.path.join(BUILD, "ringsplat"), "render", *self.head(),
                   "--quality", "paper", "--shading", "phong", "--fit", "sphere", "--look-ahead", 4, "--slots", 16, "--send-ahead", 16, *options]
        # Files are written by another run: the library for them takes memory and cores.
        on_ranks(*command, "--path", views, "--frames-in-flight", 1, "--stats", stats)
        on_ranks(*command, "--azimuth", 30, "--elevation", 75, "-o", picture)
        with open(stats, encoding="utf-8") as file:
            frames = json.load(file)[1:]
        last = frames[-1]
        # Nodes of one rank say the same; GPs have the first ranks, Renderers the others, or the same.
        memory = {}
        for k, node in enumerate(last["nodes"]):
            rank = int(node["node"].split()[-1]) if "roles" in layout else k
            memory[rank] = max(memory.get(rank, 0), node["peak_memory"])
        with open(picture, "rb") as file:
            digest = hashlib.sha256(file.read()).hexdigest()[:16]
        return {"seconds": statistics.median(f["seconds"] for f in frames), "bytes": last["total"]["payload_bytes_sent"],
                "messages": last["total"]["payloads_sent"], "memory_most": max(memory.values()), "memory_sum": sum(memory.values()), "hash": digest}

    # Simulated ranks

    def ball(self):
        path, curve = self.path("ball1024_128x128x1024_uint8.raw"), self.path("ball.json")
        if not os.path.exists(path):
            program("synth", "ball", "-o", self.path("ball1024.raw"), "--dims", "128x128x1024", "--spacing", "8x8x1")
            step_function(curve, threshold_for(path, round(0.32 * 128 * 128 * 1024)))
        return [path, "--spacing", "8x8x1", "--tf", curve, "--shading", "none", "--elevation", 90, "--zoom", 1.7]

    def simulated(self, study, network, ranks, size=1024, width=1024):
        if ranks > self.most_ranks:
            return
        common = {"study": study, "machine": network, "ranks": ranks, "picture": size, "voxels_a_slice": width**2}
        voxels = ["--voxel-weight", f"{(width / 128) ** 2:g}"]
        for strategy, even in STRATEGIES:
            self.note(**common, program="sort-last", setting=strategy + (", even" if even else ""), **self.simulated_sections(network, ranks, size, voxels, strategy, even))
        frame = simulate({"machine": os.path.join(MACHINES, network), "frames-in-flight": 1, "gps": "auto"}, *self.ball(), *voxels, "--fit", "sphere",
                         "--size", f"{size}x{size}", "--count-only", monitors={"ranks": str(ranks)})[0]
        chosen, total, drawing = frame["layout"], frame["total"], [n["seconds"]["drawing"] for n in simulation.nodes(frame, "Renderer")]
        self.note(**common, program="ring", setting=f"{chosen['gps']}+{chosen['renderers']}" + (" colocated" if chosen["roles"] == "colocated" else ""),
                  seconds=frame["seconds"], bytes=total["payload_bytes_sent"], messages=total["payloads_sent"],
                  painting_mean=statistics.mean(drawing), painting_most=max(drawing))

    def simulated_sections(self, network, ranks, size, voxels, strategy, even):
        weight = (size // DRAWN) ** 2
        machine = slower(os.path.join(MACHINES, network), weight, self.path(f"{weight}-{network}"))
        config = self.path("ranks.toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write(f'machine = "{machine}"\nroles = "colocated"\ngps = {ranks}\nrenderers = {ranks}\n')
        blend, compress = self.costs_of_icet()
        environment = dict(os.environ, RINGSPLAT_BUILD=BUILD, RINGSPLAT_OTHER=os.path.join(BUILD, "sort_last_smpi.so"))
        # A drawn voxel covers what it stands for.
        command = [os.path.join(REPO, "scripts/simulate.sh"), config, *self.ball(), "--radius", 0.5, *voxels, "--size", DRAWN, "--region", DRAWN, "--pixel-weight", weight,
                   "--strategy", strategy, "--blend-seconds-per-byte", blend, "--compress-seconds-per-pixel", compress, *(["--even"] if even else [])]
        ended = subprocess.run(list(map(str, command)), env=environment, capture_output=True, text=True)
        if ended.returncode != 0:
            sys.exit(f"{command}:\n{ended.stdout}{ended.stderr}")
        frame = json.loads(ended.stdout.splitlines()[-1])
        return {key: frame[key] for key in ("seconds", "painting_mean", "painting_most", "bytes", "messages")} | {"hash": frame["picture"]}

    def strong(self):
        for network in NETWORKS:
            for ranks in (16, 64, 256, 1024):
                self.simulated("strong", network, ranks)

    def pictures(self):
        for size in (256, 512, 2048, 4096):
            for network in NETWORKS:
                self.simulated("pictures", network, 64, size=size)

    def slices(self):
        for width in (512, 256, 128):
            for network in NETWORKS:
                self.simulated("slices", network, 64, width=width)


STUDIES = [Study.real, Study.strong, Study.pictures, Study.slices]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", required=True, help="a folder")
    parser.add_argument("--most-ranks", type=int, default=1024)
    parser.add_argument("--only", help="some of the studies, with commas between them")
    arguments = parser.parse_args()
    by_name = {study.__name__: study for study in STUDIES}
    wanted = arguments.only.split(",") if arguments.only else by_name
    for name in wanted:
        if name not in by_name:
            parser.error(f"--only: there is no study '{name}', but {', '.join(by_name)}")
    os.makedirs(arguments.output, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        study = Study(folder, arguments.output, arguments.most_ranks)
        print(*FIELDS, flush=True)
        for name in wanted:
            by_name[name](study)


if __name__ == "__main__":
    main()
