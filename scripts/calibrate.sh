#!/usr/bin/env bash
# Measures what nodes spend on this machine and writes it as a machine to simulate:
#
#   scripts/calibrate.sh MACHINE.toml [REPETITIONS]   (default 5; nothing else should run)
#
# One GP and one Renderer on a core each render the repository's head, a volume without a visible voxel, one of eight voxels,
# and pass tokens through 4096 empty slices, on one rank and between two; every cost is the median over all frames.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

output=${1:?where to write the machine: scripts/calibrate.sh mpi_configs/machines/NAME.toml}
repetitions=${2:-5}
line 4096
"$build/ringsplat" synth constant -o "$work/tiny.nrrd" --dims 2x2x2 >/dev/null
one=("${dedicated[@]}" --frames-in-flight 1)
for ((k = 0; k < repetitions; ++k)); do
  render 2 head "$head" "${one[@]}" --tf mr-soft --size 512 --orbit 4 --elevation 25
  render 2 empty "$head" "${one[@]}" --tf "$work/nothing.json" --size 512 --orbit 4 --elevation 25
  render 2 tiny "$work/tiny.nrrd" "${one[@]}" --tf grey --size 512 --orbit 4
  render 2 line "${line[@]}" "${one[@]}" --orbit 4
  render 2 hop "${line[@]}" --gps 2 --renderers 1 --roles colocated --frames-in-flight 1 --orbit 4
done
python3 "$repo/scripts/calibrated_machine.py" "$work" "$(cores)" >"$work/machine.toml"
mv "$work/machine.toml" "$output"
say "$output describes this machine"
