#!/usr/bin/env bash
# Measures what nodes spend on this machine and writes it as a machine to simulate:
#
#   scripts/calibrate.sh MACHINE.toml [REPETITIONS [FOLDER]]   (default 5; nothing else should run; FOLDER keeps the statistics)
#
# GPs' costs are of one GP and one Renderer on a core each: the repository's head, a volume without a visible voxel, one of eight voxels, and
# tokens through 4096 empty slices, on one rank and between two. Renderers' costs, and all of sheets, are fitted to runs that differ in what
# is seen, in the picture's size and in the number of Renderers (scripts/calibrated_machine.py). It takes the medians of all repetitions and
# says how far the fitted costs are off.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

output=${1:?where to write the machine: scripts/calibrate.sh mpi_configs/machines/NAME.toml}
repetitions=${2:-5}
kept=${3:-}
line 4096
"$build/ringsplat" synth constant -o "$work/tiny.nrrd" --dims 2x2x2 >/dev/null
"$build/ringsplat" synth ball -o "$work/wide.nrrd" --dims 512x512x64 >/dev/null
one=("${dedicated[@]}" --frames-in-flight 1)
# renderers N: a GP and so many Renderers, which look through the same slices, in one process.
renderers() { echo --gps 1 --renderers "$1" --frames-in-flight 1; }
orbit=(--orbit 5 --elevation 25 --axes all)
soft=(--tf mr-soft "${orbit[@]}")
for ((k = 0; k < repetitions; ++k)); do
  render 2 empty "$head" "${one[@]}" --tf "$work/nothing.json" --size 512 "${orbit[@]}"
  render 2 tiny "$work/tiny.nrrd" "${one[@]}" --tf grey --size 512 --orbit 5
  render 2 line "${line[@]}" "${one[@]}" --orbit 5
  render 2 hop "${line[@]}" --gps 2 --renderers 1 --roles colocated --frames-in-flight 1 --orbit 5

  render 2 splats-head "$head" "${one[@]}" "${soft[@]}" --size 512
  render 2 splats-head-two "$head" "${colocated[@]}" --frames-in-flight 1 "${soft[@]}" --size 512
  render 0 splats-head-many "$head" $(renderers 8) "${soft[@]}" --size 512

  quality=best
  render 2 sheets-head "$head" "${one[@]}" "${soft[@]}" --size 512
  render 2 sheets-head-two "$head" "${colocated[@]}" --frames-in-flight 1 "${soft[@]}" --size 512
  render 2 sheets-head-small "$head" "${one[@]}" "${soft[@]}" --size 256
  render 2 sheets-head-tiny "$head" "${one[@]}" "${soft[@]}" --clip 60:64,60:64,60:64 --size 512
  render 0 sheets-head-several "$head" $(renderers 6) "${soft[@]}" --size 512
  render 0 sheets-head-many "$head" $(renderers 32) "${soft[@]}" --size 256
  render 0 sheets-wide-few "$work/wide.nrrd" $(renderers 4) --tf grey "${orbit[@]}" --size 256
  render 0 sheets-wide-many "$work/wide.nrrd" $(renderers 32) --tf grey "${orbit[@]}" --size 256
  quality=paper
done
python3 -B "$repo/scripts/calibrated_machine.py" "$work" "$(cores)" >"$work/machine.toml"
mv "$work/machine.toml" "$output"
[[ -z $kept ]] || { mkdir -p "$kept" && cp "$work"/*.jsonl "$kept"; }
say "$output describes this machine"
