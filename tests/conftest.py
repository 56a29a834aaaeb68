"""For all tests: hypothesis looks for wrong behaviour, never at the clock of a busy machine."""

from __future__ import annotations

import os
import signal

from hypothesis import settings

settings.register_profile("sayso", deadline=None)
settings.load_profile("sayso")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a shell starts what runs in the background like that, and the
    signal.signal(signal.SIGINT, signal.default_int_handler)  # programs under test would inherit it

for name in ("COLUMNS", "LINES"):  # programs under test are to ask their terminal how big it is
    os.environ.pop(name, None)
