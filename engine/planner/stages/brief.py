"""The brief form of an answer: what a model writes that a grammar holds to it, a line without ornament.

``navigation(kitchen); beep()``, or ``impossible: …``, ``refuse: …``, ``response: …``. It has a third less tokens than
the object (``engine.planner.reply``) that it stands for, of which a small model writes twenty in a second. It is known
here only: exchanges and events have the object.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import Any, Final

from engine.skills.registry import Parameter, Skill
from engine.strict_json import read_json

MOST_CALLS: Final = 15
"""What a small model writes at most: one that repeats itself comes to an end."""
_REASON: Final = re.compile(r"(impossible|refuse|response|clarification)\s*[:：]\s*(.+)", re.DOTALL)
_NEXT_CALL: Final = re.compile(r";\s*(?=[a-z]\w*\()")
_RULES: Final = (
    r'number ::= "?" | "-"? [0-9]{1,4} ("." [0-9]{1,3})?',
    r'words ::= "?" | [a-zA-Z0-9\u4e00-\u9fff] [a-zA-Z0-9 \u4e00-\u9fff]{0,39}',
    r"""sentence ::= "'" [^'\\\x00-\x1f]{1,120} "'" """.rstrip(),
    r"text ::= [^\x00-\x1f]{1,200}",
)


def brief(answer: str) -> str:
    """An answer, which is an object of JSON, in the brief form; as it is, if it is none."""
    try:
        found: Any = read_json(answer)
    except ValueError:
        return answer
    if not isinstance(found, dict):
        return answer
    if isinstance(actions := found.get("action"), list) and actions:
        return "; ".join(map(str, actions))
    reasons = ("clarification", "refuse", "impossible", "response")
    return next((f"{key}: {found[key]}" for key in reasons if found.get(key)), answer)


def full(line: str) -> str:
    """What :func:`brief` makes a line of; as it is, if it is no such line."""
    if (reason := _REASON.fullmatch(line)) is not None:
        return json.dumps({reason[1]: reason[2]}, ensure_ascii=False)
    if re.match(r"[a-z]\w*\(", line):
        return json.dumps({"action": _NEXT_CALL.split(line)}, ensure_ascii=False)
    return line


def grammar(skills: Iterable[Skill], *, talks: bool) -> str:
    """GBNF of the form; only one who ``talks`` may answer with mere words."""
    calls = " | ".join(map(_call, skills))
    talk = ' | "response: " text' if talks else ""
    root = f'root ::= call ("; " call){{0,{MOST_CALLS - 1}}} | ("impossible: " | "refuse: ") text{talk}'
    return "\n".join((root, f"call ::= {calls}", *_RULES))


def _call(skill: Skill) -> str:
    """GBNF of one call."""
    rule = ""
    for parameter in reversed(skill.parameters):
        joint = "" if parameter is skill.parameters[0] else '", " '
        rule = f"{joint}{_kind(parameter)} {rule}".strip()
        if parameter.default is not None:
            rule = f"({rule})?"
    return f'"{skill.name}(" {rule} ")"' if rule else f'"{skill.name}()"'


def _kind(parameter: Parameter) -> str:
    return "number" if parameter.type == "number" else "sentence" if parameter.word == "sentence" else "words"
