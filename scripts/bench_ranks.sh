#!/usr/bin/env bash
# More ranks than cores:  scripts/bench_ranks.sh [REPETITIONS]   (default 3; nothing else should run)
#
# The repository's head at 512x512 pixels, an orbit of 24 views, one frame in flight, drawn with splats and with sheets by one process, by two
# colocated ranks, and by 16 and 64 ranks whose roles the program chooses, all on this machine's cores. Prints a Markdown table of medians
# over the frames of all repetitions, different numbers of ranks taking turns.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

repetitions=${1:-3}
view=("$head" --tf mr-soft --size 512 --orbit 24 --elevation 25 --axes all --frames-in-flight 1)
for ((k = 0; k < repetitions; ++k)); do
  for quality in paper best; do
    render 0 "$quality-1" "${view[@]}"
    render 2 "$quality-2" "${view[@]}" "${colocated[@]}"
    for ranks in 16 64; do render "$ranks" "$quality-$ranks" "${view[@]}" --gps auto; done
  done
done
python3 -B "$repo/scripts/bench_ranks_report.py" "$work"
