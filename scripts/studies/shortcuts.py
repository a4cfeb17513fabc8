"""What each shortcut costs and gains.

The repository's head, 512x512, Phong, 24 views that traverse all three slice sets, with mr-soft (about 32 % of the voxels visible) and
mr-surface (about 11 %). Every row is rendered once a round, all rows in turn, the first (no shortcut) among them; figures are medians
over the frames of all rounds. Errors are against the method's truth, at three views, one for each slice set. With "bounds" it prints
only the ratios that the project holds to bounds.
"""
import json
import math

from .output import median, ms, print_head, print_row, rms
from .run import AHEAD, COLOCATED, DEDICATED, HEAD, Bench, parser, program, repeat, say
from .volumes import padded

FUNCTIONS = ("soft", "surface")
THRESHOLD = ("--opaque-threshold", 1 / 512)
OPAQUE = ("--opaque-threshold", 0)
ONE_AHEAD = ("--frames-in-flight", 1, "--look-ahead", 1)
NONE = (*OPAQUE, *ONE_AHEAD, *DEDICATED)
IN_SLICES = ("--image-plane", "slices")
ALL = (*THRESHOLD, "--frames-in-flight", 1, *AHEAD, *COLOCATED)
HALF = ("--undersample", 2)
ROWS = {
    "none": NONE,
    "opaque threshold": (*THRESHOLD, *ONE_AHEAD, *DEDICATED),
    "frames in flight 2": (*OPAQUE, "--frames-in-flight", 2, "--look-ahead", 1, *DEDICATED),
    "look ahead 4": (*OPAQUE, "--frames-in-flight", 1, "--look-ahead", 4, *DEDICATED),
    "look ahead 4, send ahead 16": (*OPAQUE, "--frames-in-flight", 1, *AHEAD, *DEDICATED),
    "colocated": (*OPAQUE, *ONE_AHEAD, *COLOCATED),
    "slices plane": (*NONE, *IN_SLICES),
    "undersample 2": (*NONE, *HALF),
    "undersample 2 prefiltered": (*NONE, *HALF, "--prefilter"),
    "undersample 4": (*NONE, "--undersample", 4),
    "all": ALL,
    "all, slices plane": (*ALL, *IN_SLICES),
    "all, undersample 2": (*ALL, *HALF),
    "all, undersample 2 prefiltered": (*ALL, *HALF, "--prefilter"),
}


def main(words):
    arguments = parser(__doc__)
    repeat(arguments, 3)
    arguments.add_argument("tables", nargs="?", choices=("bounds",))
    arguments.add_argument("--size", type=int, default=512)
    arguments.add_argument("--views", type=int, default=24)
    options = arguments.parse_args(words)
    with Bench() as bench:
        size = ("--size", options.size)
        # Every third view looks along another slice set.
        views = [f"{360 // options.views * k} {65 if k % 3 == 2 else 25 - 50 * (k % 2)}" for k in range(options.views)]
        path = ("--path", bench.write("views.txt", "\n".join(views) + "\n"))
        truth_views = ("--path", bench.write("truth_views.txt", "20 10\n75 -15\n40 65\n"))
        held = Held(bench, options.size, path, views)
        for k in range(options.repeat):
            say(f"round {k + 1} of {options.repeat}")
            held.render()
            for name, row in ROWS.items() if not options.tables else ():
                for function in FUNCTIONS:
                    bench.render(2, f"{function}-{name}", HEAD, "--tf", f"mr-{function}", *size, *path, *row)
        if not options.tables:
            say("errors")
            for name, row in ROWS.items():
                for function in FUNCTIONS:
                    bench.render(2, f"error-{function}-{name}", HEAD, "--tf", f"mr-{function}", *size, *truth_views, *row, "--error", "method")
            print_shortcuts(bench)
        held.print()


def print_shortcuts(bench):
    for function in FUNCTIONS:
        print_head(function, "ms a frame", "ms between frames", "times as fast", "MB a frame", "RMSE, 1/255", "largest")
        base = bench.median(f"{function}-none", lambda f: f["period"])
        for name in ROWS:
            period = bench.median(f"{function}-{name}", lambda f: f["period"])
            megabytes = bench.median(f"{function}-{name}", lambda f: f["total"]["payload_bytes_sent"], first=0) / 1e6
            errors = [f["error"] for f in bench.frames(f"error-{function}-{name}", 0)]
            print_row(name, ms(bench.median(f"{function}-{name}", lambda f: f["seconds"])), ms(period), f"{base / period:.2f}", f"{megabytes:.1f}",
                      f"{rms(e['rmse'] for e in errors):.3g}", f"{max(e['largest'] for e in errors):.3g}")
        print()


