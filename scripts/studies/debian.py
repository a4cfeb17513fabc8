"""Debian's NumPy and matplotlib belong to Debian's own Python, which need not be the first in PATH."""
import importlib.util
import os
import sys

PYTHON = "/usr/bin/python3"


def restart_without(*modules, in_environments=False):
    """Runs the program again with Debian's Python where this one lacks a module. A virtual environment is meant, and stays unless asked.
Returns a module that is still missing."""
    missing = next((module for module in modules if importlib.util.find_spec(module) is None), None)
    if missing and (in_environments or sys.prefix == sys.base_prefix) and os.access(PYTHON, os.X_OK):
        if os.path.realpath(PYTHON) != os.path.realpath(sys.executable):
            os.execv(PYTHON, [PYTHON, "-B", *sys.argv])
    return missing
