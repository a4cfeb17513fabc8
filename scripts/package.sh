#!/usr/bin/env bash
# Makes a Debian package of the release build, build/package/ringsplat_VERSION_ARCHITECTURE.deb, and tries it in a clean
# Debian 12: as root and with debootstrap it installs the package there with apt, renders on one process and on two
# ranks, removes it, and looks for what is left. Before a release; takes minutes.
#
#   scripts/package.sh             make the package and try it
#   scripts/package.sh --no-trial  only make it
#
# The clean system comes from this system's own sources, or from what RINGSPLAT_DEBIAN_MIRROR names.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

(($# == 0)) || [[ $* == --no-trial ]] || die "package.sh does not know $*; it knows --no-trial"
folder=$repo/build/package

make_package() {
  rm -f "$folder"/*.deb
  cmake --preset release -S "$repo" -B "$folder" -DRINGSPLAT_BUILD_TESTS=OFF -DRINGSPLAT_SIMULATION=OFF >&2
  cmake --build "$folder" >&2
  (cd "$folder" && cpack -G DEB >&2)
  package=$(echo "$folder"/*.deb)
  say "$package, $(du -k "$package" | cut -f1) KiB"
}

# Where apt takes Debian 12 from here.
find_mirror() {
  apt-get indextargets --format '$(ORIGIN) $(CODENAME) $(REPO_URI)' 'Created-By: Packages' 2>/dev/null |
    awk '$1 == "Debian" && $2 == "bookworm" { print $3; exit }'
}

# Why the package cannot be tried here; empty when it can.
no_trial_because() {
  if ((EUID != 0)); then
    echo "only root can make a clean Debian to try it in"
  elif ! command -v debootstrap >/dev/null; then
    echo "debootstrap is missing, which makes a clean Debian to try it in (scripts/setup.sh --release)"
  elif [[ -z $mirror ]]; then
    echo "this system has no source of Debian 12; RINGSPLAT_DEBIAN_MIRROR can name one"
  fi
}

# Removes the clean system, whatever became of the trial.
remove_system() {
  ! mountpoint -q "$system/proc" || umount "$system/proc"
  rm -rf --one-file-system "$system"
}

inside() { chroot "$system" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive HOME=/root \
  http_proxy="${http_proxy:-}" https_proxy="${https_proxy:-}" "$@"; }

# Files and folders of the package, by their names.
files_left() { find "$system" -xdev \( -path "$system/proc" -o -path "$system/tmp" -o -path "$system/var/cache" -o -path "$system/var/log" \) -prune -o -iname '*ringsplat*' -print; }

make_system() {
  system=$(mktemp -d "$folder/debian.XXXXXX")
  trap remove_system EXIT
  debootstrap --variant=minbase bookworm "$system" "$mirror" >"$folder/debootstrap.log" 2>&1 ||
    die "debootstrap failed; see $folder/debootstrap.log"
  chmod 755 "$system"
  cp -L /etc/resolv.conf "$system/etc/resolv.conf"
  mount -t proc proc "$system/proc"
  inside apt-get update -q >&2
}

try_package() {
  cp "$package" "$system/tmp/"
  inside apt-get install -y -q --no-install-recommends "/tmp/${package##*/}" openmpi-bin fonts-dejavu-core >"$folder/install.log" 2>&1 ||
    die "apt could not install it; see $folder/install.log"
  inside ringsplat --version
  inside bash -euc 'cd /tmp
    ringsplat synth shell -o shell.nrrd --dims 48
    ringsplat render shell.nrrd -o one.png --size 128 --annotate
    ringsplat render shell.nrrd -o alone.exr --size 128
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
    mpirun -n 2 ringsplat render shell.nrrd -o ranks.exr --size 128
    cmp alone.exr ranks.exr
    for file in man/man1/ringsplat.1 bash-completion/completions/ringsplat doc/ringsplat/LICENSE; do
      ls /usr/share/$file* >/dev/null
    done' >&2
  inside apt-get purge -y -q ringsplat >&2
  local left
  left=$(files_left)
  [[ -z $left ]] || die "it leaves behind: $left"
  say "installed, rendered and removed in a clean Debian 12; nothing is left behind"
}

make_package
if [[ $* == --no-trial ]]; then
  exit 0
fi
mirror=${RINGSPLAT_DEBIAN_MIRROR:-$(find_mirror)}
reason=$(no_trial_because)
if [[ -n $reason ]]; then
  say "the package was not tried: $reason"
  exit 0
fi
make_system
try_package