def front_view(size):
    """World to screen as azimuth = elevation = 0 has it at zoom 1: the box's bounding sphere fits the picture. The upper left quarter of
    that picture is then the same matrix with half the size."""
    info = json.loads(program("info", HEAD, "--json"))
    scale = size / math.hypot(*info["size"])
    steps = list(zip(info["directions"], info["spacing"], info["dims"]))
    middle = [o + sum(d[k] * s * (n - 1) / 2 for d, s, n in steps) for k, o in enumerate(info["origin"])]
    right = [scale, 0.0, 0.0, size / 2 - scale * middle[0]]
    down = [0.0, 0.0, -scale, size / 2 + scale * middle[2]]
    return json.dumps({"matrix": [*right, *down, 0.0, scale, 0.0, -scale * middle[1]]}) + "\n"


class Held:
    """What is held to bounds, with all shortcuts that are on without being asked for."""

    def __init__(self, bench, size, path, views):
        self.bench, self.size = bench, size
        soft, surface, two = (HEAD, "--tf", "mr-soft"), (HEAD, "--tf", "mr-surface"), COLOCATED
        front = ("--path", bench.write("front.txt", front_view(size) * 8))
        zoomed = ("--path", bench.write("zoomed.txt", "".join(f"{view} 0 2\n" for view in views)))
        box = (padded(HEAD, bench.path("padded.nrrd")), "--tf", "mr-soft")
        # Name: ranks and options.
        self.runs = {
            "one-process": (0, *soft, *path),
            "2-colocated": (2, *soft, *path, *two),
            "16-colocated": (16, *soft, *path, "--roles", "colocated", "--gps", 16, "--renderers", 16),
            "16-auto": (16, *soft, *path, "--gps", "auto"),
            "surface": (2, *surface, *path, *two),
            "undersampled": (2, *soft, *path, *HALF, *two),
            "prefiltered": (2, *soft, *path, *HALF, "--prefilter", *two),
            "padded": (2, *box, *zoomed, *two),
            "front": (2, *soft, *front, *two),
            "front-quarter": (2, *soft, *front, "--size", size // 2, *two),
        }

    def render(self):
        for name, (ranks, *options) in self.runs.items():
            size = () if name == "front-quarter" else ("--size", self.size)
            self.bench.render(ranks, f"held-{name}", *options, *size, "--frames-in-flight", 1, *AHEAD)

    def milliseconds(self, name):
        """Of each round's run."""
        return [1e3 * median(f["seconds"] for f in run) for run in self.bench.by_run(f"held-{name}")]

    def ratio(self, what, a, b, bound):
        """The median of the rounds' ratios, since a machine's speed may drift from round to round."""
        first, second = self.milliseconds(a), self.milliseconds(b)
        print_row(what, f"{median(first):.1f} of {median(second):.1f} ms", f"{median(x / y for x, y in zip(first, second)):.2f}", bound)

    def print(self):
        print_head("", "time", "ratio", "bound")
        self.ratio("surface, of soft", "surface", "2-colocated", "at most 0.33")
        self.ratio("in a box twice as large, of the volume alone", "padded", "2-colocated", "at most 1.10")
        self.ratio("full, of undersampled by 2", "2-colocated", "undersampled", "at least 5")
        self.ratio("prefiltered, of skipped", "prefiltered", "undersampled", "at most 1.3")
        self.ratio("one process, of 2 colocated ranks", "one-process", "2-colocated", "at least 1.7")
        self.ratio("16 colocated ranks, of 2", "16-colocated", "2-colocated", "at most 1.33")
        self.ratio("16 ranks with `--gps auto`, of 2", "16-auto", "2-colocated", "at most 1.33")
        few, many = (self.bench.frames(f"held-{name}", 0)[0]["total"]["splats_drawn"] for name in ("front-quarter", "front"))
        self.ratio("a quarter of the picture, of the whole", "front-quarter", "front", f"its splats: {few / many:.2f}")
