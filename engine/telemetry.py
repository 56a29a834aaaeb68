"""The libraries that sayso is made of report nothing to their makers.

onnxruntime queues events for a host of Microsoft's and writes a device id into the user's cache as soon as it is
imported; huggingface_hub reports what is loaded, and looks for newer versions of it. Both read variables of the
environment once, when they are imported, and a call afterwards is too late. So ``engine/__init__.py`` sets the
variables before anything else of ours is imported. Every program of sayso begins with the ``engine`` package, also
each ``python -m`` child, and children of other people inherit the variables.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from types import MappingProxyType

TELEMETRY: Mapping[str, str] = MappingProxyType(
    {
        "DO_NOT_TRACK": "1",  # what many programs heed: https://donottrack.sh
        "HF_HUB_DISABLE_TELEMETRY": "1",
        "ORT_DISABLE_TELEMETRY": "1",  # onnxruntime 1.31; its disable_telemetry_events() comes after the device id
    }
)
"""Variables that keep reports at home, also in programs that we merely run."""

_OFFLINE = {"HF_HUB_OFFLINE": "1"}  # models of the hub are taken as they lie on this machine


def switch_off() -> None:
    """Set the variables for this process and its children, whatever they were. To be called before onnxruntime and
    huggingface_hub are imported."""
    os.environ.update({**TELEMETRY, **_OFFLINE})
