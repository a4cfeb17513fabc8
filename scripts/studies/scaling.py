"""Strong and weak scaling on simulated machines, and where tokens are the limit.

Writes FOLDER/scaling.csv, a row for each simulated frame as it comes, and draws it into FOLDER/scaling.png. Studies:

    strong   a cube of 1024³ voxels on ever more ranks, a ring on a fat tree and a mesh; and a ring of sheets
    weak     a million voxels a rank
    large    a cube of 4096³ voxels
    edges    1,020 hosts in a mesh: Renderers at its edge, or every rank a Renderer as well as a GP
    tokens   1024 slices of fewer and fewer voxels, down to none that is visible
    remedies what helps where tokens are the limit
    bundles  slices that travel together, on a slow network and on a fast one

A volume of n³ voxels is rendered by the counts of one of 128 × 128 × n, from 1024³ on of 256 × 256 × n, whose voxels stand for several
of their slice (docs/simulation.md). With 1,024 ranks a row takes one to two minutes, of 4096³ ten and more, and up to 6 GB.

--real also times real ranks here against this machine simulated: FOLDER/this-machine.toml (scripts/study calibrate) and FOLDER/real.csv.
"""
import os
import statistics

from .output import median, plotting, read_csv, write_csv, write_figure
from .run import MACHINES, nodes, parser, program
from .simulation import simulate
from .volumes import step_function, threshold_for

FIELDS = ["study", "setting", "method", "machine", "topology", "layout", "ranks", "gps", "renderers", "voxels", "slices", "voxels_a_slice",
          "seconds", "period", "gp_computing", "gp_computing_most", "gp_waiting_for_token", "gp_sending", "renderer_drawing",
          "renderer_drawing_most", "tokens", "payloads", "payload_gigabytes", "visible_voxels", "splats"]


def ring(ranks):
    """A ring whose roles the program chooses."""
    return {"topology": "ring", "gps": "auto", "ranks": ranks}


def everywhere(ranks):
    """Every rank a GP and a Renderer, on the links of a mesh whose ends are joined."""
    return {"topology": "ring", "gps": ranks, "renderers": ranks, "roles": "colocated", "ranks": ranks}


def mesh(columns, rows, renderers):
    return {"topology": "mesh", "mesh": f"{columns}x{rows}", "renderers": renderers, "routing": "direct", "ranks": columns * rows + renderers}


LARGEST = [ring(1024), mesh(32, 30, 60)]
RINGS = [ring(16), ring(64), ring(256), ring(1024)]
STRONG = [*RINGS[:3], mesh(4, 4, 7), mesh(8, 8, 15), mesh(16, 16, 31), *LARGEST]
WEAK_RINGS = [(256, ring(16)), (512, ring(128)), (1024, ring(1024))]
WEAK = [*WEAK_RINGS, (256, mesh(4, 3, 5)), (512, mesh(11, 10, 18)), (1024, mesh(32, 30, 60))]
SMALL = [{"topology": "ring", "gps": 33, "renderers": 31, "ranks": 64}, mesh(8, 8, 15)]
MACHINE = {"ring": "infiniband-fat-tree.toml", "mesh": "mesh.toml"}
# Where a token's hop takes longer than a Renderer spends on a payload.
SLOW_NETWORK = "ethernet-cluster.toml"
QUALITY = {"splats": "paper", "sheets": "best"}
# Options on top of the others, and how many frames: with more than one, the median of the time between frames counts.
REMEDIES = {"as it is": ({}, 1), "1 slot": ({"slots": 1}, 1), "16 slots": ({"slots": 16}, 1), "look ahead 4": ({"look-ahead": 4}, 1),
            "send ahead 4": ({"send-ahead": 4}, 1), "send ahead 16, 16 slots": ({"send-ahead": 16, "slots": 16}, 1),
            "look ahead 4, send ahead 16, 16 slots": ({"look-ahead": 4, "send-ahead": 16, "slots": 16}, 1),
            "2 frames in flight": ({"frames-in-flight": 2}, 4),
            "2 frames in flight, look ahead 64": ({"frames-in-flight": 2, "look-ahead": 64}, 4),
            "2 frames in flight, look ahead 64, 1024 slots": ({"frames-in-flight": 2, "look-ahead": 64, "slots": 1024}, 4),
            "4 frames in flight, look ahead 128, 1024 slots": ({"frames-in-flight": 4, "look-ahead": 128, "slots": 1024}, 8),
            "half the slices": ({"undersample": 2}, 1)}
