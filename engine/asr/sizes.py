"""Whisper models by the names that everybody knows them by: "base", "small", "large-v3".

What is on our own list of models is fetched and verified by us. The others are found where the Hugging Face hub keeps
what other programs, or ``hf download``, have fetched; we fetch nothing from there, for nobody has told us which bytes
would be the right ones.
"""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path
from typing import Final

from engine.errors import ModelError

PREFIX: Final = "whisper-"
"""Of the names on our list."""
SIZES: Final = tuple("tiny tiny.en base base.en small small.en medium medium.en large-v1 large-v2 large-v3".split())  # noqa: SIM905
"""Those that there are for CTranslate2 (https://huggingface.co/Systran)."""


def listed(name: str, models: Container[str]) -> str | None:
    """What is called ``name`` on a list of ``models``: "base" is whisper-base. None: it is not on it."""
    return next((known for known in (name, PREFIX + name) if known in models), None)


def is_size(name: str) -> bool:
    """There is such a Whisper, whether it is here or not."""
    return name.removeprefix(PREFIX) in SIZES


def title(folder: Path) -> str:
    """What the model in a folder is called; in the hub's cache that folder is named by a checksum."""
    return folder.parents[1].name.rpartition("--")[2] if folder.parent.name == "snapshots" else folder.name


def in_hub(name: str) -> Path:
    """The folder of a Whisper in the hub's cache. Raises ``ModelError`` where it is not there."""
    from huggingface_hub import try_to_load_from_cache

    repository = f"Systran/faster-whisper-{name.removeprefix(PREFIX)}"
    found = try_to_load_from_cache(repository, "model.bin")
    if not isinstance(found, str):
        raise ModelError(
            f"Whisper {name.removeprefix(PREFIX)} is not on this machine.",
            hint=f"Run: hf download {repository}. Or set asr.model to a folder that holds it.",
        )
    return Path(found).parent
