"""Other names for the rooms and the furniture of a house: people say couch and settee where the map says sofa."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from importlib.resources import files
from typing import Final

import yaml

from engine.han import SIMPLER

_FILE: Final = files("assets") / "names.yaml"


def synonyms(names: Mapping[str, str], taken: Collection[str] = ()) -> dict[str, str]:
    """Further words for what has these ``names``, each with what it means. No word that is a name already, or is
    ``taken``, and none that could mean two of them."""
    found: dict[str, set[str]] = {}
    for group in _groups():
        meant = {names[word] for word in group if word in names}
        for word in group:
            if meant and word not in names and word not in taken:
                found.setdefault(word, set()).update(meant)
    return {word: meant.pop() for word, meant in found.items() if len(meant) == 1}


@cache
def _groups() -> tuple[tuple[str, ...], ...]:
    read = yaml.safe_load(_FILE.read_text("utf-8"))
    return tuple(tuple(word.casefold().translate(SIMPLER) for word in group) for group in read)
