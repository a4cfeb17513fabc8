"""Sort-last compositing (IceT) beside the ring, both with sheets.

Writes FOLDER/sort_last.csv, a row for each run as it comes, draws it into FOLDER/sort_last.png and prints it as a table. Studies:

    real     the head refined to 512³ on 2 and 4 ranks of this machine; nothing else should run
    strong   simulated: a ball of 32 % of 512³ voxels at 512² on ever more ranks of two networks
    large    along an axis, of 1024³ voxels at 1024²
    views    on 64 ranks along an axis, turned further, and from an eye
    sparse   on 64 ranks a shell of 3 % of the voxels
    layers   some of these rows by the program's --layers, which draws them

Frames turn by two degrees: of the first one all voxels are new to who draws them, of a later one they are kept. Both sides draw with the
same encoder and painter. Sort-last: sections with as many slices each or with the same cost, radix-k, ranks put on hosts one after
another. The ring: what the program chooses, ranks put on hosts in turn; on real ranks as many GPs as Renderers on ranks of their own, or
every rank both. What IceT itself costs a byte and a pixel is measured on two real ranks first (IceT's own clocks); --icet says it instead.
`real` compares pictures with one rank's. IceT comes with Debian's paraview-dev (112 MB to download, 740 MB installed); configure again
when it is there.
"""
import json
import os
import re
import sys
import tempfile
from collections import defaultdict

from .output import median, ms, plotting, print_head, print_row, read_csv, write_figure
from .run import AHEAD, BUILD, HEAD, MACHINES, PROGRAM, fail, on_ranks, output_of, parser, program, read_frames
from .scaling import Rows, chosen_studies
from .simulation import run_simulation, simulate
from .volumes import refined, step_function, threshold_for

FIELDS = ["study", "machine", "program", "setting", "ranks", "scene", "view", "voxels", "picture", "first", "turning", "painting_mean",
          "painting_most", "bytes_first", "bytes_turning", "messages", "differing_pixels", "rmse"]
NETWORKS = ["infiniband-fat-tree.toml", "ethernet-cluster.toml"]
# Pixels of a simulated picture that are drawn: each stands for a square of the true one's, and links are as much slower.
DRAWN = 128
FRAMES, REAL_FRAMES, TURN = 5, 7, 2
# Azimuth, elevation, degrees that an eye sees, and zoom.
VIEWS = {"axis": (0, 90, 0, 1.7), "30/20": (30, 20, 0, 1.7), "36/35": (36, 35, 0, 1.7), "eye, 30/20": (30, 20, 40, 1.7),
         "close, 30/20": (30, 20, 0, 6)}
SCENES = {"ball": 0.32, "shell": 0.03}
# Ranks, scene, view and slices of a layer.
LAYERS = [(16, "ball", "30/20", 16), (64, "ball", "30/20", 8), (64, "ball", "30/20", 16), (64, "ball", "30/20", 32),
          (256, "ball", "30/20", 16), (1024, "ball", "30/20", 16), (64, "ball", "axis", 16), (64, "ball", "close, 30/20", 16),
          (64, "shell", "30/20", 16)]


