"""For all tests: hypothesis looks for wrong behaviour, never at the clock of a busy machine; garbage is small."""

from __future__ import annotations

import gc
import os
import signal

import psutil
import pytest
from hypothesis import settings

settings.register_profile("sayso", deadline=None)
settings.load_profile("sayso")

# A shell ignores one of these for what runs in the background, and nohup the other: the programs under test would, too.
# A handler ends with us.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
for number in (signal.SIGHUP, signal.SIGQUIT):
    if signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, lambda *_: None)

for name in ("COLUMNS", "LINES"):  # programs under test are to ask their terminal how big it is
    os.environ.pop(name, None)


@pytest.hookimpl(trylast=True)
def pytest_collection_finish() -> None:
    """What thousands of collected tests and their modules are made of stays until the end: the garbage collector, which
    would look through it again and again, has only what a test makes."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 10, 10)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """One more than there are cores: a quarter of the time a worker waits for a program that it has started."""
    return (psutil.cpu_count() or 1) + 1
