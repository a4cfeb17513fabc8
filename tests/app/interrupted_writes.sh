#!/usr/bin/env bash
# A run that ends in the middle of a file leaves nothing but what was there:
#   interrupted_writes.sh MPIEXEC PROGRAM VOLUME SCRATCH
set -u
mpiexec=$1 program=$2 volume=$3 scratch=$4
# shellcheck source=tests/support/launcher.sh
. "$(dirname "$0")/../support/launcher.sh"
rm -rf "$scratch" && mkdir -p "$scratch/out"
trap 'kill -KILL $(jobs -p) 2>/dev/null' EXIT
fail() {
  echo "FAILED: $*" >&2
  ls -lA "$scratch/out" >&2
  cat "$scratch/log" >&2
  exit 1
}

# nothing_left: on disks whose files may be without a name, nothing stays of one that was not finished.
nothing_left() { [[ -z $named && -z $(find "$scratch/out" -name ".*" -type f) || -n $named ]]; }

# until_begun PID: waits until a process has begun a file.
named=
until_begun() {
  until ls -l "/proc/$1/fd" 2>/dev/null | grep -q "$scratch/out/#.*(deleted)"; do
    kill -0 "$1" 2>/dev/null || fail "the run ended before it was disturbed"
    [[ -z $(find "$scratch/out" -name ".ringsplat_$1-*") ]] || { named=yes && return; }
    sleep 0.02
  done
}

# begin_volume: starts writing a large volume over an old one, and returns once the file has begun.
begin_volume() {
  echo old >"$scratch/out/v.nrrd"
  "$program" synth marschner-lobb --dims 600x600x600 --type float32 -o "$scratch/out/v.nrrd" \
    >"$scratch/log" 2>&1 &
  writer=$!
  until_begun $writer
}

# UCX, part of some MPIs, handles SIGHUP from before main() on, even when it should be ignored.
export UCX_DEBUG_SIGNO=0
declare -A status=([HUP]=129 [INT]=130 [QUIT]=131 [PIPE]=141 [TERM]=143 [XCPU]=152 [KILL]=137)
for signal in HUP INT QUIT PIPE TERM XCPU KILL; do
  # A shell's background jobs ignore INT and QUIT, and so would the program.
  set -m
  begin_volume
  set +m
  kill "-$signal" $writer
  wait $writer 2>/dev/null
  code=$?
  ((code == ${status[$signal]})) || fail "SIG$signal ended the run with $code, not ${status[$signal]}"
  nothing_left || fail "SIG$signal left a file"
  [[ $(cat "$scratch/out/v.nrrd") == old ]] || fail "SIG$signal touched the old file"
done

# Ignored signals stay ignored.
(trap '' HUP && exec "$program" synth marschner-lobb --dims 160x160x160 --type float32 -o "$scratch/out/nohup.nrrd") \
  >"$scratch/log" 2>&1 &
writer=$!
until_begun $writer
kill -HUP $writer
wait $writer || fail "nohup did not help"
[[ -s $scratch/out/nohup.nrrd ]] || fail "nohup's file is missing"
rm "$scratch/out/nohup.nrrd"

# An orbit on ranks: complete pictures stay, and nothing else.
"$mpiexec" -n 3 "$program" render "$volume" --gps 2 --renderers 1 --orbit 100000 --size 512 \
  -o "$scratch/out/f.exr" >"$scratch/log" 2>&1 &
launcher=$!
until [[ -s $scratch/out/f-0001.exr ]]; do sleep 0.02; done
kill -TERM $launcher
await_launcher $launcher "$scratch/log" 60 || fail "a launcher that was terminated goes on"
nothing_left || fail "a launcher that was terminated left a file"
for picture in "$scratch"/out/f-*.exr; do
  "$program" compare "$picture" "$picture" >/dev/null 2>>"$scratch/log" || fail "$picture is not whole"
done

rm -r "$scratch"
echo "interrupted writes left nothing"
