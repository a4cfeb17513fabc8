#!/usr/bin/env python3
"""What a --config file and options mean for a simulation: the platform's settings and each rank's host.

    simulated_job.py JOB HOSTS CONFIG.toml [OPTION...]

Writes JOB, to be sourced by bash, and HOSTS, a line for each rank. Used by scripts/simulate.sh.
"""
import argparse
import os
import shlex
import sys

try:
    import tomllib
except ImportError:
    sys.exit("ringsplat: simulations need Python 3.11 or later")

REPO = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")


def fail(problem, hint):
    sys.exit(f"ringsplat: error: {problem}; hint: {hint}")


def read_toml(path):
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except OSError as error:
        fail(f"{path} cannot be read: {error.strerror}", "mpi_configs/simulated and mpi_configs/machines have such files")
    except tomllib.TOMLDecodeError as error:
        fail(f"{path} is no TOML: {error}", "mpi_configs/simulated and mpi_configs/machines have such files")


def found(path):
    """A file named in a configuration: as it is, or from the repository."""
    if os.path.exists(path) or os.path.isabs(path):
        return path
    from_repo = os.path.normpath(os.path.join(REPO, path))
    return from_repo if os.path.exists(from_repo) else path


def layout_of(settings, config):
    """Numbers of GPs and Renderers and the mesh, as choose_layout() of the program takes them."""
    try:
        if "auto" in (settings.get("gps"), settings.get("renderers")):
            ranks = os.environ.get("RINGSPLAT_RANKS", "")
            if not ranks.isdigit() or int(ranks) < 2:
                fail("with gps auto the program chooses the roles of so many ranks, but nothing says how many", "set RINGSPLAT_RANKS to two or more")
            return int(ranks), 0, ""
        if settings.get("topology", "ring") == "mesh":
            columns, rows = (int(n) for n in str(settings["mesh"]).split("x"))
            return columns * rows, int(settings.get("renderers", rows)), f"{columns}x{rows}"
        return int(settings["gps"]), int(settings["renderers"]), ""
    except (KeyError, ValueError) as error:
        fail(f"{config}: {error} does not say the layout", "give gps and renderers, or topology, mesh and renderers")


def parser_of(*names):
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    for name in names:
        parser.add_argument(f"--{name}")
    return parser


def main():
    job, hosts, config, *options = sys.argv[1:]
    settings = read_toml(config)
    given, _ = parser_of("gps", "renderers", "topology", "mesh", "roles").parse_known_args(options)
    # The program takes the machine once, by the path that is found here.
    machine_given, options = parser_of("machine").parse_known_args(options)
    settings |= {key: value for key, value in (vars(given) | vars(machine_given)).items() if value is not None}
    if "machine" not in settings:
        fail(f"{config} names no machine", 'for instance machine = "mpi_configs/machines/pixel-planes-5.toml"')
    machine = found(settings["machine"])
    gps, renderers, mesh = layout_of(settings, config)
    ranks = gps if not renderers else max(gps, renderers) if settings.get("roles") == "colocated" else gps + renderers
    if ranks < 1:
        fail(f"{config} asks for {ranks} ranks", "use at least one GP and one Renderer")
    platform = read_toml(machine).get("platform", {})
    if not renderers and platform.get("kind") == "mesh":
        fail("the ranks of a mesh have fixed roles, so gps cannot be auto", "give topology, mesh and renderers")
    places = int(platform.get("hosts", 0)) or -(-ranks // int(platform.get("cores", 1)))
    if os.environ.get("RINGSPLAT_MAP_BY") == "node":
        places_of = [rank % places for rank in range(ranks)]
    elif platform.get("hosts"):
        places_of = [rank * places // ranks for rank in range(ranks)]
    else:
        places_of = [rank // int(platform.get("cores", 1)) for rank in range(ranks)]
    with open(hosts, "w", encoding="utf-8") as file:
        file.writelines(f"n{place}\n" for place in places_of)
    # A volume in the configuration is meant from the repository too.
    arguments = ["--config", config, "--machine", machine, *options]
    if "volume" in settings and not (options and not options[0].startswith("-")):
        arguments.insert(0, found(settings["volume"]))
    values = {"MACHINE": machine, "RANKS": ranks, "GPS": gps, "RENDERERS": renderers or 1, "MESH": mesh}
    with open(job, "w", encoding="utf-8") as file:
        for key, value in values.items():
            file.write(f"export RINGSPLAT_{key}={shlex.quote(str(value))}\n")
        file.write(f"arguments=({' '.join(shlex.quote(str(a)) for a in arguments)})\n")


if __name__ == "__main__":
    main()
