"""Who says what: each voice says the phrase a few times, some of what is like it, and a little of everything else.

Most speakers train the network, some set its threshold, and the rest try it. The split is by who speaks, and strict:
whoever speaks with two accents or in two languages does the same in all of them, a voice that is mixed of speakers
with different roles says nothing, and a head names everybody whom it knows (:attr:`engine.wake.head.Head.trained_by`),
so that a later trial can leave them out whatever voices there are by then.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, Literal

from engine.wake.training import chinese, texts
from engine.wake.training.voices import Remembered, Sound, Voice

Role = Literal["train", "tune", "test"]
SHARES: Final[tuple[Role, ...]] = ("train", "train", "test", "train", "tune", "train", "train", "test")
KNOWN: Final[tuple[Role, ...]] = ("train", "tune")
PACES: Final = (1.0, 0.88, 1.15, 1.3)


@dataclass(frozen=True, slots=True)
class Take:
    """Something that somebody says."""

    voice: Voice
    text: str
    pace: float
    phrase: bool  # it is the phrase


@dataclass(slots=True)
class Said:
    """Everything that voices of one role said."""

    phrase: list[Sound] = field(default_factory=list)
    near: list[Sound] = field(default_factory=list)
    other: list[Sound] = field(default_factory=list)


def roles(voices: Sequence[Voice]) -> dict[str, Role]:
    """What each voice does: of every engine's speakers the same share, and of those of every language. A voice that is
    mixed of speakers with different roles has none."""
    speaks: dict[str, set[str]] = {}
    for voice in voices:
        for speaker in voice.speakers:
            speaks.setdefault(speaker, set()).add(voice.language)
    alike: dict[tuple[str, ...], list[str]] = {}
    for speaker, languages in speaks.items():
        alike.setdefault((speaker.partition(":")[0], *sorted(languages)), []).append(speaker)
    role_of = {
        speaker: SHARES[index % len(SHARES)]
        for several in alike.values()
        for index, speaker in enumerate(sorted(several, key=lambda speaker: _chance(speaker).random()))
    }
    theirs = {voice.name: {role_of[speaker] for speaker in voice.speakers} for voice in voices}
    return {name: several.pop() for name, several in theirs.items() if len(several) == 1}


def known_speakers(voices: Sequence[Voice]) -> tuple[str, ...]:
    """Those whom a head knows that was trained with these voices: who trains it, and who sets its threshold."""
    parts = roles(voices)
    known = {speaker for voice in voices if parts.get(voice.name) in KNOWN for speaker in voice.speakers}
    return tuple(sorted(known))


def takes(
    phrase: str, voice: Voice, *, phrases: int, near: int, others: int, rambling: int, slips: int
) -> tuple[list[Take], list[Take]]:
    """What a voice says: the phrase and what is like it, and other things: sentences that many say, ``rambling`` that
    only this voice does, and as many as ``slips`` with something in it that is like the phrase."""
    language = voice.language
    if texts.language_of(phrase) != language:  # it can only talk
        phrases = near = slips = 0
    chance = _chance(f"{voice.name} {phrase}")
    ways = texts.ways_to_say(phrase)
    # the pace is that of the way, so that the same is not said twice
    own = [Take(voice, ways[index % len(ways)], PACES[index % len(PACES)], True) for index in range(phrases)]
    like = texts.near(phrase, 200)
    own += [Take(voice, text, chance.choice(PACES[:3]), False) for text in chance.sample(like, min(near, len(like)))]
    talk = texts.rambling(slips, chance, like, language)
    chance = _chance(voice.name)  # the same for every phrase: it is remembered
    talk += chance.sample(texts.talk(language), others) + texts.rambling(rambling, chance, language=language)
    never = "" if phrase in chinese.WAYS else _letters(phrase)
    return own, [Take(voice, text, 1.0, False) for text in talk if not never or never not in _letters(text)]


def perform(
    phrase: str, voices: Sequence[Voice], remembered: Remembered, on_take: Callable[[int, int], None], share: float = 1
) -> dict[Role, Said]:
    """Let all of them speak, a ``share`` of what they usually say; ``on_take`` is told how many takes are done, of how
    many."""
    parts = roles(voices)
    plan = [
        (voice, *takes(phrase, voice, **_amounts(voice, parts[voice.name], share)))
        for voice in voices
        if voice.name in parts
    ]
    total = sum(len(own) + len(others) for _, own, others in plan)
    said: dict[Role, Said] = {"train": Said(), "tune": Said(), "test": Said()}
    done = 0
    for voice, own, others in plan:
        to = said[parts[voice.name]]
        for take, kept in _sorted(own, others, to):
            kept.append(remembered.say(voice, take.text, take.pace))
            done += 1
            on_take(done, total)
    return said


def _sorted(own: Sequence[Take], others: Sequence[Take], to: Said) -> Iterator[tuple[Take, list[Sound]]]:
    for take in own:
        yield take, to.phrase if take.phrase else to.near
    for take in others:
        yield take, to.other


def _amounts(voice: Voice, role: Role, share: float) -> dict[str, int]:
    """A voice that takes a second for a word says less than one that takes a hundredth. Who tries talks on: false
    alarms are rare, and of a few minutes one knows nothing."""
    natural = voice.name.startswith(("kokoro:", "piper:"))
    if natural and voice.language == "zh":  # there are few of them, and eSpeak is a poor model of a tone
        usual = {"phrases": 10, "near": 10, "others": 2, "rambling": 1, "slips": 1}
    elif natural:
        usual = {"phrases": 2, "near": 3, "others": 1, "rambling": 1, "slips": 1}
    elif role == "train":
        usual = {"phrases": 4, "near": 14, "others": 6, "rambling": 8, "slips": 8}
    else:
        usual = {"phrases": 4, "near": 14, "others": 20, "rambling": 40, "slips": 0}
    if voice.language == "zh":
        usual["phrases"] = max(usual["phrases"], len(chinese.WAYS["停"]))  # each of them
    return {what: min(count, max(1, round(count * share))) for what, count in usual.items()}


def _letters(text: str) -> str:
    return "".join(sign for sign in text.casefold() if sign.isalpha())


def _chance(seed: str) -> random.Random:
    return random.Random(seed)
