#!/usr/bin/env bash
# C and Fortran against the installed library: check_languages.sh SOURCE FOLDER RINGSPLAT MPIEXEC FLAGS
set -euo pipefail
source=$1 folder=$2 ringsplat=$3 mpiexec=$4 flags=$5

build=$folder/languages library=$(dirname "$(find "$folder/prefix" -name libringsplat.so)")
# gfortran reads arrays of class(*) as if they were aligned like pointers.
cmake -S "$source/examples/languages" -B "$build" -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE=Release \
  "-DCMAKE_C_FLAGS=$flags" "-DCMAKE_Fortran_FLAGS=$flags ${flags:+-fno-sanitize=alignment}" >/dev/null
cmake --build "$build" >/dev/null
# shellcheck disable=SC2086
cc -std=c11 -Wall -Wextra -pedantic -Werror $flags -I "$folder/prefix/include" "$source/tests/c/check_c.c" -o "$build/check_c" \
  -L "$library" -lringsplat -Wl,-rpath,"$library"
"$build/check_c" "$build/c.png"

# heat LANGUAGE RANKS: with a picture at the end and, by a file, at steps 20 and 40.
heat() {
  printf '[top]\nevery = 20\nfile = "top_%s-{step}.png"\nview = "top"\nsize = 64\n' "$1" >"$build/$1.toml"
  "$mpiexec" -n "$2" "$build/heat_$1" "$build/heat_$1.png" 40 "$build/$1.toml"
}
rm -f "$build"/top_*.png
heat c 3
if [[ -x $build/heat_f ]]; then
  heat f 2
  for step in 000020 000040; do
    "$ringsplat" compare "$build/top_c-$step.png" "$build/top_f-$step.png" --fail-above 0
  done
  "$ringsplat" compare "$build/heat_c.png" "$build/heat_f.png" --fail-above 0
else
  echo "there is no Fortran compiler: only C was tested"
fi
