"""ParaView on any number of ranks:  mpirun -n 2 pvbatch --sym paraview_view.py SCENE PICTURE. It mixes the numbers it is given, here linear ones,
in 8 bits a channel, and keeps no opacity. Its default is the GPU ray caster, here on a rasteriser in software."""
import os
import sys

import numpy
import paraview
from paraview.simple import (ColorBy, CreateView, GetColorTransferFunction, GetOpacityTransferFunction, ImageReader, Render, Show,
                             UpdatePipeline, servermanager)
from vtkmodules.util.numpy_support import vtk_to_numpy

sys.path.insert(0, os.environ["PYTHONPATH"])
from referees.scene import Scene, write_picture  # noqa: E402

TYPES = {"uint8": "unsigned char", "int16": "short", "float32": "float"}
scene = Scene(sys.argv[1])
reader = ImageReader(FileNames=[str(scene.folder / "volume.nrrd")], DataScalarType=TYPES[scene.voxels.dtype.name], DataByteOrder="LittleEndian",
                     FileDimensionality=3, FileLowerLeft=1,
                     DataExtent=[end for n in scene.dims for end in (0, n - 1)], DataSpacing=list(scene.spacing),
                     ScalarArrayName="value")
UpdatePipeline(proxy=reader)
view = CreateView("RenderView", ViewSize=[scene.size] * 2, UseColorPaletteForBackground=0, BackgroundColorMode="Single Color", Background=[0, 0, 0],
                  OrientationAxesVisibility=0, UseFXAA=0, MultiSamples=0, RemoteRenderThreshold=0)
shown = Show(reader, view)
shown.SetRepresentationType("Volume")
ColorBy(shown, ("POINTS", "value"))
GetColorTransferFunction("value").RGBPoints = [float(x) for point in scene.colours for x in point]
GetColorTransferFunction("value").ColorSpace = "RGB"
GetOpacityTransferFunction("value").Points = [x for point in scene.opacities for x in (*point, 0.5, 0)]
shown.ScalarOpacityUnitDistance = scene.unit
shown.VolumeRenderingMode = "Smart"
shown.Shade = 0
Render(view)  # moves the camera
view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = (list(v) for v in (scene.eye, scene.target, scene.up))
view.CameraParallelProjection, view.CameraParallelScale, view.CameraViewAngle = int(scene.fov is None), (scene.height or 1) / 2, scene.fov or 30
Render(view)
image = view.CaptureWindow(1)  # by all ranks
if servermanager.vtkProcessModule.GetProcessModule().GetPartitionId() == 0:
    pixels = numpy.full((scene.size, scene.size, 4), numpy.nan)
    pixels[..., :3] = numpy.flipud(vtk_to_numpy(image.GetPointData().GetScalars()).reshape(scene.size, scene.size, -1)[..., :3]) / 255
    write_picture(sys.argv[2], pixels)
    print(paraview.__version__)
