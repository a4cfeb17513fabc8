"""What the peers' programs share: the scene that scripts/study peers wrote, ringsplat's camera, and the frames' times and pictures.

Imported by scripts that run in VTK's and ParaView's own Pythons.
"""
import json
import math
import time
from pathlib import Path

import numpy

LIGHT = (-0.4, 0.6, 0.7)  # right, up, to the viewer: ringsplat's
AMBIENT, DIFFUSE, SPECULAR = 0.25, 0.75, 0.25
# By the mirrored ray, as in ringsplat. The fixed-point caster's highlight is by the half vector, whose angle is half the mirrored ray's:
# about four times the exponent.
EXPONENT, HALF_VECTOR_EXPONENT = 24.0, 4 * 24.0


class Scene:
    def __init__(self, folder):
        self.folder = Path(folder)
        fields = json.loads((self.folder / "scene.json").read_text())
        self.dims, self.spacing, self.size, self.functions = (fields[key] for key in ("dims", "spacing", "size", "functions"))
        self.views = [tuple(map(float, line.split())) for line in (self.folder / "views.txt").read_text().splitlines()]

    def camera(self, azimuth, elevation):
        """Orthographic, the bounding sphere fits the picture (view/camera.cpp): its radius, centre, and where the eye, what is up and the
        light are."""
        ca, sa = math.cos(math.radians(azimuth)), math.sin(math.radians(azimuth))
        ce, se = math.cos(math.radians(elevation)), math.sin(math.radians(elevation))
        right, up, to_viewer = axes = numpy.array([(ca, sa, 0), (-se * sa, se * ca, ce), (ce * sa, -ce * ca, se)])
        extent = numpy.array(self.dims) * self.spacing
        centre = 0.5 * (extent - self.spacing)
        radius = 0.5 * numpy.linalg.norm(extent)
        return float(radius), *(v.tolist() for v in (centre, centre + 3 * radius * to_viewer, up, centre + numpy.array(LIGHT) @ axes))


def draw_frames(scene, turn, render, picture, prefix, first=True):
    """Prints the seconds of each view's frame, and where there is a prefix writes PREFIX-NNNN.pfm, linear over black. `picture` gives width,
    height and pixels with the bottom row first; of several processes the first one alone writes."""
    for number, view in enumerate(scene.views):
        turn(scene.camera(*view))
        start = time.perf_counter()
        render()
        seconds = time.perf_counter() - start
        if first:
            print(seconds, flush=True)
        if prefix:
            width, height, pixels = picture()
            if first:
                data = (pixels[:, :3].astype("<f4") / 255).tobytes()
                Path(f"{prefix}-{number:04}.pfm").write_bytes(f"PF\n{width} {height}\n-1.0\n".encode() + data)
