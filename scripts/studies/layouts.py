"""What ranks and layouts take on this machine: `ranks` is what a user types, `rates` what nodes do in a second."""
import re
import statistics
import time

from .output import median, ms, print_head, print_row, print_table
from .run import HEAD, PROGRAM, REPO, Bench, node_seconds, on_ranks, output_of, parser, read_frames, repeat

TABLES = ("typed", "one", "configs")
QUALITIES = {"best": (), "paper": ("--quality", "paper")}


class Command:
    """The repetitions of one command line."""

    def __init__(self):
        self.pictures, self.seconds = [], []

    def run(self, bench, ranks, *options):
        stats, begun = bench.path("stats.jsonl"), time.monotonic()
        output_of(*on_ranks(ranks, PROGRAM, "render", HEAD, "--orbit", 24, *options, "--stats", stats))
        self.seconds.append(time.monotonic() - begun)
        frames = read_frames(stats)
        # The first frame still allocates.
        self.pictures.append(statistics.mean(frame["period"] for frame in frames[1:]))
        self.layout = frames[0]["layout"]

    def nodes(self):
        return f"{self.layout['gps']} + {self.layout['renderers']}" + (" colocated" if self.layout["roles"] == "colocated" else "")


def ranks(words):
    """Three tables, medians over the repetitions, which take turns: `ringsplat render tests/data/head.nrrd --orbit 24 -o x.png` without and
with --quality paper, in one process and on 2, 4, 16 and 64 ranks, all on this machine's cores (typed); one picture of the head and of
it refined to 512³ voxels (one); the same orbit, without pictures, with every file of mpi_configs (configs)."""
    arguments = parser(ranks.__doc__)
    repeat(arguments, 3)
    arguments.add_argument("--ranks", nargs="+", type=int, default=[2, 4, 16, 64], metavar="N")
    arguments.add_argument("--beside", type=int, default=0, metavar="N", help="busy processes that are nobody's ranks")
    arguments.add_argument("tables", nargs="*", metavar="|".join(TABLES), help="only this one")
    options = arguments.parse_args(words)
    tables = options.tables or TABLES
    if unknown := set(tables) - set(TABLES):
        arguments.error(f"there is no table {', '.join(unknown)}")
    counts = [0, *options.ranks]  # 0: one process
    typed = {(quality, n): Command() for quality in QUALITIES for n in counts}
    configs = {file: Command() for file in sorted((REPO / "mpi_configs").glob("*.toml"))}
    with Bench() as bench:
        bench.busy(options.beside)
        for _ in range(options.repeat):
            if "typed" in tables:
                for n in counts:
                    for quality in QUALITIES:
                        typed[quality, n].run(bench, n, "-o", bench.path("x.png"), *QUALITIES[quality])
            if "configs" in tables:
                for file, command in configs.items():
                    n = int(re.search(r"^# *mpirun -n (\d+) ", file.read_text(), re.M)[1])
                    command.run(bench, n, "--config", file, "--size", "512x512")
        one = pictures_of_one(bench, counts, options.repeat) if "one" in tables else {}
    if "typed" in tables:
        print_typed(typed)
    if "one" in tables:
        print()
        print_head("`ringsplat render VOLUME -o x.png`", *map(launch, counts))
        for volume, seconds in one.items():
            print_row(volume, *(f"{median(seconds[n]):.2f} s" for n in counts))
    if "configs" in tables:
        print()
        print_table(("configuration", "ranks", "GPs + Renderers", "ms a picture"),
                    ((f"`{file.name}`", c.layout["ranks"], c.nodes(), ms(median(c.pictures))) for file, c in configs.items()))


def pictures_of_one(bench, counts, repetitions):
    """Seconds of whole commands, by the volume's name and the ranks."""
    from .volumes import refined
    large = bench.path("head-512.nrrd")
    refined(HEAD, large)
    seconds = {volume: {n: [] for n in counts} for volume in (HEAD, large)}
    for _ in range(repetitions):
        for volume in seconds:
            for n in counts:
                begun = time.monotonic()
                output_of(*on_ranks(n, PROGRAM, "render", volume, "-o", bench.path("x.png")))
                seconds[volume][n].append(time.monotonic() - begun)
    return {f"`{volume.name}`": by_ranks for volume, by_ranks in seconds.items()}


