"""The sentences that are written in the source and may be said, found by its syntax.

What an f-string puts into a sentence stands as Ж0, Ж1…, a number as 1.5, so that the sentence can be tried as it is
said. What stands close behind something else (``goal{where}.``) may be empty, and is left out, and so is what stands
before another sentence (``{why} It stands.``): that is found where it is written.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import engine

SOURCE: Final = Path(engine.__file__).parent

SILENT: Final = frozenset(
    {"progress", "Log", "ErrorRaised", "PlanRejected", "_enter", "_ack", "_new_cycle", "create_task", "add_argument"}
    | {"TypeError", "ValueError", "AssertionError"}
)
"""What is called with a text that is shown as progress, logged, or told to programmers."""

_SENTENCE: Final = re.compile(r".*\S \S.*|[A-Z][a-z]+\.", re.DOTALL)
_ANOTHER: Final = re.compile(r" (?=[A-Z])|(?=[a-z])")
_FIELD: Final = re.compile(r"\{[\w:.]*\}")


@dataclass(frozen=True, slots=True)
class Written:
    """A text, and where it stands."""

    where: str
    text: str


def written(place: str, calls: Collection[str] | None = None) -> Iterator[Written]:
    """The texts of a file or folder of the engine; ``calls``: only in calls of one of these names, also of those that
    nobody hears, and where they are kept as messages."""
    path = (SOURCE / place).resolve()
    for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
        tree = ast.parse(file.read_text("utf-8"))
        silent = {id(part) for node in ast.walk(tree) for part in _silent(node, SILENT - set(calls or ()))}
        roots = [tree] if calls is None else [node for node in ast.walk(tree) if _called(node) in calls or _kept(node)]
        for node in (node for root in roots for node in ast.walk(root)):
            if id(node) not in silent and isinstance(node, ast.expr) and _SENTENCE.fullmatch(text := _text(node)):
                yield Written(f"{file.relative_to(SOURCE.parent)}:{node.lineno}", text.strip())


def _silent(node: ast.AST, silent: Collection[str]) -> Iterator[ast.AST]:
    """What is part of a node and is not said by itself."""
    match node:
        case ast.Expr(ast.Constant()):  # a docstring
            yield node.value
        case ast.JoinedStr():  # its parts; but what is put into it may be said
            for part in node.values:
                yield part
                if isinstance(part, ast.FormattedValue) and part.format_spec is not None:
                    yield from ast.walk(part.format_spec)
        case ast.Call(ast.Attribute(ast.Name("re"))):
            yield from ast.walk(node)
        case ast.Call() if _called(node) in silent:
            yield from ast.walk(node)
        case ast.Assert(_, ast.expr() as message):
            yield from ast.walk(message)


def _called(node: ast.AST) -> str | None:
    match node:
        case ast.Call(ast.Name(name) | ast.Attribute(_, name)):
            return name
    return None


def _kept(node: ast.AST) -> bool:
    """Whether it keeps a text under a name for what is said."""
    match node:
        case ast.Assign([ast.Name("message" | "detail" | "answer" | "hint" | "why" | "reason" | "text" | "fix")]):
            return True
    return False


def _text(node: ast.expr) -> str:
    match node:
        case ast.Constant(str(text)):
            return _with_probes(text)
        case ast.JoinedStr(values):
            return _filled(values)
    return ""


def _with_probes(text: str) -> str:
    """A text for ``str.format`` with something in its slots."""
    return _FIELD.sub(lambda field: "1.5" if ":" in field[0] else "Ж0", text)


def _filled(values: Sequence[ast.expr]) -> str:
    text = ""
    for index, part in enumerate(values):
        if isinstance(part, ast.FormattedValue):
            spec = "" if part.format_spec is None else ast.unparse(part.format_spec)
            if spec or not text or text[-1] in " ('":
                text += "50%" if "%" in spec else "1.5" if spec else f"Ж{index}"
        elif isinstance(part, ast.Constant):
            words = _with_probes(str(part.value))
            text = words if text == "Ж0" and _ANOTHER.match(words) else text + words
    return text
