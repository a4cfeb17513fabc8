#!/usr/bin/env bash
# Installs what Ringsplat needs on Debian 12 (as root or with sudo), and only what is missing.
#
#   scripts/setup.sh            what building, drawing and all tests need
#   scripts/setup.sh --drawing  only what building and drawing need
#   scripts/setup.sh --mpich    MPICH too, beside Open MPI, for scripts/check.sh
#   scripts/setup.sh --release  what a release takes, too: scripts/package.sh and the API reference
#   scripts/setup.sh --check    installs nothing, says what is missing; exit 1 when something is
#   scripts/setup.sh --list     installs nothing, prints the packages and what they are for
#
# RINGSPLAT_SKIP_SETUP=1 makes it do nothing, for machines that have the libraries from elsewhere.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

# The only list of what Ringsplat needs by Debian's names: packages, and what for.
drawing=(
  "g++ cmake ninja-build pkg-config ccache: the build"
  "libopenmpi-dev openmpi-bin: MPI"
  "libglm-dev libhwy-dev libfmt-dev libcli11-dev nlohmann-json3-dev zlib1g-dev libtbb-dev libboost-dev: everything"
  "libopenimageio-dev fonts-dejavu-core: pictures, and text in them"
  "libturbojpeg0-dev: JPEGs of the viewer's server"
  "libgdcm-dev: DICOM"
  "libtiff-dev: TIFF"
  "libhdf5-dev: HDF5"
  "libexpat1-dev liblz4-dev liblzma-dev: VTK's XML"
  "libblosc-dev libzstd-dev: Zarr"
)
tests=("catch2: tests")
# Without these the tests that need them are skipped and say so.
optional=(
  "libsimgrid-dev: simulated machines"
  "python3 python3-numpy python3-matplotlib: studies and their plots"
  "python3-venv: packages of PyPI for studies and for the Python module"
  "python3-dev: the Python module"
  "chromium chromium-driver python3-selenium: tests of the viewer's page"
  "ffmpeg: films as MP4"
  "gfortran: the example in Fortran"
  "iproute2: tests on several machines"
)
mpich=("libmpich-dev mpich: a second MPI")
release=("dpkg-dev file debootstrap doxygen: a release")

required=("${drawing[@]}" "${tests[@]}") check=0 list=0
for word; do
  case $word in
    --drawing) required=("${drawing[@]}") optional=() ;;
    --check) check=1 ;;
    --list) list=1 ;;
    --mpich) required+=("${mpich[@]}") ;;
    --release) required+=("${release[@]}") ;;
    *) die "setup.sh does not know $word; it knows --drawing, --mpich, --release, --check and --list" ;;
  esac
done

# The packages of a list's lines.
packages() { printf '%s\n' "${@%%:*}" | tr ' ' '\n' | sed '/^$/d'; }

missing() {
  local package
  for package in "$@"; do
    [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || printf '%s\n' "$package"
  done
}

need_debian() {
  command -v apt-get >/dev/null && command -v dpkg-query >/dev/null && return
  say "This script knows Debian and its relatives only. Ringsplat needs, by their Debian 12 names:"
  printf '  %s\n' "${required[@]}" "${optional[@]}" >&2
  die "install them, then call this again with RINGSPLAT_SKIP_SETUP=1"
}

as_root() {
  if ((EUID == 0)); then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    die "root is needed to install packages and there is no sudo; as root: apt-get install ${needed[*]}"
  fi
}

install() { as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@" >&2; }

if ((list)); then
  printf '%s\n' "${required[@]}" "${optional[@]}"
  exit
fi
[[ ${RINGSPLAT_SKIP_SETUP:-} != 1 ]] || exit 0
need_debian
mapfile -t needed < <(missing $(packages "${required[@]}"))
mapfile -t wanted < <(missing $(packages "${optional[@]}"))
((${#needed[@]} + ${#wanted[@]} > 0)) || exit 0

if ((check)); then
  say "missing: ${needed[*]} ${wanted[*]}"
  exit 1
fi

say "installing: ${needed[*]} ${wanted[*]}"
as_root apt-get update -q >&2 || say "the package lists could not be brought up to date; trying with those there are"
if ((${#needed[@]} > 0)); then
  install "${needed[@]}" || die "apt-get could not install: ${needed[*]}"
fi
for package in "${wanted[@]}"; do
  install "$package" || say "could not install $package: what needs it will be left out"
done
