"""Renders the scene of scene.py with VTK's fixed-point ray caster, or its GPU ray caster on Mesa's software rasteriser.

    vtk_frames.py FOLDER FUNCTION phong|none vtk|vtk-gpu [PICTURES]

Prints the seconds of each view's frame. PICTURES: also writes PROGRAM-FUNCTION-SHADING-NNNN.pfm, linear over black.
Ends with 1 where there is no such rasteriser; then VTK may also crash.
"""
import json
import math
import sys
import time
from pathlib import Path

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

LIGHT = (-0.4, 0.6, 0.7)  # right, up, to the viewer: ringsplat's
MATERIAL = {"SetAmbient": 0.25, "SetDiffuse": 0.75, "SetSpecular": 0.25}
# By the mirrored ray, as in ringsplat. The fixed-point caster's highlight is by the half vector, whose angle is half the
# mirrored ray's: about four times the exponent.
EXPONENT = {"vtk": 4 * 24.0, "vtk-gpu": 24.0}


def make_image(folder, scene):
    image = vtk.vtkImageData()
    image.SetDimensions(scene["dims"])
    image.SetSpacing(scene["spacing"])
    values = numpy.fromfile(folder / "head.raw", numpy.uint8)
    image.GetPointData().SetScalars(numpy_to_vtk(values, deep=True))
    return image


MAPPERS = {"vtk": vtk.vtkFixedPointVolumeRayCastMapper, "vtk-gpu": vtk.vtkGPUVolumeRayCastMapper}


def make_volume(image, scene, function, shaded, program):
    unit = min(scene["spacing"])
    mapper = MAPPERS[program]()
    mapper.SetInputData(image)
    mapper.SetAutoAdjustSampleDistances(False)
    mapper.SetImageSampleDistance(1.0)
    mapper.SetSampleDistance(unit)
    opacity, white = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction()
    for value, alpha in scene["functions"][function]:
        opacity.AddPoint(value, alpha)
    white.AddRGBPoint(0, 1, 1, 1)
    surface = vtk.vtkVolumeProperty()
    surface.SetScalarOpacity(opacity)
    surface.SetColor(white)
    surface.SetScalarOpacityUnitDistance(unit)
    surface.SetInterpolationTypeToLinear()
    surface.SetShade(shaded)
    for set_, value in MATERIAL.items():
        getattr(surface, set_)(value)
    surface.SetSpecularPower(EXPONENT[program])
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(surface)
    return volume


def make_window(size):
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0, 0, 0)
    renderer.AutomaticLightCreationOff()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    return window, renderer


def turn(renderer, light, scene, azimuth, elevation):
    """ringsplat's camera (view/camera.cpp): orthographic, the bounding sphere fits the picture."""
    ca, sa = math.cos(math.radians(azimuth)), math.sin(math.radians(azimuth))
    ce, se = math.cos(math.radians(elevation)), math.sin(math.radians(elevation))
    right, up, to_viewer = numpy.array([(ca, sa, 0), (-se * sa, se * ca, ce), (ce * sa, -ce * ca, se)])
    extent = numpy.array(scene["dims"]) * scene["spacing"]
    centre = 0.5 * (extent - scene["spacing"])
    radius = 0.5 * numpy.linalg.norm(extent)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetParallelScale(radius)
    camera.SetFocalPoint(centre)
    camera.SetPosition(centre + 3 * radius * to_viewer)
    camera.SetViewUp(up)
    renderer.ResetCameraClippingRange()
    light.SetFocalPoint(centre)
    light.SetPosition(centre + numpy.array(LIGHT) @ [right, up, to_viewer])


def write_pfm(window, path):
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGB()
    grab.ReadFrontBufferOff()
    grab.Update()
    width, height, _ = grab.GetOutput().GetDimensions()
    pixels = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).astype("<f4") / 255
    path.write_bytes(f"PF\n{width} {height}\n-1.0\n".encode() + pixels.tobytes())  # both have the bottom row first


def require_software(window, volume):
    """The comparison is on processors, so a graphics card's times do not belong in it. To be asked after a frame."""
    if not volume.GetMapper().IsRenderSupported(window, volume.GetProperty()):
        sys.exit("VTK's GPU ray caster cannot render here")
    if "llvmpipe" not in window.ReportCapabilities():
        sys.exit("VTK does not render by Mesa's llvmpipe here")


def main():
    folder, function, shading, program = Path(sys.argv[1]), *sys.argv[2:5]
    scene = json.loads((folder / "scene.json").read_text())
    window, renderer = make_window(scene["size"])
    light = vtk.vtkLight()
    light.SetLightTypeToSceneLight()
    light.SetAmbientColor(1, 1, 1)  # black unless told otherwise: no ambient light
    light.PositionalOff()
    renderer.AddLight(light)
    volume = make_volume(make_image(folder, scene), scene, function, shading == "phong", program)
    renderer.AddVolume(volume)
    views = [tuple(map(float, line.split())) for line in (folder / "views.txt").read_text().splitlines()]
    turn(renderer, light, scene, *views[0])
    window.Render()  # gradients and tables are made once
    if program == "vtk-gpu":
        require_software(window, volume)
    for k, view in enumerate(views):
        turn(renderer, light, scene, *view)
        start = time.perf_counter()
        window.Render()
        if program == "vtk-gpu":
            window.WaitForCompletion()  # the rasteriser's threads go on after the call
        print(time.perf_counter() - start)
        if len(sys.argv) > 5:
            write_pfm(window, folder / f"{program}-{function}-{shading}-{k:04}.pfm")


if __name__ == "__main__":
    main()
