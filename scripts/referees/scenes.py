"""The fifteen scenes. Each is hard in one way, unlit, black behind, and transparent at the volume's ends, as programs differ in where a
field ends."""
import math
from dataclasses import dataclass, field

import numpy

from .closed import depth, front_to_back


@dataclass
class Scene:
    name: str
    about: str
    voxels: numpy.ndarray  # z, y, x
    opacities: list  # (value, opacity of one unit length, the smallest spacing)
    colours: list  # (value, display colour)
    view: tuple = (30, 20)  # azimuth, elevation, as ringsplat has them
    height: float = 0  # the picture's, in the world; 0: what shows most of the volume
    fov: float = 0  # degrees; 0: orthographic
    steps: numpy.ndarray = field(default_factory=lambda: numpy.eye(3))  # the world vector from voxel to voxel, of each axis
    origin: tuple = (0, 0, 0)
    truth: object = None  # closed form: colours of a ray along the z axis with so large a cosine to it

    @property
    def camera(self):
        (a, e), extent = map(math.radians, self.view), numpy.array(self.voxels.shape[::-1]) @ numpy.abs(self.steps)
        to_viewer = numpy.array([math.cos(e) * math.sin(a), -math.cos(e) * math.cos(a), math.sin(e)])
        up = [-math.sin(e) * math.sin(a), math.sin(e) * math.cos(a), math.cos(e)]
        centre = numpy.array(self.origin) + 0.5 * (numpy.array(self.voxels.shape[::-1]) - 1) @ self.steps
        diagonal = float(numpy.linalg.norm(extent))
        lens = {"fov": self.fov} if self.fov else {"height": self.height or 0.62 * diagonal}
        eye = centre + (0.75 if self.fov else 2) * diagonal * to_viewer
        return {"projection": "perspective" if self.fov else "orthographic", "eye": eye.tolist(), "target": centre.tolist(), "up": up, **lens}


def places(*dims):
    """Lattice coordinates x, y, z of all voxels."""
    z, y, x = numpy.indices(dims[::-1]).astype(float)
    return x, y, z


def faded(voxels, width=3):
    """To 0 towards the lattice's ends."""
    for axis, n in enumerate(voxels.shape):
        ramp = numpy.minimum(1, numpy.minimum(numpy.arange(n), numpy.arange(n)[::-1]) / width)
        voxels = voxels * numpy.expand_dims(ramp, [a for a in range(3) if a != axis])
    return voxels


def from_middle(side):
    x, y, z = (p - (side - 1) / 2 for p in places(side, side, side))
    return numpy.sqrt(x * x + y * y + z * z)


def blobs(*dims):
    """Smooth lumps from 0 to 1, different along all axes."""
    x, y, z = (p / (n - 1) for p, n in zip(places(*dims), dims))
    lumps = [(0.35, 0.4, 0.45, 0.14, 1), (0.68, 0.6, 0.55, 0.11, 0.9), (0.5, 0.3, 0.72, 0.08, 0.7), (0.3, 0.72, 0.3, 0.09, 0.8)]
    return faded(numpy.minimum(1, sum(h * numpy.exp(-((x - a)**2 + (y - b)**2 + (z - c)**2) / (2 * s * s)) for a, b, c, s, h in lumps)))


def marschner_lobb(side=41):
    x, y, z = (2 * p / (side - 1) - 1 for p in places(side, side, side))
    ripple = numpy.cos(12 * math.pi * numpy.cos(math.pi / 2 * numpy.sqrt(x * x + y * y)))
    return faded((1 - numpy.sin(math.pi / 2 * z) + 0.25 * (1 + ripple)) / 2.5).astype(numpy.float32)


def layers(values, *dims):
    """Voxels whose values depend on z alone."""
    return numpy.broadcast_to(numpy.asarray(values)[:, None, None], dims[::-1]).copy()


RAINBOW = [(0, (0.1, 0.2, 1)), (0.35, (0.1, 0.9, 0.4)), (0.65, (1, 0.8, 0.1)), (1, (1, 0.2, 0.1))]


def rainbow(low, high):
    return [(low + (high - low) * value, colour) for value, colour in RAINBOW]


def with_holes(voxels):
    voxels = voxels.astype(numpy.float32)
    voxels[14:19, 10:20, 12:22] = voxels[24, 26, 20] = voxels[20, 18, 27] = numpy.nan
    return voxels


