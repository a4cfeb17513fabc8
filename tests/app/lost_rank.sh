#!/usr/bin/env bash
# A rank that dies or stops in mid-frame ends the job with a message:  lost_rank.sh MPIEXEC PROGRAM VOLUME SCRATCH
set -u
mpiexec=$1 program=$2 volume=$3 scratch=$4
rm -rf "$scratch" && mkdir -p "$scratch"
fail() {
  echo "FAILED: $*" >&2
  cat "$scratch/log" >&2
  exit 1
}

# lose SIGNAL: starts an orbit, sends SIGNAL to its last rank once frames come, and waits for the job's end.
# Leaves its exit code in `code` and the seconds from the signal to the end in `took`.
lose() {
  local signal=$1 launcher victim started
  : >"$scratch/out"
  "$mpiexec" -n 3 "$program" render "$volume" --gps 2 --renderers 1 --orbit 100000 --size 128 \
    --stall-timeout 2 -o "$scratch/f.exr" >"$scratch/out" 2>"$scratch/log" &
  launcher=$!
  until [[ $(wc -l <"$scratch/out") -ge 3 ]]; do
    kill -0 $launcher 2>/dev/null || fail "the job ended before it was disturbed"
    sleep 0.05
  done
  victim=$(pgrep -P $launcher | tail -n 1)
  kill "-$signal" "$victim"
  started=$EPOCHREALTIME
  wait $launcher
  code=$?
  took=$(awk -v a="$started" -v b="$EPOCHREALTIME" 'BEGIN { print b - a }')
  kill -KILL "$victim" 2>/dev/null
  awk -v t="$took" 'BEGIN { exit !(t < 10) }' || fail "after SIG$signal the job took $took s to end"
  ((code != 0)) || fail "after SIG$signal the job's exit code was 0"
}

lose KILL
grep -qiE "signal 9|killed" "$scratch/log" || fail "nobody said that a rank was killed"

lose STOP
((code == 3)) || fail "a stalled job ended with $code, not 3"
grep -q "waits for" "$scratch/log" || fail "the watchdog did not say who waits for whom"
find "$scratch" -name '*.exr*' ! -name 'f-*.exr' | grep -q . && fail "half-written pictures were left behind"
echo "a killed and a stopped rank each ended the job"
