"""python -m ringsplat: the whole command line, in one process."""

import sys

from . import _core

sys.exit(_core.main(["ringsplat", *sys.argv[1:]]))
