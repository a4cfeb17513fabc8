"""VTK: every kind of .vti, .pvti, and legacy .vtk."""
import itertools

import numpy as np
from cases import FOLDER, case, voxels
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOLegacy import vtkStructuredPointsWriter
from vtkmodules.vtkIOParallelXML import vtkXMLPImageDataWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLImageDataWriter

SPACING = (0.5, 2.0, 3.25)
ORIGIN = (1.0, -2.0, 3.0)


def array(name, volume, components=1):
    data = numpy_to_vtk(np.ascontiguousarray(volume).reshape(-1, components), deep=True)
    data.SetName(name)
    return data


def lattice(volume, first=(0, 0, 0), cells=False):
    """Of the points, or the cells, of a[z, y, x]."""
    image = vtkImageData()
    sizes = [size - (0 if cells else 1) for size in volume.shape[2::-1]]
    image.SetExtent(*[n for start, size in zip(first, sizes) for n in (start, start + size)])
    image.SetSpacing(SPACING)
    image.SetOrigin(ORIGIN)
    return image


def write_vti(image, file, mode, compressor, header=32, big=False, encode=False):
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(str(FOLDER / file))
    writer.SetInputData(image)
    {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary,
     "appended": writer.SetDataModeToAppended}[mode]()
    {"none": writer.SetCompressorTypeToNone, "zlib": writer.SetCompressorTypeToZLib,
     "lz4": writer.SetCompressorTypeToLZ4, "lzma": writer.SetCompressorTypeToLZMA}[compressor]()
    (writer.SetHeaderTypeToUInt64 if header == 64 else writer.SetHeaderTypeToUInt32)()
    (writer.SetByteOrderToBigEndian if big else writer.SetByteOrderToLittleEndian)()
    writer.SetEncodeAppendedData(encode)
    writer.SetBlockSize(64)
    assert writer.Write() == 1, file


def kinds():
    yield "ascii", "none", 32, False, False
    for mode, compressor, header, big in itertools.product(
            ("binary", "appended", "encoded"), ("none", "zlib", "lz4", "lzma"), (32, 64), (False, True)):
        if big and (compressor == "lz4" or header == 64):
            continue
        yield mode.replace("encoded", "appended"), compressor, header, big, mode == "encoded"


for mode, compressor, header, big, encode in kinds():
    volume = voxels("int16")
    image = lattice(volume)
    image.GetPointData().SetScalars(array("ct", volume))
    name = f"vtk_{mode}{'_base64' if encode else ''}_{compressor}_{header}{'_big' if big else ''}"
    write_vti(image, f"{name}.vti", mode, compressor, header, big, encode)
    case(name, f"{name}.vti", volume, spacing=SPACING, origin=ORIGIN, world="lattice", frames=1, channels=1)

for dtype in ("int8", "uint8", "uint16", "int32", "uint32", "float32", "float64"):
    volume = voxels(dtype)
    image = lattice(volume)
    image.GetPointData().SetScalars(array("a", volume))
    write_vti(image, f"vtk_{dtype}.vti", "appended", "zlib")
    case(f"vtk_{dtype}", f"vtk_{dtype}.vti", volume, spacing=SPACING)

# An extent that does not begin at 0, and a turned lattice.
volume = voxels("float32")
image = lattice(volume, first=(10, -3, 2))
image.SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1)
image.GetPointData().SetScalars(array("a", volume))
write_vti(image, "vtk_turned.vti", "appended", "none", 64)
corner = [0.0, 0.0, 0.0]
image.TransformIndexToPhysicalPoint(10, -3, 2, corner)
case("vtk_turned", "vtk_turned.vti", volume, spacing=SPACING, origin=corner,
     direction=[[0, 1, 0], [-1, 0, 0], [0, 0, 1]])

# Cells, whose centres lie half a step from the points.
volume = voxels("uint8")
image = lattice(volume, cells=True)
image.GetCellData().SetScalars(array("mass", volume))
write_vti(image, "vtk_cells.vti", "appended", "lz4")
case("vtk_cells", "vtk_cells.vti", volume, spacing=SPACING, origin=[o + s / 2 for o, s in zip(ORIGIN, SPACING)])

