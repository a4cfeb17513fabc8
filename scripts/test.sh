#!/usr/bin/env bash
# Installs what is missing, builds everything and runs all tests, and without options a few under the sanitizers:
#   scripts/test.sh [CTEST OPTION...]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

"$repo/scripts/setup.sh"
# What Python's module is built and tested with; without PyPI it is left out.
python3 -B "$repo/tests/python/make.py" "$repo/build/python" || say "Python's module is left out"
(cd "$repo" && cmake --preset release >&2)
build_ringsplat all
# Tests that start ranks say how many cores they take, so that CTest runs no more of them at once than fit.
cd "$repo"
ctest --preset release --parallel "$(cores)" --no-tests=error "$@"
(($# > 0)) || "$repo/scripts/check.sh" smoke
