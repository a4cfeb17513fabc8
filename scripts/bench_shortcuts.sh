#!/usr/bin/env bash
# What each shortcut costs and gains:  scripts/bench_shortcuts.sh [ROUNDS]   (default 3; nothing else should run)
#
# The repository's head, 512x512, Phong, 24 views that traverse all three slice sets, with mr-soft (about 32 % of the
# voxels visible) and mr-surface (about 11 %). Every row is rendered once a round, all rows in turn, the first (no
# shortcut) among them; figures are medians over the frames of all rounds. Errors are against the method's truth, at three
# views, one for each slice set. Prints Markdown tables.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

rounds=${1:-3}

# Every third view looks along another slice set.
for ((k = 0; k < 24; ++k)); do echo "$((15 * k)) $((k % 3 == 2 ? 65 : 25 - 50 * (k % 2)))"; done >"$work/views.txt"
printf '20 10\n75 -15\n40 65\n' >"$work/truth_views.txt"
python3 "$repo/scripts/pad_volume.py" "$head" "$work/padded.nrrd"
python3 "$repo/scripts/bench_shortcuts_report.py" front-matrix "$("$build/ringsplat" info "$head" --json)" 512 8 >"$work/front.txt"

# The rows of the table: a name, how many ranks, and options that come after those that switch all shortcuts off.
none=(--opaque-threshold 0 --payload words --precision float --frames-in-flight 1 --look-ahead 1)
dedicated=(--gps 1 --renderers 1)
colocated=(--roles colocated --gps 2 --renderers 2)
runs=(--opaque-threshold 0 --payload runs --frames-in-flight 1 --look-ahead 1)
names=() # in the tables' order
declare -A row_ranks row_options
row() {
  names+=("$1")
  row_ranks[$1]=$2
  row_options[$1]=${*:3}
}
row none 2 "${none[@]}" "${dedicated[@]}"
row opaque-threshold 2 --opaque-threshold 0.001953125 "${none[@]:2}" "${dedicated[@]}"
row runs 2 "${runs[@]}" "${dedicated[@]}"
row runs-half 2 "${runs[@]}" --precision half "${dedicated[@]}"
row runs-u8 2 "${runs[@]}" --precision u8 "${dedicated[@]}"
row frames-in-flight-2 2 "${none[@]:0:6}" --frames-in-flight 2 --look-ahead 1 "${dedicated[@]}"
row look-ahead-4 2 "${none[@]:0:6}" --frames-in-flight 1 --look-ahead 4 "${dedicated[@]}"
row colocated 2 "${none[@]}" "${colocated[@]}"
all=(--opaque-threshold 0.001953125 --payload runs --frames-in-flight 2 --look-ahead 4)
row all-exact 2 "${all[@]}" "${colocated[@]}"
row all-u8 2 "${all[@]}" --precision u8 "${colocated[@]}"
row undersample-2 2 "${none[@]}" --undersample 2 "${dedicated[@]}"
row undersample-2-prefiltered 2 "${none[@]}" --undersample 2 --prefilter "${dedicated[@]}"
row undersample-4 2 "${none[@]}" --undersample 4 "${dedicated[@]}"
row all-undersample-2 2 "${all[@]}" --undersample 2 --prefilter "${colocated[@]}"

# shellcheck disable=SC2086  # a row's options are words
table_row() { # FUNCTION ROW
  render "${row_ranks[$2]}" "$1-$2" "$head" --tf "mr-$1" --size 512 --path "$work/views.txt" ${row_options[$2]}
}
# shellcheck disable=SC2086
error_row() {
  render "${row_ranks[$2]}" "error-$1-$2" "$head" --tf "mr-$1" --size 512 --path "$work/truth_views.txt" ${row_options[$2]} --error method
}

default() { # NAME RANKS OPTION...: a run with the program's own defaults but one frame in flight
  local name=$1 ranks=$2
  shift 2
  render "$ranks" "$name" "$@" --size 512 --frames-in-flight 1 --path "$work/views.txt"
}

held_rows() {
  default held-one-process 0 "$head" --tf mr-soft
  default held-2-colocated 2 "$head" --tf mr-soft "${colocated[@]}"
  default held-16-colocated 16 "$head" --tf mr-soft --roles colocated --gps 16 --renderers 16
  default held-surface 2 "$head" --tf mr-surface "${colocated[@]}"
  sed 's/$/ 0 2/' "$work/views.txt" >"$work/zoomed.txt"
  render 2 held-padded "$work/padded.nrrd" --tf mr-soft --size 512 --frames-in-flight 1 --path "$work/zoomed.txt" "${colocated[@]}"
  local size
  for size in 512 256; do
    render 2 "held-front-$size" "$head" --tf mr-soft --size "$size" --frames-in-flight 1 --path "$work/front.txt" "${colocated[@]}"
  done
}

for ((k = 1; k <= rounds; ++k)); do
  say "round $k of $rounds"
  for name in "${names[@]}"; do
    for function in soft surface; do table_row "$function" "$name"; done
  done
  held_rows
done
say "errors"
for name in "${names[@]}"; do
  for function in soft surface; do error_row "$function" "$name"; done
done
python3 "$repo/scripts/bench_shortcuts_report.py" tables "$work" "${names[@]}"