# Several arrays, vectors and colours.
volume, other = voxels("float32"), voxels("uint8", seed=5)
vectors = np.stack([voxels("float32", seed=n) for n in (1, 2, 3)], axis=-1)
image = lattice(volume)
image.GetPointData().AddArray(array("other", other))
image.GetPointData().SetScalars(array("active", volume))
image.GetPointData().AddArray(array("flow", vectors, 3))
write_vti(image, "vtk_arrays.vti", "appended", "zlib")
case("vtk_active", "vtk_arrays.vti", volume)
case("vtk_named", "vtk_arrays.vti", other, channel="other")
case("vtk_component", "vtk_arrays.vti", vectors[..., 2], channel="flow:2")

colours = np.stack([voxels("uint8", seed=n) for n in (1, 40, 90)], axis=-1)
weights = np.array([2126, 7152, 722])
luminance = ((colours.astype(int) @ weights + 5000) // 10000).astype("uint8")
image = lattice(volume)
image.GetPointData().SetScalars(array("colours", colours, 3))
write_vti(image, "vtk_colours.vti", "binary", "zlib")
case("vtk_luminance", "vtk_colours.vti", luminance, channels=3)
case("vtk_green", "vtk_colours.vti", colours[..., 1], channel="g")

for kind in ("ascii", "binary"):
    volume = voxels("int16")
    image = lattice(volume)
    image.GetPointData().SetScalars(array("ct", volume))
    writer = vtkStructuredPointsWriter()
    writer.SetFileName(str(FOLDER / f"vtk_legacy_{kind}.vtk"))
    writer.SetInputData(image)
    writer.SetFileVersion(42)
    (writer.SetFileTypeToASCII if kind == "ascii" else writer.SetFileTypeToBinary)()
    assert writer.Write() == 1
    case(f"vtk_legacy_{kind}", f"vtk_legacy_{kind}.vtk", volume, spacing=SPACING, origin=ORIGIN)


def write_pieces(name, file, ghosts=None, compressor="none"):
    """The .vti `file` in pieces: of one file, or of several that share so many layers of cells."""
    reader = vtkXMLImageDataReader()
    reader.SetFileName(str(FOLDER / file))
    writer = vtkXMLImageDataWriter() if ghosts is None else vtkXMLPImageDataWriter()
    writer.SetFileName(str(FOLDER / name))
    writer.SetInputConnection(reader.GetOutputPort())
    writer.SetNumberOfPieces(4)
    if ghosts is not None:
        writer.SetStartPiece(0)
        writer.SetEndPiece(3)
        writer.SetGhostLevel(ghosts)
    writer.SetDataModeToAppended()
    writer.SetEncodeAppendedData(False)
    (writer.SetCompressorTypeToZLib if compressor == "zlib" else writer.SetCompressorTypeToNone)()
    assert writer.Write() == 1
    pieces = (FOLDER / name).read_bytes().count(b"<Piece Extent=")
    assert pieces == 4, pieces


shape = (11, 9, 10)
volume = voxels("float32", shape)
image = lattice(volume, first=(2, -1, 0))
image.GetPointData().SetScalars(array("a", volume))
write_vti(image, "whole.vti", "appended", "none")
place = {"spacing": SPACING, "origin": [o + s * n for o, s, n in zip(ORIGIN, SPACING, (2, -1, 0))]}
for name, how in (("vtk_pieces.vti", {}), ("vtk_pieces_zlib.vti", {"compressor": "zlib"}), ("vtk_files.pvti", {"ghosts": 0}),
                  ("vtk_files_zlib.pvti", {"ghosts": 0, "compressor": "zlib"}), ("vtk_ghosts.pvti", {"ghosts": 2})):
    write_pieces(name, "whole.vti", **how)
    case(name.replace(".", "_"), name, volume, channels=1, **place)
cells = np.stack([voxels("uint8", shape, seed=n) for n in (1, 2, 3)], axis=-1)
image = lattice(cells[..., 0], cells=True)
image.GetCellData().SetVectors(array("v", cells, 3))
write_vti(image, "whole_cells.vti", "appended", "none")
for ghosts in (0, 1):
    write_pieces(f"vtk_cells_{ghosts}.pvti", "whole_cells.vti", ghosts)
    case(f"vtk_cells_{ghosts}", f"vtk_cells_{ghosts}.pvti", cells[..., 1], channel="1", channels=3,
         origin=[o + s / 2 for o, s in zip(ORIGIN, SPACING)])
