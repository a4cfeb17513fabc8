"""What all programs of scripts/bench_peers.sh are given: the head, its transfer functions and the views.

    scene.py HEAD.nrrd FOLDER SOFT.json SURFACE.json

Writes into FOLDER the voxels with axes along the world's (head.raw, x fastest), scene.json, views.txt (a line a
view: azimuth elevation), and for each transfer function its opacities with white (NAME.json for ringsplat,
NAME.opacity: one number a value for VolPack). White, as VolPack's fast path is grey and programs differ in the
space in which they mix colours.
"""
import gzip
import json
import math
import sys
from pathlib import Path

import numpy

VIEWS = 24
SIZE = 512


def read_head(path):
    """Voxels [z, y, x] and spacing; the file's axes point along the world's or against them."""
    header, data = path.read_bytes().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in header.decode().splitlines() if ": " in line)
    x, y, z = map(int, fields["sizes"].split())
    voxels = numpy.frombuffer(gzip.decompress(data), numpy.uint8).reshape(z, y, x)
    directions = [json.loads(d.replace("(", "[").replace(")", "]")) for d in fields["space directions"].split()]
    spacing = [directions[k][k] for k in range(3)]
    for axis, step in zip((2, 1, 0), spacing):
        if step < 0:
            voxels = numpy.flip(voxels, axis)
    return voxels, [abs(s) for s in spacing]


def fade(voxels, width=3):
    """To 0 towards the lattice's ends: the neck is cut there, and programs differ in where the field ends."""
    faded = voxels.astype(float)
    for axis in range(3):
        count = voxels.shape[axis]
        ramp = numpy.minimum(1, numpy.minimum(numpy.arange(count), numpy.arange(count)[::-1]) / width)
        faded *= numpy.expand_dims(ramp, [a for a in range(3) if a != axis])
    return numpy.rint(faded).astype(numpy.uint8)


def views():
    """Once around, up and down so steeply that all three slice sets are traversed."""
    return [(360.0 * k / VIEWS, 70 * math.sin(2 * math.pi * k / 8)) for k in range(VIEWS)]


def whiten(function):
    """The opacity points (value, opacity) of ParaView's JSON, and that JSON in white."""
    points = [(function["Points"][k], function["Points"][k + 1]) for k in range(0, len(function["Points"]), 4)]
    ends = (points[0][0], points[-1][0])
    function["RGBPoints"] = [c for end in ends for c in (end, 1, 1, 1)]
    function["ColorSpace"] = "RGB"
    return points, [function]


def main():
    head, folder = Path(sys.argv[1]), Path(sys.argv[2])
    voxels, spacing = read_head(head)
    voxels = fade(voxels)
    voxels.tofile(folder / "head.raw")
    scene = {"dims": list(voxels.shape[::-1]), "spacing": spacing, "size": SIZE, "functions": {}}
    for name, file in zip(("soft", "surface"), sys.argv[3:5]):
        points, white = whiten(json.loads(Path(file).read_text())[0])
        scene["functions"][name] = points
        (folder / f"{name}.json").write_text(json.dumps(white))
        opacity = numpy.interp(numpy.arange(256), *zip(*points))
        (folder / f"{name}.opacity").write_text("\n".join(f"{o:.9g}" for o in opacity) + "\n")
        scene[f"{name} visible"] = float((opacity[voxels] > 0).mean())
    (folder / "views.txt").write_text("".join(f"{a:.6f} {e:.6f}\n" for a, e in views()))
    (folder / "scene.json").write_text(json.dumps(scene))


if __name__ == "__main__":
    main()
