"""When a condition needs no look or no watching, and which other nodes it takes something from."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from engine.planner import amounts
from engine.planner.doing.doing import Doing
from engine.planner.entities import Entities
from engine.planner.text.counts import is_amount
from engine.understanding.acts import RoleName
from engine.understanding.meaning import Condition, Do, If, Node, Role

_TOLD: Final = re.compile(
    r"\b(?:i|we|you(?:'re| are)?|further|told|someone|somebody|he|she|they)\b.*"
    r"\b(?:say|says|said|tell|tells|told|call|calls|shout|stop|stops|whistle|notice|otherwise)|"
    r"further (?:notice|orders|instructions)|otherwise|"
    r"\b(?:i|we)(?:'m| am|'ve| have)? (?:get |got )?(?:bored|tired|fed up|done|had enough|finished|ready)|"
    r"我.*(?:说|叫|喊|让)|叫停|喊停|另行通知"
)
"""The user says so, which ends every action anyway."""
_GOES_ON: Final = frozenset({"follow", "patrol", "dance"})
"""Acts that go on until something ends them."""
_ITSELF: Final = re.compile(
    r"you(?:rself|'re| are|'ve| have)?|u|(?:your|ur) (?:hands?|gripper|claw|arm)|你(?:自己|手里|手上|手)?|机器人"
)
_ITSELF_HOLDS: Final = re.compile(
    r"(?:you|you're|you are|you've|you have) (?:already |still )?((?:got |hold|carry|grip).*)|"
    r"(?:你|你?手[里上])((?:拿|抓|夹).*)|"
    r"(?:have |you )?(got your hands? full|your hands? (?:is |are )?full|"
    r"got (?:any|some)?thing in your (?:hands?|gripper))|"
    r"(?:there is |there's )?((?:any|some|no)thing in your (?:hands?|gripper|claw))|"
    r"((?:拿|抓|夹)[着了].*)|你?(手[里上](?:有|没有?).*)"
)
"""That it holds something, told as an event."""
_EMPTY: Final = re.compile(r"empty|free|nothing|空|没")
_HOLDING: Final = re.compile(r"hold|carry|grip|got|full|in your (?:hand|grip)|拿|抓|夹|空手|手里|empty[- ]?handed")
_HELD_THING: Final = re.compile(
    r".*?(?:holding|carrying|hold|carry|got|have)|in your (?:hands?|gripper|grip)|[拿抓夹]着?|手[里上](?:没?有|没)?"
)
"""What stands before the name of the thing in such a state."""
_ANYTHING: Final = re.compile(
    r"your hands? (?:are )?full|(?:any|some|no)thing.*|things?|stuff|(?:什么|任何)?东西|什么|空|.*handed"
)


def untimed(act: Do) -> Do:
    """The act without "until", where its skill ends just then; else as it is."""
    until = act.until
    if until is None or until.words("times"):
        return act
    if until.kind == "event" and _TOLD.search(until.words("topic").casefold()):
        if act.act in _GOES_ON:
            return replace(act, until=None)
        if act.act == "wait" and not act.words("time"):
            return replace(act, act="stop", until=None)
    if until.kind == "seen" and act.act == "follow" and until.words("place") and not act.words("place"):
        who, followed = until.words("person") or until.words("thing"), act.all("person")
        if NAMED_BEFORE.fullmatch(who.casefold()) or who in followed:  # "follow Tom until he is in the kitchen"
            return replace(act, until=None, roles=(*act.roles, *(r for r in until.roles if r.name == "place")))
    if until.kind == "event" and act.act == "follow" and not act.words("place"):
        topic = next((role for role in until.roles if role.name == "topic"), None)
        gets = _GETS_TO.fullmatch(topic.words) if topic is not None else None
        if topic is not None and gets is not None:  # "follow Tom until he gets to the kitchen"
            place = replace(topic, name="place", words=gets["place"] or gets["zh"])
            return replace(act, until=None, roles=(*act.roles, place))
    if until.kind == "seen" and act.act in ("turn_left", "turn_right", "turn", "turn_around", "look"):
        sought = tuple(role for role in until.roles if role.name in ("thing", "person"))
        if sought and not act.roles and not until.words("place"):
            return Do("find", sought)
    return act


_GETS_TO: Final = re.compile(
    r"\w+ (?:gets? to|arrives? (?:at|in)|reach(?:es)?|comes? to|goes? (?:in)?to|is (?:in|at)|enters?) (?P<place>.+)|"
    r"[他她它](?:走?到|进)了?(?P<zh>.+)",
    re.IGNORECASE,
)


def of_itself(doing: Doing, condition: Condition) -> bool | None:
    """Whether a condition about what the robot holds is met; None for any other condition."""
    who = condition.words("person") or condition.words("thing")
    if _ITSELF.fullmatch(who.casefold()) and _BUSY.fullmatch(condition.words("state").casefold()):
        return condition.kind == "is_not"  # who takes a request is not
    found = _about_its_hand(condition) or _about_what_it_holds(doing, condition)
    if found is None and condition.kind in ("seen", "unseen"):
        named = doing.entities.of(condition.words("thing") or "it")
        found = ("got", named.words) if named.held and named.thing is not None else None  # "the blue box you've got"
    if found is None:
        return None
    state, thing = found
    if _EMPTY.search(state):
        met = not doing.in_hand
    elif not doing.in_hand or not thing or _ANYTHING.fullmatch(thing):
        met = bool(doing.in_hand)
    else:
        met = doing.held(doing.thing(thing))
    return met == (condition.kind not in ("is_not", "unseen"))


_BUSY: Final = re.compile(r"(?:too |so |very |still )?busy|很?太?忙")


def of_success(condition: Condition, *, worked: bool) -> bool | None:
    """Whether a condition on how the last action went is met; None for any other condition."""
    who = condition.words("person").casefold() or condition.words("thing").casefold()
    said = (condition.words("topic") or condition.words("state")).casefold().replace("’", "'")
    if condition.kind in ("seen", "unseen") or condition.words("place") or (who and not _DEED.fullmatch(who)):
        return None
    if _WENT.fullmatch(said) is None or not (who or _SAYS_WHOSE.match(said)):
        return None
    succeeds = (_WENT_NOT.search(said) is None) == (condition.kind != "is_not")
    return worked == succeeds


_DEED: Final = re.compile(r"you(?:'ve| have)?|that|this|it|你|这|那")
_SAYS_WHOSE: Final = re.compile(r"(?:you|that|this|it)\b|[你这那没成失找]")
_WENT: Final = re.compile(
    r"(?:(?:you|that|this|it)(?:'ve)? )?"
    r"(?:(?:can|could|do|did|does|has|have|is|was|are|actually)(?: not|n't)? |cannot )*"
    r"(?:work|succe|fail|went (?:well|wrong)|go(?:es)? (?:well|wrong)|manage|ma[dk]e it|f(?:ou|i)nd|reach|able to)"
    r"[a-z]*(?: (?:it|that|them|one|there|him|her))?|你?(?:没有?)?(?:成功|失败|做到|找到|拿到)了?"
)
"""Told of how that went which the robot has just done."""
_WENT_NOT: Final = re.compile(r"n't|\bnot\b|cannot|fail|wrong|没|失败")


def _about_its_hand(condition: Condition) -> tuple[str, str] | None:
    """The state of its hand that a condition is about, and the thing that is named; None where it is about none."""
    who, thing = condition.words("person").casefold(), condition.words("thing")
    state = condition.words("state").casefold()
    if condition.kind == "event" or (not (who or thing) and (_IN_HAND.fullmatch(condition.words("place") or "手里"))):
        told = _ITSELF_HOLDS.fullmatch(re.sub(r"\bur\b", "your", condition.words("topic").casefold() or state))
        who, state = ("you", next(filter(None, told.groups()))) if told is not None else ("", "")
    elif condition.kind in ("seen", "unseen") and _IN_HAND.fullmatch(condition.words("place").casefold()):
        return "got", thing  # "if there's nothing in your hand"
    elif thing and condition.kind in ("is", "is_not") and _IN_HAND.fullmatch(state):
        return "got", thing
    elif condition.kind not in ("is", "is_not"):
        return None
    if not who:  # "your hand is empty"
        who, thing = (condition.words("place") or thing).casefold(), ""
    elif condition.words("place") and not _ITSELF.fullmatch(condition.words("place").casefold()):
        return None
    if not _ITSELF.fullmatch(who) or not (_HOLDING.search(state) or _EMPTY.fullmatch(state)):
        return None
    return state, thing or _HELD_THING.sub("", state).strip()


_IN_HAND: Final = re.compile(r"你?(?:手[里上]?|手中)|(?:in |on )?(?:your|the) (?:hands?|gripper|claw)")


def _about_what_it_holds(doing: Doing, condition: Condition) -> tuple[str, str] | None:
    """The same of a condition on what that is: "if what you're carrying is a box"."""
    who, state = condition.words("person") or condition.words("thing"), condition.words("state")
    speaks_of_it = _ITSELF.fullmatch(who.casefold()) is not None or doing.entities.of(who or "it").held
    speaks_of_it = speaks_of_it and re.search(r"carry|hold|grip|hand|拿|抓|夹", doing.said.casefold()) is not None
    thing = doing.entities.of(state).thing if state and condition.kind in ("is", "is_not") and speaks_of_it else None
    return ("", thing) if thing is not None else None


def looked_for_once(nodes: Sequence[Node], entities: Entities, said: str = "") -> tuple[Node, ...]:
    """The nodes without a search that the condition behind it makes anyway: "look for the ball in the hall, and if it's
    there dance"; and with what needs a thing that may be missing as what depends on it: "bring me the red box, or if
    you can't find that, the blue one"."""
    made: list[Node] = []
    for given in nodes:
        node = given
        if isinstance(given, If):
            node = _without_what_stays(_at_each_place(_of_a_mess(_named_nowhere(_of_failing(given))), entities), said)
        last = made[-1] if made else None
        if isinstance(node, If) and isinstance(last, Do):
            node = _of_the_one_before(node, last)
        if isinstance(node, If) and (wait := _when_it_is_over(node)) is not None:
            made += (wait, *node.then)
            continue
        if isinstance(node, If) and isinstance(last, Do) and _is_had_then(node, last):
            made += node.then
            continue
        if isinstance(node, If) and _ends_anyway(node):
            continue
        if isinstance(node, If) and isinstance(last, If) and _one_or_the_other(last, node, entities):
            made[-1] = replace(last, otherwise=(node,))
        elif isinstance(node, If) and (missed := _only_if_missed(node, entities)) is not None:
            made += missed
        elif (
            isinstance(node, If) and isinstance(last, Do) and last.act == "count" and (counted := _counted(last, node))
        ):
            made[-1] = replace(node, condition=counted)
        elif isinstance(node, If) and isinstance(last, Do) and last.act in _LOOKS and _about_it(last, node, entities):
            taken = [role for role in last.roles if role.name in ("thing", "person", "place")]
            kept = [role for role in node.condition.roles if not entities.of(role.words).refers]
            names = {role.name for role in kept}
            roles = (*(role for role in taken if role.name not in names), *kept)
            made[-1] = replace(node, condition=replace(node.condition, roles=roles))
        elif isinstance(node, If) and isinstance(last, Do) and last.act in _NEEDS and _is_missing(last, node, entities):
            sought = [role for role in last.roles if role.name == "thing"]
            at = [replace(role, name="place") for role in last.roles if role.name == "source"]
            at = at or _elsewhere(node, entities)
            if at:
                made[-1] = If(Condition("seen", (*sought, *at)), (last, *node.otherwise), node.then)
            else:
                made.append(If(_FAILED, node.then, node.otherwise))
        else:
            made.append(node)
    return tuple(made)


