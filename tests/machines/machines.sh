#!/usr/bin/env bash
# Runs jobs on several machines, which are network namespaces joined by a bridge:
#   machines.sh CASE MPIEXEC PROGRAM SCRATCH
# Exit code 77, and a line that says why, where the kernel does not let this be done.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source-path=SCRIPTDIR source=hosts.sh
source "$here/hosts.sh"
# shellcheck source-path=SCRIPTDIR source=../support/launcher.sh
source "$here/../support/launcher.sh"
case=$1 mpiexec=$2 program=$3 scratch=$4
launcher=''

skip() {
  echo "skipped: $*"
  exit 77
}

fail() {
  echo "FAILED: $case: $*" >&2
  tail -n 60 "$scratch/log" >&2
  exit 1 # the namespace's other processes end with this one
}

if [[ -z ${RINGSPLAT_OWN_NAMESPACES:-} ]]; then
  "$mpiexec" --version 2>&1 | grep -qE '(Open MPI|OpenRTE)\) 4' || skip "hosts are started through the agent of Open MPI 4"
  in_own_namespaces "$0" "$@"
  skip "this kernel lets nobody make network namespaces and bridges here (or iproute2 is missing)"
fi

# The agent is root inside the namespaces, whoever that is outside.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
rm -rf "$scratch" && mkdir -p "$scratch/pictures" && cd "$scratch" || exit 1
: >log
# Sockets in the folders that Open MPI makes have short names only.
TMPDIR=$(mktemp -d)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT

network=(
  --mca plm_rsh_agent "$here/on_host.sh" --mca oob_tcp_if_include eth0
  --mca btl_tcp_if_include eth0 --mca btl 'self,vader,tcp' --mca pml ob1
)

# launch RANKS SLOTS OPTION...: the program on that many ranks, SLOTS to a host; mpirun runs on host1.
launch() {
  local ranks=$1 slots=$2 k
  shift 2
  for ((k = 1; k <= hosts; ++k)); do echo "host$k slots=$slots"; done >hostfile
  exec "$here/on_host.sh" host1 "$(printf '%q ' "$mpiexec" --hostfile hostfile "${network[@]}" -n "$ranks" "$program" render volume.nrrd "$@")"
}

make_volume() { "$program" synth shell -o volume.nrrd --dims 48x48x48 --no-compression >/dev/null 2>>log || fail "no volume could be made"; }

# same_bits: every layout with both engines, and that all hosts took part.
same_bits() {
  local quality layout picture k before=()
  local -A layouts=([ring]='--gps 4 --renderers 2' [mesh]='--topology mesh --mesh 2x2 --renderers 2'
    [colocated]='--roles colocated --gps 6 --renderers 6')
  for quality in paper best; do
    local view=(--size 96x80 --region 32 --azimuth 35 --elevation 20 --tf mr-soft --quality "$quality")
    "$program" render volume.nrrd "${view[@]}" -o alone.exr >/dev/null 2>>log || fail "the volume cannot be rendered"
    for layout in "${!layouts[@]}"; do
      for ((k = 1; k <= hosts; ++k)); do before[k]=$(bytes_through "host$k"); done
      picture=pictures/$quality-$layout.exr
      # shellcheck disable=SC2086  # words
      (launch 6 $((6 / hosts)) "${view[@]}" ${layouts[$layout]} -o "$picture") >>log 2>&1 || fail "$layout, $quality: the job failed"
      cmp alone.exr "$picture" || fail "$layout, $quality: not the bits of one process"
      for ((k = 1; k <= hosts; ++k)); do
        (($(bytes_through "host$k") - before[k] > 30000)) || fail "$layout, $quality: host$k sent hardly anything over the network"
      done
    done
  done
}

rank_pid() {
  local pid
  for pid in $(pgrep -x -f "$program render.*"); do
    tr '\0' '\n' <"/proc/$pid/environ" 2>/dev/null | grep -qx "OMPI_COMM_WORLD_RANK=$1" && echo "$pid" && return
  done
  fail "no process of rank $1 was found"
}

# start: a long job of 3 GPs and a Renderer, two ranks on either host, which has written pictures when this returns.
start() {
  : >out
  (launch 4 2 --gps 3 --renderers 1 --size 64 --orbit 100000 --stall-timeout 3 -o pictures/f.exr) >out 2>log </dev/null &
  launcher=$!
  for _ in {1..600}; do
    (($(wc -l <out) >= 3)) && return
    kill -0 "$launcher" 2>/dev/null || fail "the job ended before it was disturbed"
    sleep 0.05
  done
  fail "no picture came"
}

# ends_within SECONDS: leaves the launcher's exit code in `code`.
ends_within() {
  await_launcher "$launcher" log "$1" || fail "the job goes on after $1 s"
}

ranks_end() {
  for _ in {1..300}; do
    pgrep -f "$program render" >/dev/null || return 0
    sleep 0.1
  done
  fail "ranks go on without their job"
}

must_say() { grep -qE "$1" log || fail "nobody said '$1'"; }
must_end_with() { ((code == $1 || code == -1)) || fail "the exit code is $code, not $1"; }

case $case in
  bits_2 | bits_3) hosts=${case#bits_} ;;
  *) hosts=2 ;;
esac
make_hosts "$hosts" "$scratch" || fail "the hosts could not be made"
make_volume

case $case in
  bits_*) same_bits ;;
  stopped_rank)
    start
    kill -STOP "$(rank_pid 2)"
    ends_within 60
    must_end_with 3
    must_say 'rank [013] is stalled: .* waits for'
    ranks_end
    ;;
  killed_rank)
    start
    kill -KILL "$(rank_pid 2)"
    ends_within 60
    must_end_with 137
    must_say 'process rank 2 .* on node host2 exited on signal 9'
    ranks_end
    ;;
  lost_host)
    start
    ranks=("$(rank_pid 2)" "$(rank_pid 3)")
    # Were ranks lost at the same moment, mpirun might only say that it cannot route a message there.
    kill -KILL "$(pgrep -x orted)"
    for _ in {1..100}; do grep -q 'lost communication' log && break || sleep 0.05; done
    kill -KILL "${ranks[@]}" 2>/dev/null
    ends_within 60
    ((code != 0)) || fail "the exit code is 0"
    must_say 'lost communication with a remote daemon'
    must_say 'on node host2'
    ranks_end
    ;;
  cut_off)
    # The launcher cannot tell the other host that the job is over, and takes that for a slow network: it goes on
    # until TCP gives the connection up. docs/faults.md names the settings.
    for k in 1 2; do ip netns exec "host$k" sysctl -q -w net.ipv4.tcp_retries2=5; done
    start
    ip link set to_host2 down
    ends_within 90
    must_end_with 3
    must_say 'rank [01] is stalled: .* waits for'
    ranks_end
    ;;
  *) fail "there is no such case" ;;
esac
echo "$case: as documented"
rm -rf "$scratch"
