"""What one meaning comes to: a plan, an answer, a question, or why there is none.

The entities of this house say what the words of the meaning name, ``doing`` turns its acts into actions, and only the
skill registry makes a plan of them. What is said to the robot as somebody it talks with ("again", "go on", "what do you
hold") is answered from what is on record.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Final, TypeGuard

from engine.errors import ExitCode, PlanError
from engine.facts import fact, is_of_the_clock
from engine.plan import Action, ActionCall, Plan
from engine.planner import about_itself, amounts
from engine.planner.doing.acts import calls_of
from engine.planner.doing.answers import depends_on_an_answer, is_met
from engine.planner.doing.conditions import looked_for_once, of_itself, of_success, with_antecedent
from engine.planner.doing.doing import MOST, Doing, NowhereKnown, Open, Unable, Which
from engine.planner.doing.errands import brought
from engine.planner.doing.handling import is_rubbish, rubbish_in
from engine.planner.doing.looking import topic_of
from engine.planner.doing.people import as_name, somebody
from engine.planner.doing.said_once import in_full
from engine.planner.doing.several import looked_first
from engine.planner.doing.sought import ANYTHING, PERSON, Sought, sought
from engine.planner.entities import Entities
from engine.planner.happened import (
    answered_last,
    counted_last,
    decided_last,
    last_question,
    named_last,
    planned_last,
    worked_last,
)
from engine.planner.phrases.phrases import Phrases, Told
from engine.planner.phrases.said import Calls
from engine.planner.request import Heard, Language, NoPlan
from engine.planner.sentences import SAID
from engine.planner.text.counts import how_many
from engine.planner.unknown_places import meant, room_instead, unknown
from engine.planner.validation import Validation
from engine.skills.vocabulary import ME, Vocabulary
from engine.understanding.meaning import About, Condition, Do, If, Meaning, Node, Not, Repeat, Retract, Role

DOUBT: Final = 0.15
"""How much the reader may doubt that a request is an order for something of it to be done."""
_ASKED: Final = frozenset({"condition", "every", "until", "times", "role"})
"""What is asked about rather than turned down."""
_WHERE_IS: Final = re.compile(r"\bwhere(?:'s| is| are)?\b|在哪|哪里|哪儿")
_SOMEBODY: Final = re.compile(r"him|her|them|they|he|she|someone|somebody|他们?|她们?|谁|有人")
_NO_ORDERS: Final = frozenset({"talk", "fact"})
_OF_THE_SESSION: Final = frozenset({"answer", "report", "yes", "no", "fragment", "again", "undo", "resume", "other"})
"""Acts of the conversation, and what no skill serves."""


class Outcomes:
    """Makes plans of meanings, for one house."""

    def __init__(
        self,
        phrases: Callable[[Language], Phrases],
        validation: Validation,
        vocabulary: Vocabulary,
        entities: Entities,
        tell: Callable[[Sequence[Action], Language], Told],
    ) -> None:
        """``tell`` tells actions in a language."""
        self._phrases = phrases
        self._tell = tell
        self._validation = validation
        self._vocabulary = vocabulary
        self._entities = entities
        self._inventory = vocabulary.inventory()

    def of(self, meaning: Meaning, heard: Heard) -> Plan | NoPlan | None:
        """What comes of one meaning; None where it is for others: what no skill serves."""
        if (name := _own_name(heard.text)) and not meaning.has(Retract):
            return self._planned(heard, (ActionCall("learn_name", (name,)),))
        wanted = tuple(node for node in self._wanted(meaning) if _is_order(node))
        wanted = tuple(node for node in wanted if not _is_answer(node)) or wanted
        if not wanted:
            return self._no_act(meaning, heard)
        if len(wanted) == 1 and isinstance(act := wanted[0], Do) and self._is_of_the_session(act):
            return self._of_the_session(act, heard)
        if len(wanted) == 1 and isinstance(act := wanted[0], Do) and (told := self._seen_lately(act, heard)):
            return _answer(heard, told)
        if meaning.doubt > DOUBT and not meaning.has(Retract) and not meaning.has(Not):
            return _question(heard, "no_order", SAID[heard.language]["no_order_doubt"])
        request = heard.request
        thing, place = self._told_of(meaning)
        thing = thing or named_last(request.happened, "object") or request.holding or self._only_seen(request.seen)
        begins = min((role.start for node in wanted if isinstance(node, Do) for role in node.roles), default=0)
        thing = thing or self._entities.thing_in(heard.text[:begins]) or rubbish_in(heard.text[:begins])
        told_of = next((node for node in meaning.nodes if _is_of_a_person(node)), None)
        there = place or named_last(request.happened, "place")
        return self._done(wanted, heard, thing, there, told_of=told_of)

    def after(
        self,
        meaning: Meaning,
        heard: Heard,
        sees: Callable[[str], bool] | bool,
        decided: tuple[bool, ...] | None = None,
    ) -> Plan | NoPlan | None:
        """What is to be done after the look of a condition; ``sees`` says what was seen, or whether it holds.
        ``decided`` are the conditions before it; None: as the last plan has it."""
        wanted = self._wanted(meaning)
        if decided is None:
            decided = () if heard.request.text else decided_last(heard.request.happened)
        doing = Doing(self._entities, heard.request.holding, said=heard.text)
        try:
            following = self._next_condition(wanted, decided, doing)
            if following is None:
                return None
            node, condition, behind = following
            if doing.calls and of_success(condition, worked=True) is not None:
                worked = worked_last(heard.request.happened) is True
                holds = sees if isinstance(sees, bool) else of_success(condition, worked=worked) is True
                return self._going_on(node, behind, doing, heard, (*decided, holds))
            if depends_on_an_answer(condition, doing.calls):
                return self._after_an_answer(node, behind, doing, heard, sees, decided)
            looked_for = sought(doing, condition)
        except (Open, Which, NowhereKnown, Unable):
            return None
        if looked_for.asks and not isinstance(sees, bool):
            sees = (worked_last(heard.request.happened) is True) == looked_for.there
        if not isinstance(sees, bool):
            sees = _seen_there(sees, heard.request.may_be_at, looked_for.at)
        if not isinstance(sees, bool) and looked_for.is_open(sees):
            key = "which_speaker" if looked_for.who == ME else "which_person"
            return _question(heard, "which_person", SAID[heard.language][key].format(who=looked_for.who))
        people = counted_last(heard.request.happened)
        if people is None and looked_for.counts_people and not isinstance(sees, bool):
            return None
        thing, holds = looked_for.thing, sees if isinstance(sees, bool) else looked_for.holds(sees, people or 0)
        branch = node.then if holds else node.otherwise
        if holds and not looked_for.there and _OVER_THERE.search(heard.text):
            branch = tuple(_put_there(one, condition, "put", "bring") for one in branch)
        elif holds and looked_for.empty:
            branch = tuple(_put_there(one, condition, "put") for one in branch)
        rest = (*_only_wanted(branch), *behind)
        missing = holds != looked_for.there
        if missing and not isinstance(sees, bool) and self._is_known(rest[:1], looked_for, heard):
            return self.after(meaning, heard, heard.request.sees or sees, (*decided, holds))
        decided = (*decided, holds)
        if not isinstance(sees, bool):
            rest, decided = self._decided_too(rest, looked_for, sees, decided)
        told = _what_was_seen(looked_for, heard.language, missing=missing)
        if all(self._only_tells(one) for one in rest):
            return _answer(heard, told)
        rest = tuple(Do("say", (Role("text", told, 0, 0),)) if self._only_tells(one) else one for one in rest)
        fitting = self._inventory if thing == ANYTHING else self._entities.fitting(thing)
        names = tuple(name for name in fitting if not isinstance(sees, bool) and sees(name))
        if missing and condition.words("state"):  # "if the box is red": it is another one then
            thing = self._entities.near(condition.words("thing"))
        thing = "" if thing == PERSON else thing
        it = names[0] if len(names) == 1 else thing
        if thing in ("", ANYTHING) and not holds:  # "if the desk is empty, put the red box on it, else take the box …"
            named = (words for one in node.then if isinstance(one, Do) for words in one.all("thing"))
            it = next((known for words in named if (known := self._entities.of(words).thing)), it)
        found = self._done(rest, heard, it, doing.place, after=replace(looked_for, names=names))
        return self._decided(found, heard, decided)

    def _decided_too(
        self,
        nodes: Sequence[Do | If | Repeat],
        looked_for: Sought,
        sees: Callable[[str], bool],
        decided: tuple[bool, ...],
    ) -> tuple[tuple[Do | If | Repeat, ...], tuple[bool, ...]]:
        """The nodes with what is to be done in place of the conditions that the same look decides: those on other
        things there."""
        rest = tuple(nodes)
        for at, node in enumerate(rest):
            if not isinstance(node, If):
                continue
            condition, place = node.condition, self._entities.of(node.condition.words("place") or "there")
            thing = self._entities.of(condition.words("thing") or "it")
            same_place = place.refers or looked_for.at in (place.surface, place.room)
            one_thing = thing.thing is not None and not thing.every and how_many(thing.words) is None
            on_things = condition.kind in ("seen", "unseen") and len(condition.all("thing")) == 1
            if not (looked_for.at and same_place and one_thing and on_things) or condition.words("person"):
                break
            assert thing.thing is not None
            holds = sees(thing.thing) == (condition.kind == "seen")
            branch = _only_wanted(node.then if holds else node.otherwise)
            found = tuple(self._about(one, thing.words) for one in branch)
            return self._decided_too((*rest[:at], *found, *rest[at + 1 :]), looked_for, sees, (*decided, holds))
        return rest, decided

    def _about(self, node: Do | If | Repeat, thing: str) -> Do | If | Repeat:
        """The act with ``thing`` as what "it" is."""
        if not isinstance(node, Do):
            return node
        roles = (
            replace(role, words=thing) if role.name == "thing" and self._entities.of(role.words).refers else role
            for role in node.roles
        )
        return replace(node, roles=tuple(roles))

    def _is_known(self, following: Sequence[Do | If | Repeat], looked_for: Sought, heard: Heard) -> bool:
        """Whether the condition that follows is on the same thing, and that was seen elsewhere: no look is needed."""
        node = next(iter(following), None)
        sees, thing = heard.request.sees, looked_for.thing
        one_thing = looked_for.count is None and not looked_for.who and thing not in (ANYTHING, PERSON)
        if not isinstance(node, If) or sees is None or not one_thing or not sees(thing):
            return False
        other = self._entities.of(node.condition.words("thing") or "it")
        return bool(node.condition.words("place")) and (other.refers or other.thing == thing)

    def _next_condition(
        self, wanted: Sequence[Do | If | Repeat], decided: Sequence[bool], doing: Doing
    ) -> tuple[If, Condition, Sequence[Do | If | Repeat]] | None:
        """The first condition that is not ``decided`` yet, and what stands behind it; ``doing`` learns what was named
        before. None where there is none."""
        for held in (*decided, None):
            index, node = next(((at, one) for at, one in enumerate(wanted) if isinstance(one, If)), (0, None))
            if node is None:
                return None
            calls_of(wanted[:index], doing)
            condition = self._condition(node, doing, index)
            if held is None:
                return node, condition, wanted[index + 1 :]
            wanted = (*_only_wanted(node.then if held else node.otherwise), *wanted[index + 1 :])
            self._name(condition, doing)
        return None

    @staticmethod
    def _decided(found: Plan | NoPlan | None, heard: Heard, decided: tuple[bool, ...]) -> Plan | NoPlan:
        """What is done after conditions were ``decided`` so; the word that there is nothing to do."""
        if isinstance(found, Plan) and not found.finished:
            return replace(found, decided=decided)
        return found if found is not None else _answer(heard, SAID[heard.language]["all_right"])

    def _name(self, condition: Condition, doing: Doing) -> None:
        """What a condition names is what "it" and "there" are from now on."""
        for words in condition.all("thing")[:1]:
            with suppress(Open, Which, NowhereKnown, Unable):
                doing.thing(words)
        doing.went(Do("look", tuple(role for role in condition.roles if role.name == "place")))

    def _going_on(
        self,
        node: If,
        rest: Sequence[Do | If | Repeat],
        doing: Doing,
        heard: Heard,
        decided: tuple[bool, ...],
        after: Sought | None = None,
    ) -> Plan | NoPlan:
        """What is to be done behind a condition that needed no look, the last of those that are ``decided``."""
        branch = _only_wanted(node.then if decided[-1] else node.otherwise)
        if after is None:  # how it went is told, where that is all that is asked for: "if you can't find it, say so"
            told = SAID[heard.language]["worked" if worked_last(heard.request.happened) else "did_not_work"]
            branch = tuple(Do("say", (Role("text", told, 0, 0),)) if self._only_tells(one) else one for one in branch)
        begins = min((role.start for one in branch if isinstance(one, Do) for role in one.roles), default=0)
        named = doing.named or self._entities.thing_in(heard.text[:begins])
        found = self._done((*branch, *rest), heard, named, doing.place, after=after)
        return self._decided(found, heard, decided)

    def _after_an_answer(
        self,
        node: If,
        rest: Sequence[Do | If | Repeat],
        doing: Doing,
        heard: Heard,
        sees: Callable[[str], bool] | bool,
        decided: tuple[bool, ...],
    ) -> Plan | NoPlan | None:
        """What is to be done after somebody has answered; a question where the answer tells neither yes nor no."""
        answer = answered_last(heard.request.happened)
        if not answer and not isinstance(sees, bool):
            return None
        holds = sees if isinstance(sees, bool) else is_met(node.condition, answer)
        if holds is None:
            return _question(heard, "unclear_answer", SAID[heard.language]["unclear_answer"].format(words=answer))
        asked = Sought(PERSON, holds, (), who=doing.who)
        return self._going_on(node, rest, doing, heard, (*decided, holds), after=asked)

    def _seen_lately(self, act: Do, heard: Heard) -> str:
        """Where somebody was seen whom a question is about; empty where that is not known: they are looked for then."""
        if act.act != "find" or _WHERE_IS.search(heard.text.casefold()) is None or not act.words("person"):
            return ""
        try:
            who, _ = self._entities.somebody(act.words("person"))
        except PlanError:
            return ""
        return heard.request.people.get(who.name, "")

    def _is_of_the_session(self, act: Do) -> bool:
        """Whether it is one of the conversation; what is answered to somebody else is done."""
        others = any(not self._entities.of(words).me for words in act.all("person"))
        return act.act in _OF_THE_SESSION and not (act.act == "answer" and others)

    def _wanted(self, meaning: Meaning) -> tuple[Do | If | Repeat, ...]:
        once = looked_for_once(in_full(meaning.wanted()), self._entities, meaning.text)
        return _only_wanted(brought(looked_first(once, self._entities), meaning.text))

    def _only_tells(self, node: Node) -> bool:
        """Whether it asks for no more than the answer: "let me know", "say so"."""
        if not isinstance(node, Do) or node.act not in ("tell", "report", "say"):
            return False
        if (node.act == "say" or node.words("text")) and node.words("text").casefold() not in ("so", "that", "it"):
            return False
        return all(self._entities.of(words).me for words in node.all("person"))

    def _told_of(self, meaning: Meaning) -> tuple[str, str]:
        """The thing and the place of which something is told before the order: "that bottle's empty, bin it"."""
        facts = [node for node in meaning.nodes if isinstance(node, Do) and node.act == "fact"]
        named = [words for node in facts for words in node.all("thing")]
        things = [self._entities.of(words).thing or (words if is_rubbish(words) else None) for words in named]
        places = [self._entities.of(words).place for node in facts for words in node.all("place")]
        return next(filter(None, things), ""), next(filter(None, places), "")

    def _no_act(self, meaning: Meaning, heard: Heard) -> Plan | NoPlan | None:
        """The answer to what asks for nothing: small talk, or that what was said before is taken back."""
        phrases = self._phrases(heard.language)
        if _takes_all_back(meaning):
            return _answer(heard, SAID[heard.language]["all_right"])
        if meaning.nodes and all(isinstance(node, Do) and node.act == "talk" for node in meaning.nodes):
            return _answer(heard, phrases.talk(heard.text))
        return None

    def _of_the_session(self, act: Do, heard: Heard) -> Plan | NoPlan | None:
        """What acts of the conversation come to."""
        happened, phrases = heard.request.happened, self._phrases(heard.language)
        match act.act:
            case "again" if last := planned_last(happened):
                count = amounts.times(act.words("times")) or 1
                return self._once_more(last * min(count, MOST), heard)
            case "resume":
                return self._continued(heard)
            case "undo":
                return self._undone(heard)
            case "report":
                return self._reported(act, heard)
            case "answer":
                asked = next((words for words in (heard.text, act.words("topic")) if is_of_the_clock(words)), "")
                return _answer(heard, fact(asked) if asked else phrases.talk(heard.text, asks=True))
            case "yes" | "no" if last_question(happened) is None:
                return _answer(heard, SAID[heard.language]["all_right"])
            case "fragment" if not happened and (talk := phrases.only_talk(heard.text)):
                return _answer(heard, talk)
            case "fragment" if len(act.roles) == 1 and self._is_name(act.words("place")):
                found = self._done((replace(act, act="go"),), heard)
                unknown_place = isinstance(found, NoPlan) and found.code == "unknown_place"
                return (self.meant(heard) or found) if unknown_place else found
            case "fragment" if not any(self._entities.of(role.words).thing for role in act.roles):
                return self.meant(heard) or _question(heard, "no_act", phrases.question("what_do"))
            case "fragment" | "again":
                return _question(heard, "no_act", phrases.question("what_do"))
        return None

    def _once_more(self, actions: tuple[Action, ...], heard: Heard) -> Plan | NoPlan:
        actions = (replace(actions[0], alongside=False), *actions[1:])
        told = self._tell(actions, heard.language)
        calls = self._validation.calls(Plan(heard.text, actions, "", "reader"))
        return _sourced(self._validation.of(heard.text, calls, told.steps, told.response))

    def _continued(self, heard: Heard) -> Plan | NoPlan:
        """What an interruption left of the last plan."""

        def doing(action: Action) -> str:
            told = self._tell((replace(action, alongside=False),), heard.language)
            return told.doing or told.steps[0]

        if why := about_itself.cannot_continue(heard.request.on_record, heard.language, doing):
            return _question(heard, "nothing_to_continue", why)
        first, *others = heard.request.on_record.left
        left = (replace(first, alongside=False), *others)
        told = self._tell(left, heard.language)
        return Plan(heard.text, left, told.response, "reader", told.steps)

    def _undone(self, heard: Heard) -> Plan | NoPlan:
        """The way back from what was done last."""
        record = heard.request.on_record
        if not record.back:
            return NoPlan(heard.text, "no_way_back", record.no_way_back or SAID[heard.language]["nothing_to_undo"])
        return self._planned(heard, record.back)

    def _reported(self, act: Do, heard: Heard) -> Plan | NoPlan | None:
        """What the robot tells about itself: from what is on record, or with a skill."""
        asked = any(action.name == "ask_person" for action in planned_last(heard.request.happened) or ())
        if asked and _WHAT_WAS_SAID.search(heard.text.casefold()):
            return self._planned(heard, (ActionCall("report_answer"),))
        kind = topic_of(f"{act.words('topic')} {heard.text}")
        if kind == "places":
            known = ("、" if heard.language == "zh" else ", ").join(self._phrases(heard.language).places)
            return _answer(heard, SAID[heard.language]["knows_places"].format(known=known))
        if kind in ("report_pose", "seewhat", "list_skills"):
            return self._planned(heard, (ActionCall(kind),))
        answer = about_itself.of(kind, heard.request.on_record, heard.request.holding, heard.language)
        return _answer(heard, answer or SAID[heard.language]["asked"])

    def _only_seen(self, seen: Sequence[str]) -> str:
        """The one thing that was seen; empty where there are several, or none."""
        names = [name for name in self._inventory if any(name in told for told in seen)]
        return names[0] if len(names) == 1 and len(seen) == 1 else ""

    def _done(
        self,
        acts: Sequence[Do | If | Repeat],
        heard: Heard,
        named: str = "",
        place: str = "",
        *,
        after: Sought | None = None,
        told_of: Do | None = None,
    ) -> Plan | NoPlan | None:
        """The plan of what is wanted; ``named`` is the thing that "it" is at first, ``place`` the symbol of "there".
        ``told_of`` is what was told of a person before: "him" and "her" are that person.
        ``after`` is what a condition has looked for, with the names of what it has found: "it" and "them" are that."""
        doing = Doing(
            self._entities, heard.request.holding, named, place, said=heard.text, greeting=SAID[heard.language]["hello"]
        )
        doing.depends = after is not None
        doing.instead_of = _corrected_thing(acts)
        if after is not None and after.thing == PERSON:
            doing.who = doing.found = after.who or PERSON
        elif after is not None:
            doing.sought, doing.seen = named, after.names
        acts = tuple(self._completed(node) if isinstance(node, Do) else node for node in acts)
        if told_of is not None:
            with suppress(Open, Which, NowhereKnown, Unable):
                words, where = told_of.words("person"), told_of.words("place")
                doing.who, doing.there = somebody(doing, words, where, stranger=True)
        try:
            index = next((index for index, node in enumerate(acts) if isinstance(node, If)), None)
            if index is not None:
                first = calls_of(acts[:index], doing)
                node = acts[index]
                assert isinstance(node, If)
                condition = self._condition(node, doing, index)
                holds = of_itself(doing, condition)
                worked = True if first else worked_last(heard.request.happened)
                if holds is None and worked is not None:
                    holds = of_success(condition, worked=worked)
                    if first and holds is not None and (not holds or node.otherwise):
                        found = self._planned(heard, first)  # and when it is known how that went, the rest
                        return replace(found, finished=False, minds_failure=True) if isinstance(found, Plan) else found
                if holds is not None:  # there is nothing to look at
                    branch = _only_wanted(node.then if holds else node.otherwise)
                    rest = (*acts[:index], *branch, *acts[index + 1 :])
                    nothing = _answer(heard, SAID[heard.language]["all_right"])
                    return self._done(rest, heard, named, place) if rest else nothing
                answered = depends_on_an_answer(condition, first)
                looked_for = None if answered else sought(doing, condition)
                found = self._planned(heard, first if looked_for is None else (*first, *looked_for.look))
                minds = looked_for is not None and looked_for.asks
                return replace(found, finished=False, minds_failure=minds) if isinstance(found, Plan) else found
            calls = calls_of(acts, doing)
            if not calls:
                return None
            return self._validation.one_of(self._planned(heard, calls), heard.request, heard.language, doing.located)
        except Open as gap:
            question = self._phrases(heard.language).question(gap.question)
            asked = _question(heard, "vague" if gap.vague else "incomplete", question)
            return replace(asked, lacks=gap.question)
        except Which as several:
            return _question(heard, "ambiguous", str(several))
        except NowhereKnown as place:
            return self._unknown(heard, place.words)
        except Unable as why:
            asks = why.what == "person" and _SOMEBODY.fullmatch(why.words.casefold())
            code = ExitCode.CLARIFY if asks or why.what in _ASKED else ExitCode.FAILED
            key = f"unable_{why.what}"
            return NoPlan(heard.text, key, SAID[heard.language][key].format(words=why.words), code)

    def _condition(self, node: If, doing: Doing, index: int) -> Condition:
        """The condition of the node at ``index``, before which ``doing`` has been done."""
        thing, place = not index or not doing.named, not index and not doing.place
        return with_antecedent(node, self._entities, doing.said, thing=thing, place=place, person=not doing.who)

    def _completed(self, act: Do) -> Do:
        """The act with what a correction leaves to what it corrects: a unit ("no, two"), a kind ("the blue one")."""
        return replace(act, roles=tuple(self._completed_role(role) for role in act.roles))

    def _completed_role(self, role: Role) -> Role:
        if not role.instead_of:
            return role
        if role.name == "thing":
            old = self._entities.near(role.instead_of)
            if (alike := self._entities.like(role.words, self._entities.of(role.instead_of).thing or old)) is not None:
                return replace(role, words=alike)
        if role.name in ("amount", "time") and (number := amounts.number(role.words)) is not None:
            return replace(role, words=f"{number:g} {amounts.unit_in(role.instead_of)}".rstrip())
        return role

    def _planned(self, heard: Heard, calls: Calls) -> Plan | NoPlan:
        told = self._phrases(heard.language).told(calls)
        return _sourced(self._validation.of(heard.text, calls, told.steps, told.response))

    def _is_name(self, words: str) -> bool:
        """Whether that may name a place, so that it is an order by itself: neither letters of the map nor numbers do,
        though an order can go by them ("go to M")."""
        letters = "".join(character if character.isalpha() else " " for character in words).split()
        return bool(letters) and not any(map(self._vocabulary.is_symbol, letters))

    def meant(self, heard: Heard) -> NoPlan | None:
        """The question whether a place is meant by what is only the letter, the beginning or a misspelling of its
        name; None where it is none of these."""
        return meant(heard.text, self._vocabulary, heard.language)

    def _unknown(self, heard: Heard, name: str) -> NoPlan:
        """A journey to a place that the map does not have."""
        offered = room_instead(heard.text, name, self._vocabulary, heard.language)
        return offered or unknown(heard.text, name, self._phrases(heard.language).places, heard.language)


def _corrected_thing(nodes: Sequence[Node]) -> str:
    """The words in place of which a correction has put another thing; empty where none has."""
    roles = (role for node in nodes if isinstance(node, Do) for role in node.roles if role.name == "thing")
    return next((role.instead_of for role in roles if role.instead_of), "")


_WHAT_WAS_SAID: Final = re.compile(
    r"\bwhat (?:did|has) \w+ (?:say|said|answer|answered|reply|replied|want|wanted)\b|"
    r"\b(?:his|her|their|the) (?:answer|reply)\b|(?:说|回答|答)了?(?:什么|啥)|怎么(?:说|回答)"
)
"""That asks for the answer of a person."""
_OVER_THERE: Final = re.compile(r"[放拿搬送带摆挂][过上进回]去")
"""To where it is not yet: "if it isn't on the shelf, put it up"."""


def _put_there(node: Node, condition: Condition, *acts: str) -> Node:
    """One of these acts, with a thing, at the place of the condition where it has none of its own."""
    if not isinstance(node, Do) or node.act not in acts or node.words("place") or node.words("person"):
        return node
    places = tuple(role for role in condition.roles if role.name == "place")
    return replace(node, roles=(*node.roles, *places))


def _seen_there(
    sees: Callable[[str], bool], may_be_at: Callable[[str, str], bool], place: str
) -> Callable[[str], bool]:
    """Whether something was seen that is not elsewhere: from the desk, a cup on the table is seen as well."""
    return (lambda thing: sees(thing) and may_be_at(thing, place)) if place else sees


def _answer(heard: Heard, words: str) -> Plan:
    """Words alone; nothing is done."""
    return Plan(heard.text, (), words, "reader")


def _what_was_seen(sought: Sought, language: Language, *, missing: bool) -> str:
    """What a look has shown, as it is told."""
    said = SAID[language]
    if sought.count is not None:
        return said["not_so_many" if missing else "so_many"]
    key = {ANYTHING: "_any", PERSON: "_person"}.get(sought.thing, "")
    return said[f"{'absent' if missing else 'present'}{key}"].format(thing=sought.thing)


def _question(heard: Heard, code: str, words: str) -> NoPlan:
    return NoPlan(heard.text, code, words, ExitCode.CLARIFY)


def _sourced(found: Plan | NoPlan) -> Plan | NoPlan:
    return replace(found, source="reader") if isinstance(found, Plan) else found


def is_no_order(meaning: Meaning) -> bool:
    """Whether nothing in it is to be done; small talk and what takes all back, which have their own answers, apart."""
    talk = all(isinstance(node, Do) and node.act != "fact" for node in meaning.nodes)
    return not talk and not _takes_all_back(meaning) and not any(_is_order(node) for node in meaning.wanted())


_OWN_NAME: Final = re.compile(
    r"(?:(?:hi|hello|hey|(?:please )?remember (?:my name|me|who i am))[,: ]+)?"
    r"(?:(?:my name is|my name's|call me|i am called|i'm called) (?P<said>[^\W\d_][\w'-]*)|"
    r"(?:i am|i'm) (?P<en>(?-i:[A-Z])[\w'-]*(?: (?-i:[A-Z])[\w'-]*)?))|"
    r"(?:你好[，,]?)?(?:我叫|我的名字[叫是]|叫我)(?P<zh>[\u3400-\u9fff\w]{1,6})",
    re.IGNORECASE,
)
"""How people say who they are."""


_REMEMBER_IT: Final = re.compile(
    r"[,.;!] *(?:and )?(?:please )?(?:remember|keep|learn|don't forget) (?:it|that|this|me|my name)"
    r"(?:,? (?:please|will you|would you|ok(?:ay)?))*[ .!?]*$|[，。]?(?:请)?(?:记住|别忘了)(?:我|我的名字)?[。！]?$",
    re.IGNORECASE,
)


def _own_name(text: str) -> str:
    """The name of the speaker, where the whole of the request says it; empty where it does not."""
    found = _OWN_NAME.fullmatch(_REMEMBER_IT.sub("", text.replace("’", "'")).strip(" .!。！"))
    if found is None:
        return ""
    return as_name(found["said"] or found["en"] or found["zh"])


def _takes_all_back(meaning: Meaning) -> bool:
    return meaning.has(Retract) and not meaning.has(Not) and not meaning.has(About) and not meaning.wanted()


def _is_order(node: Node) -> bool:
    return not (isinstance(node, Do) and node.act in _NO_ORDERS)


def _is_of_a_person(node: Node) -> TypeGuard[Do]:
    """Whether it tells something of one person: "Maria is in the bedroom"."""
    return isinstance(node, Do) and node.act == "fact" and len(node.all("person")) == 1


def _is_answer(node: Node) -> bool:
    """ "Fine, then …": what follows it is the order."""
    return isinstance(node, Do) and node.act in ("yes", "no")


def _only_wanted(nodes: Sequence[Node]) -> tuple[Do | If | Repeat, ...]:
    return tuple(node for node in nodes if isinstance(node, (Do, If, Repeat)))
