#!/usr/bin/env python3
"""Checks that scripts/study calibrate finds the costs that statistics were made from.

usage: check_calibration.py FOLDER_OF_SCRIPTS SCRATCH      (exits with 77 where Python cannot read TOML)
"""
import contextlib
import io
import json
import os
import random
import shutil
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv[1])
from studies.debian import restart_without  # noqa: E402

if missing := restart_without("numpy", "tomllib", in_environments=True):
    print(f"skipped: {missing} is missing")
    sys.exit(77)

import tomllib  # noqa: E402
from studies.calibrate import Runs, machine_of, non_negative  # noqa: E402

COSTS = {"gp": {"visible_voxel": 1.2e-8, "transparent_voxel": 2e-10, "slice": 3e-7, "frame": 5e-4, "token": 4e-7},
         "renderer": {"splat": 4e-8, "slice": 2e-6, "composite": 2e-10, "pixel": 1e-8},
         "sheets": {"look": 4e-9, "copy": 5e-8, "place": 1.5e-7, "slice": 5e-6, "sample": 2e-9, "table": 9e-4}}
VOXELS = 128 * 128 * 124
PARTS = ("computing", "waiting_for_token", "sending", "drawing", "compositing", "delivering", "idle")
COUNTS = ("splats_sent", "splats_drawn", "splats_clipped", "payloads_drawn", "slices", "blocks", "samples", "visible_voxels", "tile_bytes")


def node(name, spent, **counts):
    counts = {count: int(value) for count, value in counts.items()}
    return {"node": name, **dict.fromkeys(COUNTS, 0), **counts, "seconds": {**dict.fromkeys(PARTS, 0.0), **spent}}


def write(folder, name, *frames):
    """A run of frames, each its seconds and nodes, after a first one that takes as long as any may."""
    with open(os.path.join(folder, name + ".jsonl"), "w", encoding="utf-8") as file:
        for number, (seconds, nodes) in enumerate([frames[0], *frames]):
            late = 100 if number == 0 else 1
            nodes = [{**n, "seconds": {part: late * s for part, s in n["seconds"].items()}} for n in nodes]
            total = {count: sum(n[count] for n in nodes) for count in COUNTS}
            total["seconds"] = {part: sum(n["seconds"][part] for n in nodes) for part in PARTS}
            file.write(json.dumps({"frame": number, "seconds": late * seconds, "nodes": nodes, "total": total}) + "\n")


def gp_runs(folder):
    gp = COSTS["gp"]
    write(folder, "tiny", (gp["frame"], [node("GP 0", {"computing": gp["frame"]})]))
    write(folder, "empty", (1, [node("GP 0", {"computing": gp["frame"] + VOXELS * gp["transparent_voxel"]})]))
    computing = gp["frame"] + 4096 * gp["slice"]
    write(folder, "line", (computing + 4096 * gp["token"], [node("GP 0", {"computing": computing}, slices=4096)]))
    write(folder, "hop", (4096 * (gp["slice"] + gp["token"] + 3 * 2e-7), [node("GP 0", {})]))


def splat_frame(splats, payloads, pixels):
    gp, renderer = COSTS["gp"], COSTS["renderer"]
    computing = gp["frame"] + splats * gp["visible_voxel"] + (VOXELS - splats) * gp["transparent_voxel"]
    drawing = {"drawing": splats * renderer["splat"], "compositing": payloads * renderer["slice"] + pixels * renderer["composite"],
               "delivering": 1000 * renderer["pixel"]}
    return (1, [node("GP 0", {"computing": computing}, visible_voxels=splats),
                node("Renderer 0", drawing, splats_drawn=splats, payloads_drawn=payloads, samples=pixels, tile_bytes=16000)])


def sheet_frame(blocks, placed, payloads, samples, dear, noise):
    """`dear`: so many times as much for a sample."""
    gp, sheets = COSTS["gp"], COSTS["sheets"]
    computing = gp["frame"] + payloads * gp["slice"] + blocks * sheets["look"] + placed * sheets["copy"]
    drawing = (sheets["table"] + payloads * sheets["slice"] + blocks * sheets["look"] + placed * sheets["place"]
               + dear * samples * sheets["sample"])
    return (1, [node("GP 0", {"computing": computing * noise()}, slices=payloads, blocks=blocks, splats_sent=placed),
                node("Renderer 0", {"drawing": drawing * noise()}, blocks=blocks, splats_drawn=placed, payloads_drawn=payloads, samples=samples)])


def calibrated(folder, random_part):
    """The machine and what was said of its fit."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    numbers = random.Random(1)

    def noise():
        return 1 + random_part * (2 * numbers.random() - 1)

    gp_runs(folder)
    write(folder, "splats-head", splat_frame(600000, 120, 8e6), splat_frame(700000, 110, 6e6))
    write(folder, "splats-head-many", splat_frame(600000, 9000, 7e6))
    for name, dear, *counts in (("head", 1, 31000, 12000, 120, 8e6), ("head-small", 1, 30000, 11000, 120, 2e6),
                                ("head-many", 1, 300000, 30000, 3000, 2e6), ("head-tiny", 1, 60, 4, 4, 200),
                                ("wide-few", 3, 250000, 120000, 60, 2e6), ("wide-many", 3, 900000, 300000, 600, 2e6)):
        write(folder, "sheets-" + name, *(sheet_frame(*counts, dear, noise) for _ in range(4)))
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        machine = machine_of(Runs(folder), 2)
    return tomllib.loads(machine), said.getvalue()


def close(machine, room, relative):
    for name, cost in COSTS[room].items():
        found = machine[room][name]
        print(f"{room}.{name}: {found}, made from {cost}")
        if abs(found - cost) > relative * cost:
            sys.exit(f"{room}.{name} is not within {relative} of what it was made from")


def check_least_squares():
    # Without a bound the second would be -1; with it the first takes the mean of 1 and 2, by the rows' squares.
    fitted = non_negative([[1, 0], [1, 1]], [2, 1])
    assert fitted[1] == 0 and abs(fitted[0] - 1.5) < 1e-12, fitted
    # What was never paid costs nothing.
    fitted = non_negative([[2, 0], [4, 0]], [6, 12])
    assert fitted[1] == 0 and abs(fitted[0] - 3) < 1e-12, fitted


def main():
    scratch = sys.argv[2]
    check_least_squares()
    machine, said = calibrated(scratch, 0)
    for room in COSTS:
        close(machine, room, 1e-3)
    assert "sheets: 48 parts of frames in 6 runs, off by 0.0 % of a frame" in said, said
    machine, said = calibrated(scratch, 0.05)
    close(machine, "sheets", 0.2)
    off = float(said.split("sheets: 48 parts of frames in 6 runs, off by ")[1].split()[0])
    assert 0.5 < off < 5, said


if __name__ == "__main__":
    main()
