#!/usr/bin/env bash
# Installs what Ringsplat needs on Debian 12 (as root or with sudo), and only what is missing.
#
#   scripts/setup.sh            install
#   scripts/setup.sh --check    only say what is missing; exit 1 when something is
#   scripts/setup.sh --mpich    MPICH too, beside Open MPI, for scripts/check.sh
#   scripts/setup.sh --release  what a release takes, too: scripts/package.sh and the API reference
#   scripts/setup.sh --required only what the build and the tests need
#
# RINGSPLAT_SKIP_SETUP=1 makes it do nothing, for machines that have the libraries from elsewhere.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

required=(
  g++ cmake ninja-build pkg-config ccache     # the build
  libopenmpi-dev openmpi-bin                  # MPI
  libglm-dev libhwy-dev libfmt-dev libspdlog-dev libcli11-dev nlohmann-json3-dev zlib1g-dev libtbb-dev
  libopenimageio-dev fonts-dejavu-core        # pictures, and text in them
  libpng-dev                                  # pictures in builds without OpenImageIO
  libboost-dev libturbojpeg0-dev              # the viewer's server and its JPEGs
  libinsighttoolkit5-dev libhdf5-dev          # volumes
  libexpat1-dev liblz4-dev liblzma-dev        # volumes of VTK
  catch2                                      # tests
)
# Without these the program and its tests build and run; the scripts that need them say so.
optional=(
  libsimgrid-dev                              # simulated machines
  python3 python3-numpy python3-matplotlib    # plots
  python3-venv                                # SSIM and FLIP, which scripts/accuracy.sh takes from PyPI
  python3-dev                                 # Python's module; nanobind and its tests' packages come from PyPI
  chromium chromium-driver python3-selenium   # tests of the viewer's page
  ffmpeg                                      # the viewer's films as MP4
  iproute2                                    # tests on several machines
)

mpich=(libmpich-dev mpich)
release=(dpkg-dev file debootstrap doxygen)

check=0
for word; do
  case $word in
    --check) check=1 ;;
    --mpich) required+=("${mpich[@]}") ;;
    --release) required+=("${release[@]}") ;;
    --required) optional=() ;;
    *) die "setup.sh does not know $word; it knows --check, --mpich, --release and --required" ;;
  esac
done

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
  ((${#optional[@]} == 0)) || say "(the last ${#optional[@]} are for simulations, plots, films and tests in a browser)"
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

[[ ${RINGSPLAT_SKIP_SETUP:-} != 1 ]] || exit 0
need_debian
mapfile -t needed < <(missing "${required[@]}")
mapfile -t wanted < <(missing "${optional[@]}")
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
