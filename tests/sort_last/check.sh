#!/usr/bin/env bash
# The race's pictures are the program's:  check.sh MPIEXEC PROGRAM SORT_LAST HEAD SCRATCH [BUILD]
# On one rank bit for bit; on several, whose pictures IceT composites in its own order, but for rounding and what an opaque
# pixel would have left out. With BUILD also on simulated ranks, which must draw as many splats.
set -euo pipefail
mpiexec=$1 program=$2 sort_last=$3 head=$4 scratch=$5
rm -rf "$scratch" && mkdir -p "$scratch" && cd "$scratch"
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
view=(--size 128 --azimuth 30 --shading phong)
for case in "1 75 radixk" "3 75 bswap" "3 -75 radixk --even"; do # seen from either side
  read -r ranks elevation options <<<"$case"
  "$program" render "$head" --quality paper --fit sphere "${view[@]}" --elevation "$elevation" --tf mr-soft --tf-out tf.json -o ring.exr >/dev/null
  # shellcheck disable=SC2086  # words
  "$mpiexec" -n "$ranks" "$sort_last" "$head" --tf tf.json "${view[@]}" --elevation "$elevation" --strategy $options -o sections.exr >out
  most=0.1
  if ((ranks == 1)); then most=0; fi
  "$program" compare sections.exr ring.exr --fail-above "$most" >/dev/null || fail "$case: another picture"
done
if "$mpiexec" -n 2 "$sort_last" "$head" --tf tf.json >out 2>&1; then fail "a view along another axis was drawn"; fi
grep -q 'does not traverse the z slices' out || fail "a view along another axis was refused without a reason"

# Sheets: along each axis and from either side, with an eye, again when kept slices are there; and how far seams differ.
sheets=(--size 128 --engine sheets)
for case in "1 0 90" "1 30 20" "1 250 -50" "1 30 20 --fov 40" "3 0 -90" "3 30 20 --even" "3 100 10" "3 250 -50 --fov 40"; do
  read -r ranks azimuth elevation options <<<"$case"
  view=(--azimuth "$azimuth" --elevation "$elevation")
  projection=()
  if [[ $options == --fov* ]]; then projection=(--projection perspective); fi
  # shellcheck disable=SC2086  # words
  "$mpiexec" -n "$ranks" "$sort_last" "$head" --tf tf.json "${sheets[@]}" "${view[@]}" $options --frames 2 -o sections.exr >out
  [[ $(grep -o '"picture": .*' out | sort -u | wc -l) == 1 ]] || fail "$case: the second frame is another one"
  "$program" render "$head" --quality best --fit sphere --size 128 "${view[@]}" "${projection[@]}" --tf tf.json -o ring.exr >/dev/null
  most=0.2
  if ((ranks == 1)); then most=0; fi
  "$program" compare sections.exr ring.exr --fail-above "$most" >/dev/null || fail "sheets, $case: another picture"
done

[[ -n ${6:-} ]] || exit 0
printf 'machine = "mpi_configs/machines/ethernet-cluster.toml"\nroles = "colocated"\ngps = 16\nrenderers = 16\n' >ranks.toml
items() { grep -o '"items": [0-9]*' "$1"; }
"$mpiexec" -n 2 "$sort_last" "$head" --tf tf.json --elevation 90 --size 64 >real
RINGSPLAT_BUILD=$6 RINGSPLAT_OTHER=$6/sort_last_smpi.so "$(dirname "${BASH_SOURCE[0]}")/../../scripts/simulate.sh" "$scratch/ranks.toml" \
  "$head" --tf tf.json --elevation 90 --size 64 -o simulated.exr >simulated
[[ $(items real) == $(items simulated) ]] || fail "simulated ranks draw $(items simulated), real ones $(items real)"
"$program" render "$head" --quality paper --fit sphere --shading phong --elevation 90 --size 64 --tf tf.json -o ring.exr >/dev/null
"$program" compare simulated.exr ring.exr --fail-above 0.1 >/dev/null || fail "simulated ranks draw another picture"
