#!/usr/bin/env bash
# Strong and weak scaling:  scripts/scaling_study.sh FOLDER [MOST_RANKS]   (default 1024)
#
# Simulated ranks on described machines: FOLDER/scaling.csv and .png. Real ranks on this machine against the same machine
# simulated, of which scripts/calibrate.sh writes the description: FOLDER/real.csv. Nothing else should run.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

folder=${1:?where to write: scripts/scaling_study.sh FOLDER}
mkdir -p "$folder"
python3 -c "import matplotlib" || die "the plot needs matplotlib: apt-get install python3-matplotlib, and the python3 it belongs to first in PATH"
python3 "$repo/scripts/scaling_study.py" -o "$folder" --most-ranks "${2:-1024}"
python3 "$repo/scripts/plot_scaling.py" "$folder/scaling.csv" -o "$folder/scaling.png"
"$repo/scripts/calibrate.sh" "$folder/this-machine.toml"
python3 "$repo/scripts/compare_simulated.py" "$folder/this-machine.toml" --csv "$folder/real.csv"
