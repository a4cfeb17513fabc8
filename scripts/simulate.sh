#!/usr/bin/env bash
# Runs the program on a simulated machine (SimGrid):
#
#   scripts/simulate.sh [--build] CONFIG.toml [OPTION...]
#
# --build builds what it needs first, in build/release.
# CONFIG is a --config file of `ringsplat render` whose machine, gps, renderers, topology, mesh and roles say what is simulated; the
# options that follow are the program's and come first. mpi_configs/simulated has configurations, docs/simulation.md the method.
# The seconds that are printed, and those in --stats, are seconds of the simulated machine.
#
#   RINGSPLAT_RANKS=N      how many ranks, with gps = "auto"
#   RINGSPLAT_MAP_BY=node  puts ranks on the hosts in turn, as mpirun --map-by node does; otherwise they fill one after another
#   RINGSPLAT_BUILD=FOLDER     another build than build/release
#   RINGSPLAT_OTHER=FILE.so    runs another program on the configuration's ranks, with the options and --machine FILE
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

build_first=
if [[ ${1:-} == --build ]]; then
  build_first=yes
  shift
fi
(($# > 0)) || die "say what to simulate: scripts/simulate.sh mpi_configs/simulated/pp5-20+4.toml"
command -v smpirun >/dev/null || die "SimGrid is not installed: scripts/setup.sh installs it (Debian: libsimgrid-dev)"
build=${RINGSPLAT_BUILD:-$build}
if [[ -n $build_first ]]; then build_ringsplat ringsplat_smpi ringsplat_platform; fi
[[ -e $build/ringsplat_smpi.so && -e $build/ringsplat_platform.so ]] ||
  die "$build has no program for simulated ranks; hint: scripts/simulate.sh --build ..."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 "$repo/scripts/studies/simulated_job.py" "$work/job" "$work/hosts" "$@" || exit 2
# RINGSPLAT_* for the platform, and `arguments` for the program.
source "$work/job"

# No host timing anywhere, and a network whose times are hops * latency + bytes / bandwidth.
exact=(
  --cfg=smpi/simulate-computation:no --cfg=smpi/wtime:0 --cfg=smpi/test:0 --cfg=smpi/async-small-thresh:0
  --cfg=network/model:CM02 --cfg=network/crosstraffic:no --cfg=network/TCP-gamma:1e15
  --cfg=smpi/coll-selector:ompi --cfg=smpi/bcast:binomial_tree
  --cfg=contexts/stack-size:1024 --log=root.thresh:critical
  # Ranks share the program's variables, which are the same for all.
  --cfg=smpi/privatization:no
)
status=0
program=("$build/ringsplat_smpi.so" render "${arguments[@]}")
if [[ -n ${RINGSPLAT_OTHER:-} ]]; then program=("$RINGSPLAT_OTHER" "${@:2}" --machine "$RINGSPLAT_MACHINE"); fi
smpirun -quiet -platform "$build/ringsplat_platform.so" -hostfile "$work/hosts" -np "$RINGSPLAT_RANKS" "${exact[@]}" \
  "${program[@]}" >"$work/out" || status=$?
# What smpirun says itself when a rank fails.
grep -v -e '^Execution failed' -e '--cfg=' "$work/out" || true
exit "$status"
