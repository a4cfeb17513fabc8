#!/usr/bin/env bash
# Measures everything in docs/accuracy.md again:  scripts/accuracy.sh [FOLDER]   (default build/accuracy)
#
# The default study and its pictures, the sweep of angles, the roundings; CSV, JSON and plots go to FOLDER, and the
# plots replace those in docs. Frame times want an idle machine. SSIM and FLIP need two packages of PyPI, which go to
# build/perceptual; without a network the columns are left out.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

folder=${1:-$repo/build/accuracy}
environment=$repo/build/perceptual
plots=python3
"$plots" -c 'import matplotlib' 2>/dev/null || plots=/usr/bin/python3 # Debian's matplotlib belongs to Debian's own
mkdir -p "$folder"
rm -f "$folder/perceptual.csv"
build_ringsplat ringsplat_cli measure_roundings

"$build/ringsplat" study -o "$folder/study.csv" --keep-images "$folder/pictures"
"$build/ringsplat" study "$repo/scripts/angles.toml" -o "$folder/angles.csv"
"$build/measure_roundings" >"$folder/roundings.csv"

if [[ -x $environment/bin/python ]] || python3 -m venv "$environment"; then
  "$environment/bin/python" -c 'import skimage, flip_evaluator' 2>/dev/null ||
    "$environment/bin/pip" install --quiet scikit-image flip-evaluator ||
    say "scikit-image and flip-evaluator could not be installed: no SSIM and FLIP"
  if "$environment/bin/python" -c 'import skimage, flip_evaluator' 2>/dev/null; then
    "$environment/bin/python" "$repo/scripts/perceptual.py" "$folder/study.csv" "$folder/pictures" -o "$folder/perceptual.csv"
  fi
fi

table=$folder/study.csv
[[ -f $folder/perceptual.csv ]] && table=$folder/perceptual.csv
"$plots" "$repo/scripts/accuracy_report.py" "$table"
"$plots" "$repo/scripts/plot_speed_error.py" "$folder/study.csv" -o "$folder"
mv "$folder/speed-error-field.png" "$repo/docs/accuracy-speed-error.png"
"$plots" "$repo/scripts/plot_speed_error.py" "$folder/angles.csv" -o "$folder"
mv "$folder/angle-error-field.png" "$repo/docs/accuracy-angle-error.png"
"$plots" "$repo/scripts/plot_rounding.py" "$folder/roundings.csv" -o "$repo/docs/accuracy-rounding.png"
