#!/usr/bin/env bash
# What each shortcut costs and gains:  scripts/bench_shortcuts.sh [ROUNDS [bounds]]   (default 3; nothing else should run)
#
# The repository's head, 512x512, Phong, 24 views that traverse all three slice sets, with mr-soft (about 32 % of the
# voxels visible) and mr-surface (about 11 %). Every row is rendered once a round, all rows in turn, the first (no
# shortcut) among them; figures are medians over the frames of all rounds. Errors are against the method's truth, at three
# views, one for each slice set. Prints Markdown tables; with "bounds" only that of the ratios that are held to bounds.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

rounds=${1:-3} tables=${2:-all}
[[ $tables == all || $tables == bounds ]] || die "the second argument can be: bounds"

# Every third view looks along another slice set.
for ((k = 0; k < 24; ++k)); do echo "$((15 * k)) $((k % 3 == 2 ? 65 : 25 - 50 * (k % 2)))"; done >"$work/views.txt"
printf '20 10\n75 -15\n40 65\n' >"$work/truth_views.txt"
python3 "$repo/scripts/pad_volume.py" "$head" "$work/padded.nrrd"
python3 "$repo/scripts/bench_shortcuts_report.py" front-matrix "$("$build/ringsplat" info "$head" --json)" 512 8 >"$work/front.txt"

# The rows of the table: a name, how many ranks, and options that come after those that switch all shortcuts off.
none=(--opaque-threshold 0 --payload words --precision float --frames-in-flight 1 --look-ahead 1)
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
row look-ahead-4,-send-ahead-16 2 "${none[@]:0:6}" --frames-in-flight 1 "${ahead[@]}" "${dedicated[@]}"
row colocated 2 "${none[@]}" "${colocated[@]}"
slices=(--image-plane slices)
row slices-plane 2 "${runs[@]}" "${slices[@]}" "${dedicated[@]}"
row slices-plane,-2-samples 2 "${runs[@]}" "${slices[@]}" --samples 2 "${dedicated[@]}"
row undersample-2 2 "${none[@]}" --undersample 2 "${dedicated[@]}"
row undersample-2-prefiltered 2 "${none[@]}" --undersample 2 --prefilter "${dedicated[@]}"
row undersample-4 2 "${none[@]}" --undersample 4 "${dedicated[@]}"
all=(--opaque-threshold 0.001953125 --payload runs --frames-in-flight 1 "${ahead[@]}")
row all,-on-the-screen 2 "${all[@]}" "${colocated[@]}"
row all 2 "${all[@]}" "${slices[@]}" "${colocated[@]}"
row all,-u8 2 "${all[@]}" "${slices[@]}" --precision u8 "${colocated[@]}"
row all,-undersample-2 2 "${all[@]}" "${slices[@]}" --undersample 2 "${colocated[@]}"
row all,-undersample-2-prefiltered 2 "${all[@]}" "${slices[@]}" --undersample 2 --prefilter "${colocated[@]}"

# shellcheck disable=SC2086  # a row's options are words
table_row() { # FUNCTION ROW
  render "${row_ranks[$2]}" "$1-$2" "$head" --tf "mr-$1" --size 512 --path "$work/views.txt" ${row_options[$2]}
}
# shellcheck disable=SC2086
error_row() {
  render "${row_ranks[$2]}" "error-$1-$2" "$head" --tf "mr-$1" --size 512 --path "$work/truth_views.txt" ${row_options[$2]} --error method
}

default() { # NAME RANKS OPTION...: a run with all shortcuts that are on without being asked for
  local name=$1 ranks=$2
  shift 2
  render "$ranks" "$name" "$@" --size 512 --path "$work/views.txt"
}

# What is held to bounds, on the screen and in the slices' plane.
held_rows() {
  local plane size
  sed 's/$/ 0 2/' "$work/views.txt" >"$work/zoomed.txt"
  for plane in screen slices; do
    local in_plane=(--image-plane "$plane" --frames-in-flight 1 "${ahead[@]}") name=held-$plane
    default "$name-one-process" 0 "$head" --tf mr-soft "${in_plane[@]}"
    default "$name-2-colocated" 2 "$head" --tf mr-soft "${in_plane[@]}" "${colocated[@]}"
    default "$name-16-colocated" 16 "$head" --tf mr-soft "${in_plane[@]}" --roles colocated --gps 16 --renderers 16
    default "$name-16-auto" 16 "$head" --tf mr-soft "${in_plane[@]}" --gps auto
    default "$name-surface" 2 "$head" --tf mr-surface "${in_plane[@]}" "${colocated[@]}"
    default "$name-undersampled" 2 "$head" --tf mr-soft "${in_plane[@]}" --undersample 2 "${colocated[@]}"
    default "$name-prefiltered" 2 "$head" --tf mr-soft "${in_plane[@]}" --undersample 2 --prefilter "${colocated[@]}"
    render 2 "$name-padded" "$work/padded.nrrd" --tf mr-soft --size 512 "${in_plane[@]}" --path "$work/zoomed.txt" "${colocated[@]}"
    for size in 512 256; do
      render 2 "$name-front-$size" "$head" --tf mr-soft --size "$size" "${in_plane[@]}" --path "$work/front.txt" "${colocated[@]}"
    done
  done
}

for ((k = 1; k <= rounds; ++k)); do
  say "round $k of $rounds"
  held_rows
  if [[ $tables == bounds ]]; then continue; fi
  for name in "${names[@]}"; do
    for function in soft surface; do table_row "$function" "$name"; done
  done
done
if [[ $tables == all ]]; then
  say "errors"
  for name in "${names[@]}"; do
    for function in soft surface; do error_row "$function" "$name"; done
  done
  python3 "$repo/scripts/bench_shortcuts_report.py" tables "$work" "${names[@]}"
fi
python3 "$repo/scripts/bench_shortcuts_report.py" bounds "$work"
