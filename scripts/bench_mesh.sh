#!/usr/bin/env bash
# Measures the mesh on this machine:  scripts/bench_mesh.sh [REPETITIONS]   (default 3; nothing else should run)
#
# Ring against mesh and manhattan against direct routing on 8 to 24 ranks, what a hop costs, and how often messages meet on a link
# when tokens move in step and when they drift. Prints Markdown tables.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

repetitions=${1:-3}
view=(--elevation 25 --tf mr-soft --size 256x256 --region 32)

line 2048
empty=("${line[@]}" --renderers 1 --orbit 4 --frames-in-flight 1)

for ((k = 0; k < repetitions; ++k)); do
  for shape in 2x2+4 3x3+3 4x4+4 4x4+8; do
    mesh=${shape%+*}
    renderers=${shape#*+}
    gps=$((${mesh%x*} * ${mesh#*x}))
    ranks=$((gps + renderers))
    orbit=("$head" --orbit 8 "${view[@]}" --axes all --renderers "$renderers")
    render "$ranks" "frame-$shape-ring" "${orbit[@]}" --gps "$gps"
    for routing in manhattan direct; do
      render "$ranks" "frame-$shape-$routing" "${orbit[@]}" --topology mesh --mesh "$mesh" --routing "$routing"
    done
  done
  for mesh in 2x2 3x3 4x4; do
    gps=$((${mesh%x*} * ${mesh#*x}))
    for routing in manhattan direct; do
      render $((gps + 1)) "hop-$mesh-$routing" "${empty[@]}" --topology mesh --mesh "$mesh" --routing "$routing"
    done
  done
done

# Counts, not times: once is enough.
for shape in 2x2+4 3x3+6 4x4+4 4x4+8; do
  for slots in 1 4; do
    options=("$head" "${view[@]}" --fit sphere --topology mesh --mesh "${shape%+*}" --renderers "${shape#*+}" --link-slots "$slots")
    render 0 "queue-$shape-$slots-step" "${options[@]}" --transport loopback --in-step
    render 0 "queue-$shape-$slots-loopback" "${options[@]}" --transport loopback --shuffle --max-delay 3
    render $((${shape%x*} * ${shape%x*} + ${shape#*+})) "queue-$shape-$slots-mpi" "${options[@]}"
  done
done
python3 "$repo/scripts/bench_mesh_report.py" "$work"
