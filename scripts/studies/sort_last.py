"""Sort-last compositing (IceT) beside the ring.

Writes FOLDER/sort_last.csv, a row for each run as it comes, draws it into FOLDER/sort_last.png and prints it as a table. Studies:

    real     the head at 512x512 on 1 to 8 ranks of this machine, the median of some frames; nothing else should run
    strong   simulated: a ball of 32 % of 1024³ voxels at 1024² on ever more ranks of two networks
    pictures the same on 64 ranks with smaller and larger pictures
    slices   1024 slices of fewer and fewer voxels on 64 ranks

Both draw splats with the same painter. Sort-last: sections with as many slices each or with the same cost, binary swap and radix-k. The
ring: what the program chooses on simulated ranks; on real ones as many GPs as Renderers on ranks of their own, three of four ranks
GPs, and every rank both. What IceT itself costs a byte and a pixel is measured on two real ranks first (IceT's own clocks). `real` counts
what all ranks send, and their largest memory. IceT comes with Debian's paraview-dev (112 MB to download, 740 MB installed); configure
again when it is there.
"""
import hashlib
import json
import os
import re
import statistics
import sys
import tempfile
from collections import defaultdict

from .output import median, ms, plotting, print_head, print_row, read_csv, write_figure
from .run import AHEAD, BUILD, HEAD, MACHINES, PROGRAM, nodes, on_ranks, output_of, parser, program, read_frames
from .scaling import Rows, chosen_studies
from .simulation import run_simulation, simulate

FIELDS = ["study", "machine", "program", "setting", "ranks", "picture", "voxels_a_slice", "seconds", "painting_mean", "painting_most", "bytes",
          "messages", "memory_most", "memory_sum", "hash"]
NETWORKS = ["infiniband-fat-tree.toml", "ethernet-cluster.toml"]
STRATEGIES = [("radixk", True), ("radixk", False), ("bswap", True), ("bswap", False)]
# Pixels of a simulated picture that are drawn: each stands for a square of the true one's, and links are as much slower.
DRAWN = 128
REAL_FRAMES = 9


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


