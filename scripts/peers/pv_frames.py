"""Renders the scene of scene.py with ParaView:  mpirun -n N pvbatch --sym pv_frames.py FOLDER FUNCTION phong|none smart|cast [PREFIX]

`smart` is ParaView's default, the GPU ray caster, which Mesa's llvmpipe runs where there is no graphics card; `cast` the
fixed-point ray caster. Each process renders its part of the volume, IceT composites. Process 0 prints the seconds of each
view's frame. PREFIX: it also writes PREFIX-NNNN.pfm, linear over black. Every process runs this script, as only so a light
with an ambient part can be set.
"""
import json
import math
import sys
import time
from pathlib import Path

import numpy
from paraview.simple import (AddLight, ColorBy, CreateView, GetColorTransferFunction, GetOpacityTransferFunction, ImageReader, Render, Show,
                             UpdatePipeline)
from paraview.simple import servermanager
from vtkmodules.util.numpy_support import vtk_to_numpy

LIGHT = (-0.4, 0.6, 0.7)  # right, up, to the viewer: ringsplat's
# Exponents: see vtk_frames.py.
MODES = {"smart": ("Smart", 24.0), "cast": ("Ray Cast Only", 4 * 24.0)}


def read_head(folder, scene):
    reader = ImageReader(FileNames=[str(folder / "head.raw")])
    reader.DataScalarType = "unsigned char"
    reader.DataByteOrder = "LittleEndian"
    reader.FileDimensionality = 3
    reader.FileLowerLeft = 1
    reader.DataExtent = [end for size in scene["dims"] for end in (0, size - 1)]
    reader.DataSpacing = scene["spacing"]
    reader.ScalarArrayName = "value"
    UpdatePipeline(proxy=reader)
    return reader


def show(reader, view, scene, function, shaded, program):
    mode, exponent = MODES[program]
    shown = Show(reader, view)
    shown.SetRepresentationType("Volume")
    ColorBy(shown, ("POINTS", "value"))
    colours, opacities = GetColorTransferFunction("value"), GetOpacityTransferFunction("value")
    colours.RGBPoints = [0, 1, 1, 1, 255, 1, 1, 1]
    opacities.Points = [number for value, alpha in scene["functions"][function] for number in (value, alpha, 0.5, 0)]
    shown.ScalarOpacityUnitDistance = min(scene["spacing"])
    shown.VolumeRenderingMode = mode
    shown.Shade = int(shaded)
    shown.Ambient, shown.Diffuse, shown.Specular, shown.SpecularPower = 0.25, 0.75, 0.25, exponent
    return shown


def make_view(scene):
    view = CreateView("RenderView")
    view.ViewSize = [scene["size"]] * 2
    view.UseColorPaletteForBackground = 0
    view.Background = [0, 0, 0]
    view.BackgroundColorMode = "Single Color"
    view.OrientationAxesVisibility = 0
    view.UseLight = 0
    view.UseFXAA = 0
    view.MultiSamples = 0
    view.CameraParallelProjection = 1
    view.RemoteRenderThreshold = 0  # never gather the volume on one process
    light = AddLight(view)
    light.Coords = "Scene"
    light.Type = "Directional"
    return view, light


def turn(view, light, scene, azimuth, elevation):
    """ringsplat's camera, as in vtk_frames.py."""
    ca, sa = math.cos(math.radians(azimuth)), math.sin(math.radians(azimuth))
    ce, se = math.cos(math.radians(elevation)), math.sin(math.radians(elevation))
    right, up, to_viewer = numpy.array([(ca, sa, 0), (-se * sa, se * ca, ce), (ce * sa, -ce * ca, se)])
    extent = numpy.array(scene["dims"]) * scene["spacing"]
    centre = 0.5 * (extent - scene["spacing"])
    radius = 0.5 * numpy.linalg.norm(extent)
    view.CameraParallelScale = float(radius)
    view.CameraFocalPoint = centre.tolist()
    view.CameraPosition = (centre + 3 * radius * to_viewer).tolist()
    view.CameraViewUp = up.tolist()
    light.FocalPoint = centre.tolist()
    light.Position = (centre + numpy.array(LIGHT) @ [right, up, to_viewer]).tolist()
    # No property of a light's proxy sets its ambient part.
    light.UpdateVTKObjects()
    light.GetClientSideObject().SetAmbientColor(1, 1, 1)


def write_pfm(picture, path):
    width, height, _ = picture.GetDimensions()
    pixels = vtk_to_numpy(picture.GetPointData().GetScalars())[:, :3].astype("<f4") / 255
    path.write_bytes(f"PF\n{width} {height}\n-1.0\n".encode() + pixels.tobytes())  # both have the bottom row first


def main():
    folder, function, shading, program = Path(sys.argv[1]), *sys.argv[2:5]
    scene = json.loads((folder / "scene.json").read_text())
    first = servermanager.vtkProcessModule.GetProcessModule().GetPartitionId() == 0
    view, light = make_view(scene)
    shown = show(read_head(folder, scene), view, scene, function, shading == "phong", program)
    views = [tuple(map(float, line.split())) for line in (folder / "views.txt").read_text().splitlines()]
    turn(view, light, scene, *views[0])
    Render(view)  # tables are made once
    for k, angles in enumerate(views):
        turn(view, light, scene, *angles)
        start = time.perf_counter()
        Render(view)
        seconds = time.perf_counter() - start
        if first:
            print(seconds, flush=True)
        if len(sys.argv) > 5:
            picture = view.CaptureWindow(1)  # renders, so by all
            if first:
                write_pfm(picture, Path(f"{sys.argv[5]}-{k:04}.pfm"))


if __name__ == "__main__":
    main()
