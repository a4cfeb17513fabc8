#!/usr/bin/env bash
# Does one thing to a running job that must not happen:  faults.sh CASE MPIEXEC PROGRAM READ_FAULTS_LIBRARY SCRATCH
# The job must end soon, with the exit code and the words that docs/faults.md ("What happens when") promises. What it
# leaves are whole pictures and no processes.
set -u
fault=$1 mpiexec=$2 program=$3 library=$4 scratch=$5
# shellcheck source=tests/support/launcher.sh
. "$(dirname "$0")/../support/launcher.sh"
rm -rf "$scratch" && mkdir -p "$scratch/pictures" && cd "$scratch" || exit 1
launcher='' everyone=''

fail() {
  echo "FAILED: $fault: $*" >&2
  tail -n 40 log >&2
  # shellcheck disable=SC2086
  [[ -z $everyone ]] || kill -KILL $launcher $everyone 2>/dev/null
  exit 1
}

skip() {
  echo "skipped: $*"
  rm -rf "$scratch"
  exit 0
}

descendants() {
  local child
  for child in $(pgrep -P "$1"); do
    echo "$child"
    descendants "$child"
  done
}

# rank_pid RANK: its process, by what Open MPI and MPICH tell their ranks.
rank_pid() {
  local pid
  for pid in $everyone; do
    tr '\0' '\n' <"/proc/$pid/environ" 2>/dev/null | grep -qxE "(OMPI_COMM_WORLD_RANK|PMI_RANK)=$1" && echo "$pid" && return
  done
  fail "no process of rank $1 was found"
}

make_volume() { "$program" synth shell -o "$1" --dims 48x48x48 --no-compression >/dev/null 2>log || fail "no volume could be made"; }

# start RANKS OPTION...: a long job, which has written pictures when this returns.
start() {
  local ranks=$1
  shift
  make_volume volume.nrrd
  "$mpiexec" -n "$ranks" "$program" render volume.nrrd --size 64 -o pictures/f.exr "$@" >out 2>log </dev/null &
  launcher=$!
  for _ in {1..600}; do
    [[ -f out ]] && (($(wc -l <out) >= 3)) && break
    kill -0 "$launcher" 2>/dev/null || fail "the job ended before it was disturbed"
    sleep 0.05
  done
  (($(wc -l <out) >= 3)) || fail "no picture came"
  everyone=$(descendants "$launcher")
}

# Waits for the job's end, and leaves its exit code in `code`.
await_end() {
  local pid
  await_launcher "$launcher" log 60 || fail "the job goes on after a minute"
  for pid in $everyone; do
    for _ in {1..50}; do
      grep -qsv '^[0-9]* (.*) Z' "/proc/$pid/stat" || continue 2
      sleep 0.1
    done
    fail "process $pid goes on without its job"
  done
}

must_say() { grep -qE "$1" log out || fail "nobody said '$1'"; } # MPICH says on stdout how a rank ended
must_end_with() { ((code == $1 || code == -1)) || fail "the exit code is $code, not $1"; }

# The job's last pictures can be read, and the next run leaves no unfinished ones behind.
check_pictures() {
  local picture
  for picture in $(find pictures -name 'f-*.exr' | sort | tail -n 2); do
    "$program" compare "$picture" "$picture" >/dev/null 2>log || fail "$picture is no whole picture"
  done
  "$program" render volume.nrrd --size 64 -o pictures/next.exr >/dev/null 2>log || fail "the next run failed"
  [[ -z $(find pictures -name '.*' -type f) ]] || fail "unfinished pictures are left: $(ls -A pictures | grep '^\.')"
}

# lose SIGNAL RANK: of 2 GPs, the first with the frame buffer, and a Renderer.
lose() {
  start 3 --gps 2 --renderers 1 --orbit 100000 --stall-timeout 3
  kill "-$1" "$(rank_pid "$2")" || fail "no signal could be sent"
  [[ $1 != STOP || $2 != 0 ]] || catch_amid_frame
  await_end
}

# Rank 0 may have been stopped when nobody waited for it. Then it goes on for a moment.
catch_amid_frame() {
  for _ in {1..5}; do
    sleep 5
    kill -0 "$launcher" 2>/dev/null || return
    kill -CONT "$(rank_pid 0)" && sleep 0.02 && kill -STOP "$(rank_pid 0)"
  done
}

killed() {
  lose KILL "$1"
  ((code != 0)) || fail "the exit code is 0"
  must_say 'signal 9|[Kk]illed|KILLED|EXIT CODE: 9'
  check_pictures
}

stopped() {
  lose STOP "$1"
  must_end_with 3
  must_say 'rank [012] is stalled: .* waits for'
  ! grep -qE 'rank ([0-9]):? rank \1|rank ([0-9])\]: error: rank \2: ' log || fail "a rank was named twice"
  check_pictures
}

# start_with_idle_rank VIEWS: more ranks than cores, of which --gps auto leaves the last idle.
start_with_idle_rank() {
  local ranks=$(($(nproc) + 2))
  start "$ranks" --gps auto --orbit "$1" --stall-timeout 3
  grep -qE 'chose .* [0-9]+ idle' log && idle=$((ranks - 1)) && return
  # shellcheck disable=SC2086
  kill -KILL $launcher $everyone
  skip "no rank was left idle on this machine"
}

