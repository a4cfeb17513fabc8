#!/usr/bin/env bash
# Installs what is missing, then builds and tests Ringsplat in every way, one after another, each in its own folder below build:
#
#   scripts/check.sh                 release, asan, tsan, mpich and minimal; this may take hours
#   scripts/check.sh asan mpich      only these
#   scripts/check.sh smoke           minutes: the rooms base and net under asan, threads that share work under tsan
#
# Goes on after a failure. Says at the end what passed; exit 1 when something failed.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

summary=() failed=0

# attempt PRESET TESTS [TARGET...]: configures, builds the preset's targets or those named, and runs its tests
# whose names match TESTS.
attempt() {
  local preset=$1 tests=$2 results=$repo/build/$1/check.xml verdict=passed seconds=$SECONDS
  shift 2
  local targets=() launch=()
  (($# == 0)) || targets=(--target "$@")
  [[ $preset != tsan ]] || mapfile -t launch < <(tsan_launch)
  say "$preset: building and testing in build/$preset"
  rm -f "$results"
  if ! (cd "$repo" && cmake --preset "$preset" && cmake --build --preset "$preset" "${targets[@]}" &&
    "${launch[@]}" ctest --preset "$preset" --tests-regex "$tests" --parallel "$(cores)" --no-tests=error \
      --output-junit "$results") >&2; then
    verdict=FAILED
    failed=1
  fi
  summary+=("$(printf '%-8s %s  %s, %d s' "$preset" "$verdict" "$(counts "$results")" $((SECONDS - seconds)))")
}

# counts JUNIT_FILE: how many tests passed, were skipped and failed, and the names of the latter.
counts() {
  [[ -f $1 ]] || { echo "nothing was tested, as it was not built" && return; }
  local text
  text=$(tr '\n\t' '  ' <"$1" | sed 's/<testcase/\n<testcase/g')
  attribute() { sed -n "1s/.* $1=\"\([0-9]*\)\".*/\1/p" <<<"$text"; }
  local all failures skipped
  all=$(attribute tests) failures=$(attribute failures) skipped=$(attribute skipped)
  printf '%d passed, %d skipped, %d failed' $((all - failures - skipped)) "$skipped" "$failures"
  ((failures == 0)) || sed -n 's/^<testcase name="\([^"]*\)".*status="fail".*/\1/p' <<<"$text" | paste -sd ' ' | sed 's/^/: /' | tr -d '\n'
}

# GCC 12's ThreadSanitizer does not start where addresses are as random as newer kernels make them.
tsan_launch() {
  local bits
  bits=$(cat /proc/sys/vm/mmap_rnd_bits 2>/dev/null) || bits=0
  if ((bits > 28)) && setarch "$(uname -m)" -R true 2>/dev/null; then
    printf '%s\n' setarch "$(uname -m)" -R
  fi
}

(($# > 0)) || set -- release asan tsan mpich minimal
for name; do
  case $name in
    release | asan | tsan | mpich | minimal | smoke) ;;
    *) die "there is no check '$name'; there are release, asan, tsan, mpich, minimal and smoke" ;;
  esac
done
if [[ " $* " == *" mpich "* ]]; then
  "$repo/scripts/setup.sh" --mpich
else
  "$repo/scripts/setup.sh"
fi
python3 -B "$repo/tests/python/make.py" "$repo/build/python" || say "Python's module is left out"
for name; do
  case $name in
    smoke)
      attempt asan '^(base|net)$' test_base test_net
      attempt tsan '^base_threads$' test_base
      ;;
    *) attempt "$name" . ;;
  esac
done
printf 'ringsplat: %s\n' "${summary[@]}"
exit "$failed"
