"""Places that people named ("remember this as the kitchen"), kept for the house that they are in."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import yaml
from pydantic import ValidationError

from config.schema import Place
from config.writing import write_whole
from engine import yaml_file
from engine.errors import StorageError
from engine.skills.places import free_symbol
from engine.yaml_file import BadFile

HEAD = "# Places that you had the robot remember in this house. You may change them; they are read at the start.\n"


def file_for(folder: Path, house: str) -> Path:
    """Where those of a house are."""
    plain = "".join(sign if sign.isalnum() or sign in "-_" else "_" for sign in house) or "house"
    return folder / f"{plain}.yaml"


def read(file: Path) -> dict[str, Place]:
    """By name. Raises :class:`StorageError` for a file that cannot be read."""
    try:
        raw = yaml_file.read(file) or {}
        return {name: Place.model_validate({"name": name, **place}) for name, place in raw.items()}
    except FileNotFoundError:
        return {}
    except (BadFile, ValidationError, AttributeError, TypeError) as error:
        if isinstance(error.__cause__, NotADirectoryError):
            return {}
        message = f"The places in {file} cannot be read: {str(error).splitlines()[0]}."
        raise StorageError(message, hint="Mend the file, or delete it.") from error


def write(file: Path, places: Mapping[str, Place]) -> None:
    """Keep them. Raises :class:`StorageError`."""
    kept = {
        name: place.model_dump(mode="json", exclude={"name"}, exclude_defaults=True) for name, place in places.items()
    }
    text = HEAD + yaml.safe_dump(kept, allow_unicode=True, sort_keys=False)
    try:
        write_whole(file, text.encode(), mode=0o644)
    except OSError as error:
        raise StorageError(f"The place is not kept in {file}: {error.strerror}.") from error


def joined(places: Mapping[str, Place], remembered: Mapping[str, Place]) -> dict[str, Place]:
    """Places by symbol: those of the map and those that were remembered, which move one of the same name."""
    found = dict(places)
    for name, place in remembered.items():
        known = {word.casefold(): s for s, one in found.items() for word in (one.name, *one.aliases)}
        symbol = known.get(name.casefold())
        if symbol is None:
            found[free_symbol(found)] = place
        else:
            found[symbol] = found[symbol].model_copy(
                update={"position": place.position, "orientation": place.orientation}
            )
    return found
