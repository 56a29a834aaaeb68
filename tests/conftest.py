"""For all tests: hypothesis looks for wrong behaviour, never at the clock of a busy machine."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("sayso", deadline=None)
settings.load_profile("sayso")
