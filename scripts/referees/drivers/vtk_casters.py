"""VTK's ray casters:  vtk_casters.py SCENE PICTURE fixed|gpu SAMPLES_A_VOXEL. It mixes the numbers it is given, here linear ones, in 8 bits a
channel."""
import sys

import numpy
import vtk
from referees.scene import Scene, write_picture
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

scene = Scene(sys.argv[1])
image = vtk.vtkImageData(dimensions=scene.dims, spacing=scene.spacing)
image.GetPointData().SetScalars(numpy_to_vtk(scene.voxels.ravel(), deep=True))
mapper = vtk.vtkFixedPointVolumeRayCastMapper() if sys.argv[3] == "fixed" else vtk.vtkGPUVolumeRayCastMapper()
mapper.SetInputData(image)
mapper.SetAutoAdjustSampleDistances(False)
mapper.SetSampleDistance(scene.unit / float(sys.argv[4]))
mapper.SetImageSampleDistance(1)  # a ray a pixel
look = vtk.vtkVolumeProperty(shade=False, interpolation_type=vtk.VTK_LINEAR_INTERPOLATION, scalar_opacity_unit_distance=scene.unit)
opacity, colours = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction()
for point in scene.opacities:
    opacity.AddPoint(*point)
for point in scene.colours:
    colours.AddRGBPoint(*point)
look.SetScalarOpacity(opacity)
look.SetColor(colours)
renderer, window = vtk.vtkRenderer(background=(0, 0, 0)), vtk.vtkRenderWindow(off_screen_rendering=True, multi_samples=0, alpha_bit_planes=1)
window.SetSize(scene.size, scene.size)
window.AddRenderer(renderer)
renderer.AddVolume(vtk.vtkVolume(mapper=mapper, property=look))
camera = renderer.GetActiveCamera()
camera.SetPosition(scene.eye)
camera.SetFocalPoint(scene.target)
camera.SetViewUp(scene.up)
camera.SetParallelProjection(scene.fov is None)
camera.SetViewAngle(scene.fov or 30)
camera.SetParallelScale((scene.height or 1) / 2)
renderer.ResetCameraClippingRange()
window.Render()
grab = vtk.vtkWindowToImageFilter(input=window, read_front_buffer=False)
grab.SetInputBufferTypeToRGBA()
grab.Update()
pixels = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).reshape(scene.size, scene.size, 4)
write_picture(sys.argv[2], numpy.flipud(pixels) / 255)
print(vtk.vtkVersion.GetVTKVersion())
