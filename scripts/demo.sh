#!/usr/bin/env bash
# Renders a head with six ranks:  scripts/demo.sh [VOLUME [RENDER OPTION...]]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

"$repo/scripts/setup.sh"
build_ringsplat ringsplat_cli

volume=$repo/tests/data/head.nrrd
look=(--tf mr-skin --azimuth -35 --elevation 8 --zoom 1.4 --background '#20242c')
if (($# > 0)); then
  volume=$1
  shift
  look=("$@")
fi
picture=$repo/out/$(basename "${volume%%.*}").png
statistics=${picture%.png}.json
mkdir -p "$repo/out"

say "rendering with 4 GPs and 2 Renderers; the picture, and the seconds that the frame took:"
run_ranks 6 "$build/ringsplat" render "$volume" --gps 4 --renderers 2 --size 512x512 "${look[@]}" -o "$picture" --stats "$statistics"
say "what each of them did: $statistics"
