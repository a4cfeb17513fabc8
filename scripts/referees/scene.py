"""A scene's folder as drivers take it. Needs NumPy only, as drivers run in other programs' own Pythons.

    scene = Scene(sys.argv[1]); ...; write_picture(sys.argv[2], pixels)

The lattice is straightened: the first voxel's centre is at 0, x, y and z run along the lattice's axes, and the camera is turned with it, so
that programs which know spacing only show the same picture.
"""
import json
import re
from pathlib import Path

import numpy

from .files import linear, read_nrrd, write_picture  # noqa: F401


class Scene:
    def __init__(self, folder):
        self.folder = Path(folder)
        fields, self.voxels = read_nrrd(self.folder / "volume.nrrd")
        steps = numpy.array(re.findall(r"[^(), ]+", fields["space directions"]), float).reshape(3, 3)
        origin = numpy.array(re.findall(r"[^(), ]+", fields["space origin"]), float)
        self.dims = self.voxels.shape[::-1]
        self.spacing = numpy.linalg.norm(steps, axis=1)
        self.unit = float(self.spacing.min())  # the length that opacities are of
        axes = steps / self.spacing[:, None]
        function = json.loads((self.folder / "function.json").read_text())[0]
        self.opacities = [tuple(function["Points"][k:k + 2]) for k in range(0, len(function["Points"]), 4)]
        self.colours = [(p[0], *linear(p[1:])) for p in numpy.reshape(function["RGBPoints"], (-1, 4))]
        camera = json.loads((self.folder / "camera.json").read_text())
        self.size = camera["size"][0]
        self.height, self.fov = camera.get("height"), camera.get("fov")  # orthographic: world height of the picture; perspective: degrees
        self.eye, self.target = (axes @ (numpy.array(camera[key]) - origin) for key in ("eye", "target"))
        self.up = axes @ numpy.array(camera["up"])
        self.world = camera

    def table(self, count):
        """Values, linear colours and opacities in even steps from below to above all points, for programs that want a table."""
        ends = [point[0] for points in (self.opacities, self.colours) for point in points]
        beyond = 0.01 * (max(ends) - min(ends))
        values = numpy.linspace(min(ends) - beyond, max(ends) + beyond, count)
        colours = numpy.stack([numpy.interp(values, [p[0] for p in self.colours], [p[c] for p in self.colours]) for c in (1, 2, 3)], axis=1)
        return values, colours, numpy.interp(values, *zip(*self.opacities))
