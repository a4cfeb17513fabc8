#!/usr/bin/env bash
# Runs all decoders on damaged inputs under the address and undefined-behaviour sanitizers:
#   scripts/fuzz.sh [--build] MINUTES [DRIVER...]
# --build builds them first, in build/asan. The minutes are shared out evenly. Prints each driver's inputs and findings; inputs that were found are kept in
# build/fuzz-found. Exits with 1 when there are any. RINGSPLAT_FUZZ_SEED picks other random numbers.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

build_first=
if [[ ${1-} == --build ]]; then
  build_first=yes
  shift
fi
[[ ${1-} =~ ^[0-9]+$ ]] && (($1 > 0)) || die "usage: scripts/fuzz.sh [--build] MINUTES [DRIVER...]"
minutes=$1
shift

cd "$repo"
if [[ -n $build_first ]]; then
  [[ -f build/asan/build.ninja ]] || cmake --preset asan >&2
  cmake --build --preset asan --target fuzz >&2
fi
fuzz=$repo/build/asan/fuzz
[[ -x $fuzz ]] || die "build/asan has no fuzz; hint: scripts/fuzz.sh --build $minutes"
readarray -t drivers < <("$fuzz" --list "$@")
((${#drivers[@]} > 0)) || die "no such driver"
seconds=$((60 * minutes * $(cores) / ${#drivers[@]}))

# As many at once as there are cores; each has its own report, so that they do not mix.
reports=$(mktemp -d)
trap 'rm -rf "$reports"' EXIT
printf '%s\n' "${drivers[@]}" |
  xargs -P "$(cores)" -I{} sh -c '"$1" "$2" --seconds "$3" --seed "$4" --keep "$5" >"$6/$2" 2>&1 || true' \
    sh "$fuzz" {} "$((seconds > 0 ? seconds : 1))" "${RINGSPLAT_FUZZ_SEED:-1}" "$repo/build/fuzz-found" "$reports"
cd "$reports"
cat "${drivers[@]}"
# A driver's last line is its summary; without it the driver itself has failed.
clean=$(grep -l ' 0 findings of 0 causes$' "${drivers[@]}" | wc -l)
say "$clean of ${#drivers[@]} drivers found nothing in $minutes minute(s)"
((clean == ${#drivers[@]})) || exit 1
