#!/usr/bin/env bash
# Installs what drawing needs, builds the program, and renders a head with six ranks, as in the paper and at its best:
#   scripts/demo.sh [VOLUME [RENDER OPTION...]]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

"$repo/scripts/setup.sh" --drawing
build_ringsplat ringsplat_cli

volume=$repo/tests/data/head.nrrd
look=(--tf mr-skin --azimuth -35 --elevation 8 --fit sphere --zoom 1.4 --background '#20242c')
if (($# > 0)); then
  volume=$1
  shift
  look=("$@")
fi
name=$repo/out/$(basename "${volume%%.*}")
mkdir -p "$repo/out"

# demo QUALITY RANKS_OPTION...: the picture, the seconds that the frame took, and how far it is from the truth.
demo() {
  local quality=$1
  shift
  say "--quality $quality, $*:"
  run_ranks 6 "$build/ringsplat" render "$volume" --quality "$quality" "$@" --size 512x512 "${look[@]}" --error field \
    -o "$name-$quality.png" --stats "$name-$quality.json"
  say "what each of them did: $name-$quality.json"
}

demo paper --gps 4 --renderers 2
# Sheets are the Renderers' work: every rank that has a core is one.
demo best --gps auto
