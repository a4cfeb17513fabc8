# shellcheck shell=bash
# What the scripts share; sourced, not run.

repo=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build="$repo/build/release"

# Builds with the same flags in several folders share what ccache keeps; who has configured it knows better.
if command -v ccache >/dev/null && [[ -z $(ccache --get-config base_dir) ]]; then
  export CCACHE_BASEDIR=$repo CCACHE_NOHASHDIR=1
fi

say() { printf 'ringsplat: %s\n' "$*" >&2; }
die() {
  say "$*"
  exit 1
}

# Physical cores this process may use: what Open MPI counts as slots, capped by the scheduler's affinity.
cores() {
  local allowed physical
  allowed=$(nproc)
  physical=$(lscpu -p=CORE,SOCKET 2>/dev/null | grep -v '^#' | sort -u | wc -l)
  echo $((physical > 0 && physical < allowed ? physical : allowed))
}

# build_ringsplat TARGET...: configures when that has not been done, then builds.
build_ringsplat() (
  cd "$repo" || exit
  [[ -f $build/build.ninja ]] || cmake --preset release >&2 || exit
  cmake --build --preset release --target "$@" >&2
)

# allow_ranks N: lets this user's mpirun start N ranks on this machine, as root too and however few cores there are.
# (Open MPI 4 and 5; others do without.)
allow_ranks() {
  if ((EUID == 0)); then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  fi
  if (($1 > $(cores))); then
    export OMPI_MCA_rmaps_base_oversubscribe=1 PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
  fi
}

# run_ranks N PROGRAM...: with mpirun, or the launcher that RINGSPLAT_MPIEXEC names.
run_ranks() {
  allow_ranks "$1"
  "${RINGSPLAT_MPIEXEC:-mpirun}" -n "$@"
}
