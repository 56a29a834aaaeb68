"""For all tests: hypothesis looks for wrong behaviour, never at the clock of a busy machine."""

from __future__ import annotations

import os
import signal

from hypothesis import settings

settings.register_profile("sayso", deadline=None)
settings.load_profile("sayso")

# A shell ignores one of these for what runs in the background, and nohup the other: the programs under test would, too.
# A handler ends with us.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda *_: None)

for name in ("COLUMNS", "LINES"):  # programs under test are to ask their terminal how big it is
    os.environ.pop(name, None)
