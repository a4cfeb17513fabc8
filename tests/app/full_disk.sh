#!/usr/bin/env bash
# Every kind of file on a disk without room for it:  full_disk.sh MPIEXEC PROGRAM VOLUME SCRATCH
# Mounts a small disk; where that is not allowed it says so and exits with 77.
set -u
if [[ ${IN_OWN_MOUNTS:-} != yes ]]; then
  if ! unshare -m true 2>/dev/null; then
    echo "skipped: this user may not mount a disk"
    exit 77
  fi
  IN_OWN_MOUNTS=yes exec unshare -m "$0" "$@"
fi
mpiexec=$1 program=$2 volume=$3 scratch=$4
# shellcheck source=tests/support/launcher.sh
. "$(dirname "$0")/../support/launcher.sh"
rm -rf "$scratch" && mkdir -p "$scratch/disk" "$scratch/whole"
disk=$scratch/disk
fail() {
  echo "FAILED: $*" >&2
  ls -lA "$disk" >&2
  cat "$scratch/log" >&2
  exit 1
}
mount -t tmpfs -o size=1m,nr_inodes=200 ringsplat "$disk" || {
  echo "skipped: this user may not mount a disk"
  exit 77
}

# fill KIB: fills the disk but for KIB KiB.
fill() {
  rm -f "$disk/filler"
  local left
  left=$(df -k --output=avail "$disk" | tail -n 1)
  ((left <= $1)) || head -c $(((left - $1) * 1024)) /dev/zero >"$disk/filler"
}

# without_room FILE KIB COMMAND...: runs COMMAND, which writes FILE, with KIB KiB free.
without_room() {
  local file=$1 room=$2
  shift 2
  find "$disk" -mindepth 1 -delete
  echo old >"$disk/$file"
  fill "$room"
  "$@" >"$scratch/out" 2>"$scratch/log" &
  await_launcher $! "$scratch/log" 60 || fail "$* goes on after a minute"
  ((code == 3 || code == -1)) || fail "$* ended with $code, not 3"
  (($(grep -c 'ringsplat.*error: .* cannot be written: ' "$scratch/log") == 1)) || fail "$* did not say what was wrong"
  [[ $(cat "$disk/$file") == old ]] || fail "$* did not leave $file alone"
  [[ -z $(find "$disk" -name '.*' -type f) ]] || fail "$* left a hidden file"
}

render() { "$program" render "$volume" --size 200 "$@"; }
without_room p.png 4 render -o "$disk/p.png"
without_room p.jpg 4 render --background white -o "$disk/p.jpg"
without_room p-0003.exr 16 render --orbit 12 -o "$disk/p.exr"
without_room p-0003.png 16 "$mpiexec" -n 3 "$program" render "$volume" --gps 2 --renderers 1 --size 200 --orbit 12 \
  -o "$disk/p.png"

small=("$program" render "$volume" --orbit 8 --size 8 -o "$scratch/whole/p.png")
without_room f.json 0 "${small[@]}" --tf-out "$disk/f.json"
without_room s.json 4 "$mpiexec" -n 3 "$program" render "$volume" --gps 2 --renderers 1 --size 8 --orbit 8 \
  -o "$scratch/whole/p.png" --stats "$disk/s.json"
without_room t.json 4 "$mpiexec" -n 3 "$program" render "$volume" --gps 2 --renderers 1 --size 8 --orbit 8 \
  -o "$scratch/whole/p.png" --trace "$disk/t.json"
without_room r.exr 0 "$program" reference "$volume" --size 16 -o "$disk/r.exr"
render -o "$scratch/whole/a.png" >/dev/null && render --azimuth 20 -o "$scratch/whole/b.png" >/dev/null
without_room d.png 4 "$program" compare "$scratch/whole/a.png" "$scratch/whole/b.png" --diff "$disk/d.png"

synth() { "$program" synth gaussians --dims 40x40x40 "$@"; }
without_room v.nrrd 4 synth --type float32 -o "$disk/v.nrrd"
without_room v.nrrd 32 synth --no-compression -o "$disk/v.nrrd"
without_room v.raw 32 synth -o "$disk/v.mhd"

# A file that is only kept for the next run gives a warning, not a failure.
find "$disk" -mindepth 1 -delete
fill 0
"$program" synth ball --dims 12x12x12 -o "$scratch/whole/ball.nrrd" >/dev/null || fail "synth failed"
XDG_CACHE_HOME=$(realpath "$disk")/cache "$program" info "$scratch/whole/ball.nrrd" --ranks 2 \
  >"$scratch/out" 2>"$scratch/log" || fail "a cache without room ended the run"
grep -q "the machine cannot be kept for the next run: .* cannot be written: " "$scratch/log" ||
  fail "nobody said that there is no room for the cache"
[[ -z $(find "$disk" -type f ! -name filler) ]] || fail "a cache without room left a file"

umount "$disk"
rm -r "$scratch"
echo "nothing was lost on a full disk"