_FAILED: Final = Condition("event", (Role("topic", "you fail", 0, 0),))
"""That the action before it has failed."""


def _of_failing(node: If) -> If:
    """ "If you can't": that what was tried before has failed."""
    condition = node.condition
    if condition.kind == "seen" or any(role.name not in ("person", "topic") for role in condition.roles):
        return node
    said = " ".join(role.words.casefold().replace("’", "'") for role in condition.roles)
    fails = _CANNOT.fullmatch(said) is not None or (condition.kind == "unseen" and said == "you")
    return replace(node, condition=_FAILED) if fails and condition.kind != "is_not" else node


_CANNOT: Final = re.compile(r"(?:you|it) (?:can't|can not|cannot|couldn't|could not|don't|do not|didn't|did not)")


def _when_it_is_over(node: If) -> Do | None:
    """The wait that a condition is which only time decides: "as soon as ten seconds are over"."""
    if node.otherwise or node.condition.kind not in ("event", "is") or not node.condition.roles:
        return None
    found = _OVER.fullmatch(" ".join(role.words for role in node.condition.roles).casefold())
    time = (found["en"] or found["zh"]) if found is not None else ""
    if amounts.quantity(time, "s") is None:
        return None
    return Do("wait", (replace(node.condition.roles[0], name="time", words=time),))


