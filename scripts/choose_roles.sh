#!/usr/bin/env bash
# Which ranks should be GPs and which Renderers:  scripts/choose_roles.sh N VOLUME [OPTION...]
#
# Prints the frame time predicted for every way to give N ranks their roles, best first. Options are those of `ringsplat info`: the view and the
# picture as for `ringsplat render`, --cores C for the cores that the ranks share, or --machine FILE for a machine of mpi_configs/machines.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

(($# > 1)) || die "say how many ranks and what to render: scripts/choose_roles.sh 16 tests/data/head.nrrd"
build=${RINGSPLAT_BUILD:-$build}
[[ -n ${RINGSPLAT_BUILD:-} ]] || build_ringsplat ringsplat_cli
ranks=$1
volume=$2
shift 2
exec "$build/ringsplat" info "$volume" --ranks "$ranks" "$@"
