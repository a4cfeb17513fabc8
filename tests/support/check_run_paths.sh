#!/usr/bin/env bash
# check_run_paths.sh FOLDER...: fails when a program or library below looks for libraries in the current folder, as the
# loader takes every entry of a run path that is empty or relative.
set -eu -o pipefail
paths=$(find "$@" -name CMakeFiles -prune -o -type f \( -perm -u+x -o -name '*.so*' \) -print0 |
  xargs -0 readelf -d 2>/dev/null | awk '/^File:/ { file = $2 } /\((RUNPATH|RPATH)\)/ { print file, $NF }' || true)
[[ -n $paths ]] || { echo "no program with a run path is in $*" >&2; exit 1; }
while read -r file path; do
  path=${path#[} path=${path%]}
  [[ :$path: =~ :([^/\$:][^:]*)?: ]] && echo "$file: $path" >&2 && wrong=1
done <<<"$paths"
echo "$(wc -l <<<"$paths") run paths"
exit "${wrong:-0}"
