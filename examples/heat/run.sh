#!/usr/bin/env bash
# Builds the example against the Ringsplat that is built in build/release, runs it and joins its pictures into one film:
#
#   examples/heat/run.sh [RANKS [FOLDER]]
#
# The film is FOLDER/heat.mp4 where ffmpeg is installed; without it only the pictures are there.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../scripts/lib.sh"

ranks=${1:-4} folder=${2:-$repo/build/heat}
[[ -x $build/ringsplat ]] || die "build Ringsplat first: scripts/test.sh, or cmake --preset release && cmake --build --preset release"
cmake --install "$build" --prefix "$folder/prefix" >/dev/null
cmake -S "$repo/examples/heat" -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE=Release >/dev/null
cmake --build "$folder/build" >/dev/null
run_ranks "$ranks" "$folder/build/heat" "$folder/pictures"
if command -v ffmpeg >/dev/null; then
  ffmpeg -loglevel error -y -framerate 20 -i "$folder/pictures/heat-%04d.png" -pix_fmt yuv420p "$folder/heat.mp4"
  say "wrote $folder/heat.mp4"
else
  say "ffmpeg is not installed; the pictures are in $folder/pictures"
fi
