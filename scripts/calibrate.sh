#!/usr/bin/env bash
# Measures what nodes spend on this machine and writes it as a machine to simulate:
#
#   scripts/calibrate.sh MACHINE.toml [REPETITIONS]   (default 5; nothing else should run)
#
# One GP and one Renderer on a core each render the repository's head, a volume without a visible voxel, one of eight voxels,
# and pass tokens through 4096 empty slices, on one rank and between two; every cost is the median over all frames. What sheets cost is
# measured in one process.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

output=${1:?where to write the machine: scripts/calibrate.sh mpi_configs/machines/NAME.toml}
repetitions=${2:-5}
line 4096
"$build/ringsplat" synth constant -o "$work/tiny.nrrd" --dims 2x2x2 >/dev/null
"$build/ringsplat" synth ball -o "$work/wide.nrrd" --dims 512x512x64 >/dev/null
one=("${dedicated[@]}" --frames-in-flight 1)
for ((k = 0; k < repetitions; ++k)); do
  render 2 head "$head" "${one[@]}" --tf mr-soft --size 512 --orbit 4 --elevation 25
  render 2 empty "$head" "${one[@]}" --tf "$work/nothing.json" --size 512 --orbit 4 --elevation 25
  render 2 tiny "$work/tiny.nrrd" "${one[@]}" --tf grey --size 512 --orbit 4
  render 2 line "${line[@]}" "${one[@]}" --orbit 4
  render 2 hop "${line[@]}" --gps 2 --renderers 1 --roles colocated --frames-in-flight 1 --orbit 4

  # Sheets, in one process: pixels, Renderers that look through the same slices, and larger slices tell what each costs.
  quality=best
  render 0 sheets "$head" "${one[@]}" --tf mr-soft --size 512 --orbit 4 --elevation 25
  render 0 sheets_small "$head" "${one[@]}" --tf mr-soft --size 256 --orbit 4 --elevation 25
  render 0 sheets_many "$head" --gps 1 --renderers 32 --frames-in-flight 1 --tf mr-soft --size 256 --orbit 4 --elevation 25
  render 0 sheets_few "$work/wide.nrrd" --gps 1 --renderers 4 --frames-in-flight 1 --tf grey --size 256 --orbit 4 --elevation 25
  render 0 sheets_wide "$work/wide.nrrd" --gps 1 --renderers 32 --frames-in-flight 1 --tf grey --size 256 --orbit 4 --elevation 25
  render 0 sheets_tiny "$head" "${one[@]}" --tf mr-soft --clip 60:64,60:64,60:64 --size 256 --orbit 4 --elevation 25
  quality=paper
done
python3 "$repo/scripts/calibrated_machine.py" "$work" "$(cores)" >"$work/machine.toml"
mv "$work/machine.toml" "$output"
say "$output describes this machine"
