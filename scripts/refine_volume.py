#!/usr/bin/env python3
"""Makes a volume four times as fine along each axis, linearly between its voxels:  refine_volume.py INPUT.nrrd OUTPUT.nrrd

Reads what scripts/make_test_head.py writes: one uint8 NRRD file, gzip. Axes are first filled up with zeros to a power of
two, so the head becomes 512x512x512. The output is not compressed, so that all ranks can read it at once.
"""
import sys

from pad_volume import directions, header_of, read_volume, sizes

TIMES = 2  # how often the number of voxels along each axis is doubled


def halfway(a: bytes, b: bytes) -> bytes:
    """The means of bytes, rounded down: those of one huge number, whose bytes do not carry into each other."""
    x, y = int.from_bytes(a, "little"), int.from_bytes(b, "little")
    mask = int.from_bytes(b"\x7f" * len(a), "little")
    return ((x & y) + (((x ^ y) >> 1) & mask)).to_bytes(len(a), "little")


def filled(voxels: bytes, dims: list[int], to: list[int]) -> bytes:
    out = bytearray(to[0] * to[1] * to[2])
    for z in range(dims[2]):
        for y in range(dims[1]):
            source, at = (z * dims[1] + y) * dims[0], (z * to[1] + y) * to[0]
            out[at : at + dims[0]] = voxels[source : source + dims[0]]
    return bytes(out)


def doubled_rows(voxels: bytes, nx: int) -> bytes:
    """Along x; behind a row's last voxel comes that voxel again."""
    following = bytearray(voxels[1:] + voxels[-1:])
    following[nx - 1 :: nx] = voxels[nx - 1 :: nx]
    out = bytearray(2 * len(voxels))
    out[0::2] = voxels
    out[1::2] = halfway(voxels, following)
    return bytes(out)


def doubled_blocks(voxels: bytes, length: int, count: int) -> bytes:
    """Along an axis whose steps are `length` voxels, of which `count` follow each other."""
    out = []
    for start in range(0, len(voxels), length * count):
        line = memoryview(voxels)[start : start + length * count]
        following = bytes(line[length:]) + bytes(line[-length:])
        between = halfway(line, following)
        for at in range(0, len(line), length):
            out += [line[at : at + length], between[at : at + length]]
    return b"".join(out)


def refined(voxels: bytes, dims: list[int]) -> tuple[bytes, list[int]]:
    to = [1 << (n - 1).bit_length() for n in dims]
    voxels = filled(voxels, dims, to)
    nx, ny, nz = to
    for _ in range(TIMES):
        voxels = doubled_blocks(voxels, nx * ny, nz)
        voxels = doubled_blocks(voxels, nx, ny)
        voxels = doubled_rows(voxels, nx)
        nx, ny, nz = 2 * nx, 2 * ny, 2 * nz
    return voxels, [nx, ny, nz]


def main() -> None:
    first_line, fields, voxels = read_volume(sys.argv[1])
    voxels, dims = refined(voxels, sizes(fields))
    steps = [[c / (1 << TIMES) for c in step] for step in directions(fields)]
    fields["sizes"] = " ".join(map(str, dims))
    fields["space directions"] = " ".join("(" + ",".join(f"{c:.12g}" for c in step) + ")" for step in steps)
    fields["encoding"] = "raw"
    with open(sys.argv[2], "wb") as file:
        file.write(header_of(first_line, fields) + voxels)


if __name__ == "__main__":
    main()