def launch(ranks):
    return f"`mpirun -n {ranks}{' --oversubscribe' if ranks > 2 else ''}`" if ranks else "one process"


def print_typed(typed):
    print_head("`ringsplat render tests/data/head.nrrd --orbit 24 -o x.png`", "works as", "ms a picture", "of one process", "s in all")
    for (quality, n), command in typed.items():
        idle = command.layout["idle"]
        works_as = (f"{command.nodes()}, {idle} idle" if idle else command.nodes()) if n else "all cores"
        picture = median(command.pictures)
        print_row(f"{launch(n)}{' `--quality paper`' if quality == 'paper' else ''}", works_as, ms(picture),
                  f"{picture / median(typed[quality, 0].pictures):.2f}", f"{median(command.seconds):.2f}")


def rates(words):
    """What a GP and a Renderer do in a second, a frame on two ranks and on sixteen, and a token's hop. The repository's head
(128x128x124, about 32 % visible), an orbit of 24 views; medians over the frames of all repetitions, whose layouts take turns."""
    arguments = parser(rates.__doc__)
    repeat(arguments, 5)
    options = arguments.parse_args(words)
    orbit = ("--orbit", 24, "--elevation", 25, "--tf", "mr-soft", "--frames-in-flight", 1)
    layouts = {"1 + 1": (1, 1), "12 + 4": (12, 4)}
    with Bench() as bench:
        line = bench.make_line(4096)
        for _ in range(options.repeat):
            for size in (256, 512, 1024):
                bench.render(2, f"draw-{size}", HEAD, "--gps", 1, "--renderers", 1, "--size", size, *orbit)
            for size in (256, 512):
                for name, (gps, renderers) in layouts.items():
                    bench.render(gps + renderers, f"layout-{size}-{name}", HEAD, "--gps", gps, "--renderers", renderers, "--size", size, *orbit)
            for gps in (1, 3, 7, 15):
                bench.render(gps + 1, f"hop-{gps}", *line, "--gps", gps, "--renderers", 1, "--orbit", 5)
        print_rates(bench)
        print()
        print_head("picture", "GPs + Renderers on this machine", "ms a frame", "against 1 + 1")
        for size in (256, 512):
            # One frame in flight: from the announcement to the last tile, nothing else going on.
            seconds = {name: bench.median(f"layout-{size}-{name}", lambda f: f["seconds"]) for name in layouts}
            for name in layouts:
                print_row(f"{size}²", name, ms(seconds[name]), f"{seconds[name] / seconds['1 + 1']:.2f}")
        print()
        print_table(("ranks", "µs a token hop"),
                    ((gps + 1, f"{1e6 * bench.median(f'hop-{gps}', lambda f: f['seconds'] / (f['traversal']['slices'] - 1)):.2f}")
                     for gps in (1, 3, 7, 15)))


def print_rates(bench):
    print_head("picture", "Renderer: M splats/s", "of it compositing", "GP: M visible voxels/s", "GP: M voxels/s", "splats", "MB a frame")
    voxels = 128 * 128 * 124
    for size in (256, 512, 1024):
        def typical(of):
            return bench.median(f"draw-{size}", of)

        def drawing(f):
            return node_seconds(f, "Renderer", "drawing", "compositing")

        splats = typical(lambda f: f["total"]["splats_drawn"] / drawing(f))
        compositing = typical(lambda f: node_seconds(f, "Renderer", "compositing") / drawing(f))
        visible = typical(lambda f: f["total"]["visible_voxels"] / node_seconds(f, "GP", "computing"))
        all_voxels = typical(lambda f: voxels / node_seconds(f, "GP", "computing"))
        print_row(f"{size}²", f"{splats / 1e6:.1f}", f"{100 * compositing:.0f} %", f"{visible / 1e6:.1f}", f"{all_voxels / 1e6:.0f}",
                  f"{typical(lambda f: f['total']['splats_drawn']):,.0f}", f"{typical(lambda f: f['total']['payload_bytes_sent']) / 1e6:.1f}")