_OVER: Final = re.compile(
    r"(?P<en>.+?)(?: (?:is|are|has|have))?(?: (?:over|up|past|passed|gone|elapsed|later))(?: by)?|"
    r"(?P<zh>.+?)(?:过后|之后|以后|过去了?|到了?)"
)
"""A time that has passed."""


def _is_had_then(node: If, last: Do) -> bool:
    """Whether it only says that what is brought is there: "once I've got it, go back"."""
    topic = node.condition.words("topic").casefold().replace("’", "'")
    brings = last.act == "bring" and not node.otherwise and node.condition.kind == "event"
    return brings and _I_HAVE_IT.fullmatch(topic) is not None


_I_HAVE_IT: Final = re.compile(
    r"(?:i|we)(?:'ve| have)(?: got)? (?:it|that|them)|(?:i|we) (?:get|got) (?:it|that|them)|我拿到(?:它|东西)?了?"
)


def _of_the_one_before(node: If, last: Do) -> If:
    """ "Bring me the blue cup, and if you can't find it the white one": a reader has made that "if you can't find the
    white one, bring the white one"."""
    condition, first = node.condition, node.then[0] if node.then else None
    if condition.kind != "unseen" or not isinstance(first, Do) or first.act not in _NEEDS or last.act not in _NEEDS:
        return node
    needed, wanted = ([role for role in act.roles if role.name == "thing"] for act in (first, last))
    spans = [(role.start, role.end) for role in condition.roles]
    if len(needed) != 1 or len(wanted) != 1 or spans != [(needed[0].start, needed[0].end)]:
        return node
    return replace(node, condition=replace(condition, roles=(wanted[0],)))


