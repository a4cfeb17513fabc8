"""Volumes and transfer functions that studies make, mostly of the repository's head. Needs NumPy."""
import gzip
import json
import re
import sys

from .output import whole_file
from .run import fail, parser

try:
    import numpy
except ImportError:
    sys.exit("ringsplat: this needs NumPy: apt-get install python3-numpy")

REFINED = 4


class Volume:
    """One uint8 NRRD file with gzip, as tests/data/make_head.py writes it: voxels [z, y, x] and where they lie in the world."""

    def __init__(self, path):
        with open(path, "rb") as file:
            header, packed = file.read().split(b"\n\n", 1)
        lines = header.decode().splitlines()
        self.first_line = lines[0]
        self.fields = dict(line.split(": ", 1) for line in lines if ": " in line)
        if self.fields["type"] != "uint8" or self.fields["encoding"] != "gzip":
            fail(f"{path} is no gzip-compressed uint8 NRRD")
        sizes = [int(n) for n in self.fields["sizes"].split()]
        self.voxels = numpy.frombuffer(gzip.decompress(packed), numpy.uint8).reshape(sizes[::-1])
        self.directions = [self.vector(v) for v in re.findall(r"\([^)]*\)", self.fields["space directions"])]
        self.origin = self.vector(self.fields["space origin"])

    @staticmethod
    def vector(text):
        return numpy.array([float(x) for x in text.strip("()").split(",")])

    @staticmethod
    def text(vector):
        return "(" + ",".join(f"{x:.12g}" for x in vector) + ")"

    def write(self, path, packed=False):
        """Raw unless packed, so that all ranks can read it at once."""
        fields = self.fields | {"sizes": " ".join(map(str, self.voxels.shape[::-1])), "encoding": "gzip" if packed else "raw",
                                "space directions": " ".join(map(self.text, self.directions)), "space origin": self.text(self.origin)}
        header = self.first_line + "\n" + "".join(f"{key}: {value}\n" for key, value in fields.items()) + "\n"
        data = self.voxels.tobytes()
        with whole_file(path) as beside, open(beside, "wb") as file:
            # No time stamp, so that the same input gives the same file.
            file.write(header.encode() + (gzip.compress(data, 6, mtime=0) if packed else data))
        return path


def two_files(words, doc):
    arguments = parser(doc)
    arguments.add_argument("input", help="a uint8 NRRD with gzip, as tests/data/head.nrrd")
    arguments.add_argument("output")
    return arguments.parse_args(words)


def pad(words):
    options = two_files(words, "Puts a volume into a box of zeros twice as large; voxels keep their places in the world.")
    padded(options.input, options.output)


def padded(source, target):
    volume = Volume(source)
    dims = volume.voxels.shape
    wide = numpy.zeros([2 * n for n in dims], numpy.uint8)
    wide[tuple(slice(n // 2, n // 2 + n) for n in dims)] = volume.voxels
    volume.origin = volume.origin - sum(n // 2 * step for n, step in zip(dims[::-1], volume.directions))
    volume.voxels = wide
    return volume.write(target, packed=True)


def refine(words):
    options = two_files(words, "Makes a volume four times as fine along each axis, linearly between its voxels.\n"
                               "Axes are first filled up with zeros to a power of two, so the head becomes 512 x 512 x 512.")
    refined(options.input, options.output)


def refined(source, target):
    volume = Volume(source)
    voxels = numpy.zeros([1 << (n - 1).bit_length() for n in volume.voxels.shape], numpy.uint8)
    voxels[tuple(map(slice, volume.voxels.shape))] = volume.voxels
    for _ in range(REFINED.bit_length() - 1):
        for axis in range(3):
            # Behind the last voxel comes that voxel again; means are rounded down.
            following = numpy.concatenate([voxels, voxels.take([-1], axis)], axis).take(range(1, voxels.shape[axis] + 1), axis)
            between = (voxels & following) + ((voxels ^ following) >> 1)
            shape = [n * (1 + (a == axis)) for a, n in enumerate(voxels.shape)]
            voxels = numpy.stack([voxels, between], axis + 1).reshape(shape)
    volume.voxels = voxels
    volume.directions = [step / REFINED for step in volume.directions]
    return volume.write(target)


def every_other_voxel(source, target):
    """Undersamples by two along every axis (Neumann 1992, section 4.4)."""
    volume = Volume(source)
    volume.voxels = volume.voxels[::2, ::2, ::2]
    volume.directions = [2 * step for step in volume.directions]
    return volume.write(target)


def step_function(path, first_visible, opacity=0.3):
    """A transfer function of 8-bit values that shows those from `first_visible` on."""
    points = [0, 0 if first_visible > 0 else opacity, 0.5, 0]
    if first_visible > 0:
        points += [first_visible - 1, 0, 0.5, 0, first_visible, opacity, 0.5, 0]
    points += [255, opacity, 0.5, 0]
    with open(path, "w", encoding="utf-8") as file:
        json.dump([{"Name": "step", "ColorSpace": "RGB", "NanColor": [1, 0, 0],
                    "RGBPoints": [0, 0.5, 0.5, 0.5, 255, 1, 1, 1], "Points": points}], file)
    return path


def threshold_for(path, visible):
    """The 8-bit value from which on a raw volume has about `visible` voxels."""
    counts = numpy.bincount(numpy.fromfile(path, numpy.uint8), minlength=256)
    above = counts[::-1].cumsum()[::-1]
    return min(range(1, 256), key=lambda value: abs(above[value] - visible))
