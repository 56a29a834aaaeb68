"""What the robot learnt of a house, kept for it: places that people named ("remember this as the kitchen"), and people
who told their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Generic, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from config.schema import KnownPerson, Place
from config.writing import write_whole
from engine import yaml_file
from engine.errors import StorageError
from engine.skills.places import free_symbol
from engine.yaml_file import BadFile

T = TypeVar("T", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Kept(Generic[T]):
    """One kind of what is kept, by name, a file for each house."""

    model: type[T]
    head: str
    named: bool = False  # whether the model holds its name as well

    def read(self, file: Path) -> dict[str, T]:
        """By name. Raises :class:`StorageError` for a file that cannot be read."""
        try:
            raw = yaml_file.read(file) or {}
            return {
                name: self.model.model_validate({"name": name, **told} if self.named else told)
                for name, told in raw.items()
            }
        except FileNotFoundError:
            return {}
        except (BadFile, ValidationError, AttributeError, TypeError) as error:
            if isinstance(error.__cause__, NotADirectoryError):
                return {}
            message = f"What was learnt, in {file}, cannot be read: {str(error).splitlines()[0]}."
            raise StorageError(message, hint="Mend the file, or delete it.") from error

    def write(self, file: Path, told: Mapping[str, T]) -> None:
        """Keep them. Raises :class:`StorageError`."""
        kept = {
            name: one.model_dump(mode="json", exclude={"name"}, exclude_defaults=True) for name, one in told.items()
        }
        text = self.head + yaml.safe_dump(kept, allow_unicode=True, sort_keys=False)
        try:
            write_whole(file, text.encode(), mode=0o644)
        except OSError as error:
            raise StorageError(f"What was learnt could not be saved in {file}: {error.strerror}.") from error


PLACES: Final = Kept(
    Place,
    "# Places that you had the robot remember in this house. You may change them; they are read at the start.\n",
    named=True,
)
PEOPLE: Final = Kept(
    KnownPerson,
    "# People who told the robot their names in this house. You may change them; they are read at the start.\n",
)


def file_for(folder: Path, house: str) -> Path:
    """Where those of a house are."""
    plain = "".join(sign if sign.isalnum() or sign in "-_" else "_" for sign in house) or "house"
    return folder / f"{plain}.yaml"


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
