"""openPMD meshes by openpmd-api, in HDF5."""
import numpy as np
import openpmd_api as io

from cases import FOLDER, case, voxels

SHAPE = (6, 5, 7)


def mesh(iteration, name, labels, spacing, offset, components, unit=1.0):
    made = iteration.meshes[name]
    made.geometry = io.Geometry.cartesian
    made.axis_labels = labels
    made.grid_spacing = spacing
    made.grid_global_offset = offset
    made.grid_unit_SI = unit
    kept = []
    for component, (data, position) in components.items():
        record = made[component]
        record.reset_dataset(io.Dataset(data.dtype, data.shape))
        record.position = position
        record.store_chunk(data)
        kept.append(data)
    return kept


rho = [voxels("float32", SHAPE, seed) for seed in range(3)]
ex, ey = voxels("float64", SHAPE, 7), voxels("float64", SHAPE, 8)
series = io.Series(str(FOLDER / "groups.h5"), io.Access.create)
for number, data in zip((100, 200, 1000), rho):
    step = series.iterations[number]
    mesh(step, "rho", ["z", "y", "x"], [3.0, 2.0, 1.0], [30.0, 20.0, 10.0],
         {io.Mesh_Record_Component.SCALAR: (data, [0.0, 0.0, 0.0])}, unit=0.5)
    # x is the slowest: the lattice's first axis is the world's z.
    mesh(step, "E", ["x", "y", "z"], [3.0, 2.0, 1.0], [30.0, 20.0, 10.0],
         {"x": (ex, [0.5, 0.0, 0.0]), "y": (ey, [0.0, 0.5, 0.0])})
    series.flush()
series.close()
straight = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
for frame in range(3):
    case(f"openpmd_rho_{frame}", "groups.h5", rho[frame], part="meshes/rho", frame=frame, frames=3,
         spacing=[0.5, 1, 1.5], origin=[5, 10, 15], direction=straight, unit="m", world="lattice")
case("openpmd_ex", "groups.h5", ex, part="meshes/E/x", spacing=[1, 2, 3], origin=[31.5, 20, 10],
     direction=[[0, 0, 1], [0, 1, 0], [1, 0, 0]], frames=3)
case("openpmd_ey", "groups.h5", ey, part="meshes/E/y", spacing=[1, 2, 3], origin=[30, 21, 10])
case("openpmd_absolute", "groups.h5", rho[2], part="/data/1000/meshes/rho", origin=[5, 10, 15], frames=1)
