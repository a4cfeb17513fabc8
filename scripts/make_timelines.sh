#!/usr/bin/env bash
# Draws Figs. 5 and 8 of Neumann 1992 from this machine's own runs:  scripts/make_timelines.sh [FOLDER]   (default docs)
#
# Three GPs, two Renderers and six slices. GP-bound: large slices, a small picture. Renderer-bound: small slices, a
# large picture and wide kernels, and a Renderer takes one payload ahead. Each is
# rendered 40 times, as five ranks share the machine with everything else; the fastest frame is drawn.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

folder=$(realpath "${1:-$repo/docs}")
build_ringsplat ringsplat_cli
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Ranks that work keep their core; those that wait sleep in any case.
export OMPI_MCA_mpi_yield_when_idle=0
"$build/ringsplat" synth ball --dims 768x6x768 --spacing 1x64x1 -o "$work/large.nrrd" >/dev/null
"$build/ringsplat" synth ball --dims 192x6x192 --spacing 1x16x1 -o "$work/small.nrrd" >/dev/null

# timeline NAME TITLE ZOOM VOLUME OPTION...
timeline() {
  local name=$1 title=$2 zoom=$3
  shift 3
  for _ in {1..40}; do echo "20 15 0 $zoom"; done >"$work/views"
  run_ranks 5 "$build/ringsplat" render --quality paper "$@" --gps 3 --renderers 2 --path "$work/views" --tf grey --frames-in-flight 1 \
    -o "$work/picture.exr" --trace "$work/$name.json" >/dev/null
  say "$name, its fastest frame:"
  python3 "$repo/scripts/plot_timeline.py" "$work/$name.json" --frame fastest --title "$title" -o "$folder/timeline-$name.png"
  python3 "$repo/scripts/plot_balance.py" "$work/$name.json" --frame fastest -o "$folder/balance-$name.png"
}

timeline gp-bound "GP-bound: Renderers wait for slices (as in Fig. 5)" 1 "$work/large.nrrd" --size 256
timeline renderer-bound "Renderer-bound: GPs wait for Renderers (as in Fig. 8)" 1.3 "$work/small.nrrd" --size 1024 --radius 2.4 --slots 2
