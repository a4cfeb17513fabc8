"""The files of a scene, and pictures: what anybody can read, written and read in a few lines."""
import json
import struct
import zlib
from pathlib import Path

import numpy

NRRD_TYPES = {"uint8": "u1", "int16": "<i2", "float32": "<f4"}


def linear(colour):
    """Of display values (sRGB), which transfer functions have."""
    colour = numpy.asarray(colour, float)
    return numpy.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)


def write_scene(folder, scene, size):
    """volume.nrrd, function.json (as ParaView exports it) and camera.json."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    voxels = scene.voxels
    vectors = " ".join("(" + ",".join(repr(float(x)) for x in vector) + ")" for vector in scene.steps)
    origin = ",".join(repr(float(x)) for x in scene.origin)
    header = (f"NRRD0004\ntype: {voxels.dtype.name}\ndimension: 3\nspace dimension: 3\nsizes: {' '.join(map(str, voxels.shape[::-1]))}\n"
              f"space directions: {vectors}\nspace origin: ({origin})\nendian: little\nencoding: raw\n\n")
    (folder / "volume.nrrd").write_bytes(header.encode() + numpy.ascontiguousarray(voxels).tobytes())
    function = {"Name": scene.name, "ColorSpace": "RGB", "RGBPoints": [x for value, colour in scene.colours for x in (value, *colour)],
                "Points": [x for value, opacity in scene.opacities for x in (value, opacity, 0.5, 0)]}
    (folder / "function.json").write_text(json.dumps([function], indent=1))
    (folder / "camera.json").write_text(json.dumps({"size": [size, size], **scene.camera}, indent=1))


def read_nrrd(path):
    """The header's fields, and voxels with z first."""
    header, _, data = Path(path).read_bytes().partition(b"\n\n")
    fields = dict(line.split(": ", 1) for line in header.decode().splitlines() if ": " in line)
    return fields, numpy.frombuffer(data, NRRD_TYPES[fields["type"]]).reshape([int(n) for n in fields["sizes"].split()][::-1])


def write_picture(path, pixels):
    """A driver's picture: height x width x RGBA, linear premultiplied float32, the top row first, and nothing else."""
    numpy.ascontiguousarray(pixels, "<f4").tofile(path)


def read_picture(path, size):
    return numpy.fromfile(path, "<f4").reshape(size, size, 4)


def read_exr(path):
    """An OpenEXR of float32 channels A, B, G, R in blocks of 16 deflated rows, as ringsplat writes them."""
    data, at, fields = Path(path).read_bytes(), 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        length = struct.unpack("<i", rest[:4])[0]
        fields[name], at = rest[4:4 + length], at + len(name) + len(kind) + 6 + length
    left, top, right, bottom = struct.unpack("<4i", fields[b"dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    assert fields[b"compression"] == b"\3" and fields[b"channels"].count(b"\0\2\0\0\0") == 4, f"{path} is no such OpenEXR"
    blocks = -(-height // 16)
    rows = []
    for offset in struct.unpack_from(f"<{blocks}Q", data, at + 1):
        row, packed = struct.unpack_from("<2i", data, offset)
        size = 16 * width * min(16, top + height - row)
        block = data[offset + 8:offset + 8 + packed]
        if packed < size:
            deltas = numpy.frombuffer(zlib.decompress(block), numpy.uint8).astype(numpy.int64)
            deltas[1:] -= 128
            halves = numpy.cumsum(deltas).astype(numpy.uint8)
            block = numpy.empty(size, numpy.uint8)
            block[::2], block[1::2] = halves[:(size + 1) // 2], halves[(size + 1) // 2:]
        rows.append(numpy.frombuffer(bytes(block), "<f4").reshape(-1, 4, width))
    return numpy.concatenate(rows).transpose(0, 2, 1)[:, :, ::-1]