class Study(Rows):
    def __init__(self, folder, output, most_ranks):
        super().__init__(folder, output, "sort_last.csv", FIELDS, most_ranks)
        self.icet = None

    # Real ranks

    def head(self):
        curve = self.path("soft.json")
        if not os.path.exists(curve):
            program("render", HEAD, "-o", self.path("x.exr"), "--quality", "paper", "--size", 16, "--tf", "mr-soft", "--tf-out", curve)
        return [HEAD, "--tf", curve, "--size", 512]

    def sections(self, ranks, strategy, even):
        command = [BUILD / "sort_last", *self.head(), "--azimuth", 30, "--elevation", 75, "--strategy", strategy, "--frames", REAL_FRAMES]
        return [json.loads(line) for line in output_of(*on_ranks(ranks, *command, *(["--even"] if even else []))).splitlines()]

    def costs_of_icet(self):
        """Seconds a received byte and a looked-at pixel of an own picture, once measured."""
        if self.icet is None:
            frames = self.sections(2, "bswap", True)[1:]
            self.icet = [median(f["blending"] / f["bytes"] for f in frames), median(f["compressing"] / f["pixels"] for f in frames)]
            print(f"IceT takes {1e9 * self.icet[0]:.3f} ns a byte and {1e9 * self.icet[1]:.3f} ns a pixel", file=sys.stderr, flush=True)
        return self.icet

    def real(self):
        for ranks in (1, 2, 3, 4, 6, 8):
            if ranks > self.most_ranks:
                return
            common = {"study": "real", "machine": "here", "ranks": ranks, "picture": 512, "voxels_a_slice": 128 * 128}
            for strategy, even in STRATEGIES:
                frames = self.sections(ranks, strategy, even)[1:]
                middle = {key: median(f[key] for f in frames)
                          for key in ("seconds", "painting_mean", "painting_most", "bytes", "messages", "memory_most", "memory_sum")}
                self.note(common | middle | {"program": "sort-last", "setting": strategy + (", even" if even else ""), "hash": frames[-1]["picture"]})
            for setting, layout in real_rings(ranks):
                if min(layout["gps"], layout["renderers"]) > 0:
                    self.note(common | self.real_ring(layout) | {"program": "ring", "setting": setting})

    def real_ring(self, layout):
        stats, views, picture = self.path("ring.json"), self.path("views.txt"), self.path("ring.exr")
        with open(views, "w", encoding="utf-8") as file:
            file.write("30 75\n" * REAL_FRAMES)
        options = [word for key, value in layout.items() for word in (f"--{key}", value)]
        command = on_ranks(layout["gps"] if "roles" in layout else layout["gps"] + layout["renderers"], PROGRAM, "render", *self.head(),
                           "--quality", "paper", "--shading", "phong", "--fit", "sphere", *AHEAD, *options)
        # Files are written by another run: the library for them takes memory and cores.
        output_of(*command, "--path", views, "--frames-in-flight", 1, "--stats", stats)
        output_of(*command, "--azimuth", 30, "--elevation", 75, "-o", picture)
        frames = read_frames(stats)[1:]
        last = frames[-1]
        # Nodes of one rank say the same; GPs have the first ranks, Renderers the others, or the same.
        memory = {}
        for k, node in enumerate(last["nodes"]):
            rank = int(node["node"].split()[-1]) if "roles" in layout else k
            memory[rank] = max(memory.get(rank, 0), node["peak_memory"])
        with open(picture, "rb") as file:
            digest = hashlib.sha256(file.read()).hexdigest()[:16]
        return {"seconds": median(f["seconds"] for f in frames), "bytes": last["total"]["payload_bytes_sent"],
                "messages": last["total"]["payloads_sent"], "memory_most": max(memory.values()), "memory_sum": sum(memory.values()), "hash": digest}

    # Simulated ranks

    def from_above(self):
        volume, curve = self.ball(1024, 128)
        return [*volume, "--tf", curve, "--shading", "none", "--elevation", 90, "--zoom", 1.7]

    def simulated(self, study, network, ranks, size=1024, width=1024):
        if ranks > self.most_ranks:
            return
        common = {"study": study, "machine": network, "ranks": ranks, "picture": size, "voxels_a_slice": width**2}
        voxels = ["--voxel-weight", f"{(width / 128) ** 2:g}"]
        for strategy, even in STRATEGIES:
            self.note(common | self.simulated_sections(network, ranks, size, voxels, strategy, even)
                      | {"program": "sort-last", "setting": strategy + (", even" if even else "")})
        frame = simulate({"machine": str(MACHINES / network), "frames-in-flight": 1, "gps": "auto"}, *self.from_above(), *voxels, "--fit", "sphere",
                         "--size", f"{size}x{size}", "--count-only", monitors={"ranks": ranks})[0]
        roles, total, drawing = frame["layout"], frame["total"], [n["seconds"]["drawing"] for n in nodes(frame, "Renderer")]
        self.note(common | {"program": "ring", "seconds": frame["seconds"], "bytes": total["payload_bytes_sent"], "messages": total["payloads_sent"],
                            "setting": f"{roles['gps']}+{roles['renderers']}" + (" colocated" if roles["roles"] == "colocated" else ""),
                            "painting_mean": statistics.fmean(drawing), "painting_most": max(drawing)})

    def simulated_sections(self, network, ranks, size, voxels, strategy, even):
        weight = (size // DRAWN) ** 2
        machine = slower(MACHINES / network, weight, self.path(f"{weight}-{network}"))
        config = self.path("ranks.toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write(f'machine = "{machine}"\nroles = "colocated"\ngps = {ranks}\nrenderers = {ranks}\n')
        blend, compress = self.costs_of_icet()
        # A drawn voxel covers what it stands for.
        said = run_simulation(config, *self.from_above(), "--radius", 0.5, *voxels, "--size", DRAWN, "--region", DRAWN, "--pixel-weight", weight,
                              "--strategy", strategy, "--blend-seconds-per-byte", blend, "--compress-seconds-per-pixel", compress,
                              *(["--even"] if even else []), monitors={"other": BUILD / "sort_last_smpi.so"})
        frame = json.loads(said.splitlines()[-1])
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


# Study, what is along x, its name.
PANELS = [("real", "ranks", "ranks, here"), ("strong", "ranks", "simulated ranks"), ("pictures", "picture", "width of the picture, 64 ranks"),
          ("slices", "voxels_a_slice", "voxels of a slice, 64 ranks")]
COLOURS = {"ring": "#0072B2", "sort-last": "#D55E00"}
LINES = {"here": "-", "infiniband-fat-tree.toml": "-", "ethernet-cluster.toml": "--"}
NAMES = {"here": "here", "infiniband-fat-tree.toml": "InfiniBand", "ethernet-cluster.toml": "Ethernet"}


def fastest(rows):
    """{study: {(machine, program): {x: row}}}: of each program the setting that is fastest there."""
    best = defaultdict(lambda: defaultdict(dict))
    for row in rows:
        row["seconds"] = float(row["seconds"])
        for study, key, _ in PANELS:
            # The strong study's frame on 64 ranks belongs to the others as well.
            if row["study"] != study and not (study in ("pictures", "slices") and row["study"] == "strong" and row["ranks"] == "64"):
                continue
            of, x = best[study][row["machine"], row["program"]], int(row[key])
            if x not in of or row["seconds"] < of[x]["seconds"]:
                of[x] = row
    return best


def draw(plt, best):
    panels = [panel for panel in PANELS if panel[0] in best]
    figure, axes = plt.subplots(1, len(panels), figsize=(4.2 * len(panels), 4), layout="constrained", squeeze=False)
    for axis, (study, _, name) in zip(axes[0], panels):
        for (machine, of_program), of in sorted(best[study].items()):
            xs = sorted(of)
            axis.plot(xs, [1e3 * of[x]["seconds"] for x in xs], LINES[machine], color=COLOURS[of_program],
                      marker="o" if of_program == "ring" else "s", label=f"{of_program}, {NAMES[machine]}")
        axis.set(xscale="log", yscale="log", xlabel=name)
        axis.grid(which="both")
        axis.legend(handlelength=3.5)
    axes[0][0].set_ylabel("milliseconds a frame")
    return figure


def print_fastest(best):
    print_head("study", "machine", "ranks", "picture", "voxels of a slice", "ring, ms", "its layout", "sort-last, ms", "its way", "sort-last / ring")
    for study in best:
        for machine in NAMES:
            ring, sections = best[study][machine, "ring"], best[study][machine, "sort-last"]
            for x in sorted(set(ring) & set(sections)):
                r, s = ring[x], sections[x]
                if r["study"] == study:  # else in another panel's rows already
                    print_row(study, NAMES[machine], r["ranks"], f"{r['picture']}²", r["voxels_a_slice"], ms(r["seconds"]), r["setting"],
                              ms(s["seconds"]), s["setting"], f"{s['seconds'] / r['seconds']:.2f}")


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("--draw", action="store_true", help="only draws and prints FOLDER/sort_last.csv again")
    options, studies = chosen_studies(arguments, words, [Study.real, Study.strong, Study.pictures, Study.slices])
    plt = plotting()
    if not options.draw:
        with tempfile.TemporaryDirectory() as folder:
            study = Study(folder, options.folder, options.most_ranks)
            for run in studies:
                run(study)
    best = fastest(read_csv(os.path.join(options.folder, "sort_last.csv")))
    write_figure(draw(plt, best), os.path.join(options.folder, "sort_last.png"))
    print_fastest(best)
