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


def read_volume(path: str) -> tuple[str, dict[str, str], bytes]:
    """Its first line, its fields and its voxels."""
    with open(path, "rb") as file:
        header, packed = file.read().split(b"\n\n", 1)
    lines = header.decode().splitlines()
    fields = dict(line.split(": ", 1) for line in lines if ": " in line)
    if fields["type"] != "uint8" or fields["encoding"] != "gzip":
        raise SystemExit(f"{path} is no gzip-compressed uint8 NRRD")
    return lines[0], fields, gzip.decompress(packed)


def sizes(fields: dict[str, str]) -> list[int]:
    return [int(n) for n in fields["sizes"].split()]


def directions(fields: dict[str, str]) -> list[list[float]]:
    return [vector(v) for v in re.findall(r"\([^)]*\)", fields["space directions"])]


def header_of(first_line: str, fields: dict[str, str]) -> bytes:
    return (first_line + "\n" + "".join(f"{key}: {value}\n" for key, value in fields.items()) + "\n").encode()


def main() -> None:
    first_line, fields, voxels = read_volume(sys.argv[1])
    dims, steps = sizes(fields), directions(fields)
    origin = vector(fields["space origin"])
    moved = [o - sum(dims[a] // 2 * steps[a][k] for a in range(3)) for k, o in enumerate(origin)]
    fields["sizes"] = " ".join(str(2 * n) for n in dims)
    fields["space origin"] = "(" + ",".join(f"{o:.12g}" for o in moved) + ")"
    with open(sys.argv[2], "wb") as file:
        file.write(header_of(first_line, fields) + gzip.compress(padded(voxels, dims), 6, mtime=0))


if __name__ == "__main__":
    main()
