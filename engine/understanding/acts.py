"""The acts that a request can ask for, and the roles that each of them takes.

An act is what the speaker wants done, told in the speaker's terms: ``bring``, ``turn_left``, ``count``. It is no
skill: which skill serves it is decided later, by what its roles turn out to name. Acts without any skill are listed
too, because a request that is understood can be declined with the right words."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, Literal, NamedTuple

RoleName = Literal[
    "thing", "place", "source", "person", "except", "amount", "time", "times", "manner", "colour", "text", "topic",
    "state",
]  # fmt: skip
"""What a part of a request is to its act.

thing: what is acted on: an object, furniture, a device, a line. place: where to, or where it happens. source: where
the thing is now. person: whom it is done to or for ("me" too). except: which of those are not meant. amount: a
distance or an angle. time: a duration or a moment. times: how often. manner: how, at which speed. colour: of a light.
text: words to be said or asked. topic: what is asked about. state: what something is to be or is asked to be ("open",
"empty")."""
ROLES: Final[tuple[RoleName, ...]] = (
    "thing", "place", "source", "person", "except", "amount", "time", "times", "manner", "colour", "text", "topic",
    "state",
)  # fmt: skip


class Act(NamedTuple):
    """One act: its roles, and what it means in a sentence for people."""

    roles: tuple[RoleName, ...]
    means: str


def _acts() -> dict[str, Act]:
    acts: dict[str, Act] = {}

    def add(name: str, roles: str, means: str) -> None:
        acts[name] = Act(tuple(role for role in ROLES if role in roles.split()), means)

    # Moving the base
    add("go", "place thing person except manner", "drive to a place, a thing or a person")
    add("come", "person manner", "come to the speaker")
    add("forward", "amount time manner", "drive straight ahead")
    add("backward", "amount time manner", "drive straight back")
    add("sideways_left", "amount time manner", "move sideways to the left without turning")
    add("sideways_right", "amount time manner", "move sideways to the right without turning")
    add("turn_left", "amount time manner", "turn left on the spot")
    add("turn_right", "amount time manner", "turn right on the spot")
    add("move", "amount time manner", "drive or move, in a direction that is not said")
    add("turn", "amount time manner", "turn, to a side that is not said")
    add("turn_around", "amount times manner", "turn about to face the other way, or spin")
    add("face", "place thing person", "turn towards something or someone")
    add("leave", "place", "get out of a room, or out of the way")
    add("go_back", "place manner", "return to where it was before, or to where it started")
    add("charge", "place", "go and recharge")
    add("drive_shape", "thing amount times manner", "drive a figure: a square, a circle, an eight")
    add("follow", "person thing place source", "follow someone, or something such as a line or a colour")
    add("guide", "person place source", "lead someone to a place")
    add("patrol", "place except times time", "go round several places again and again")
    add("stop", "time", "stand still")
    add("wait", "time place person", "wait for a time")
    add("drift", "", "drive a drift")
    add("dance", "time", "dance")
    # Handling things
    add("pick_up", "thing source except manner", "take a thing into the gripper")
    add("put", "thing place except manner", "put a thing somewhere; without a place: put it down here")
    add("bring", "thing person place source except manner", "fetch a thing and bring it to someone or somewhere")
    add("drop", "thing", "let go of what is held")
    add("throw_away", "thing source except", "put a thing into the bin")
    add("tidy", "thing place source except", "put things that lie about where they belong, or to a given place")
    add("clean", "place thing except", "clean a room or a surface")
    add("sort", "thing manner place except", "sort things, by colour or by tag number")
    add("push", "thing place amount", "push or move a thing without picking it up")
    add("open", "thing except", "open a door, a drawer, a window, a box")
    add("close", "thing except", "close a door, a drawer, a window, a box")
    add("switch_on", "thing place except", "turn a device or the lights of a house on")
    add("switch_off", "thing place except", "turn a device or the lights of a house off")
    # Looking
    add("look", "place thing person except", "look, or look around, and say what is there")
    add("find", "thing person place except", "search for a thing or a person, or tell where it is")
    add("count", "thing person place except", "count things or people and tell how many")
    add("describe", "thing person place topic", "look at a thing or a person and tell what it is like")
    add("check", "thing person place state except", "look whether something is so")
    add("read", "thing", "read a text, a label or a code aloud")
    # The robot's own arm and signals
    add("arm_up", "", "raise the arm")
    add("arm_down", "", "lower the arm, or fold it away")
    add("arm_turn", "amount place", "turn the arm about its vertical axis to an angle or a side")
    add("open_gripper", "", "open the gripper")
    add("close_gripper", "", "close the gripper")
    add("nod", "times", "nod")
    add("shake", "times", "shake its head, as a no")
    add("applaud", "times", "clap")
    add("wave", "person times", "wave")
    add("beep", "time times", "beep or honk; `time` is how long it sounds")
    add("light", "colour", "switch its own light to a colour, or on")
    add("light_off", "", "switch its own light off")
    # Speaking
    add("say", "text times", "say given words aloud, to nobody in particular")
    add("tell", "person text topic place except", "go and tell someone something")
    add("ask", "person text topic place", "go and ask someone something")
    add("answer", "topic person", "tell something it knows: the time, its name, a joke")
    add("greet", "person place except", "greet someone")
    add("meet", "person place", "go to someone and get to know them")
    add("introduce", "person place", "introduce someone to others")
    # What it knows of itself
    add("report", "topic", "tell about itself: where it is, what it holds, its battery, what it did and why")
    add("skills", "", "tell what it can do")
    add("remember", "place text", "remember this spot, by a name if one is given")
    # The conversation
    add("end_task", "", "end the task: we are done")
    add("again", "times", "do the last thing once more")
    add("undo", "", "undo what was done last")
    add("resume", "", "go on with what was interrupted")
    add("yes", "", "yes")
    add("no", "", "no")
    add(
        "fragment",
        "thing place source person amount time times manner colour text state",
        "only an answer or a part of a request, without a verb that says what to do",
    )
    add(
        "fact",
        "thing person place state topic",
        "the speaker tells how things are (where a thing is), and asks for nothing by that",
    )
    add("talk", "", "small talk, thanks, or a remark that asks for nothing")
    add("other", "thing place person", "something else that a robot could be asked for: fold, pour, cook, iron, call")
    return acts


ACTS: Final[Mapping[str, Act]] = MappingProxyType(_acts())
"""All acts by name."""

CONDITIONS: Final[Mapping[str, Act]] = MappingProxyType(
    {
        "seen": Act(("thing", "place", "person", "times"), "there is such a thing or person (there)"),
        "unseen": Act(("thing", "place", "person", "times"), "there is no such thing or person (there)"),
        "is": Act(("thing", "place", "person", "times", "state"), "something or someone is in a state: open, asleep"),
        "is_not": Act(("thing", "place", "person", "times", "state"), "something or someone is not in a state"),
        "event": Act(("times", "topic"), "anything else: when the bell rings, if it rains, when I say so"),
    }
)
"""What a request can depend on. ``times`` is there where it is to be done each time that it holds ("whenever")."""
