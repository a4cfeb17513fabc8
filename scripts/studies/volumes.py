"""Volumes and transfer functions that studies make, mostly of the repository's head. Needs NumPy."""
import gzip
import json
import os
import re
import struct
import sys

from .output import whole_file
from .run import HEAD, fail, parser

try:
    import numpy
except ImportError:
    sys.exit("ringsplat: this needs NumPy: apt-get install python3-numpy")

MRICRON = "/usr/share/mricron/templates/ch2.nii.gz"
REFINED = 4


class Volume:
    """One uint8 NRRD file with gzip, as test_head() writes it: voxels [z, y, x] and where they lie in the world."""

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


def read_nifti(path):
    """Voxels as array[x, y, z], and the 4 x 4 matrix from voxel to RAS world (millimetres)."""
    with gzip.open(path) as file:
        data = file.read()
    if struct.unpack_from("<i", data, 0)[0] != 348 or data[344:347] != b"n+1":
        fail(f"{path} is not a little-endian single-file NIfTI-1")
    dims = struct.unpack_from("<8h", data, 40)
    datatype, sform_code = struct.unpack_from("<h", data, 70)[0], struct.unpack_from("<h", data, 254)[0]
    if dims[0] != 3 or datatype != 2 or sform_code == 0:
        fail(f"{path}: expected 3D uint8 with an sform matrix")
    offset = int(struct.unpack_from("<f", data, 108)[0])
    voxels = numpy.frombuffer(data, numpy.uint8, dims[1] * dims[2] * dims[3], offset)
    affine = numpy.vstack([numpy.array(struct.unpack_from("<12f", data, 280)).reshape(3, 4), [0, 0, 0, 1]])
    return voxels.reshape(dims[1:4], order="F"), affine


def box_weights(old, new):
    """new x old matrix: the share of each old voxel in each new one (area average, rows sum to 1)."""
    edges = numpy.arange(new + 1) * (old / new)
    low = numpy.maximum(edges[:-1, None], numpy.arange(old)[None, :])
    high = numpy.minimum(edges[1:, None], numpy.arange(1, old + 1)[None, :])
    weights = numpy.maximum(high - low, 0)
    return weights / weights.sum(axis=1, keepdims=True)


def resample(voxels, dims):
    for axis, weights in enumerate(box_weights(old, new) for old, new in zip(voxels.shape, dims)):
        voxels = numpy.moveaxis(numpy.tensordot(weights, voxels.astype(numpy.float64), (1, axis)), 0, axis)
    return numpy.clip(numpy.rint(voxels), 0, 255).astype(numpy.uint8)


def test_head(words):
    arguments = parser("Makes tests/data/head.nrrd: the Colin27 head of Debian's mricron-data as 128 x 128 x 124 uint8.")
    arguments.add_argument("input", nargs="?", default=MRICRON)
    arguments.add_argument("output", nargs="?", default=str(HEAD))
    options = arguments.parse_args(words)
    voxels, to_ras = read_nifti(options.input)
    dims = (128, 128, 124)
    head = resample(voxels, dims)

    # The new lattice spans the same box: voxel edges, not centres, coincide at both ends.
    scale = numpy.array(voxels.shape) / numpy.array(dims)
    to_old = numpy.diag([*scale, 1.0])
    to_old[:3, 3] = scale / 2 - 0.5
    affine = numpy.diag([-1.0, -1.0, 1.0, 1.0]) @ to_ras @ to_old
    directions = " ".join(Volume.text(affine[:3, axis]) for axis in range(3))
    header = ("NRRD0004\n# Colin27 head of mricron-data (BSD-3-Clause), resampled by scripts/study test-head\n"
              "type: uint8\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {dims[0]} {dims[1]} {dims[2]}\nspace directions: {directions}\n"
              f"kinds: domain domain domain\nencoding: gzip\nspace origin: {Volume.text(affine[:3, 3])}\n\n")
    with whole_file(options.output) as beside, open(beside, "wb") as file:
        file.write(header.encode() + gzip.compress(head.tobytes(order="F"), 9, mtime=0))
    print(f"{options.output}: {os.path.getsize(options.output)} bytes, {100 * (head >= 75).mean():.1f} % of the voxels are >= 75")
