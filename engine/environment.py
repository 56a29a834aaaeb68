"""What a program that sayso merely runs may know of the environment: variables that are named here, and no others.

A list of what to keep back would never be whole: a key can have any name. Programs get what says where things are and
how people read. They do not get what opens a door: sockets of agents and of the desktop, and proxies, whose addresses
hold passwords.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping

from engine.telemetry import TELEMETRY

_PLACES = """PATH HOME PWD TMPDIR SHELL USER LOGNAME LD_LIBRARY_PATH DYLD_LIBRARY_PATH SSL_CERT_DIR SSL_CERT_FILE
    XDG_CACHE_HOME XDG_CONFIG_DIRS XDG_CONFIG_HOME XDG_DATA_DIRS XDG_DATA_HOME XDG_STATE_HOME"""
_PEOPLE = """LANG LANGUAGE LC_ALL LC_ADDRESS LC_COLLATE LC_CTYPE LC_IDENTIFICATION LC_MEASUREMENT LC_MESSAGES
    LC_MONETARY LC_NAME LC_NUMERIC LC_PAPER LC_TELEPHONE LC_TIME TZ TERM COLORTERM NO_COLOR COLUMNS LINES"""
"""Each LC_ by its name: ssh carries over whatever else is called so, with anything in it."""
_RUNNING = """VIRTUAL_ENV CONDA_PREFIX PYTHONPATH PYTHONUTF8 PYTHONIOENCODING PYTHONDONTWRITEBYTECODE OMP_NUM_THREADS
    OPENBLAS_NUM_THREADS"""
KNOWN = frozenset((*_PLACES.split(), *_PEOPLE.split(), *_RUNNING.split(), *TELEMETRY))
"""Variables that every program may see."""


def clean_environment(more: Collection[str] = (), environ: Mapping[str, str] | None = None) -> dict[str, str]:
    """What every program may see of our own environment (or ``environ``), and ``more`` by their names."""
    variables = os.environ if environ is None else environ
    return {name: value for name, value in variables.items() if name in KNOWN or name in more}
