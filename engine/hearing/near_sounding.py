"""What was said instead of a word that makes no sense where it was heard: the command word that sounds most like it.

Noise makes "I troll the hallway" of "patrol the hallway". Where neither the likeliest reading nor another one is a
command, one word (or two that were one) may be replaced by a word of commands that sounds nearly the same. That is done
only where the whole becomes a complete command and no other word comes near; never to what was heard clearly; and
never where a mistake would matter: to numbers, sides, directions, stops and negations, and to words that are known; nor
in what people say to each other.

How English is written says roughly how it sounds, and both words are judged by the same rules, so that no dictionary of
pronunciations is needed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final

from engine.asr.recogniser import Rejected, Transcript
from engine.hearing.readings import Judge, is_to_each_other, makes_no_sense

CLEAR: Final = 0.8
"""Confidence from which a text is what was said, whatever it means."""

NEAR: Final = 0.31
"""Greatest distance of two words that may be the same, of their length…"""

APART: Final = 0.1
"""…and how much farther all others have to be."""

SHORT: Final = 3
FARTHER: Final = 1.45
"""Words of so few sounds count as that many times as different: nearly every one has others beside it."""

LONGEST: Final = 16
"""Words of a text in which one is looked for: more are talk."""

VERBS: Final = tuple(
    "go drive move come turn spin pick take bring fetch get grab put place drop open close raise lower nod shake wave "  # noqa: SIM905
    "clap dance beep wait find look follow patrol clean tidy sort remember remove clear where what how end current "
    "around position room table line gripper robot battery servo twice".split()
)
"""Beside the names of things and places, which each house has its own, what commands are made of."""

_UNTOUCHED: Final = frozenset(
    "left right forward forwards ahead straight back backward backwards up down on off in out stop halt wait freeze "  # noqa: SIM905
    "don't dont never no nothing without until except unless if say half quarter once degrees degree metre "
    "metres meter meters centimetre centimetres second seconds minute minutes he she they we you me him her them us "
    "who".split()
)
"""Never taken for another word, nor put in the place of one."""
_NUMBER: Final = re.compile(
    r".*\d.*|one|two|three|four|five|six|seven|eight|nine|ten|eleven|twelve|\w+teen|(?:twen|thir|for|fif|six|seven|eigh"
    r"|nine)ty|hundred|thousand|zero|point"
)
_WORD: Final = re.compile(r"[^\W_]+(?:['’][^\W_]+)*")

_SOUNDS: Final = tuple(
    (re.compile(spelt), sound)
    for spelt, sound in (
        ("[ts]ion", "Sn"), ("^kn", "n"), ("^wr", "r"), ("^wh(?=o)", "h"), ("wh", "w"), ("eigh", "A"), ("igh", "I"),
        ("[ao]ugh", "o"), ("tch", "C"), ("dg", "J"), ("ch", "C"), ("sh", "S"), ("th", "T"), ("ph", "f"), ("gh", ""),
        ("ck", "k"), ("qu", "kw"), ("x", "ks"), ("ng", "N"), ("mb$", "m"), ("c(?=[eiy])", "s"), ("c", "k"),
        ("g(?=e$)", "J"), ("ee|ea|ie(?=.)", "E"), ("oo|ew|ue$", "U"), ("oa|ow$|oll?$", "O"), ("ou|ow", "W"),
        ("ai|ay|ey", "A"), ("oi|oy", "oE"), ("au|aw|al(?=[kl])", "o"), ("[eiu]r(?![aeiouy])", "R"), ("re$", "R"),
        ("a(?=[^aeiouywx]e)", "A"), ("i(?=[^aeiouywx]e)|i(?=nd$)|ie$", "I"), ("o(?=[^aeiouywx]e)|o$", "O"),
        ("u(?=[^aeiouywx]e)", "U"), ("^y", "y"), ("y$", "E"), ("y", "i"), ("e(?=d$)", ""), ("e$", ""),
    )
)  # fmt: skip
"""How letters are spoken, the first rule that fits; all others as they are written."""
_LEAST: Final = 0.5
_VOWELS: Final = frozenset("aeiouAEIOUWR")
_ALIKE: Final = tuple((frozenset(signs), far) for signs, far in (
    ("pb", 0.25), ("td", 0.25), ("kg", 0.25), ("fv", 0.25), ("sz", 0.25), ("CJ", 0.25), ("iE", 0.25), ("oO", 0.25),
    ("uU", 0.25), ("ae", 0.3), ("ei", 0.3), ("SC", 0.3), ("mnN", 0.3), ("Tfvd", 0.4), ("ptkbdg", 0.5), ("fsSTCz", 0.5),
    ("lrwy", 0.6), ("aeiouAEIOUWR", 0.5),
))  # fmt: skip
"""Sounds that are taken for each other, and how different they are nevertheless; the first that holds both."""


def heard_as_command(found: Transcript | Rejected, judge: Judge, nouns: Sequence[str]) -> Transcript | Rejected:
    """What was found, with the one word that makes no sense replaced where that is clear. ``nouns``: the names of
    things and places."""
    if not isinstance(found, Transcript) or found.confidence >= CLEAR or not makes_no_sense(found.text, judge):
        return found
    known = _lexicon(tuple(nouns))
    for text in (found.text, *found.others):
        if (meant := _meant(text, judge, known)) is not None:
            return replace(found, text=meant, others=(found.text, *found.others))
    return found


def distance(heard: str, meant: str) -> float:
    """How different two words sound: 0 the same, about 1 nothing in common."""
    one, other = sound_of(heard), sound_of(meant)
    longer = max(len(one), len(other), 1)
    if _LEAST * abs(len(one) - len(other)) > longer / 2:
        return 1.0
    row = [0.0]
    for sign in other:
        row.append(row[-1] + _alone(sign))
    for sign in one:
        before, row = row, [row[0] + _alone(sign)]
        for at, wanted in enumerate(other):
            row.append(min(before[at] + _apart(sign, wanted), before[at + 1] + _alone(sign), row[at] + _alone(wanted)))
    return row[-1] / longer * (FARTHER if longer <= SHORT else 1.0)


@lru_cache(maxsize=4096)
def sound_of(word: str) -> str:
    """Roughly how a word sounds, a sign for a sound: "patrol" is ``patrol``, "light" is ``lIt``."""
    rest, sounds = word.casefold().replace("’", "'").replace("'", ""), ""
    while rest:
        for pattern, sound in _SOUNDS:
            if (match := pattern.match(rest)) and (not match.re.pattern.startswith("^") or not sounds):
                sounds += sound
                rest = rest[match.end() :]
                break
        else:
            sounds += rest[0] if rest[0].isalnum() else ""
            rest = rest[1:]
    return re.sub(r"(.)\1+", r"\1", sounds)


def _meant(text: str, judge: Judge, known: frozenset[str]) -> str | None:
    """The one command that ``text`` may be with another word in it; None where there is none, or several."""
    words = list(_WORD.finditer(text))
    if not 2 <= len(words) <= LONGEST or is_to_each_other(text):
        return None
    nearest: dict[str, float] = {}
    for start, end, meant, far in _replacements([word[0].casefold() for word in words], known):
        said = text[: words[start].start()] + meant + text[words[end - 1].end() :]
        if far < nearest.get(said, 1.0) and judge(said) == "complete":
            nearest[said] = far
    best = sorted(nearest, key=nearest.__getitem__)
    if not best or nearest[best[0]] > NEAR or (len(best) > 1 and nearest[best[1]] < nearest[best[0]] + APART):
        return None
    return best[0]


def _replacements(words: list[str], known: frozenset[str]) -> Iterator[tuple[int, int, str, float]]:
    """From which word to which one another is meant, and how far that is."""
    for start, _ in enumerate(words):
        for end in (start + 1, start + 2):
            heard = words[start:end]
            if end > len(words) or known.isdisjoint(words[:start] + words[end:]) or any(map(_NUMBER.fullmatch, heard)):
                continue
            if any(word in known or word in _UNTOUCHED for word in heard) or ("not" in heard and len(words) > 2):
                continue  # "not twice" was a nod; "not follow me" was none
            for meant, far in _near("".join(heard), known):
                yield start, end, meant, far


@lru_cache(maxsize=256)
def _near(heard: str, known: frozenset[str]) -> tuple[tuple[str, float], ...]:
    return tuple((meant, far) for meant in known if (far := distance(heard, meant)) < NEAR + APART)


@lru_cache(maxsize=4)
def _lexicon(nouns: tuple[str, ...]) -> frozenset[str]:
    words = {word for noun in nouns if noun.isascii() for word in noun.casefold().split()}
    return frozenset((words | set(VERBS)) - _UNTOUCHED)


@lru_cache(maxsize=4096)
def _apart(one: str, other: str) -> float:
    if one == other:
        return 0.0
    return next((far for signs, far in _ALIKE if one in signs and other in signs), 1.1)


def _alone(sign: str) -> float:
    """A sound that only one of both words has: vowels and stops at the end are lost first."""
    return _LEAST if sign in _VOWELS or sign in "tdh" else 0.7
