#!/usr/bin/env bash
# What a user types:  scripts/bench_ranks.sh [REPETITIONS [typed|configs]]   (default 3 and both; nothing else should run)
#
# `ringsplat render tests/data/head.nrrd --orbit 24 -o x.png` without and with --quality paper, in one process and on 2, 4, 16 and 64 ranks,
# all on this machine's cores; then the same orbit, without pictures, with every file of mpi_configs. Prints Markdown tables of medians over
# the repetitions, which take turns.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

repetitions=${1:-3} tables=${2:-typed configs}

# timed NAME K RANKS OPTION...: repetition K of an orbit of 24, its frames into NAME-K.jsonl and the whole command's seconds into NAME-K.seconds.
timed() {
  local name=$1-$2 ranks=$3 launch=() begun=$EPOCHREALTIME
  shift 3
  if ((ranks > 0)); then launch=(run_ranks "$ranks"); fi
  ("${launch[@]}" "$build/ringsplat" render "$head" --orbit 24 "$@" --stats "$work/$name.jsonl") >/dev/null 2>"$work/log" ||
    { cat "$work/log" >&2; die "a run of $name failed"; }
  echo "$begun $EPOCHREALTIME" | awk '{ print $2 - $1 }' >"$work/$name.seconds"
}

for ((k = 0; k < repetitions; ++k)); do
  if [[ $tables == *typed* ]]; then
    for ranks in 0 2 4 16 64; do
      timed "typed-best-$ranks" "$k" "$ranks" -o "$work/x.png"
      timed "typed-paper-$ranks" "$k" "$ranks" -o "$work/x.png" --quality paper
    done
  fi
  if [[ $tables == *configs* ]]; then
    for file in "$repo"/mpi_configs/*.toml; do
      ranks=$(sed -n 's/^# *mpirun -n \([0-9]*\) .*/\1/p' "$file")
      timed "config-$(basename "$file" .toml)" "$k" "$ranks" --config "$file" --size 512x512
    done
  fi
done
python3 -B "$repo/scripts/bench_ranks_report.py" "$work"
