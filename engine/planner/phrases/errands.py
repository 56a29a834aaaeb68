"""What is said about things: which one is meant, and the actions that fetch, carry, put or follow it.

"It" is what was named last in the same sentence, or else, where something is put down, what the robot holds. A thing
that was picked up in this sentence is not picked up again to be put somewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from engine.plan import ActionCall, Quantity
from engine.planner.phrases.conventions import HALF, QUARTER
from engine.planner.phrases.said import ONE, Calls, Incomplete, Said, Things, call, just

BIN: Final = "bin"


def named_in(said: Said) -> str:
    """The thing that a clause names, as skills know it; empty when it names none."""
    return f"block {said.numbers['tag']:g}" if "tag" in said.numbers else _as_called(said.words.get("object", ""), said)


def _as_called(thing: str, said: Said) -> str:
    """The thing; a "white one" after a blue cup is a white cup."""
    if not thing.endswith(f" {ONE}"):
        return thing
    _, _, noun = said.things.named.rpartition(" ")
    return thing.removesuffix(ONE) + (noun or "thing")


def things_after(said: Said, calls: Calls) -> Things:
    """What the next clause may refer to."""
    if said.intent not in _OF_A_THING:
        return said.things._replace(fetched=None)
    thing = named_in(said) or said.things.named or said.things.held
    done = tuple((call.name, call.positional) for call in calls)
    if said.intent == "PickUp":
        return Things(thing, thing, done)
    fetched = tuple(slot for slot in said.words.items() if slot[0] == "source") if said.intent == "Fetch" else None
    return Things(thing, "" if said.intent in _LAYS_DOWN else said.things.held, done, fetched)


def going_on(said: Said) -> Said | None:
    """What is said about "it" after "fetch the cup from the table": from there it goes where this clause says, and not
    by way of whoever speaks. None for any other clause."""
    if said.things.fetched is None or said.intent not in _LAYS_DOWN or named_in(said):
        return None
    return replace(said, words={**said.words, **dict(said.things.fetched)})


def _thing(said: Said) -> str:
    """The thing that is meant. Raises :class:`Incomplete` when it is "it", and nothing was named before."""
    thing = named_in(said) or said.things.named
    if not thing:
        raise Incomplete("which_thing")
    return thing


def _is_held(said: Said) -> bool:
    """Whether the thing that is meant is in the hand by now: "the box" is the red box that was picked up."""
    named, held = named_in(said) or said.things.named, said.things.held
    return bool(held) and (not named or held == named or held.endswith(f" {named}"))


def _picked_up(said: Said) -> Calls:
    """Nothing where it is held already, or where "it" can only be what the robot holds."""
    if _is_held(said) or not (named_in(said) or said.things.named):
        return ()
    return (*_going(said), *call("pick_object", _thing(said)))


def _going(said: Said) -> Calls:
    """To where the thing is said to be."""
    return call("navigation", said.words["source"]) if "source" in said.words else ()


def _turned(said: Said) -> Calls:
    """To the side that is to be looked at."""
    aside = said.words.get("aside")
    if aside is None:
        return ()
    way = "move_right" if aside == "right" else "move_left"
    return call(way, Quantity(HALF if aside == "back" else QUARTER, "deg"))


def _pick_up(said: Said) -> Calls | None:
    return None if said.things.held else (*_going(said), *call("pick_object", _thing(said)))


def _put(said: Said) -> Calls | None:
    if said.things.held and not _is_held(said):
        return None  # the hand is full of something else
    if "place" in said.words:
        return _put_in_place(said)
    surface = said.words["surface"]
    put = call("place_in_bin") if surface == BIN else call("place_object", surface)
    return _picked_up(said) + put


def _put_in_place(said: Said) -> Calls:
    place = said.words["place"]
    if _is_held(said) or not (named_in(said) or said.things.named):
        return call("navigation", place) + call("putdown")
    return call("carry", _thing(said), place)


def _put_down(said: Said) -> Calls | None:
    named = named_in(said)
    if not named and any(name == "carry" for name, _ in said.things.done):
        return ()  # it is there by now
    if said.things.held:
        return call("putdown") if _is_held(said) else None
    # "the box" may be another one than what the robot holds; "it" was only named, not picked up
    return None if named or said.things.named else call("putdown")


def _carry(said: Said) -> Calls | None:
    if said.things.held and not _is_held(said):
        return None
    source = (said.words["source"],) if "source" in said.words else ()
    return call("carry", _thing(said), said.words["place"], *source)


def _both(errand: Callable[[Said], Calls | None]) -> Callable[[Said], Calls | None]:
    """The same with one thing and another, one after the other."""

    def both(said: Said) -> Calls | None:
        if said.things.held:
            return None
        first, second = said.words["object"], said.words["another"]
        done = [errand(replace(said, words={**said.words, "object": thing})) for thing in (first, second)]
        return None if done[0] is None or done[1] is None else done[0] + done[1]

    return both


def _also(said: Said) -> Calls | None:
    """With another thing what was done with the one before."""
    before, thing = said.things.named, named_in(said)
    if said.things.held or not any(before in arguments for _, arguments in said.things.done):
        return None
    return tuple(
        ActionCall(name, tuple(thing if argument == before else argument for argument in arguments))
        for name, arguments in said.things.done
    )


def _locate(said: Said) -> Calls:
    return (*_going(said), *call("locate", named_in(said)))


def _in_room(name: str) -> Callable[[Said], Calls]:
    """In the room that was said; in the one that the robot is in for none."""
    return lambda said: call(name, said.words["room"]) if "room" in said.words else call(name)


def _of_colour(name: str) -> Callable[[Said], Calls]:
    """With the colour that was said; with any for none."""
    return lambda said: call(name, said.words["thing_colour"]) if "thing_colour" in said.words else call(name)


def _follow_tag(said: Said) -> Calls:
    return call("apriltag_follow", *([Quantity(said.numbers["tag"])] if "tag" in said.numbers else []))


def _sort(said: Said) -> Calls:
    if "tag" not in said.numbers:
        raise Incomplete("which_tag")
    return call("apriltag_sort", Quantity(said.numbers["tag"]))


def _height(said: Said) -> Quantity:
    if "distance" not in said.numbers:
        raise Incomplete("how_high")
    return Quantity(said.numbers["distance"], "m")


def _servo(said: Said) -> Calls:
    if "pointing" in said.words:
        return call("servo1_move", Quantity(_POINTING[said.words["pointing"]], "deg"))
    return call("servo1_move", Quantity(said.numbers["angle" if "angle" in said.numbers else "whole"], "deg"))


_POINTING: Final = {"right": 0.0, "ahead": 90.0, "left": 180.0}
"""deg, of servo 1"""


ERRANDS: Mapping[str, Callable[[Said], Calls | None]] = {
    "OpenHand": just("open_gripper"),
    "CloseHand": just("close_gripper"),
    "Servo": _servo,
    "Look": lambda said: (*_turned(said), *_going(said), *call("seewhat")),
    "Scan": _in_room("scan_room"),
    "Clean": _in_room("clean_room"),
    "Tidy": lambda said: call("tidy", said.words["thing_colour"], said.words["surface"]),
    "ThrowAway": _put,
    "Carry": _carry,
    "CarryBoth": _both(_carry),
    "Fetch": _carry,
    "Put": _put,
    "PutBoth": _both(_put),
    "Also": _also,
    "PutDown": _put_down,
    "PickUp": _pick_up,
    "Locate": _locate,
    "Approach": lambda said: call("navigate_to_object", _thing(said)),
    "FollowPerson": just("person_follow"),
    "FollowQr": just("qr_follow"),
    "FollowTag": _follow_tag,
    "FollowLine": _of_colour("follow_line"),
    "FollowLineClear": _of_colour("follow_line_clear"),
    "FollowColour": _of_colour("color_follow"),
    "Sort": _sort,
    "RemoveTall": lambda said: call("apriltag_remove_higher", _height(said)),
    "RemoveTallColour": lambda said: call("color_remove_higher", said.words["thing_colour"], _height(said)),
}
"""The actions of each intent; None where what was said makes no sense."""

NEEDED: Mapping[str, frozenset[str]] = {
    "OpenHand": frozenset({"open_gripper"}),
    "CloseHand": frozenset({"close_gripper"}),
    "Servo": frozenset({"servo1_move"}),
    "Look": frozenset({"seewhat"}),
    "Scan": frozenset({"scan_room"}),
    "Clean": frozenset({"clean_room"}),
    "Tidy": frozenset({"tidy"}),
    "ThrowAway": frozenset({"pick_object", "place_in_bin"}),
    "Carry": frozenset({"carry"}),
    "CarryBoth": frozenset({"carry"}),
    "Fetch": frozenset({"carry"}),
    "Put": frozenset({"pick_object", "place_object", "place_in_bin", "carry", "navigation", "putdown"}),
    "PutBoth": frozenset({"pick_object", "place_object", "place_in_bin", "carry"}),
    "Also": frozenset({"carry"}),
    "PutDown": frozenset({"putdown"}),
    "PickUp": frozenset({"pick_object"}),
    "Locate": frozenset({"locate"}),
    "Approach": frozenset({"navigate_to_object"}),
    "FollowPerson": frozenset({"person_follow"}),
    "FollowQr": frozenset({"qr_follow"}),
    "FollowTag": frozenset({"apriltag_follow"}),
    "FollowLine": frozenset({"follow_line"}),
    "FollowLineClear": frozenset({"follow_line_clear"}),
    "FollowColour": frozenset({"color_follow"}),
    "Sort": frozenset({"apriltag_sort"}),
    "RemoveTall": frozenset({"apriltag_remove_higher"}),
    "RemoveTallColour": frozenset({"color_remove_higher"}),
}
"""The skills without which an intent means nothing to a robot."""

_LAYS_DOWN = {"Put", "PutBoth", "PutDown", "ThrowAway", "Carry", "CarryBoth", "Fetch", "Also"}
_OF_A_THING = {*_LAYS_DOWN, "PickUp", "Locate", "Approach"}
