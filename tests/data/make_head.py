#!/usr/bin/env python3
"""Makes tests/data/head.nrrd: the Colin27 head of Debian's mricron-data as 128 x 128 x 124 uint8.

Needs python3-numpy and mricron-data:  tests/data/make_head.py [INPUT.nii.gz] [OUTPUT.nrrd]
"""
import gzip
import os
import struct
import sys

import numpy

SOURCE = "/usr/share/mricron/templates/ch2.nii.gz"
TARGET = os.path.join(os.path.dirname(os.path.abspath(__file__)), "head.nrrd")
DIMS = (128, 128, 124)


def read_nifti(path):
    """Voxels as array[x, y, z], and the 4 x 4 matrix from voxel to RAS world (millimetres)."""
    with gzip.open(path) as file:
        data = file.read()
    if struct.unpack_from("<i", data, 0)[0] != 348 or data[344:347] != b"n+1":
        raise SystemExit(f"{path} is not a little-endian single-file NIfTI-1")
    dims = struct.unpack_from("<8h", data, 40)
    datatype, sform_code = struct.unpack_from("<h", data, 70)[0], struct.unpack_from("<h", data, 254)[0]
    if dims[0] != 3 or datatype != 2 or sform_code == 0:
        raise SystemExit(f"{path}: expected 3D uint8 with an sform matrix")
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
    x, y, z = (box_weights(old, new) for old, new in zip(voxels.shape, dims))
    averaged = numpy.einsum("ai,ijk->ajk", x, voxels.astype(numpy.float64), optimize=True)
    averaged = numpy.einsum("bj,ajk->abk", y, averaged, optimize=True)
    averaged = numpy.einsum("ck,abk->abc", z, averaged, optimize=True)
    return numpy.clip(numpy.rint(averaged), 0, 255).astype(numpy.uint8)


def nrrd_header(dims, affine):
    def vector(v):
        return "(" + ",".join(f"{x:.12g}" for x in v) + ")"

    return (
        "NRRD0004\n"
        "# Colin27 head of mricron-data (BSD-3-Clause), resampled by tests/data/make_head.py\n"
        "type: uint8\ndimension: 3\nspace: left-posterior-superior\n"
        f"sizes: {dims[0]} {dims[1]} {dims[2]}\n"
        f"space directions: {' '.join(vector(affine[:3, i]) for i in range(3))}\n"
        "kinds: domain domain domain\nencoding: gzip\n"
        f"space origin: {vector(affine[:3, 3])}\n\n"
    ).encode()


def main():
    source = sys.argv[1] if len(sys.argv) > 1 else SOURCE
    target = sys.argv[2] if len(sys.argv) > 2 else TARGET
    voxels, to_ras = read_nifti(source)
    head = resample(voxels, DIMS)

    # The new lattice spans the same box: voxel edges, not centres, coincide at both ends.
    scale = numpy.array(voxels.shape) / numpy.array(DIMS)
    to_old = numpy.diag([*scale, 1.0])
    to_old[:3, 3] = scale / 2 - 0.5
    ras_to_lps = numpy.diag([-1.0, -1.0, 1.0, 1.0])
    header = nrrd_header(DIMS, ras_to_lps @ to_ras @ to_old)

    beside = target + ".part"
    with open(beside, "wb") as file:
        # No time stamp, so that the same input gives the same file.
        file.write(header + gzip.compress(head.tobytes(order="F"), 9, mtime=0))
    os.replace(beside, target)
    print(f"{target}: {os.path.getsize(target)} bytes, {100 * (head >= 75).mean():.1f} % of the voxels are >= 75")


if __name__ == "__main__":
    main()
