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

# A transfer function that shows nothing.
cat >"$work/nothing.json" <<'JSON'
[{"Name": "nothing", "ColorSpace": "RGB", "NanColor": [1, 0, 0],
  "RGBPoints": [0, 0, 0, 0, 255, 1, 1, 1], "Points": [0, 0, 0.5, 0, 255, 0, 0.5, 0]}]
JSON

# line SLICES: makes what "${line[@]}" renders, a volume of 2x2 voxels a slice with a transfer function that shows the value
# between theirs. A token goes through every slice, because each might show something, and frames cost only that.
line=("$work/line.nrrd" --tf "$work/gap.json" --size 64 --elevation 90)
line() {
  { printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 %d\nencoding: ascii\n\n' "$1" && for ((k = 0; k < $1; ++k)); do echo 0 2 2 0; done; } >"$work/line.nrrd"
  sed 's/nothing/gap/; s/"Points": .*/"Points": [0, 0, 0.5, 0, 1, 1, 0.5, 0, 2, 0, 0.5, 0]}]/' "$work/nothing.json" >"$work/gap.json"
}

# render RANKS NAME OPTION...: appends one run's frames, drawn as in the paper or as $quality says, to NAME.jsonl; 0 ranks: in one process.
# A rank has one thread, so that figures are of one core.
render() {
  local ranks=$1 name=$2 launch=()
  shift 2
  if ((ranks > 0)); then launch=(run_ranks "$ranks"); fi
  ("${launch[@]}" "$build/ringsplat" render --quality "${quality:-paper}" --threads-per-rank 1 "$@" --stats "$work/one.jsonl") >/dev/null 2>>"$work/log" ||
    { cat "$work/log" >&2; die "a run of $name failed"; }
  cat "$work/one.jsonl" >>"$work/$name.jsonl"
}
