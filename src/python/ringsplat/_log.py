"""The renderer's log lines, for Python's logging: the logger "ringsplat"."""

import atexit
import logging

from . import _core

logger = logging.getLogger("ringsplat")
_core.set_log(logger.log)
atexit.register(_core.set_log, None)
