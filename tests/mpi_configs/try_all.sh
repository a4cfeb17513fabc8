#!/usr/bin/env bash
# Runs every file of mpi_configs on this machine, as its comments say, and compares the pictures:
#   try_all.sh PROGRAM SCRATCH_FOLDER MPIEXEC
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
# shellcheck source-path=SCRIPTDIR source=../../scripts/lib.sh
source "$here/../../scripts/lib.sh"
program=$1
scratch=$2
export RINGSPLAT_MPIEXEC=$3

configs=$repo/mpi_configs
# Small and shaded, from a side that cuts through all regions. Command lines come before configuration files.
view=(--size 96x80 --region 32 --fit sphere --azimuth 35 --elevation 20 --tf mr-soft)

rm -rf "$scratch"
mkdir -p "$scratch/out" "$scratch/bin" "$scratch/mpi_configs/slurm" "$scratch/tests"
ln -s "$repo/tests/data" "$scratch/tests/data"
cp "$here/srun" "$scratch/bin/srun"
cd "$scratch"
# The commands of app files and batch scripts have no room for a view, so the program itself is wrapped.
printf '#!/bin/sh\ncase "$*" in serve* | --version | *scaling*) exec "%s" "$@" ;; esac\nexec "%s" "$@" %s\n' \
  "$program" "$program" "${view[*]}" >bin/ringsplat
chmod +x bin/ringsplat bin/srun
export PATH=$scratch/bin:$PATH RINGSPLAT_SCRIPTS=$repo/scripts
for file in "$configs"/*.toml; do cp "$file" mpi_configs/; done
# One machine stands for all nodes, its first core for all cores. A host that is listed several times has one slot a line.
on_this_machine() {
  awk '/^node[0-9]+ slots=/ { for (n = substr($2, 7); n > 0; --n) print "localhost"; next } 1' "$1" |
    sed -E 's/node[0-9]+/localhost/; s/slot=[0-9:]+/slot=0/'
}
for file in "$configs"/{hostfile,rankfile,appfile,slurm/}*; do
  on_this_machine "$file" >"mpi_configs/${file#"$configs"/}"
done

volume=tests/data/head.nrrd
tried=0

# same_picture WHAT FILE: the picture must have the bits of its engine's first one.
same_picture() {
  local first=out/first-splats.png
  [[ $1 != */sheets-* ]] || first=out/first-sheets.png
  [[ -f $first ]] || cp "$2" "$first"
  cmp "$2" "$first" || die "$1 made another picture"
  say "$1: the same picture"
  tried=$((tried + 1))
}

# The number of ranks in the command that a configuration's comment shows.
ranks_of() { sed -n 's/^# *mpirun -n \([0-9]*\) .*/\1/p' "$1"; }

for file in mpi_configs/*.toml; do
  picture=out/$(basename "$file" .toml).png
  run_ranks "$(ranks_of "$file")" ringsplat render "$volume" -o "$picture" --config "$file"
  # An orbit's first frame is the view itself.
  [[ -f $picture ]] || picture=${picture%.png}-0000.png
  same_picture "$file" "$picture"
done
[[ $(find out -name '*orbit*.png' | wc -l) == 72 ]] || die "the two orbits are not 36 pictures each"

if "$RINGSPLAT_MPIEXEC" --version 2>&1 | grep -q 'Open MPI'; then
  for hosts in mpi_configs/hostfile.*; do
    run_ranks 6 --hostfile "$hosts" ringsplat render "$volume" -o out/hostfile.png --config mpi_configs/ring-4+2.toml
    same_picture "$hosts" out/hostfile.png
  done
  run_ranks 6 --hostfile mpi_configs/hostfile.cluster --rankfile mpi_configs/rankfile.cluster \
    ringsplat render "$volume" -o out/rankfile.png --config mpi_configs/ring-4+2.toml
  same_picture mpi_configs/rankfile.cluster out/rankfile.png
  allow_ranks 6
  "$RINGSPLAT_MPIEXEC" --app mpi_configs/appfile
  same_picture mpi_configs/appfile out/head.png
else
  say "hostfiles, rankfile and app file left out: they are in Open MPI's format"
  tried=$((tried + 4))
fi

# A server runs until it is told to end; the page's address says that it runs.
try_server() {
  local pid deadline=$((SECONDS + 60))
  SLURM_NTASKS=4 setsid bash "$1" "$volume" 0 > out/serve.log &
  pid=$!
  until grep -q '^http://127.0.0.1:[0-9]*/#' out/serve.log; do
    kill -0 "$pid" && ((SECONDS < deadline)) || die "$1 shows no page"
    sleep 0.2
  done
  [[ $(stat -c %a out/serve.log) == 600 ]] || die "others may read the token in $1's log"
  kill -- "-$pid"
  wait "$pid" || true
  tried=$((tried + 1))
}

# Every row has its frames, and the ranks that drew them.
try_scaling() {
  SLURM_NTASKS=16 bash "$1" out/scaling.json 32
  python3 - out/scaling.json <<'END' || die "$1 wrote something else"
import json, sys
rows = json.load(open(sys.argv[1]))["rows"]
assert [row["ranks"] for row in rows] == [1, 2, 4, 8, 16, 16, 2, 16], rows
assert all(len(row["frames"]) == 6 and row["frames"][0]["layout"]["ranks"] == row["ranks"] for row in rows)
END
  [[ -z $(find out -name 'scaling.*' ! -name scaling.json) ]] || die "$1 left files behind"
  tried=$((tried + 1))
}

for script in mpi_configs/slurm/*.sbatch; do
  bash -n "$script"
  if [[ $script == */serve.sbatch ]]; then
    try_server "$script"
    continue
  elif [[ $script == */scaling.sbatch ]]; then
    try_scaling "$script"
    continue
  fi
  SLURM_NTASKS=16 SLURM_NTASKS_HET_GROUP_0=12 SLURM_NTASKS_HET_GROUP_1=4 bash "$script" "$volume" out/slurm.png
  same_picture "$script" out/slurm.png
done

files=$(find "$configs" -maxdepth 1 -type f ! -name README.md | wc -l)
scripts=$(find "$configs/slurm" -name '*.sbatch' | wc -l)
((tried == files + scripts)) || die "$tried of $((files + scripts)) configurations were tried"