# Every slice lies flat on the screen, and the cube fills the picture.
FROM_ABOVE = ["--azimuth", 0, "--elevation", 90, "--fit", "sphere", "--zoom", 1.7]


class Rows:
    """A study's table, written anew with each row, and the folder of what the study makes."""

    def __init__(self, folder, output, table, fields, most_ranks):
        self.folder, self.table, self.fields, self.most_ranks = folder, os.path.join(output, table), fields, most_ranks
        self.rows = []

    def path(self, name):
        return os.path.join(self.folder, name)

    def note(self, row):
        if not self.rows:
            print(*self.fields)
        self.rows.append(row)
        values = [row.get(key, "-") for key in self.fields]
        print(*(f"{value:.4g}" if isinstance(value, float) else value for value in values), flush=True)
        write_csv(self.table, self.rows, self.fields)

    def ball(self, n, base):
        """A ball of 32 % of n slices of base² voxels that are a cube in the world, with its function, as arguments; made once."""
        dims, spacing = f"{base}x{base}x{n}", f"{n / base:g}x{n / base:g}x1"
        path, curve = self.path(f"ball{n}_{dims}_uint8.raw"), self.path("ball.json")
        if not os.path.exists(path):
            program("synth", "ball", "-o", self.path(f"ball{n}.raw"), "--dims", dims, "--spacing", spacing)
        if not os.path.exists(curve):
            step_function(curve, threshold_for(path, round(0.32 * base**2 * n)))
        return [path, "--spacing", spacing], curve


def chosen_studies(arguments, words, studies):
    """A folder, the most ranks, and which of these functions to call."""
    arguments.add_argument("folder", metavar="FOLDER", help="where to write")
    arguments.add_argument("--most-ranks", type=int, default=1024)
    arguments.add_argument("--only", metavar="STUDY,...", help="some of the studies")
    options = arguments.parse_args(words)
    by_name = {study.__name__: study for study in studies}
    wanted = options.only.split(",") if options.only else by_name
    for name in wanted:
        if name not in by_name:
            arguments.error(f"--only: there is no study '{name}', but {', '.join(by_name)}")
    os.makedirs(options.folder, exist_ok=True)
    return options, [by_name[name] for name in wanted]


