"""yt's ray caster:  yt_caster.py SCENE PICTURE. Doubles; what it is given is emission and extinction, here of linear colours."""
import sys

import numpy
import yt
from referees.scene import Scene, write_picture
from yt.visualization.volume_rendering.api import Scene as YtScene
from yt.visualization.volume_rendering.api import create_volume_source
from yt.visualization.volume_rendering.transfer_functions import ColorTransferFunction

yt.set_log_level("error")
scene = Scene(sys.argv[1])
side, n = scene.size, numpy.array(scene.dims)
bounds = numpy.stack([-scene.spacing / 2, (n - 0.5) * scene.spacing], axis=1)
data = yt.load_uniform_grid({"value": (scene.voxels.transpose(2, 1, 0).astype(float), "")}, scene.dims, 1.0, bbox=bounds, periodicity=(False,) * 3)
source, stage = create_volume_source(data.all_data(), ("stream", "value")), YtScene()
source.set_log(False)
source.num_samples = 10  # in each voxel that a ray crosses
camera = stage.add_camera(data, lens_type="perspective" if scene.fov else "plane-parallel")
camera.resolution = (side, side)
# Depth is added up along the view's normal, the last sample in front: parallel rays have to come from behind, in a mirrored picture.
position = scene.eye if scene.fov else 2 * scene.target - scene.eye
camera.set_position(data.arr(position, "code_length"), north_vector=scene.up)
camera.set_focus(data.arr(scene.target, "code_length"))
if scene.fov:  # rays go through the picture's edges, so that it is one pixel smaller
    width, depth = 2 * numpy.tan(numpy.radians(scene.fov / 2)) * (side - 1) / side, 1
    length = numpy.linalg.norm(scene.eye - bounds.mean(1)) + numpy.linalg.norm(numpy.ptp(bounds, axis=1)) / 2
else:
    width, depth = scene.height, 4 * numpy.linalg.norm(n * scene.spacing)
    length = depth
camera.set_width(data.arr([width, width, depth], "code_length"))
# Extinction is of the length that yt counts depth in. A sample takes depth itself for opacity, so more than 1 would shine.
values, colours, opacities = scene.table(1 << 16)
extinction = -numpy.log1p(-numpy.minimum(opacities, 0.99)) / scene.unit * length
function = ColorTransferFunction((values[0], values[-1]), nbins=len(values), grey_opacity=True)
for table, numbers in zip(function.funcs, (*colours.T, extinction)):
    table.y = numpy.ascontiguousarray(numbers)
source.transfer_function = function
stage.add_source(source)
pixels = numpy.array(stage.render()).swapaxes(0, 1)
write_picture(sys.argv[2], pixels if scene.fov else pixels[:, ::-1])
print(yt.__version__)
