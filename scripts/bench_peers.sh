#!/usr/bin/env bash
# Compares with VTK's ray casters and VolPack:  scripts/bench_peers.sh [--plot PNG] [ROUNDS [RENDER OPTION...]]
# (default 3; nothing else should run; RENDER OPTIONs go to all of ringsplat's runs)
#
# The repository's head, 512x512, 24 views that traverse all three slice sets, the opacities of mr-soft (about 32 % of
# the voxels visible) and mr-surface (about 11 %) in white, Phong and unshaded; ringsplat with two colocated ranks, on the screen and in the
# plane of the slices, and there with kernels of radius 1.1 and with one GP and one Renderer as well, and sheets of all three qualities. The programs take turns; figures are medians over all frames of all rounds. Errors are against the field's truth, at three views, one for each slice set.
# Prints a Markdown table and draws it (--plot, else build/peers/speed-error.png; the numbers are beside it: scripts/peers/plot.py
# draws them again). VTK comes from PyPI into build/peers (about 400 MB), VolPack from libvolpack1-dev. VTK's GPU ray caster
# is measured where Mesa's software rasteriser is: libegl1 and libgl1-mesa-dri, or libosmesa6; ParaView's pvbatch on two ranks where it
# is installed.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/bench_lib.sh"

peers=$repo/build/peers
plot=$peers/speed-error.png
if [[ ${1:-} == --plot ]]; then
  plot=${2:?"--plot needs the name of a PNG file"}
  shift 2
fi
rounds=${1:-3}
options=("${@:2}")
[[ $rounds =~ ^[1-9][0-9]*$ ]] || die "the number of rounds is no number: $rounds"
truth_views=(0 2 8)
peers_python=$peers/venv/bin/python
# shellcheck source-path=SCRIPTDIR source=peers/scene_lib.sh
source "$repo/scripts/peers/scene_lib.sh"

prepare_peers() {
  mkdir -p "$peers/truth"
  if [[ ! -x $peers/venv/bin/python ]] || ! "$peers/venv/bin/python" -c 'import vtk, numpy, matplotlib' 2>/dev/null; then
    say "installing VTK into $peers/venv"
    python3 -m venv "$peers/venv" || die "there is no virtual environment: apt-get install python3-venv"
    "$peers/venv/bin/pip" install -q 'vtk>=9.4,<10' numpy matplotlib >&2 || die "VTK could not be installed"
  fi
  cc -std=gnu11 -O3 -march=native -Wall -Wextra "$repo/scripts/peers/volpack_frames.c" -o "$peers/volpack_frames" -lvolpack -lm ||
    die "VolPack is missing: apt-get install libvolpack1-dev"
}

# frames PROGRAM CASE COMMAND...: appends the seconds that it prints, but for the first frame's.
frames() {
  local list="$work/$1-$2.seconds"
  shift 2
  "$@" 2>>"$work/log" | tail -n +2 >>"$list" || { cat "$work/log" >&2; die "$1 failed"; }
}

declare -A setting=(
  [best]="${colocated[*]} --quality best"
  [normal]="${colocated[*]} --quality normal"
  [draft]="${colocated[*]} --quality draft"
  [screen]="${colocated[*]} --quality paper"
  [slices]="${colocated[*]} --quality paper --image-plane slices"
  [sharp]="${colocated[*]} --quality paper --image-plane slices --radius 1.1"
  [apart]="${dedicated[*]} --quality paper --image-plane slices"
  [sharp-apart]="${dedicated[*]} --quality paper --image-plane slices --radius 1.1"
)

ringsplat() { # SETTING FUNCTION SHADING VIEWS OPTION...
  # shellcheck disable=SC2086  # a setting's options are words
  run_ranks 2 "$build/ringsplat" render "${volume[@]}" "${ahead[@]}" --size 512 --tf "$work/$2.json" --shading "$3" \
    --path "$work/$4" ${setting[$1]} "${options[@]}" "${@:5}" >/dev/null
}

# One frame in flight: from the announcement to the finished picture, as the others' are from call to return.
ringsplat_frames() {
  ringsplat "$1" "$2" "$3" views.txt --frames-in-flight 1 --stats "$work/one.jsonl"
  "$peers/venv/bin/python" -c 'import json, sys; [print(json.loads(line)["seconds"]) for line in open(sys.argv[1])]' "$work/one.jsonl"
}

vtk_frames() { # vtk|vtk-gpu FUNCTION SHADING [PICTURES]
  env -u DISPLAY LIBGL_ALWAYS_SOFTWARE=1 "$peers/venv/bin/python" "$repo/scripts/peers/vtk_frames.py" "$work" "$2" "$3" "$1" "${@:4}"
}

prepare_peers
prepare_scene
vtk_mappers=(vtk)
if vtk_frames vtk-gpu soft none >/dev/null 2>"$work/log"; then
  vtk_mappers+=(vtk-gpu)
else
  say "VTK's GPU ray caster is left out: it does not run on Mesa's software rasteriser (apt-get install libegl1 libgl1-mesa-dri)"
fi
paraview=()
if find_paraview; then
  start_display
  paraview=(paraview)
else
  say "ParaView is left out: $paraview_hint"
fi
make_truths
pictures=(pictures)
for ((k = 1; k <= rounds; ++k)); do
  say "round $k of $rounds"
  for function in soft surface; do
    for shading in phong none; do
      for name in "${!setting[@]}"; do
        frames "$name" "$function-$shading" ringsplat_frames "$name" "$function" "$shading"
        if [[ -n ${pictures[*]} ]]; then ringsplat "$name" "$function" "$shading" truth_views.txt -o "$work/$name-$function-$shading.exr"; fi
      done
      for name in "${vtk_mappers[@]}"; do
        frames "$name" "$function-$shading" vtk_frames "$name" "$function" "$shading" "${pictures[@]}"
      done
      for name in "${paraview[@]}"; do
        frames "$name" "$function-$shading" paraview_frames 2 "$function" "$shading" smart "${pictures[@]/#pictures/$work/paraview-$function-$shading}"
      done
      frames volpack "$function-$shading" "$peers/volpack_frames" "$work" "$function" "$shading" "${dims[@]}" "${spacing[@]}" 512 "${pictures[@]}"
    done
  done
  pictures=()
done
"$peers/venv/bin/python" "$repo/scripts/peers/report.py" "$work" "$build/ringsplat" "$truths" "$peers/speed-error.csv" "${truth_views[@]}"
"$peers/venv/bin/python" "$repo/scripts/peers/plot.py" "$peers/speed-error.csv" -o "$plot"
