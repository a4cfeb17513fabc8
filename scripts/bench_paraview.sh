#!/usr/bin/env bash
# Seams, memory, time and error beside ParaView:  scripts/bench_paraview.sh [ROUNDS]   (default 3; nothing else should run)
#
# The scene of bench_peers.sh (the repository's head, 512x512, orthographic, white, soft and surface, Phong and unshaded) on 1, 2, 3,
# 4 and 6 ranks: pvbatch with IceT between its processes, with both of its ray casters, and ringsplat's colocated ranks. Prints a
# Markdown table: the pixels that differ from the same program's picture on one rank, and by how much at most; the error against the
# field's truth at three views, one for each slice set; the median time of a frame; and the peak memory (VmHWM) of the largest rank
# and of all. Numbers go to build/peers/paraview.csv. The truths take minutes and are kept in build/peers/truth.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

rounds=${1:-3}
[[ $rounds =~ ^[1-9][0-9]*$ ]] || die "the number of rounds is no number: $rounds"
rank_counts=(1 2 3 4 6)
read -r -a functions <<<"${FUNCTIONS:-soft surface}"
read -r -a shadings <<<"${SHADINGS:-phong none}"
peers=$repo/build/peers
# Debian's, for which its NumPy is.
peers_python=/usr/bin/python3
truth_views=(0 2 8)
# shellcheck source-path=SCRIPTDIR source=peers/scene_lib.sh
source "$repo/scripts/peers/scene_lib.sh"
find_paraview || die "ParaView is missing: $paraview_hint"
"$peers_python" -c 'import numpy' || die "NumPy is missing: apt-get install python3-numpy"

declare -A setting=([best]="--quality best" [paper]="--quality paper")

# run NAME FUNCTION SHADING RANKS PROGRAM...: keeps seconds, memory and pictures under NAME-FUNCTION-SHADING-RANKS. An X server that
# was slow to answer ends ParaView, so it gets a second chance.
run() {
  local key=$1-$2-$3-$4 try
  shift 4
  for try in 1 2 3; do
    rm -f "$work/memory."*
    if "$@" >"$work/one" 2>"$work/log"; then break; fi
    if ((try == 3)); then cat "$work/log" >&2; die "$key failed"; fi
    say "$key failed and is tried again"
  done
  tail -n +2 "$work/one" >>"$work/$key.seconds"
  cat "$work/memory."* >"$work/$key.memory"
}

ringsplat() { # SETTING FUNCTION SHADING RANKS
  # shellcheck disable=SC2086  # a setting's options are words
  run_ranks "$4" "${each[@]}" "$build/ringsplat" render "${volume[@]}" "${ahead[@]}" --size 512 --tf "$work/$2.json" --shading "$3" \
    --path "$work/views.txt" --roles colocated --gps "$4" --renderers "$4" ${setting[$1]} --frames-in-flight 1 \
    -o "$work/$1-$2-$3-$4.exr" --stats "$work/one.jsonl" >/dev/null
  "$peers_python" -c 'import json, sys; [print(json.loads(line)["seconds"]) for line in open(sys.argv[1])]' "$work/one.jsonl"
}

mkdir -p "$peers/truth"
prepare_scene
make_truths
# Three views for the errors, and three for more times; the first is drawn twice.
{ cat "$work/truth_views.txt" && sed -n '5p;13p;21p' "$work/views.txt"; } >"$work/some_views.txt"
mv "$work/some_views.txt" "$work/views.txt"
start_display
each=("$peers_python" "$repo/scripts/peers/peak_memory.py" "$work/memory")
for ((k = 1; k <= rounds; ++k)); do
  for function in "${functions[@]}"; do
    for shading in "${shadings[@]}"; do
      say "round $k of $rounds: $function, $shading"
      for ranks in "${rank_counts[@]}"; do
        for name in best paper; do run "$name" "$function" "$shading" "$ranks" ringsplat "$name" "$function" "$shading" "$ranks"; done
        for name in smart cast; do
          run "$name" "$function" "$shading" "$ranks" paraview_frames "$ranks" "$function" "$shading" "$name" "$work/$name-$function-$shading-$ranks"
        done
      done
    done
  done
done
"$peers_python" "$repo/scripts/peers/paraview_report.py" "$work" "$build/ringsplat" "$truths" "$peers/paraview.csv"
