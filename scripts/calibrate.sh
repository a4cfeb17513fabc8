#!/usr/bin/env bash
# Measures what nodes spend on this machine and writes it as a machine to simulate:
#
#   scripts/calibrate.sh MACHINE.toml [REPETITIONS [FOLDER]]   (default 5; nothing else should run; FOLDER keeps the statistics)
#
# GPs' costs are of one GP and one Renderer on a core each: the repository's head, a volume without a visible voxel, one of eight voxels, and
# tokens through 4096 empty slices, on one rank and between two. Renderers' costs, and all of sheets, are fitted to runs that differ in what
# is seen and in the number of Renderers (scripts/calibrated_machine.py). It takes the medians of all repetitions and
# says how far the fitted costs are off. What waiting costs ranks that share cores is found by simulating (scripts/fit_waiting.py).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

output=${1:?where to write the machine: scripts/calibrate.sh mpi_configs/machines/NAME.toml}
repetitions=${2:-5}
kept=${3:-}
line 4096
"$build/ringsplat" synth constant -o "$work/tiny.nrrd" --dims 2x2x2 >/dev/null
"$build/ringsplat" synth ball -o "$work/wide.nrrd" --dims 512x512x32 >/dev/null
"$build/ringsplat" synth shell -o "$work/shell.nrrd" --dims 512x512x32 >/dev/null
"$build/ringsplat" synth shell -o "$work/hollow.nrrd" --dims 128x128x128 >/dev/null
"$build/ringsplat" synth ball -o "$work/long.nrrd" --dims 16x16x4096 >/dev/null
one=("${dedicated[@]}" --frames-in-flight 1) two=("${colocated[@]}" --frames-in-flight 1) four=(--gps 1 --renderers 4 --frames-in-flight 1)
many=(--gps 1 --renderers 16 --frames-in-flight 1)
orbit=(--orbit 8 --elevation 25 --axes all)
soft=("$head" --tf mr-soft "${orbit[@]}")
flat=(--tf grey --size 128 --orbit 3 --elevation 85)
for ((k = 0; k < repetitions; ++k)); do
  render 2 empty "$head" "${one[@]}" --tf "$work/nothing.json" --size 512 "${orbit[@]}"
  render 2 tiny "$work/tiny.nrrd" "${one[@]}" --tf grey --size 512 --orbit 5
  render 2 line "${line[@]}" "${one[@]}" --orbit 5
  render 2 hop "${line[@]}" --gps 2 --renderers 1 --roles colocated --frames-in-flight 1 --orbit 5

  render 2 splats-head "${soft[@]}" "${one[@]}" --size 512
  render 2 splats-head-two "${soft[@]}" "${two[@]}" --size 512
  render 0 splats-head-four "${soft[@]}" "${four[@]}" --size 512
  render 0 splats-head-many "${soft[@]}" "${many[@]}" --size 512
  render 2 splats-hollow "$work/hollow.nrrd" --tf grey "${orbit[@]}" "${one[@]}" --size 512
  render 0 splats-hollow-many "$work/hollow.nrrd" --tf grey "${orbit[@]}" "${many[@]}" --size 512
  # More ranks than cores, of which scripts/compare_simulated.py times others.
  for layout in "2 3" "3 2" "5 2"; do
    read -r gps renderers <<<"$layout"
    render $((gps + renderers)) "shared-$gps-$renderers" "${soft[@]}" --gps "$gps" --renderers "$renderers" --frames-in-flight 1 --size 512
  done

  quality=best
  render 2 sheets-head "${soft[@]}" "${one[@]}" --size 512
  render 2 sheets-head-two "${soft[@]}" "${two[@]}" --size 512
  render 2 sheets-head-half "${soft[@]}" "${one[@]}" --clip 0:127,0:127,0:61 --size 512
  render 2 sheets-head-half-two "${soft[@]}" "${two[@]}" --clip 0:127,0:127,0:61 --size 512
  render 2 sheets-head-tiny "${soft[@]}" "${one[@]}" --clip 60:64,60:64,60:64 --size 512
  render 0 sheets-head-four "${soft[@]}" "${four[@]}" --size 512
  render 2 sheets-wide "$work/wide.nrrd" "${one[@]}" "${flat[@]}"
  render 2 sheets-shell "$work/shell.nrrd" "${one[@]}" "${flat[@]}"
  render 2 sheets-long "$work/long.nrrd" "${one[@]}" "${flat[@]}"
  quality=paper
done
rm "$work/one.jsonl"
[[ -z $kept ]] || { mkdir -p "$kept" && cp "$work"/*.jsonl "$kept"; }
python3 -B "$repo/scripts/calibrated_machine.py" "$work" "$(cores)" >"$work/machine.toml"
python3 -B "$repo/scripts/fit_waiting.py" "$work" "$work/machine.toml"
mv "$work/machine.toml" "$output"
say "$output describes this machine"
