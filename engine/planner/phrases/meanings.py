"""What each intent means: the actions that carry it out.

Every number and place of an action was said. The exceptions are conventions of the language: "turn left" is a quarter
turn, "turn around" a half one, "a bit" is 20 centimetres, and "slowly" and "quickly" are the speeds below.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from engine.plan import MAX_ACTIONS, Quantity
from engine.planner.phrases.again import REFERENCES
from engine.planner.phrases.conventions import A_BIT, DRIVE_SPEED, FULL, HALF, QUARTER, TURN_SPEED
from engine.planner.phrases.errands import ERRANDS
from engine.planner.phrases.said import Calls, Incomplete, Said, call, just

MOST_REPEATS = MAX_ACTIONS + 1
"""One more than any plan may have: "beep a million times" is understood, and turned down for its length."""


def calls_of(said: Said) -> Calls | None:
    """The actions for ``said``; None when its numbers make no sense. Raises :class:`Incomplete`."""
    if said.manner is not None and said.intent not in _WITH_MANNER:
        return None
    repeats = said.numbers.get("times", 1)
    if repeats != int(repeats) or repeats < 1:
        return None
    calls = _MEANINGS[said.intent](said)
    return None if calls is None else calls * int(min(repeats, MOST_REPEATS))


def _move(said: Said) -> Calls:
    way = said.words["way"]
    distance = Quantity(said.numbers["distance"] * (-1 if way in ("back", "right") else 1), "m")
    return call("move_sideways" if way in ("left", "right") else "move_forward", distance, *_pace(said))


def _move_a_bit(said: Said) -> Calls:
    return _move(replace(said, numbers={"distance": A_BIT}))


def _pace(said: Said) -> tuple[Quantity, ...]:
    """The speed argument, if one was said."""
    if "speed" in said.numbers:
        return (Quantity(said.numbers["speed"], "m/s"),)
    return () if said.manner is None else (Quantity(DRIVE_SPEED[said.manner], "m/s"),)


def _run(said: Said) -> Calls:
    speed = said.numbers.get("speed", DRIVE_SPEED[said.manner])
    x, y = {"forward": (1, 0), "back": (-1, 0), "left": (0, 1), "right": (0, -1)}[said.words["way"]]
    return _velocity(x * speed, y * speed, 0.0, said.numbers["duration"])


def _spin(said: Said) -> Calls:
    rate = said.numbers.get("rate", TURN_SPEED[said.manner])
    return _velocity(0.0, 0.0, rate if said.words["spin"] == "left" else -rate, said.numbers["duration"])


def _velocity(x: float, y: float, turn: float, duration: float) -> Calls:
    return call("set_cmdvel", Quantity(x, "m/s"), Quantity(y, "m/s"), Quantity(turn, "rad/s"), Quantity(duration, "s"))


def _turn(angle: Callable[[Said], float]) -> Callable[[Said], Calls]:
    """A turn by ``angle`` degrees to the side that was said, or to the left."""

    def turn(said: Said) -> Calls:
        degrees = angle(said)
        left = (said.words.get("spin", "left") == "left") == (degrees >= 0)  # minus 90 to the left is to the right
        rate: tuple[Quantity, ...] = ()
        if "rate" in said.numbers:
            rate = (Quantity(said.numbers["rate"], "rad/s"),)
        elif said.manner is not None:
            rate = (Quantity(TURN_SPEED[said.manner], "rad/s"),)
        return call("move_left" if left else "move_right", Quantity(abs(degrees), "deg"), *rate)

    return turn


def _angle(said: Said) -> float:
    return said.numbers["angle" if "angle" in said.numbers else "whole"]


def _whole_angle(said: Said) -> float:
    angle = _angle(said)
    if angle % HALF:
        raise Incomplete("which_way")
    return angle


def _square(said: Said) -> Calls:
    if "distance" not in said.numbers:
        raise Incomplete("how_far")
    corner = call("move_left", Quantity(QUARTER, "deg"))
    return (call("move_forward", Quantity(said.numbers["distance"], "m"), *_pace(said)) + corner) * 4


def _go_through(said: Said) -> Calls:
    """To the places that were said, in that order."""
    places = (said.words[slot] for slot in ("first", "second", "third") if slot in said.words)
    return tuple(action for place in places for action in call("navigation", place))


def _patrol(said: Said) -> Calls:
    """Through the places that were said, in that order; none for all rooms."""
    places = [said.words[slot] for slot in ("first", "second", "third") if slot in said.words]
    return call("patrol", ",".join(places)) if places else call("patrol")


def _wait(said: Said) -> Calls:
    return call("wait", Quantity(said.numbers["duration" if "duration" in said.numbers else "whole"], "s"))


def _beep(said: Said) -> Calls:
    if "duration" in said.numbers:
        return call("beep", Quantity(said.numbers["duration"], "s"))
    return call("beep") * int(min(said.numbers.get("whole", 1), MOST_REPEATS))


_MEANINGS: dict[str, Callable[[Said], Calls | None]] = {
    **ERRANDS,
    **REFERENCES,
    "Go": lambda said: call("navigation", said.words["place"]),
    "GoThrough": _go_through,
    "GoAndWait": lambda said: call("navigation", said.words["place"]) + _wait(said),
    "Return": lambda said: call("navigation", "zero"),
    "Patrol": _patrol,
    "Remember": just("get_current_pose"),
    "Move": _move,
    "MoveABit": _move_a_bit,
    "Run": _run,
    "Turn": _turn(_angle),
    "TurnQuarter": _turn(lambda said: QUARTER),
    "TurnAround": _turn(lambda said: HALF),
    "TurnFull": _turn(lambda said: FULL),
    "TurnWhole": _turn(_whole_angle),
    "Spin": _spin,
    "Square": _square,
    "ArmUp": just("arm_up"),
    "ArmDown": just("arm_down"),
    "Nod": just("arm_nod"),
    "Shake": just("arm_shake"),
    "Applaud": just("arm_applaud"),
    "Dance": just("dance"),
    "Drift": just("drift"),
    "Wait": _wait,
    "Beep": _beep,
    "Light": lambda said: call("light", said.words["colour"]),
    "Say": lambda said: call("say", said.words["text"]),
    "Where": just("report_pose"),
    "Skills": just("list_skills"),
    "EndTask": just("finish_dialogue"),
    "Halt": lambda said: (),
    "Report": lambda said: (),  # whatever looks says what it finds
}
_WITH_MANNER = {
    "Move", "MoveABit", "Run", "Turn", "TurnQuarter", "TurnAround", "TurnFull", "TurnWhole", "Spin", "Square", "Again",
}  # fmt: skip

INTENTS = frozenset(_MEANINGS)
"""Every intent that has a meaning."""

TOPICS = {
    "Go": "go", "GoThrough": "go", "Somewhere": "go", "Turn": "turn", "TurnQuarter": "turn",
    "Look": "look", "Scan": "look", "ArmUp": "arm", "ArmDown": "arm", "Light": "light",
    "Put": "put", "ThrowAway": "errand", "Carry": "errand", "Fetch": "errand",
    "Locate": "errand", "Clean": "clean", "Also": "errand", "FollowLine": "line",
}  # fmt: skip
"""What a following clause without a verb may refer to."""