def real_rings(ranks):
    """Layouts of so many ranks, of which a user would take the fastest."""
    yield f"{ranks // 2}+{ranks - ranks // 2}", {"gps": ranks // 2, "renderers": ranks - ranks // 2}
    yield f"{ranks} colocated", {"gps": ranks, "renderers": ranks, "roles": "colocated"}


def slower(machine, weight, target):
    """A machine whose links take `weight` times as long for a byte."""
    with open(machine, encoding="utf-8") as file:
        text = re.sub(r"(?m)^(\w*bandwidth) = (\S+)", lambda field: f"{field[1]} = {float(field[2]) / weight!r}", file.read())
    with open(target, "w", encoding="utf-8") as file:
        file.write(re.sub(r"(?m)^packet_bytes = (\d+)", lambda field: f"packet_bytes = {max(1, int(field[1]) // weight)}", text))
    return target


def turning(frames):
    """Seconds of those at the end, when what can be kept is."""
    return median(frame["seconds"] for frame in frames[len(frames) // 2 + 1:])


class Study(Rows):
    def __init__(self, folder, output, most_ranks):
        super().__init__(folder, output, "sort_last.csv", FIELDS, most_ranks)
        self.icet = None

    def ring_view(self, view, frames):
        """The program's options for frames that turn."""
        azimuth, elevation, fov, zoom = VIEWS[view]
        with open(self.path("views.txt"), "w", encoding="utf-8") as file:
            file.writelines(f"{azimuth + TURN * k} {elevation} 0 {zoom}\n" for k in range(frames))
        return ["--path", self.path("views.txt"), "--fit", "sphere", *(["--projection", "perspective", "--fov", fov] if fov else [])]

    def race_view(self, view, frames):
        azimuth, elevation, fov, zoom = VIEWS[view]
        return ["--engine", "sheets", "--azimuth", azimuth, "--elevation", elevation, "--zoom", zoom, "--turn", TURN, "--frames", frames,
                *(["--fov", fov] if fov else [])]

    # Real ranks

    def head(self):
        volume, curve = self.path("head.nrrd"), self.path("soft.json")
        if not os.path.exists(curve):
            refined(HEAD, volume)
            program("render", HEAD, "-o", self.path("x.exr"), "--quality", "paper", "--size", 16, "--tf", "mr-soft", "--tf-out", curve)
        return [volume, "--tf", curve, "--size", 512]

    def sections(self, ranks, even, *options):
        command = [BUILD / "sort_last", *self.head(), *self.race_view("30/20", REAL_FRAMES), *options]
        return [json.loads(line) for line in output_of(*on_ranks(ranks, *command, *(["--even"] if even else []))).splitlines()]

    def costs_of_icet(self):
        """Seconds a received byte and a looked-at pixel of an own picture, once measured; the least, as other programs may run."""
        if self.icet is None:
            frames = self.sections(2, True, "--strategy", "bswap")[1:]
            self.icet = [min(f["blending"] / f["bytes"] for f in frames), min(f["compressing"] / f["pixels"] for f in frames)]
            print(f"IceT takes {1e9 * self.icet[0]:.3f} ns a byte and {1e9 * self.icet[1]:.3f} ns a pixel", file=sys.stderr, flush=True)
        return self.icet

    def real(self):
        self.sections(1, False, "-o", self.path("one.exr"))
        for ranks in (2, 4):
            common = {"study": "real", "machine": "here", "ranks": ranks, "scene": "head", "view": "30/20", "voxels": 512, "picture": 512}
            for even in (True, False):
                frames = self.sections(ranks, even, "-o", self.path("some.exr"))
                self.note(common | self.of_sections(frames) | self.seams() | {"setting": "even" if even else "equal"})
            for setting, layout in real_rings(ranks):
                options = [word for key, value in layout.items() for word in (f"--{key}", value)]
                command = on_ranks(ranks, PROGRAM, "render", *self.head(), "--quality", "best", "--threads-per-rank", 1, "--frames-in-flight", 1,
                                   *AHEAD, *self.ring_view("30/20", REAL_FRAMES), *options)
                # Files are written by another run: the library for them takes memory and cores.
                output_of(*command, "--stats", self.path("ring.json"))
                output_of(*command, "-o", self.path("ring.exr"))
                os.replace(self.path(f"ring-{REAL_FRAMES - 1:04}.exr"), self.path("some.exr"))
                self.note(common | self.of_ring(read_frames(self.path("ring.json"))) | self.seams() | {"setting": setting})

    def seams(self):
        """How far the last picture is from one rank's."""
        said = json.loads(program("compare", self.path("some.exr"), self.path("one.exr"), "--threshold", 0, "--json"))
        return {"differing_pixels": round(said["fraction_over"] * said["pixels"]), "rmse": said["rmse"]}

    @staticmethod
    def of_sections(frames):
        last = frames[-1]
        return {"program": "sort-last", "first": frames[0]["seconds"], "turning": turning(frames),
                "bytes_first": frames[0]["bytes"], "bytes_turning": last["bytes"]} | {key: last[key] for key in (
                    "painting_mean", "painting_most", "messages")}

    @staticmethod
    def of_ring(frames):
        total = frames[-1]["total"]
        return {"program": "ring", "first": frames[0]["seconds"], "turning": turning(frames),
                "bytes_first": frames[0]["total"]["payload_bytes_sent"], "bytes_turning": total["payload_bytes_sent"],
                "messages": total["payloads_sent"]}

    # Simulated ranks

    def scene(self, name, n):
        """A cube of n³ voxels and its function, as arguments. How many voxels a value has is counted in a small one."""
        path, curve = self.path(f"{name}{n}_{n}x{n}x{n}_uint8.raw"), self.path(f"{name}.json")
        if not os.path.exists(curve):
            program("synth", name, "-o", self.path(f"{name}128.raw"), "--dims", "128x128x128")
            step_function(curve, threshold_for(self.path(f"{name}128_128x128x128_uint8.raw"), round(SCENES[name] * 128**3)))
        if not os.path.exists(path):
            program("synth", name, "-o", self.path(f"{name}{n}.raw"), "--dims", f"{n}x{n}x{n}")
        return [path, "--tf", curve]

    def simulated(self, study, network, ranks, view="30/20", scene="ball", n=512):
        if ranks > self.most_ranks:
            return
        common = {"study": study, "machine": network, "ranks": ranks, "scene": scene, "view": view, "voxels": n, "picture": n}
        for even in (True, False):
            frames = self.simulated_sections(network, ranks, n, self.scene(scene, n), view, even)
            self.note(common | self.of_sections(frames) | {"setting": "even" if even else "equal"})
        frames = simulate({"machine": str(MACHINES / network), "frames-in-flight": 1, "gps": "auto", "quality": "best"}, *self.scene(scene, n),
                          *self.ring_view(view, FRAMES), "--size", n, "--count-only", monitors={"ranks": ranks, "map_by": "node"})
        roles = frames[0]["layout"]
        layout = f"{ranks} colocated" if roles["roles"] == "colocated" else f"{roles['gps']}+{roles['renderers']}"
        self.note(common | self.of_ring(frames) | {"setting": layout})

    def simulated_sections(self, network, ranks, size, volume, view, even):
        weight = (size // DRAWN) ** 2
        machine = slower(MACHINES / network, weight, self.path(f"{weight}-{network}"))
        config = self.path("ranks.toml")
        with open(config, "w", encoding="utf-8") as file:
            file.write(f'machine = "{machine}"\nroles = "colocated"\ngps = {ranks}\nrenderers = {ranks}\n')
        blend, compress = self.costs_of_icet()
        said = run_simulation(config, *volume, *self.race_view(view, FRAMES), "--size", DRAWN, "--pixel-weight", weight,
                              "--blend-seconds-per-byte", blend, "--compress-seconds-per-pixel", compress,
                              *(["--even"] if even else []), monitors={"other": BUILD / "sort_last_smpi.so"})
        return [json.loads(line) for line in said.splitlines()] or fail(f"{ranks} simulated ranks drew nothing of {view}")

    def strong(self):
        for network in NETWORKS:
            for ranks in (16, 64, 256, 1024):
                self.simulated("strong", network, ranks)

    def large(self):
        for network in NETWORKS:
            for ranks in (64, 256):
                self.simulated("large", network, ranks, "axis", n=1024)

    def views(self):
        for view in [name for name in VIEWS if name != "30/20"]:
            for network in NETWORKS:
                self.simulated("views", network, 64, view)

    def sparse(self):
        for network in NETWORKS:
            self.simulated("sparse", network, 64, scene="shell")

    def layers(self):
        for ranks, scene, view, slices in LAYERS:
            for network in NETWORKS if ranks <= self.most_ranks else ():
                settings = {"machine": str(MACHINES / network), "frames-in-flight": 1, "quality": "best", "roles": "colocated", "gps": ranks,
                            "renderers": ranks}
                frames = simulate(settings, *self.scene(scene, 512), *self.ring_view(view, FRAMES), "--size", 512, "--layers", slices,
                                  monitors={"ranks": ranks, "map_by": "node"})
                self.note({"study": "layers", "machine": network, "ranks": ranks, "scene": scene, "view": view, "voxels": 512, "picture": 512} |
                          self.of_ring(frames) | {"program": "layers", "setting": slices})


COLOURS = {"ring": "#0072B2", "sort-last": "#D55E00"}
NAMES = {"here": "here", "infiniband-fat-tree.toml": "InfiniBand", "ethernet-cluster.toml": "Ethernet"}
COLUMNS = ("study", "machine", "ranks", "scene", "view", "voxels")
TIMES = ("first", "turning")


def fastest(rows):
    """{COLUMNS: {(program, time): row}}: of each program the setting that is fastest there."""
    best = defaultdict(dict)
    for row in rows:
        for time in TIMES:
            row[time] = float(row[time])
            of, key = best[tuple(row[column] for column in COLUMNS)], (row["program"], time)
            if key not in of or row[time] < of[key][time]:
                of[key] = row
    return best


def draw(plt, best):
    from matplotlib.ticker import LogLocator

    figure, axes = plt.subplots(1, 2, figsize=(9, 4), layout="constrained", sharey=True)
    for axis, (machine, name) in zip(axes, list(NAMES.items())[1:]):
        for of_program, colour in COLOURS.items():
            for time, line in zip(TIMES, ("-o", ":o")):
                points = sorted((int(key[2]), 1e3 * of[of_program, time][time]) for key, of in best.items()
                                if key[0] == "strong" and key[1] == machine)
                if points:
                    axis.loglog(*zip(*points), line, color=colour, label=f"{of_program}, {time}")
        axis.set(xlabel=f"simulated ranks, {name}")
        axis.set_xticks([16, 64, 256, 1024], ["16", "64", "256", "1,024"])
        axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.yaxis.set_major_formatter("{x:g}")
        axis.minorticks_off()
        axis.grid()
        axis.legend(handlelength=3.5)
    axes[0].set_ylabel("milliseconds a frame, 512³")
    return figure


def print_fastest(best):
    print_head("study", "machine", "ranks", "scene", "view", "voxels", "first frame: ring, ms", "sort-last, ms", "sort-last / ring",
               "turning: ring, ms", "sort-last, ms", "sort-last / ring", "its layout; sections")
    for key, of in best.items():
        if len(of) < 2 * len(TIMES):
            continue
        cells = []
        for time in TIMES:
            ring, sections = of["ring", time][time], of["sort-last", time][time]
            cells += [ms(ring), ms(sections), f"{sections / ring:.2f}"]
        print_row(key[0], NAMES[key[1]], *key[2:5], f"{key[5]}³", *cells,
                  f"{of['ring', 'turning']['setting']}; {of['sort-last', 'turning']['setting']}")


def main(words):
    arguments = parser(__doc__)
    arguments.add_argument("--draw", action="store_true", help="only draws and prints FOLDER/sort_last.csv again")
    arguments.add_argument("--icet", type=float, nargs=2, metavar=("BYTE", "PIXEL"), help="seconds, as another run of the study said")
    options, studies = chosen_studies(arguments, words, [Study.real, Study.strong, Study.large, Study.views, Study.sparse, Study.layers])
    plt = plotting()
    if not options.draw:
        with tempfile.TemporaryDirectory() as folder:
            study = Study(folder, options.folder, options.most_ranks)
            study.icet = options.icet
            for run in studies:
                run(study)
    best = fastest(read_csv(os.path.join(options.folder, "sort_last.csv")))
    if any(key[0] == "strong" for key in best):
        write_figure(draw(plt, best), os.path.join(options.folder, "sort_last.png"))
    print_fastest(best)