# read_while_rank_1 FAULT OPTION...: begins to render; rank 1 hangs or stops before it reads slice 24.
read_while_rank_1() {
  local fault=$1 slices=$((48 * 48 * 48))
  shift
  make_volume volume.nrrd
  local at=$(($(stat -c %s volume.nrrd) - slices + slices / 2))
  "$mpiexec" -n 3 env FAULT="$fault" FAULT_RANK=1 FAULT_AT=$at LD_PRELOAD="${LD_PRELOAD:+$LD_PRELOAD:}$library" "$program" \
    render volume.nrrd --gps 2 --renderers 1 --bundle 24 --size 64 -o pictures/f.exr --stall-timeout 3 "$@" >out 2>log </dev/null &
  launcher=$!
}

# await_words WORDS: until somebody has said them.
await_words() {
  for _ in {1..600}; do
    grep -qE "$1" log && everyone=$(descendants "$launcher") && return
    kill -0 "$launcher" 2>/dev/null || break
    sleep 0.1
  done
  fail "nobody said '$1'"
}

# read_while FAULT: renders while something is done to the volume's file before its slice 24 is read.
read_while() {
  local slices=$((48 * 48 * 48))
  make_volume volume.nrrd
  "$program" render volume.nrrd --size 64 -o right.exr >/dev/null 2>log || fail "the volume cannot be rendered"
  local at=$(($(stat -c %s volume.nrrd) - slices + slices / 2))
  "$mpiexec" -n 3 env FAULT="$1" FAULT_AT=$at LD_PRELOAD="${LD_PRELOAD:+$LD_PRELOAD:}$library" "$program" \
    render volume.nrrd --gps 2 --renderers 1 --size 64 -o pictures/f.exr >out 2>log </dev/null
  code=$?
}

refused() {
  must_end_with 2
  must_say "$1"
  (($(grep -c 'error:' log) == 1)) || fail "there is not one line of error"
  [[ -z $(ls -A pictures) ]] || fail "a picture was written"
}

case $fault in
  killed_gp) killed 1 ;;
  killed_renderer) killed 2 ;;
  killed_rank_0) killed 0 ;;
  killed_idle)
    start_with_idle_rank 100000
    kill -KILL "$(rank_pid "$idle")"
    await_end
    ((code != 0)) || fail "the exit code is 0"
    must_say 'signal 9|[Kk]illed|KILLED|EXIT CODE: 9'
    check_pictures
    ;;
  stopped_gp) stopped 1 ;;
  stopped_renderer) stopped 2 ;;
  stopped_rank_0) stopped 0 ;;
  stopped_idle)
    start_with_idle_rank 200
    kill -STOP "$(rank_pid "$idle")"
    await_end
    must_end_with 3
    must_say "rank $idle has been silent after the last frame, of which all is written, for [0-9]+ s and does not answer"
    (($(find pictures -name 'f-*.exr' | wc -l) == 200)) || fail "pictures are missing"
    check_pictures
    ;;
  suspended)
    start 3 --gps 2 --renderers 1 --orbit 120 --stall-timeout 1
    for _ in {1..4}; do # at least once while a rank waits for another
      for pid in $everyone; do kill -STOP "$pid"; done
      sleep 2
      for pid in $everyone; do kill -CONT "$pid"; done
      sleep 0.05
    done
    await_end
    must_end_with 0
    (($(find pictures -name 'f-*.exr' | wc -l) == 120)) || fail "pictures are missing"
    ;;
  terminated_rank)
    lose TERM 1
    ((code != 0)) || fail "the exit code is 0"
    must_say 'signal 15|[Tt]erminated|TERMINATED|EXIT CODE: 15'
    check_pictures
    ;;
  terminated_launcher)
    start 3 --gps 2 --renderers 1 --orbit 100000
    kill -TERM "$launcher"
    await_end
    ((code != 0)) || fail "the exit code is 0"
    check_pictures
    ;;
  hanging_file)
    read_while_rank_1 hang
    await_end
    must_end_with 3
    must_say 'error: rank 1 has been reading volume.nrrd for 3 s; hint'
    ;;
  hanging_file_awaited)
    read_while_rank_1 hang --stall-action wait
    await_words 'warning: rank 1 has been reading volume.nrrd for 3 s; the others wait'
    kill -TERM "$launcher"
    await_end
    ;;
  stopped_reader)
    read_while_rank_1 stop
    await_end
    must_end_with 3
    must_say 'error: .*rank 1 has been reading volume.nrrd for [0-9]+ s and does not answer'
    ;;
  stopped_reader_awaited)
    read_while_rank_1 stop --stall-action wait
    await_words 'warning: rank 1 has been reading volume.nrrd for [0-9]+ s and does not answer; the others wait'
    kill -CONT "$(rank_pid 1)"
    await_end
    must_end_with 0
    [[ -s pictures/f.exr ]] || fail "there is no picture"
    ;;
  truncated_file)
    read_while truncate
    refused 'volume.nrrd has changed since it was opened: .* bytes instead of'
    ;;
  changed_file)
    read_while change
    refused 'volume.nrrd has changed since it was opened: other bytes'
    ;;
  removed_file)
    read_while remove
    must_end_with 0
    [[ ! -e volume.nrrd ]] || fail "the file was not removed"
    "$program" compare pictures/f.exr right.exr --fail-above 0 >/dev/null || fail "the picture is another one"
    ;;
  blind_rank)
    make_volume volume.nrrd
    mkdir sees blind
    mv volume.nrrd sees/
    job=("$program" render volume.nrrd --gps 2 --renderers 1 -o "$scratch/pictures/f.exr")
    "$mpiexec" -n 1 --wdir "$scratch/sees" "${job[@]}" : -n 2 --wdir "$scratch/blind" "${job[@]}" >out 2>log </dev/null
    code=$?
    refused 'cannot open volume.nrrd.*rank 1'
    ;;
  *) fail "there is no such case" ;;
esac
echo "$fault: as documented, exit code $code"
rm -rf "$scratch"
