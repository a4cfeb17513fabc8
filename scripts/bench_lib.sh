# shellcheck shell=bash
# What the benchmarks share; sourced, not run. Builds the program and makes the folder $work, which goes when the script ends.

source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
build_ringsplat ringsplat_cli
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
head=$repo/tests/data/head.nrrd

# What --frames-in-flight 1 leaves to run ahead: slices, payloads and tokens.
# shellcheck disable=SC2034  # for the scripts that source this
ahead=(--look-ahead 4 --slots 16 --send-ahead 16)

# What two ranks do.
# shellcheck disable=SC2034
dedicated=(--gps 1 --renderers 1) colocated=(--roles colocated --gps 2 --renderers 2)

# A transfer function that shows nothing: frames then cost only their tokens.
cat >"$work/nothing.json" <<'JSON'
[{"Name": "nothing", "ColorSpace": "RGB", "NanColor": [1, 0, 0],
  "RGBPoints": [0, 0, 0, 0, 255, 1, 1, 1], "Points": [0, 0, 0.5, 0, 255, 0, 0.5, 0]}]
JSON

# render RANKS NAME OPTION...: appends one run's frames to NAME.jsonl; 0 ranks: in one process.
render() {
  local ranks=$1 name=$2 launch=()
  shift 2
  if ((ranks > 0)); then launch=(run_ranks "$ranks"); fi
  ("${launch[@]}" "$build/ringsplat" render "$@" --stats "$work/one.jsonl") >/dev/null 2>>"$work/log" ||
    { cat "$work/log" >&2; die "a run of $name failed"; }
  cat "$work/one.jsonl" >>"$work/$name.jsonl"
}