def _counted(count: Do, node: If) -> Condition | None:
    """The condition with what was counted before, of which it says but how many there are; None for any other."""
    condition = node.condition
    topic = next((role for role in condition.roles if role.name == "topic"), None)
    if condition.kind == "event" and topic is not None and (many := _THERE_ARE.fullmatch(topic.words.casefold())):
        three = replace(topic, name="thing", words=many["many"] or many["zh"])  # "when it is three"
        condition = Condition("seen", (three,))
    said = [role for role in condition.roles if role.name in ("thing", "person")]
    of = next((role for role in count.roles if role.name in ("thing", "person")), None)
    if of is None or len(said) != 1 or not is_amount(said[0].words) or condition.kind not in ("seen", "unseen"):
        return None
    between = " " if of.words.isascii() else ""
    places = [role for role in count.roles if role.name == "place"]
    return replace(condition, roles=(replace(of, words=f"{said[0].words}{between}{of.words}"), *places))


_THERE_ARE: Final = re.compile(r"(?:it|there|they)(?:'s|'re| is| are) (?P<many>.+)|(?:有|是)(?P<zh>.+)")


def _at_each_place(node: If, entities: Entities) -> If:
    """Of a thing that may be at one of several places, one condition after the other: "on the desk or the shelf"."""
    condition = node.condition
    places = [role for role in condition.roles if role.name == "place"]
    things = condition.all("thing")
    if condition.kind != "seen" or len(places) < 2 or len(things) != 1 or entities.of(things[0]).every:
        return node
    others = tuple(role for role in condition.roles if role.name != "place")
    first, *rest = places
    behind = _at_each_place(replace(node, condition=replace(condition, roles=(*others, *rest))), entities)
    return If(replace(condition, roles=(*others, first)), node.then, (behind,))


