#!/usr/bin/env bash
# A run that ends in the middle of a file leaves nothing, or nothing that the next run does not remove:
#   interrupted_writes.sh MPIEXEC PROGRAM VOLUME SCRATCH
set -u
mpiexec=$1 program=$2 volume=$3 scratch=$4
rm -rf "$scratch" && mkdir -p "$scratch/out"
trap 'kill -KILL $(jobs -p) 2>/dev/null' EXIT
fail() {
  echo "FAILED: $*" >&2
  ls -lA "$scratch/out" >&2
  cat "$scratch/log" >&2
  exit 1
}

# hidden [PID]: lists the hidden files, all or a process's.
hidden() { find "$scratch/out" -name ".*${1:+_$1-}*" -type f; }

# until_hidden LAUNCHED [PID]: waits until a launched process, or PID, has begun a file.
until_hidden() {
  until [[ -n $(hidden ${2:-}) ]]; do
    kill -0 "$1" 2>/dev/null || fail "the run ended before it was disturbed"
    sleep 0.02
  done
}

# begin_volume: starts writing a large volume over an old one, and returns once the file has begun.
begin_volume() {
  echo old >"$scratch/out/v.nrrd"
  "$program" synth marschner-lobb --dims 600x600x600 --type float32 -o "$scratch/out/v.nrrd" \
    >"$scratch/log" 2>&1 &
  writer=$!
  until_hidden $writer $writer
}

# UCX, part of some MPIs, handles SIGHUP from before main() on, even when it should be ignored.
export UCX_DEBUG_SIGNO=0
declare -A status=([HUP]=129 [INT]=130 [QUIT]=131 [PIPE]=141 [TERM]=143 [XCPU]=152)
for signal in HUP INT QUIT PIPE TERM XCPU; do
  # A shell's background jobs ignore INT and QUIT, and so would the program.
  set -m
  begin_volume
  set +m
  kill "-$signal" $writer
  wait $writer 2>/dev/null
  code=$?
  ((code == ${status[$signal]})) || fail "SIG$signal ended the run with $code, not ${status[$signal]}"
  [[ -z $(hidden) ]] || fail "SIG$signal left a hidden file"
  [[ $(cat "$scratch/out/v.nrrd") == old ]] || fail "SIG$signal touched the old file"
done

# Ignored signals stay ignored.
(trap '' HUP && exec "$program" synth marschner-lobb --dims 160x160x160 --type float32 -o "$scratch/out/nohup.nrrd") \
  >"$scratch/log" 2>&1 &
writer=$!
until_hidden $writer $writer
kill -HUP $writer
wait $writer || fail "nohup did not help"
[[ -s $scratch/out/nohup.nrrd ]] || fail "nohup's file is missing"
rm "$scratch/out/nohup.nrrd"

# An orbit on ranks: complete pictures stay, and nothing else.
"$mpiexec" -n 3 "$program" render "$volume" --gps 2 --renderers 1 --orbit 100000 --size 512 \
  -o "$scratch/out/f.exr" >"$scratch/log" 2>&1 &
launcher=$!
until_hidden $launcher
until [[ -s $scratch/out/f-0001.exr ]]; do sleep 0.02; done
kill -TERM $launcher
wait $launcher
[[ -z $(hidden) ]] || fail "a launcher that was terminated left a hidden file"
for picture in "$scratch"/out/f-*.exr; do
  "$program" compare "$picture" "$picture" >/dev/null 2>>"$scratch/log" || fail "$picture is not whole"
done

# A killed run leaves a file. The next run removes it, but not the file of a living process.
begin_volume
kill -KILL $writer
wait $writer 2>/dev/null
stale=$(hidden)
[[ -n $stale ]] || fail "SIGKILL left nothing to be removed"
begin_volume
[[ ! -e $stale ]] || fail "the next run did not remove $stale"
kill -STOP $writer
living=$(hidden)
"$program" render "$volume" --size 16 -o "$scratch/out/p.png" >"$scratch/log" 2>&1 || fail "render failed"
[[ $(hidden) == "$living" ]] || fail "the file of a process that lives was removed"
kill -KILL $writer
wait $writer 2>/dev/null
"$program" info "$volume" >/dev/null && [[ -e $living ]] || fail "a run that writes nothing removed $living"
"$program" render "$volume" --size 16 -o "$scratch/out/p.png" >"$scratch/log" 2>&1 || fail "render failed"
[[ -z $(hidden) ]] || fail "what a killed process left is still there"
rm -r "$scratch"
echo "interrupted writes left nothing"
