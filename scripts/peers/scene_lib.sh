# shellcheck shell=bash
# What the comparisons with other programs share: the scene, its truths, and ParaView. Sourced after bench_lib.sh by what has set
# `peers` (a folder that stays), `peers_python` (with NumPy) and `truth_views` (numbers of views in views.txt).

prepare_scene() {
  local name
  for name in soft surface; do
    "$build/ringsplat" render "$head" --tf "mr-$name" --tf-out "$work/mr-$name.json" --quality paper --size 16 -o "$work/x.exr" >/dev/null
  done
  "$peers_python" "$repo/scripts/peers/scene.py" "$head" "$work" "$work/mr-soft.json" "$work/mr-surface.json"
  read -r -a dims <<<"$(scene_field dims)"
  read -r -a spacing <<<"$(scene_field spacing)"
  volume=("$work/head.raw" --dims "${dims[0]}x${dims[1]}x${dims[2]}" --type uint8 --spacing "${spacing[0]}x${spacing[1]}x${spacing[2]}")
  for name in "${truth_views[@]}"; do sed -n "$((name + 1))p" "$work/views.txt"; done >"$work/truth_views.txt"
}

scene_field() { "$peers_python" -c 'import json, sys; print(*json.load(open(sys.argv[1]))[sys.argv[2]])' "$work/scene.json" "$1"; }

# The truths take minutes, so they are kept as long as what they are made from is the same.
make_truths() {
  local key
  key=$(cat "$work/head.raw" "$work"/{soft,surface}.json "$work/truth_views.txt" | sha256sum | cut -c1-16)
  truths=$peers/truth/$key
  [[ -e $truths/done ]] && return
  mkdir -p "$truths"
  for function in soft surface; do
    for shading in phong none; do
      say "the field's truth: $function, $shading"
      "$build/ringsplat" reference "${volume[@]}" --truth field --tolerance 1e-4 --path "$work/truth_views.txt" --tf "$work/$function.json" \
        --shading "$shading" -o "$truths/$function-$shading.exr" >/dev/null
    done
  done
  touch "$truths/done"
}

# ParaView of Debian draws only where there is an X server, and its own, so that no graphics card is used.
find_paraview() { command -v pvbatch >/dev/null && command -v Xvfb >/dev/null; }
paraview_hint='apt-get install --no-install-recommends paraview python3-paraview xvfb xauth (90 MB to download, 630 MB installed)'

start_display() {
  local number=100 try
  while [[ -e /tmp/.X11-unix/X$number || -e /tmp/.X$number-lock ]]; do number=$((number + 1)); done
  Xvfb ":$number" -screen 0 1024x1024x24 -nolisten tcp -noreset >/dev/null 2>&1 &
  xvfb=$!
  trap 'kill "$xvfb"; rm -rf "$work"' EXIT
  for ((try = 0; try < 100; ++try)); do
    if [[ -e /tmp/.X11-unix/X$number ]]; then break; fi
    sleep 0.1
  done
  export DISPLAY=":$number"
}

# paraview_frames RANKS FUNCTION SHADING smart|cast [PREFIX]: with `each` before the program, where that is set.
paraview_frames() {
  LIBGL_ALWAYS_SOFTWARE=1 run_ranks "$1" "${each[@]}" pvbatch --sym "$repo/scripts/peers/pv_frames.py" "$work" "${@:2}"
}
each=()
