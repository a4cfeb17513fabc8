"""Starts a study by its name."""
import importlib
import sys

from .run import build, fail, need

# Name: module, function, what it needs built, what it does.
PROGRAM = ("ringsplat_cli",)
SIMULATED = ("ringsplat_cli", "ringsplat_smpi", "ringsplat_platform")
STUDIES = {
    "ranks": ("layouts", "ranks", PROGRAM, "what a user types, on 1 to 64 ranks, and every file of mpi_configs"),
    "rates": ("layouts", "rates", PROGRAM, "what GPs and Renderers do in a second, and a token's hop"),
    "mesh": ("mesh", "mesh", PROGRAM, "ring against mesh, and how often messages meet on a link"),
    "links": ("mesh", "links", (), "a heat map of a mesh's links, from --stats"),
    "shortcuts": ("shortcuts", "main", PROGRAM, "what each shortcut costs and gains"),
    "qualities": ("qualities", "main", PROGRAM, "time and error of sheets' settings, of which --quality's are chosen"),
    "accuracy": ("accuracy", "main", (*PROGRAM, "measure_roundings"), "all figures and pictures of docs/measured/accuracy.md"),
    "settings": ("settings", "main", PROGRAM, "time and error of a list's settings, in views of scenes, as a table"),
    "speed-error": ("accuracy", "speed_error", (), "draws what `settings` wrote: speed against error, error against angle"),
    "perceptual": ("perceptual", "main", (), "adds SSIM and FLIP to what `settings --keep-images` wrote"),
    "viewer": ("viewer", "main", PROGRAM, "what the viewer's page gets: pictures a second, latency, idling"),
    "peers": ("peers", "main", PROGRAM, "time and error beside VTK, VolPack and ParaView"),
    "paraview": ("peers", "paraview", PROGRAM, "seams, memory, time and error beside ParaView on 1 to 6 ranks"),
    "sort-last": ("sort_last", "main", (*SIMULATED, "sort_last", "sort_last_smpi"), "the ring beside sort-last compositing with IceT"),
    "scaling": ("scaling", "main", SIMULATED, "strong and weak scaling on simulated machines"),
    "calibrate": ("calibrate", "main", SIMULATED, "measures this machine and describes it for simulations"),
    "compare-simulated": ("forecasts", "simulated", SIMULATED, "simulated frame times beside real ones"),
    "compare-predicted": ("forecasts", "predicted", SIMULATED, "predicted frame times beside simulated ones"),
    "published": ("paper", "published", SIMULATED, "the figures of Neumann 1992, section 4, on a simulated Pixel-Planes 5"),
    "gp-scaling": ("paper", "gp_scaling", SIMULATED, "Figs. 7 and 9 of Neumann 1992: frame rate against GPs"),
    "first-tokens": ("paper", "first_tokens", SIMULATED, "how long GPs wait for their first tokens (Neumann 1992, section 4.3)"),
    "timelines": ("timeline", "figures_of_the_paper", PROGRAM, "Figs. 5 and 8 of Neumann 1992 from real runs"),
    "timeline": ("timeline", "main", (), "draws a frame's timeline, from --trace"),
    "balance": ("balance", "main", (), "who was busy, who waited for whom, from --trace or --stats"),
    "gallery": ("gallery", "main", PROGRAM, "packages' volumes with no option, on one page"),
    "pad-volume": ("volumes", "pad", (), "puts a volume into a box of zeros twice as large"),
    "refine-volume": ("volumes", "refine", (), "makes a volume four times as fine along each axis"),
}
USAGE = """Benchmarks and studies of Ringsplat. Times want an idle machine.

    scripts/study NAME --help              what a study measures, and its arguments
    scripts/study NAME [ARGUMENT...]
    scripts/study --build NAME [...]       builds first what it needs, in build/release

RINGSPLAT_BUILD names another build than build/release, RINGSPLAT_MPIEXEC another launcher than mpirun.
"""


def main(words):
    asked_to_build = words[:1] == ["--build"]
    words = words[asked_to_build:]
    if not words or words[0] in ("-h", "--help"):
        print(USAGE)
        for name, (_, _, _, does) in STUDIES.items():
            print(f"  {name:18} {does}")
        return
    name, *arguments = words
    if name not in STUDIES:
        fail(f"there is no study '{name}'; hint: scripts/study --help lists them")
    module, function, targets, _ = STUDIES[name]
    if "-h" not in arguments and "--help" not in arguments:
        if asked_to_build:
            build(*targets)
        need(name, *targets)
    sys.argv[0] = f"scripts/study {name}"
    getattr(importlib.import_module(f"studies.{module}"), function)(arguments)