def _named_nowhere(node: If) -> If:
    """ "If it's nowhere": it is not there."""
    condition = node.condition
    roles = tuple(
        replace(role, words="it") if role.name == "thing" and _NOWHERE.fullmatch(role.words.casefold()) else role
        for role in condition.roles
    )
    return node if roles == condition.roles else replace(node, condition=replace(condition, kind="unseen", roles=roles))


def _of_a_mess(node: If) -> If:
    """What is tidy is not tidied: "see whether it is tidy, and clean it if it isn't"."""
    condition = node.condition
    cleans = bool(node.then) and all(isinstance(act, Do) and act.act in ("clean", "tidy") for act in node.then)
    if not cleans or condition.kind != "is" or TIDY.fullmatch(condition.words("state").casefold()) is None:
        return node
    return replace(node, condition=replace(condition, kind="is_not"))


TIDY: Final = re.compile(
    r"(?:free|clear) of (?:clutter|mess|junk|rubbish)|"
    r"(?:all |nice and |quite )?(?:tidy|clean|neat|in order)(?: enough)?|整[洁齐]|干净的?"
)
"""A state of a room in which nothing lies about."""
_NOWHERE: Final = re.compile(r"(?:it'?s |it is )?nowhere(?: to be (?:seen|found))?|luck")


def _without_what_stays(node: If, said: str) -> If:
    """Without what is said to be left as it is, which a reader takes for an act: "…, leave it there"."""
    if _STAYS.search(said.casefold()) is None:
        return node
    then, otherwise = (
        tuple(one for one in branch if not (isinstance(one, Do) and _leaves_it(one)))
        for branch in (node.then, node.otherwise)
    )
    return replace(node, then=then, otherwise=otherwise)


def _leaves_it(act: Do) -> bool:
    return act.act in ("leave", "stop") or (act.act in ("put", "drop") and not act.words("place"))


_STAYS: Final = re.compile(
    r"\b(?:leave|let) (?:it|them|him|her|that|those|everything)(?: all)?\b(?: (?:alone|be|there|where))?|"
    r"\b(?:it|they) stays?\b|"
    r"别动|不用管|不管它|放着"
)


def _only_if_missed(node: If, entities: Entities) -> tuple[Node, ...] | None:
    """What a reader has the wrong way round: "bring me the white cup, or the blue one if it can't be found" does not
    bring the white one if it cannot be found. None for every other condition."""
    first = node.then[0] if len(node.then) == 1 else None
    if not node.otherwise or not isinstance(first, Do) or first.act not in _NEEDS or first.words("source"):
        return None
    told_first = _begins(first.roles) < _begins(node.condition.roles)
    if not told_first or not _is_missing(first, node, entities):
        return None
    if at := _elsewhere(node, entities):
        things = tuple(role for role in first.roles if role.name == "thing")
        return (If(Condition("seen", (*things, *at)), node.then, node.otherwise),)
    return (first, If(_FAILED, node.otherwise, ()))


def _begins(roles: Sequence[Role]) -> int:
    return min((role.start for role in roles), default=0)


def _one_or_the_other(first: If, second: If, entities: Entities) -> bool:
    """Whether they ask for the same thing at two places: it is at one of them at the most."""
    conditions = (first.condition, second.condition)
    if first.otherwise or any(condition.kind != "seen" or condition.words("person") for condition in conditions):
        return False
    one, other = (entities.of(condition.words("thing") or "it") for condition in conditions)
    places = [entities.of(condition.words("place") or "it").place for condition in conditions]
    same = not one.every and one.thing is not None and (other.refers or other.thing == one.thing)
    return same and None not in places and places[0] != places[1]


def _ends_anyway(node: If) -> bool:
    """Whether it only says that the robot stops when it is told to."""
    stops = all(isinstance(act, Do) and act.act == "stop" for act in node.then) and not node.otherwise
    return (
        stops and node.condition.kind == "event" and _TOLD.search(node.condition.words("topic").casefold()) is not None
    )


_LOOKS: Final = frozenset({"find", "look", "check"})
_NEEDS: Final = frozenset({"bring", "pick_up", "put", "throw_away"})


