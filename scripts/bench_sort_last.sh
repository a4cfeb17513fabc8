#!/usr/bin/env bash
# Sort-last compositing with IceT beside the ring:  scripts/bench_sort_last.sh FOLDER [MOST_RANKS [STUDY,...]]   (default 1024, all)
#
# Real ranks on this machine (nothing else should run), and simulated ones on described machines: FOLDER/sort_last.csv and .png.
# scripts/sort_last_study.py says what is measured. IceT comes with Debian's paraview-dev (112 MB to download, 740 MB installed).
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

folder=${1:?where to write: scripts/bench_sort_last.sh FOLDER}
mkdir -p "$folder"
python3 -c "import matplotlib" || die "the plot needs matplotlib: apt-get install python3-matplotlib, and the python3 it belongs to first in PATH"
build_ringsplat ringsplat_cli ringsplat_smpi ringsplat_platform
build_ringsplat sort_last sort_last_smpi ||
  die "the race needs IceT: apt-get install --no-install-recommends paraview-dev, then cmake --preset release (and SimGrid: scripts/setup.sh)"
export RINGSPLAT_BUILD=$build
python3 "$repo/scripts/sort_last_study.py" -o "$folder" --most-ranks "${2:-1024}" ${3:+--only "$3"}
python3 "$repo/scripts/plot_sort_last.py" "$folder/sort_last.csv" -o "$folder/sort_last.png"
