"""HuRIC (Bastianelli et al. 2014; Vanzo et al. 2020; Apache-2.0): commands to a robot with semantic frames, as
meanings.

A fixed third, chosen by a hash of the sentence's id, is for development and never learnt from.
"""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any, Final

from engine.understanding.notation import Example, Step
from engine.understanding.training.examples import clean

_ACTS: Final = {
    "Bringing": ("bring", {"Theme": "thing", "Beneficiary": "person", "Goal": "place", "Source": "source",
                              "Manner": "manner"}),
    "Giving": ("bring", {"Theme": "thing", "Recipient": "person"}),
    "Taking": ("pick_up", {"Theme": "thing", "Source": "source"}),
    "Placing": ("put", {"Theme": "thing", "Goal": "place", "Manner": "manner"}),
    "Releasing": ("drop", {"Theme": "thing", "Goal": "place"}),
    "Motion": ("go", {"Goal": "place", "Manner": "manner"}),
    "Arriving": ("go", {"Goal": "place"}),
    "Cotheme": ("follow", {"Cotheme": "person", "Goal": "place"}),
    "Locating": ("find", {"Sought_entity": "thing", "Ground": "place"}),
    "Inspecting": ("check", {"Ground": "thing", "Desired_state": "state"}),
    "Perception_active": ("look", {"Phenomenon": "thing"}),
    "Being_located": ("fact", {"Theme": "thing", "Location": "place", "Place": "place"}),
    "Being_in_category": ("fact", {"Item": "thing", "Category": "state"}),
    "Attaching": ("other", {"Goal": "thing"}),
}  # fmt: skip
"""The act of each frame, and the roles of its roles. Turning, opening and switching are looked at below."""
_ME: Final = re.compile(r"\b(?:me|him|her|us|them|my|person|friend|guy|man|woman|mother|father|people)\b")


def examples(path: Path) -> tuple[list[Example], list[Example]]:
    """Those to learn from, and those for development."""
    learn, develop = list[Example](), list[Example]()
    for line in path.read_text("utf-8").splitlines():
        entry = json.loads(line)
        if (example := _example(entry)) is not None:
            third = hashlib.sha256(entry["id"].encode()).digest()[0] % 3 == 0
            (develop if third else learn).append(example)
    return learn, develop


def _example(entry: dict[str, Any]) -> Example | None:
    text, starts = "", []
    for token in entry["tokens"]:
        text += (" " if text else "") + token
        starts.append(len(text) - len(token))
    ends = [start + len(token) for start, token in zip(starts, entry["tokens"], strict=True)]
    steps: list[Step] = []
    for frame in sorted(entry["frames"], key=lambda frame: frame["unit"][0]):
        if frame["frame"].startswith("Being") and _inside(frame, entry["frames"]):
            continue  # "the cup that is on the table": part of a role
        roles = {name: (starts[a], ends[b - 1]) for name, (a, b) in frame["roles"].items()}
        said = {name: text[a:b] for name, (a, b) in roles.items()}
        act, names = _act(frame["frame"], said, text[starts[frame["unit"][0]] : ends[frame["unit"][1] - 1]], text)
        if not act:
            return None
        found = []
        for name, (a, b) in roles.items():
            if (role := names.get(name)) is not None:
                if act == "follow" and role == "person" and not _ME.search(said[name]) and "person" in names.values():
                    role = "person" if re.search(r"\bwith|along", text) else "thing"
                if act == "bring" and role == "place" and re.fullmatch(r"(?:to )?(?:me|him|her|us|them)", said[name]):
                    role = "person"
                found.append(clean(text, Step(role, a, b)))
        steps += [Step(act), *sorted(found, key=lambda step: step.start)]
    return Example(text, tuple(steps)) if steps else None


def _inside(frame: dict[str, Any], frames: list[dict[str, Any]]) -> bool:
    begin, end = frame["unit"]
    return any(a <= begin and end <= b for other in frames if other is not frame for a, b in other["roles"].values())


def _act(frame: str, said: dict[str, str], unit: str, text: str) -> tuple[str, dict[str, str]]:
    if frame == "Being_located" and re.search(r"\b(?:check|see|look|verify|control)\b.*\b(?:if|whether)\b", text):
        return "check", {"Theme": "thing", "Location": "place"}
    if frame == "Change_direction":
        side = "left" if "left" in said.get("Direction", "") else "right"
        turned = re.search(r"\b(left|right)\b", said.get("Direction", "")) is not None
        return (f"turn_{side}" if turned else "turn_around"), {"Angle": "amount", "Speed": "manner"}
    if frame == "Change_operational_state":
        off = re.search(r"\boff\b|\bstop|switch off|deactivate", f"{unit} {said.get('Operational_state', '')}")
        return ("switch_off" if off else "switch_on"), {"Device": "thing"}
    if frame == "Closure":
        return ("close" if re.search(r"clos|shut", unit) else "open"), {
            "Container_portal": "thing",
            "Containing_object": "thing",
        }
    if frame == "Motion" and "Goal" not in said:
        direction = f"{said.get('Direction', '')} {said.get('Area', '')} {said.get('Path', '')}"
        for words, act in (("back", "backward"), ("left", "sideways_left"), ("right", "sideways_right"),
                           ("forward|ahead|straight|front", "forward")):  # fmt: skip
            if re.search(words, direction):
                return act, {"Distance": "amount", "Manner": "manner"}
        return "", {}
    act, names = _ACTS.get(frame, ("", {}))
    if act == "pick_up" and "Beneficiary" in said:
        return "bring", {**names, "Beneficiary": "person"}
    return act, names
