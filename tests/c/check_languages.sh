#!/usr/bin/env bash
# C and Fortran against the installed library: check_languages.sh SOURCE FOLDER RINGSPLAT MPIEXEC FLAGS
set -euo pipefail
source=$1 folder=$2 ringsplat=$3 mpiexec=$4 flags=$5

build=$folder/languages library=$(dirname "$(find "$folder/prefix" -name libringsplat.so)")
cmake -S "$source/examples/languages" -B "$build" -DCMAKE_PREFIX_PATH="$folder/prefix" -DCMAKE_BUILD_TYPE=Release \
  "-DCMAKE_C_FLAGS=$flags" "-DCMAKE_Fortran_FLAGS=$flags" >/dev/null
cmake --build "$build" >/dev/null
# shellcheck disable=SC2086
cc -std=c11 -Wall -Wextra -pedantic -Werror $flags -I "$folder/prefix/include" "$source/tests/c/check_c.c" -o "$build/check_c" \
  -L "$library" -lringsplat -Wl,-rpath,"$library"
"$build/check_c" "$build/c.png"

"$mpiexec" -n 3 "$build/heat_c" "$build/heat_c.png" 40
if [[ -x $build/heat_f ]]; then
  "$mpiexec" -n 2 "$build/heat_f" "$build/heat_f.png" 40
  "$ringsplat" compare "$build/heat_c.png" "$build/heat_f.png" --fail-above 0
else
  echo "there is no Fortran compiler: only C was tested"
fi