def _is_missing(act: Do, node: If, entities: Entities) -> bool:
    """Whether a condition is that the one thing of an act is not to be found."""
    thing = node.condition.words("thing")
    needed = act.all("thing")
    if not thing and node.condition.words("place") and not node.condition.words("person"):
        thing = "it"  # "bring me a cup; if there is none on the desk, …"
    if node.condition.kind != "unseen" or not thing or len(needed) != 1:
        return False
    sought = entities.of(needed[0]).thing
    if sought is None:
        return entities.of(thing).refers
    return entities.of(thing).refers or sought in (entities.of(thing).thing, entities.like(thing, sought))


def _elsewhere(node: If, entities: Entities) -> list[Role]:
    """The places of a condition that are no "there"."""
    return [role for role in node.condition.roles if role.name == "place" and not entities.of(role.words).refers]


def _about_it(search: Do, node: If, entities: Entities) -> bool:
    """Whether a condition is about what was searched for, or lies where it was looked."""
    thing, place = node.condition.words("thing"), node.condition.words("place")
    person = search.words("person")
    if person and (not search.words("place") or entities.is_name(person)):
        return False  # a look from one place does not find them
    if search.words("thing"):
        same = entities.of(thing).thing == entities.of(search.words("thing")).thing
        return bool(thing) and (entities.of(thing).refers or same)
    return not place or entities.of(place).refers


def with_antecedent(
    node: If, entities: Entities, said: str = "", *, thing: bool = True, place: bool = True, person: bool = True
) -> Condition:
    """The condition with the thing that "it" is in it, where that is only named in what depends on it: "pick up the cup
    only if it is on the desk"; so with the place: "go down the hall unless somebody is in there". What was ``said``
    before the condition goes first: "the cup was on the desk; if it's still there …". ``thing``, ``place``, ``person``:
    whether none was named before."""
    acts = [act for act in (*node.then, *node.otherwise) if isinstance(act, Do)]
    begins = min((role.start for role in node.condition.roles), default=0)
    things = (role.words for role in _named_before(acts, begins, "thing") if not entities.of(role.words).refers)
    places = (
        role.words
        for role in _named_before(acts, begins, "source", "place")
        if entities.of(role.words).place and not entities.of(role.words).me
    )
    refers = {
        role
        for role in node.condition.roles
        if entities.of(role.words).refers
        or _OF_THEM.fullmatch(role.words)
        or (role.name == "person" and NAMED_BEFORE.fullmatch(role.words.casefold().replace("’", "'")))
    }
    people = (
        role.words
        for role in _named_before(acts, begins, "person")
        if role.start < begins and not NAMED_BEFORE.fullmatch(role.words.casefold())
    )
    meant: dict[RoleName, str | None] = {
        "thing": entities.thing_in(said[:begins]) or next(things, None) if thing else None,
        "place": entities.place_in(said[:begins]) or next(places, None) if place else None,
        "person": next(people, None) if person else None,
    }
    roles = (
        replace(role, words=words) if (words := meant.get(role.name)) and role in refers else role
        for role in node.condition.roles
    )
    condition = replace(node.condition, roles=tuple(roles))
    state = next((role for role in condition.roles if role.name == "state"), None)
    if state is None or condition.words("place") or not meant["place"] or not _THERE.search(state.words.casefold()):
        return condition
    return replace(condition, roles=(*condition.roles, replace(state, name="place", words=meant["place"])))


def _named_before(acts: Sequence[Do], begins: int, *names: RoleName) -> Sequence[Role]:
    """The roles of these names: first those that were said before the condition ``begins``, in the order of a text."""
    roles = [role for act in acts for role in act.roles if role.name in names]
    return sorted(roles, key=lambda role: (role.start >= begins, role.start))


NAMED_BEFORE: Final = re.compile(r"(?:he|she|they)(?:'s|'re| is| are)?|him|her|them|[他她]们?")
"""Who was named before: "he", "she's", "them"."""
_OF_THEM: Final = re.compile(r"(?:any|some|one|a few|several)(?: of (?:it|them|those))?", re.IGNORECASE)
"""Of what is to be taken: "take the blocks off the desk if there are any"."""
_THERE: Final = re.compile(r"\bthere\b|在那")
"""A state of being where something is to go: "to the bed if it isn't there already"."""
