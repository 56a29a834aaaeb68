"""What is wrong with a configuration, said so that it can be mended without looking anything up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Where:
    """Where a value was written: a line of a file, an environment variable or a command-line flag."""

    name: str
    """Path of the file, name of the variable, or the flag as it was given."""
    line: int = 0
    """1-based; 0 where there are no lines."""

    def __str__(self) -> str:
        return f"{self.name}:{self.line}" if self.line else self.name


@dataclass(frozen=True, slots=True)
class Problem:
    """One mistake: where it stands, which setting it is about, what is wrong, and what would be right."""

    where: Where
    key: str
    """Dotted name of the setting; empty when the file as a whole is wrong."""
    message: str
    allowed: str = ""
    nearest: str = ""
    """What was probably meant, written as it has to be written in that place."""

    def __str__(self) -> str:
        key = "" if not self.key or self.where.name.endswith(f" {self.key}") else f"{self.key}: "
        text = f"{self.where}: {key}{self.message}"
        if self.allowed:
            text += f"; allowed: {self.allowed}"
        if self.nearest:
            text += f"; did you mean {self.nearest!r}?"
        return text


class ConfigError(Exception):
    """The configuration cannot be used. ``problems`` holds all that is wrong with it, in reading order."""

    code = "config"
    exit_code = 2

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        self.message = "\n".join(str(problem) for problem in self.problems)
        self.hint = "`sayso config path` names the files that are read, `sayso config show` every setting in force."
        super().__init__(self.message)

    def __str__(self) -> str:
        return f"{self.message}\n{self.hint}"
