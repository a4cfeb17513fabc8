#!/usr/bin/env bash
# Time and error of sheets' settings, of which --quality's are chosen:
#
#   scripts/qualities.sh [--size PIXELS] [FOLDER [ROUNDS [VOLUME TF]]]     (default 512, build/qualities, 3; nothing else should run)
#
# Every setting of scripts/qualities.toml, and its views, of the repository's head with mr-soft and mr-surface, and of VOLUME with TF.
# Errors are against the field's truth (ringsplat study), times those of two colocated ranks; settings take turns. FOLDER keeps
# both, so that a further call adds rounds only. Prints a Markdown table; in bold what no other setting beats in time and error.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

size=512
if [[ ${1:-} == --size ]]; then
  size=${2:?"--size needs pixels a side"}
  shift 2
fi
folder=${1:-$repo/build/qualities} rounds=${2:-3}
[[ $rounds =~ ^[1-9][0-9]*$ ]] || die "the number of rounds is no number: $rounds"
scene=()
if (($# > 2)); then scene=("$(realpath "$3")" "${4:?"VOLUME needs a transfer function"}"); fi
mkdir -p "$folder"
folder=$(realpath "$folder")
build_ringsplat ringsplat_cli
cd "$repo"
study() { python3 "$repo/scripts/qualities_study.py" "$@"; }
study list "$repo/scripts/qualities.toml" "$size" "${scene[@]}" >"$folder/list.toml.new"
if ! cmp -s "$folder/list.toml.new" "$folder/list.toml"; then
  mv "$folder/list.toml.new" "$folder/list.toml"
  rm -f "$folder/errors.csv" "$folder/times.csv"
fi
rm -f "$folder/list.toml.new"
[[ -f $folder/errors.csv ]] || "$build/ringsplat" study "$folder/list.toml" -o "$folder/errors.csv" >&2

allow_ranks 2
for ((k = 1; k <= rounds; ++k)); do
  say "round $k of $rounds"
  study times "$folder" "${RINGSPLAT_MPIEXEC:-mpirun}" -n 2 "$build/ringsplat"
done
study table "$folder"