def jumps(side=40):
    """Boxes of 120 and 255, which share faces, edges and corners."""
    x, y, z = (p.astype(int) // 5 for p in places(side, side, side))
    inside = (numpy.minimum.reduce([x, y, z]) > 0) & (numpy.maximum.reduce([x, y, z]) < 7)
    return numpy.where(inside, numpy.array([0, 120, 255])[(x + 2 * y + z) % 3], 0).astype(numpy.uint8)


def spikes(side=24):
    voxels = numpy.zeros((side, side, side), numpy.uint8)
    for k in range(12):
        voxels[4 + (5 * k) % 16, 4 + (7 * k) % 17, 4 + (11 * k) % 16] = 255 - 12 * k
    return voxels


def turned():
    """Steps along the axes of a lattice turned about (1, 2, 3), as rows."""
    axis, angle = numpy.array([1, 2, 3]) / math.sqrt(14), math.radians(50)
    cross = numpy.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return (numpy.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross).T


def all_scenes():
    orange, white = (1, 0.6, 0.2), (1, 1, 1)
    within = numpy.r_[[0] * 6, [200] * 12, [0] * 6].astype(numpy.uint8)
    wall = numpy.r_[[0] * 4, [100] * 10, [0] * 4, [-100] * 8, [0] * 4].astype(numpy.int16)
    ramp, glass = (numpy.arange(33) / 32).astype(numpy.float32), [(0, 0), (0.1, 0), (1, 0.5)]
    peaks = [(0.3, (1, 0.2, 0.1)), (0.5, (0.2, 1, 0.1)), (0.7, (0.1, 0.3, 1))]
    return [
        Scene("slab", "twelve even layers, seen aslant", layers(within, 64, 64, 24), [(0, 0), (200, 0.1)], [(0, orange), (200, orange)],
              (30, 60), 24, truth=front_to_back((depth(12, 0.1), orange))),
        Scene("faint", "250 layers, each of opacity 0.0003", layers(numpy.r_[[0] * 3, [255] * 250, [0] * 3].astype(numpy.uint8), 24, 24, 256),
              [(0, 0), (255, 0.0003)], [(0, white), (255, white)], (0, 90), 12, truth=front_to_back((depth(250, 0.0003), white))),
        Scene("curtain", "a white wall behind a red one that lets through 2 %", layers(wall, 64, 64, 30),
              [(-100, 0.4), (-20, 0), (20, 0), (100, 0.8)], [(-100, (1, 0, 0)), (-20, (1, 0, 0)), (20, white), (100, white)], (20, 70), 20,
              truth=front_to_back((depth(8, 0.4, 0.8), (1, 0, 0)), (depth(10, 0.8, 0.8), white))),
        Scene("layer", "a ramp of which three thin layers show, each 0.1 voxels thick", layers(ramp, 64, 64, 33),
              [(0, 0)] + [p for v, _ in peaks for p in ((v - 0.0016, 0), (v, 0.99), (v + 0.0016, 0))] + [(1, 0)],
              [(0, peaks[0][1]), (0.39, peaks[0][1]), (0.41, peaks[1][1]), (0.59, peaks[1][1]), (0.61, peaks[2][1]), (1, peaks[2][1])],
              (25, 55), 20, truth=front_to_back(*((depth(1, 0.99, 0.0016 * 32), colour) for _, colour in peaks[::-1]))),
        Scene("ball", "a ball whose opacity jumps to 0.5", numpy.clip(255 * (1 - from_middle(48) / 24), 0, 255).astype(numpy.uint8),
              [(0, 0), (127.5, 0), (127.6, 0.5), (255, 0.5)], rainbow(127, 255), height=28),
        Scene("opaque", "opacity rises to 1 within a fiftieth of the values", numpy.clip(1 - from_middle(40) / 19, 0, 1).astype(numpy.float32),
              [(0, 0), (0.4, 0), (0.42, 1), (1, 1)], [(0, (1, 0.1, 0.1)), (0.4, (1, 0.1, 0.1)), (0.42, (0.1, 0.2, 1)), (1, (0.1, 0.2, 1))], height=26),
        Scene("marschner-lobb", "Marschner and Lobb's signal, a soft surface", marschner_lobb(), [(0, 0), (0.4, 0), (0.5, 0.6), (0.6, 0), (1, 0)],
              rainbow(0.4, 0.6)),
        Scene("spikes", "twelve single voxels", spikes(), [(0, 0), (255, 0.9)], rainbow(0, 255)),
        Scene("jumps", "boxes whose voxels jump from 0 to 120 and 255", jumps(), [(0, 0), (50, 0), (52, 0.08), (180, 0.08), (182, 0.4), (255, 0.4)],
              [(0, (0.2, 0.6, 1)), (180, (0.2, 0.6, 1)), (182, orange), (255, orange)]),
        Scene("flat-voxels", "voxels five times as long as wide", numpy.rint(255 * blobs(44, 40, 12)).astype(numpy.uint8), [(0, 0), (25, 0), (255, 0.4)],
              rainbow(25, 255), steps=numpy.diag([1, 1, 5.0])),
        Scene("turned", "a lattice turned in the world, far from its origin", numpy.rint(255 * blobs(40, 34, 28)).astype(numpy.uint8),
              [(0, 0), (25, 0), (255, 0.5)], rainbow(25, 255), steps=turned() * 0.7, origin=(300, -200, 150)),
        Scene("zoom", "three voxels fill the picture", marschner_lobb(), [(0, 0), (0.1, 0), (1, 0.3)], rainbow(0.2, 0.8), height=3),
        Scene("perspective", "an eye near the volume, 70 degrees wide", blobs(40, 40, 40).astype(numpy.float32), glass, rainbow(0.1, 1), fov=70),
        Scene("narrow-window", "int16 like CT, of which 60 of 4,096 values show", numpy.rint(4095 * blobs(40, 40, 40) - 1024).astype(numpy.int16),
              [(-1024, 0), (20, 0), (40, 0.6), (60, 0.05), (80, 0.6), (81, 0), (3071, 0)], rainbow(20, 80)),
        Scene("not-a-number", "floats with holes of NaN", with_holes(blobs(40, 40, 40)), glass, rainbow(0.1, 1)),
    ]
