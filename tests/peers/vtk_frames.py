"""Renders the scene of scripts/study peers with VTK's fixed-point ray caster, or its GPU ray caster on Mesa's software rasteriser.

    vtk_frames.py FOLDER FUNCTION phong|none vtk|vtk-gpu [PREFIX]

Prints the seconds of each view's frame. Ends with 1 where there is no such rasteriser; then VTK may also crash.
"""
import sys

import numpy
import vtk
from scene import AMBIENT, DIFFUSE, EXPONENT, HALF_VECTOR_EXPONENT, SPECULAR, Scene, draw_frames
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

MAPPERS = {"vtk": (vtk.vtkFixedPointVolumeRayCastMapper, HALF_VECTOR_EXPONENT), "vtk-gpu": (vtk.vtkGPUVolumeRayCastMapper, EXPONENT)}


def make_image(scene):
    image = vtk.vtkImageData()
    image.SetDimensions(scene.dims)
    image.SetSpacing(scene.spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(numpy.fromfile(scene.folder / "head.raw", numpy.uint8), deep=True))
    return image


def make_volume(scene, function, shaded, program):
    unit = min(scene.spacing)
    make_mapper, exponent = MAPPERS[program]
    mapper = make_mapper()
    mapper.SetInputData(make_image(scene))
    mapper.SetAutoAdjustSampleDistances(False)
    mapper.SetImageSampleDistance(1.0)
    mapper.SetSampleDistance(unit)
    opacity, white = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction()
    for value, alpha in scene.functions[function]:
        opacity.AddPoint(value, alpha)
    white.AddRGBPoint(0, 1, 1, 1)
    surface = vtk.vtkVolumeProperty()
    surface.SetScalarOpacity(opacity)
    surface.SetColor(white)
    surface.SetScalarOpacityUnitDistance(unit)
    surface.SetInterpolationTypeToLinear()
    surface.SetShade(shaded)
    surface.SetAmbient(AMBIENT)
    surface.SetDiffuse(DIFFUSE)
    surface.SetSpecular(SPECULAR)
    surface.SetSpecularPower(exponent)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(surface)
    return volume


def make_window(size):
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0, 0, 0)
    renderer.AutomaticLightCreationOff()
    light = vtk.vtkLight()
    light.SetLightTypeToSceneLight()
    light.SetAmbientColor(1, 1, 1)  # black unless told otherwise: no ambient light
    light.PositionalOff()
    renderer.AddLight(light)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    return window, renderer, light


def require_software(window, volume):
    """The comparison is on processors, so a graphics card's times do not belong in it. To be asked after a frame."""
    if not volume.GetMapper().IsRenderSupported(window, volume.GetProperty()):
        sys.exit("VTK's GPU ray caster cannot render here")
    if "llvmpipe" not in window.ReportCapabilities():
        sys.exit("VTK does not render by Mesa's llvmpipe here")


def main():
    scene, function, shading, program = Scene(sys.argv[1]), *sys.argv[2:5]
    window, renderer, light = make_window(scene.size)
    volume = make_volume(scene, function, shading == "phong", program)
    renderer.AddVolume(volume)

    def turn(camera):
        radius, centre, eye, up, light_position = camera
        of = renderer.GetActiveCamera()
        of.ParallelProjectionOn()
        of.SetParallelScale(radius)
        of.SetFocalPoint(centre)
        of.SetPosition(eye)
        of.SetViewUp(up)
        renderer.ResetCameraClippingRange()
        light.SetFocalPoint(centre)
        light.SetPosition(light_position)

    def render():
        window.Render()
        if program == "vtk-gpu":
            window.WaitForCompletion()  # the rasteriser's threads go on after the call

    def picture():
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(window)
        grab.SetInputBufferTypeToRGB()
        grab.ReadFrontBufferOff()
        grab.Update()
        width, height, _ = grab.GetOutput().GetDimensions()
        return width, height, vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars())

    turn(scene.camera(*scene.views[0]))
    window.Render()  # gradients and tables are made once
    if program == "vtk-gpu":
        require_software(window, volume)
    draw_frames(scene, turn, render, picture, sys.argv[5] if len(sys.argv) > 5 else None)


main()
