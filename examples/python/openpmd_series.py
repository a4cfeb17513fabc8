#!/usr/bin/env python3
"""Draws a mesh of an openPMD series, every iteration a picture; each rank reads some of the blocks in the file:

    mpirun -n 4 python3 openpmd_series.py SERIES MESH[/COMPONENT] OUT [--OPTION=VALUE ...]
    mpirun -n 4 python3 openpmd_series.py 'run/data_%T.bp' E/x 'ex-%T.png' --tf=cool-warm --azimuth=30

%T in OUT becomes the iteration's number; options are those of ringsplat.render. It needs openpmd-api, and mpi4py where
there are several ranks. openpmd-api need not be built with MPI, as every rank opens the series by itself to read.
"""

import os
import sys

import numpy as np
import openpmd_api as io
import ringsplat as rs


def communicator():
    """Of the launcher's processes, None for one alone."""
    if not any(name in os.environ for name in ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK")):
        return None
    from mpi4py import MPI

    return MPI.COMM_WORLD


def axes_of(mesh, dimensions):
    """Where z, y and x are among the file's axes; axes of other names are taken as they come."""
    labels = list(mesh.axis_labels)
    if dimensions != 3:
        raise rs.InputError(f"the mesh has {dimensions} axes; hint: only meshes of three can be drawn")
    return [labels.index(name) for name in "zyx"] if sorted(labels) == ["x", "y", "z"] else [0, 1, 2]


def blocks_of(component, rank, ranks):
    """(offset, extent) of this rank's blocks: the file's chunks, cut where there are fewer than ranks."""
    chunks = component.available_chunks()
    pieces = -(-ranks // max(1, len(chunks)))
    cut = []
    for chunk in chunks:
        first, end = chunk.offset[0], chunk.offset[0] + chunk.extent[0]
        bounds = np.linspace(first, end, pieces + 1).astype(int).tolist()
        for start, stop in zip(bounds, bounds[1:]):
            if start < stop:
                cut.append(([start, *chunk.offset[1:]], [stop - start, *chunk.extent[1:]]))
    return cut[rank::ranks]


def take_blocks(session, opened, mesh, component):
    """Gives the session one iteration's mesh; `opened`: its series, or the iteration of a stream."""
    axes = axes_of(mesh, len(component.shape))
    spacing = np.array(mesh.grid_spacing)[axes] * mesh.grid_unit_SI
    origin = (np.array(mesh.grid_global_offset) + np.array(component.position) * mesh.grid_spacing)[axes]
    session.set_grid(
        [component.shape[axis] for axis in axes],
        component.dtype,
        spacing=spacing[::-1],
        origin=origin[::-1] * mesh.grid_unit_SI,
        unit="m",
    )
    read = [(offset, component.load_chunk(offset, extent)) for offset, extent in blocks_of(component, session.rank, session.ranks)]
    opened.series_flush() if isinstance(opened, io.Iteration) else opened.flush()
    for offset, block in read:
        session.add_block([offset[axis] for axis in axes], block.transpose(axes))


def main():
    if len(sys.argv) < 4 or not all(word.startswith("--") and "=" in word for word in sys.argv[4:]):
        sys.exit(__doc__)
    file, name, out = sys.argv[1:4]
    options = {key.replace("-", "_"): value for key, value in (word[2:].split("=", 1) for word in sys.argv[4:])}
    mesh_name, _, component_name = name.partition("/")
    session = rs.Session(comm=communicator())
    series = io.Series(file, io.Access.read_only)
    for number, iteration in series.iterations.items():
        if mesh_name not in iteration.meshes:
            sys.exit(f"iteration {number} of {file} has no mesh {mesh_name}; it has: {', '.join(iteration.meshes)}")
        mesh = iteration.meshes[mesh_name]
        take_blocks(session, series, mesh, mesh[component_name or io.Mesh_Record_Component.SCALAR])
        session.commit()
        image = session.render(**options)
        iteration.close()
        if image is not None:
            image.save(out.replace("%T", str(number)))
    session.close()


if __name__ == "__main__":
    main()
