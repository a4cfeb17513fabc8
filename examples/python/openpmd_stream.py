#!/usr/bin/env python3
"""Shows a mesh of an openPMD stream in browsers, as a running simulation writes it by ADIOS2's SST engine:

    mpirun -n 2 python3 openpmd_stream.py STREAM.sst MESH[/COMPONENT] [--OPTION=VALUE ...]

It prints the page's address. Every rank reads the stream by itself, some of the blocks of each step, so the writer waits
for as many readers: RendezvousReaderCount=RANKS. With QueueFullPolicy=Block it waits while a page holds the run. Options
are those of ringsplat.Session.serve: --tf=mr-soft --port=8642 --share=0.5.
"""

import sys

import openpmd_api as io
import ringsplat as rs
from openpmd_series import communicator, take_blocks

STREAM = '{"adios2": {"engine": {"type": "sst", "parameters": {"OpenTimeoutSecs": "60"}}}}'


def main():
    if len(sys.argv) < 3 or not all(word.startswith("--") and "=" in word for word in sys.argv[3:]):
        sys.exit(__doc__)
    file, name = sys.argv[1:3]
    options = {key.replace("-", "_"): value for key, value in (word[2:].split("=", 1) for word in sys.argv[3:])}
    own = {key: kind(options.pop(key)) for key, kind in (("port", int), ("share", float)) if key in options}
    mesh_name, _, component_name = name.partition("/")
    session = rs.Session(comm=communicator())
    served = False
    for iteration in io.Series(file, io.Access.read_linear, STREAM).read_iterations():
        if mesh_name not in iteration.meshes:
            sys.exit(f"step {iteration.iteration_index} has no mesh {mesh_name}; it has: {', '.join(iteration.meshes)}")
        mesh = iteration.meshes[mesh_name]
        take_blocks(session, iteration, mesh, mesh[component_name or io.Mesh_Record_Component.SCALAR])
        if not served:
            session.commit()
            url = session.serve(name=name, **own, **options)
            served = True
            if session.rank == 0:
                print(url, flush=True)
        session.show(iteration.iteration_index, iteration.time * iteration.time_unit_SI)
        iteration.close()
    session.close()


if __name__ == "__main__":
    main()
