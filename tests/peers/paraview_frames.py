"""Renders the scene of scripts/study peers with ParaView:

    mpirun -n N pvbatch --sym paraview_frames.py FOLDER FUNCTION phong|none smart|ghosts|cast [PREFIX]

`smart` is ParaView's default, the GPU ray caster, which Mesa's llvmpipe runs where there is no graphics card; `ghosts` the same with two layers
of the neighbours' cells round each process's part, as interpolation and gradients need; `cast` the fixed-point ray caster. Each process
renders its part of the volume, IceT composites. Process 0 prints the seconds of each view's frame; with PREFIX every one writes its largest
memory, in bytes, into PREFIX.memory.PID. Every process runs this script, as only so a light with an ambient part can be set.
"""
import os
import resource
import sys
from pathlib import Path

from paraview.simple import (AddLight, ColorBy, CreateView, GetColorTransferFunction, GetOpacityTransferFunction, GhostCellsGenerator, ImageReader,
                             Render, Show, UpdatePipeline)
from paraview.simple import servermanager
from vtkmodules.util.numpy_support import vtk_to_numpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from scene import AMBIENT, DIFFUSE, EXPONENT, HALF_VECTOR_EXPONENT, SPECULAR, Scene, draw_frames  # noqa: E402

MODES = {"smart": ("Smart", EXPONENT), "ghosts": ("Smart", EXPONENT), "cast": ("Ray Cast Only", HALF_VECTOR_EXPONENT)}


def read_head(scene):
    reader = ImageReader(FileNames=[str(scene.folder / "head.raw")])
    reader.DataScalarType = "unsigned char"
    reader.DataByteOrder = "LittleEndian"
    reader.FileDimensionality = 3
    reader.FileLowerLeft = 1
    reader.DataExtent = [end for size in scene.dims for end in (0, size - 1)]
    reader.DataSpacing = scene.spacing
    reader.ScalarArrayName = "value"
    UpdatePipeline(proxy=reader)
    return reader


def show(scene, view, function, shaded, program):
    mode, exponent = MODES[program]
    head = read_head(scene)
    shown = Show(GhostCellsGenerator(Input=head, BuildIfRequired=0, MinimumNumberOfGhosts=2) if program == "ghosts" else head, view)
    shown.SetRepresentationType("Volume")
    ColorBy(shown, ("POINTS", "value"))
    colours, opacities = GetColorTransferFunction("value"), GetOpacityTransferFunction("value")
    colours.RGBPoints = [0, 1, 1, 1, 255, 1, 1, 1]
    opacities.Points = [number for value, alpha in scene.functions[function] for number in (value, alpha, 0.5, 0)]
    shown.ScalarOpacityUnitDistance = min(scene.spacing)
    shown.VolumeRenderingMode = mode
    shown.Shade = int(shaded)
    shown.Ambient, shown.Diffuse, shown.Specular, shown.SpecularPower = AMBIENT, DIFFUSE, SPECULAR, exponent


def make_view(size):
    view = CreateView("RenderView")
    view.ViewSize = [size] * 2
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


def main():
    scene, function, shading, program = Scene(sys.argv[1]), *sys.argv[2:5]
    prefix = sys.argv[5] if len(sys.argv) > 5 else None
    view, light = make_view(scene.size)
    show(scene, view, function, shading == "phong", program)

    def turn(camera):
        radius, centre, eye, up, light_position = camera
        view.CameraParallelScale = radius
        view.CameraFocalPoint = centre
        view.CameraPosition = eye
        view.CameraViewUp = up
        light.FocalPoint = centre
        light.Position = light_position
        # No property of a light's proxy sets its ambient part.
        light.UpdateVTKObjects()
        light.GetClientSideObject().SetAmbientColor(1, 1, 1)

    def picture():
        shown = view.CaptureWindow(1)  # renders, so by all
        width, height, _ = shown.GetDimensions()
        return width, height, vtk_to_numpy(shown.GetPointData().GetScalars())

    turn(scene.camera(*scene.views[0]))
    Render(view)  # tables are made once
    first = servermanager.vtkProcessModule.GetProcessModule().GetPartitionId() == 0
    draw_frames(scene, turn, lambda: Render(view), picture, prefix, first)
    if prefix:
        Path(f"{prefix}.memory.{os.getpid()}").write_text(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024}\n")


main()
