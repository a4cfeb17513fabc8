#!/usr/bin/env python3
"""Puts a volume into a box of zeros twice as large:  pad_volume.py INPUT.nrrd OUTPUT.nrrd

Reads what scripts/make_test_head.py writes: one uint8 NRRD file, gzip. The voxels keep their places in the world.
"""
import gzip
import re
import sys


def vector(text: str) -> list[float]:
    return [float(x) for x in text.strip("()").split(",")]


def padded(voxels: bytes, dims: list[int]) -> bytes:
    nx, ny, nz = dims
    px, py, pz = (n // 2 for n in dims)
    out = bytearray(8 * len(voxels))
    for z in range(nz):
        for y in range(ny):
            row = voxels[(z * ny + y) * nx :][:nx]
            at = ((z + pz) * 2 * ny + y + py) * 2 * nx + px
            out[at : at + nx] = row
    return bytes(out)


def main() -> None:
    with open(sys.argv[1], "rb") as file:
        header, packed = file.read().split(b"\n\n", 1)
    lines = header.decode().splitlines()
    fields = dict(line.split(": ", 1) for line in lines if ": " in line)
    if fields["type"] != "uint8" or fields["encoding"] != "gzip":
        raise SystemExit(f"{sys.argv[1]} is no gzip-compressed uint8 NRRD")
    dims = [int(n) for n in fields["sizes"].split()]
    steps = [vector(v) for v in re.findall(r"\([^)]*\)", fields["space directions"])]
    origin = vector(fields["space origin"])
    moved = [o - sum(dims[a] // 2 * steps[a][k] for a in range(3)) for k, o in enumerate(origin)]
    fields["sizes"] = " ".join(str(2 * n) for n in dims)
    fields["space origin"] = "(" + ",".join(f"{o:.12g}" for o in moved) + ")"
    text = lines[0] + "\n" + "".join(f"{key}: {value}\n" for key, value in fields.items()) + "\n"
    with open(sys.argv[2], "wb") as file:
        file.write(text.encode() + gzip.compress(padded(gzip.decompress(packed), dims), 6, mtime=0))


if __name__ == "__main__":
    main()
