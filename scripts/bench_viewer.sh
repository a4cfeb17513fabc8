#!/usr/bin/env bash
# What the viewer's page gets:  scripts/bench_viewer.sh [OPTION...]   (--help lists them; nothing else should run)
#
# Two ranks on this machine and one process serve the repository's head at 512x512 and 1024x1024, and the head refined
# to 512x512x512 voxels at 512x512. The test's client (tests/serve/viewer_client.py) drags, lets go and rests as the page
# does, but decodes no picture. Prints a Markdown table; takes about ten minutes.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

python3 "$repo/scripts/refine_volume.py" "$head" "$work/fine.nrrd"
allow_ranks 2
python3 "$repo/scripts/bench_viewer_client.py" --program "$build/ringsplat" --mpiexec "${RINGSPLAT_MPIEXEC:-mpirun}" \
  --head "$head" --fine "$work/fine.nrrd" "$@"