class Study(Rows):
    def __init__(self, folder, output, most_ranks):
        super().__init__(folder, output, "scaling.csv", FIELDS, most_ranks)
        self.done = {}

    def volume(self, n, width, visible):
        """A cube of n slices of width² voxels, as arguments; nothing of it is seen where it is not visible."""
        base = min(width, 128 if n < 1024 else 256)
        volume, curve = self.ball(n, base)
        if not visible:
            curve = step_function(self.path("nothing.json"), 0, opacity=0)
        return [*volume, "--tf", curve, "--voxel-weight", f"{(width / base) ** 2:g}", "--size", f"{n}x{n}", "--shading", "none", "--count-only"]

    def coarser(self, machine):
        """The machine with nodes that look for messages every millisecond of work, of which such a frame has two million."""
        with open(self.path(machine), "w", encoding="utf-8") as file:
            file.write((MACHINES / machine).read_text().replace("poll_interval = 200e-6", "poll_interval = 1e-3"))
        return self.path(machine)

    def row(self, study, layout, n, width=None, setting="", visible=True, more=None, frames=1, method="splats"):
        ranks = layout["ranks"]
        if ranks > self.most_ranks:
            return
        width = width or n
        # The last of the weak study is the last of the strong one.
        job = repr((layout, n, width, visible, more, frames, method))
        if job in self.done:
            self.note(self.done[job] | {"study": study, "setting": setting})
            return
        settings = {"machine": str(MACHINES / MACHINE[layout["topology"]]), "frames-in-flight": 1, "quality": QUALITY[method],
                    **{key: value for key, value in layout.items() if key != "ranks"}, **(more or {})}
        view = FROM_ABOVE
        if frames > 1:
            with open(self.path("views.txt"), "w", encoding="utf-8") as file:
                file.write("0 90 0 1.7\n" * frames)
            view = ["--path", self.path("views.txt")]
        all_frames = simulate(settings, *self.volume(n, width, visible), *view, monitors={"ranks": ranks, "map_by": "node"})
        roles = all_frames[0]["layout"]
        # The first frames find empty hands, the last ones are alone.
        period = median(frame["period"] for frame in all_frames[frames // 3:frames - frames // 3])
        self.done[job] = described(all_frames[frames // 2]) | {
            "study": study, "setting": setting, "method": method, "machine": os.path.basename(settings["machine"]),
            "topology": layout["topology"], "layout": layout.get("mesh", roles["gps"]), "ranks": ranks, "gps": roles["gps"],
            "renderers": roles["renderers"], "voxels": n * width**2 if visible else 0, "voxels_a_slice": width**2 if visible else 0,
            "period": period}
        self.note(self.done[job])

    def strong(self):
        for layout in STRONG:
            self.row("strong", layout, 1024)
        for layout in RINGS:
            self.row("strong", layout, 1024, method="sheets")

    def weak(self):
        for n, layout in WEAK:
            self.row("weak", layout, n)
        for n, layout in WEAK_RINGS:
            self.row("weak", layout, n, method="sheets")

    def tokens(self):
        for layout, machine in [(SMALL[0], None), (SMALL[0], SLOW_NETWORK), (SMALL[1], None)]:
            more = {"machine": str(MACHINES / machine)} if machine else {}
            for width in (1024, 512, 256, 128):
                self.row("tokens", layout, 1024, width, more=more)
            self.row("tokens", layout, 1024, 128, visible=False, more=more)

    def remedies(self):
        for setting, (more, frames) in REMEDIES.items():
            self.row("remedies", SMALL[0], 1024, 128, setting, more=more | {"machine": str(MACHINES / SLOW_NETWORK)}, frames=frames)

    def bundles(self):
        for machine in (SLOW_NETWORK, MACHINE["ring"]):
            for layout in (SMALL[0], ring(64)):
                for bundle in (1, 2, 4, 8, 16, "auto"):
                    self.row("bundles", layout, 1024, 128, f"bundles of {bundle}", more={"machine": str(MACHINES / machine), "bundle": bundle})

    def large(self):
        for layout, method in [(ring(1024), "sheets"), *((layout, "splats") for layout in reversed(LARGEST))]:
            self.row("large", layout, 4096, more={"machine": self.coarser(MACHINE[layout["topology"]])}, method=method)

    def edges(self):
        for method in QUALITY:
            self.row("edges", mesh(32, 30, 60), 1024, setting="at the edge", method=method)
            self.row("edges", everywhere(1020), 1024, setting="everywhere", more={"machine": str(MACHINES / "torus.toml")}, method=method)


def described(frame):
    def seconds(role, part):
        return [node["seconds"][part] for node in nodes(frame, role)]

    total, mean = frame["total"], statistics.fmean
    return {"slices": frame["traversal"]["slices"], "seconds": frame["seconds"], "gp_computing": mean(seconds("GP", "computing")),
            "gp_computing_most": max(seconds("GP", "computing")), "gp_waiting_for_token": mean(seconds("GP", "waiting_for_token")),
            "gp_sending": mean(seconds("GP", "sending")), "renderer_drawing": mean(seconds("Renderer", "drawing")),
            "renderer_drawing_most": max(seconds("Renderer", "drawing")), "tokens": total["tokens_passed"],
            "payloads": total["payloads_sent"], "payload_gigabytes": total["payload_bytes_sent"] / 1e9,
            "visible_voxels": total["visible_voxels"], "splats": total["splats_sent"]}


NAMES = {("splats", "ring"): ("ring, fat tree", "tab:blue"), ("splats", "mesh"): ("mesh", "tab:orange"),
         ("sheets", "ring"): ("sheets, ring, fat tree", "tab:green")}
STYLES = {"strong": ("-o", "1024³"), "large": ("-^", "4096³"), "weak": (":s", "weak: a million voxels a rank")}


def points(rows, x, y, **wanted):
    chosen = [r for r in rows if all(r[key] == value for key, value in wanted.items())]
    return list(zip(*sorted((float(r[x]), float(r[y])) for r in chosen)))


def draw_scaling(panel, rows):
    for study, (style, words) in STYLES.items():
        for (method, topology), (name, colour) in NAMES.items():
            if line := points(rows, "ranks", "seconds", study=study, topology=topology, method=method):
                panel.loglog(*line, style, color=colour, label=f"{words}, {name}")
    panel.set(xlabel="ranks", ylabel="seconds a frame", title="Strong and weak scaling")
    panel.set_xticks([16, 64, 256, 1024], ["16", "64", "256", "1024"])


def draw_tokens(panel, rows):
    """Frames of ever smaller slices."""
    some = [r | {"width": float(r["voxels_a_slice"]) ** 0.5} for r in rows if r["study"] == "tokens" and float(r["voxels"]) > 0]
    for colour, machine in zip(("tab:blue", "tab:orange", "tab:green"), sorted({(r["machine"], r["layout"], r["renderers"]) for r in some})):
        of = [r for r in some if (r["machine"], r["layout"], r["renderers"]) == machine]
        name = f"{machine[0].removesuffix('.toml')}, {machine[1]} + {machine[2]}"
        panel.loglog(*points(of, "width", "seconds"), "-o", color=colour, label=name)
        panel.loglog(*points(of, "width", "renderer_drawing_most"), ":", color=colour, label="its busiest Renderer's drawing")
    widths = sorted({r["width"] for r in some})
    panel.set_xticks(widths, [f"{width:.0f}²" for width in widths])
    panel.minorticks_off()
    panel.set(xlabel="voxels of each of 1024 slices", ylabel="seconds a frame", title="Where tokens are the limit")


def draw(plt, rows):
    figure, panels = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    for panel, draw_panel in zip(panels, (draw_scaling, draw_tokens)):
        draw_panel(panel, rows)
        panel.grid(which="both")
        panel.margins(y=0.3)
        if panel.get_legend_handles_labels()[0]:
            panel.legend()
    return figure


def main(words):
    import tempfile

    from . import calibrate, forecasts

    arguments = parser(__doc__)
    arguments.add_argument("--draw", action="store_true", help="only draws FOLDER/scaling.csv again")
    arguments.add_argument("--real", action="store_true")
    options, studies = chosen_studies(
        arguments, words, [Study.strong, Study.weak, Study.tokens, Study.remedies, Study.bundles, Study.large, Study.edges])
    plt, table = plotting(), os.path.join(options.folder, "scaling.csv")
    if not options.draw:
        with tempfile.TemporaryDirectory() as folder:
            study = Study(folder, options.folder, options.most_ranks)
            for run in studies:
                run(study)
    write_figure(draw(plt, read_csv(table)), os.path.join(options.folder, "scaling.png"))
    if options.real:
        machine = os.path.join(options.folder, "this-machine.toml")
        calibrate.main([machine])
        forecasts.simulated([machine, "--csv", os.path.join(options.folder, "real.csv")])
