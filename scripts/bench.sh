#!/usr/bin/env bash
# Measures this machine:  scripts/bench.sh [REPETITIONS]   (default 5; nothing else should run)
#
# The repository's head (128x128x124, about 32 % visible), an orbit of 24 views; figures are medians over the
# frames of all repetitions, repetitions of different layouts taking turns. Prints Markdown tables.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

repetitions=${1:-5}
orbit=(--orbit 24 --elevation 25 --tf mr-soft --axes all)

line 4096

for ((k = 0; k < repetitions; ++k)); do
  for size in 256 512 1024; do
    render 2 "draw-$size" "$head" --gps 1 --renderers 1 --size "$size" --frames-in-flight 1 "${orbit[@]}"
  done
  for size in 256 512; do
    render 2 "layout-$size-1+1" "$head" --gps 1 --renderers 1 --size "$size" --frames-in-flight 1 "${orbit[@]}"
    render 16 "layout-$size-12+4" "$head" --gps 12 --renderers 4 --size "$size" --frames-in-flight 1 "${orbit[@]}"
  done
  for gps in 1 3 7 15; do
    render $((gps + 1)) "hop-$((gps + 1))" "${line[@]}" --gps "$gps" --renderers 1 --orbit 5
  done
done
python3 "$repo/scripts/bench_report.py" "$work"
