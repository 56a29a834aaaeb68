"""From a phrase to a head, in four steps: voices speak, their sound is spoilt and embedded, networks learn, and the
result is tried on voices and recordings that took no part.

Nothing is written here but the cache of what voices said; the head is the caller's to keep or to throw away.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

import numpy as np

from engine.errors import UsageError
from engine.wake.embedding import RATE, SPAN, STEP, Embedding, Stacks
from engine.wake.head import Head
from engine.wake.training.casting import PACES, SHARES, Role, Said, known_speakers, perform, roles
from engine.wake.training.fit import fit
from engine.wake.training.sound import Chance, loudness, silence, spoilt, talk, with_phrase
from engine.wake.training.texts import language_of, ways_to_say
from engine.wake.training.trial import CONDITIONS, Heard, Point, as_trial, chosen, delays, judged, phrase_rows, points
from engine.wake.training.voices import Remembered, Sound, Voice, trimmed

Stage = Literal["speaking", "embedding", "learning", "trying"]
FEWEST_VOICES: Final = 12
FEW: Final = 5
"""Voices that say the phrase first, to find out how long it takes."""
LONGEST: Final = round(1.3 * RATE)
"""A phrase that is longer does not fit into what a head looks at, samples."""

_PIECE: Final = 12 * RATE  # of a long recording
_TOGETHER: Final = 10  # pieces that follow each other have the same role: two minutes of one speaker
_IN_A_ROW: Final = 6  # things that are said in one recording
_TALKS_WEIGHT, _PHRASE_SHARE = 1.0, 0.3  # how much of the loss the phrases are


@dataclass(frozen=True, slots=True)
class Effort:
    """How much is done."""

    phrases: int = 1400  # that are heard in training, each spoilt in its own way
    rounds: int = 1  # how often everything else is heard, spoilt in another way each time
    epochs: int = 3
    networks: int = 2
    silences: int = 120
    said: float = 1.0  # the share of what the voices usually say


USUAL: Final = Effort()
QUICK: Final = Effort(phrases=400, epochs=5, networks=1, silences=60, said=0.5)
STEPS: Final = 3
"""Windows whose mean a head goes by: with the same false alarms it hears more than by one…"""
BRIEF: Final = round(0.5 * RATE)
"""…but not of a phrase that is as short as this, samples, which one knows 0.1 s sooner by one."""


@dataclass(frozen=True, slots=True)
class Trained:
    """A head that has been tried, and what other thresholds would have led to."""

    head: Head
    points: list[Point]  # of the trial
    hours: float


def train(
    phrase: str,
    voices: Sequence[Voice],
    embedding: Embedding,
    cache: Path,
    *,
    mine: Sequence[Sound] = (),
    background: Sequence[Sound] = (),
    alarms_an_hour: float = 0.5,
    effort: Effort = USUAL,
    on_step: Callable[[Stage, int, int], None] = lambda stage, done, total: None,
) -> Trained:
    """Of the ``voices``, those of the phrase's language say it, and the others only talk. ``mine``: recordings of the
    phrase by who will say it, and of nothing else: what is before and after it would be learnt as well. ``background``:
    speech and noise without it. What is raised in ``on_step`` ends it. Raises ``UsageError`` for a phrase that cannot
    be trained, ``ModelError``."""
    remembered = Remembered(cache)
    length = _usual_length(phrase, voices, remembered)
    said = perform(phrase, voices, remembered, lambda done, total: on_step("speaking", done, total), effort.said)
    said["train"].phrase += [trimmed(sound) for sound in mine] * 3
    pieces = _divided(background)
    learnt = _rows_to_learn(said["train"], pieces["train"], embedding, np.random.default_rng(1), effort, on_step)
    networks = []
    for seed in range(effort.networks):
        before, passes = seed * effort.epochs, effort.networks * effort.epochs

        def on_epoch(epoch: int, loss: float, before: int = before, passes: int = passes) -> None:
            on_step("learning", before + epoch, passes)

        networks.append(fit(*learnt, epochs=effort.epochs, seed=seed, on_epoch=on_epoch))
    head = Head(phrase, 0.5, networks, steps=1 if length < BRIEF else STEPS)
    trials = (said["tune"], pieces["tune"]), (said["test"], pieces["test"])
    total = sum(_recordings(heard, others) for heard, others in trials)
    count = itertools.count(1)

    def tried() -> None:
        on_step("trying", next(count), total)

    tuning = _heard(head, *trials[0], embedding, np.random.default_rng(2), tried)
    threshold = chosen(points(tuning), tuning.hours, alarms_an_hour).threshold
    trying = _heard(head, *trials[1], embedding, np.random.default_rng(3), tried)
    finished = replace(
        head,
        threshold=threshold,
        delay_s=round(float(np.median(delays(tuning, threshold) or [0.0])), 3),
        trial=as_trial(trying, threshold),
        made_of=_made_of(phrase, voices, said["train"], mine, background),
        trained_by=known_speakers(voices),
    )
    return Trained(finished, points(trying), trying.hours)


def check(phrase: str, voices: Sequence[Voice], cache: Path) -> None:
    """Whether a phrase can be trained, before anybody works for it. Raises ``UsageError``, ``ModelError``."""
    _usual_length(phrase, voices, Remembered(cache))


def _usual_length(phrase: str, voices: Sequence[Voice], remembered: Remembered) -> float:
    """How long it takes to say the phrase, samples, before all of them do. Raises ``UsageError``."""
    speakers = _speakers(phrase, voices)
    if len(speakers) < FEWEST_VOICES:
        hint = "Install espeak-ng (Debian, Ubuntu: apt install espeak-ng; macOS: brew install espeak-ng)."
        raise UsageError(
            f"There are {len(speakers)} synthetic voices on this machine; it takes {FEWEST_VOICES}.", hint=hint
        )
    length = float(
        np.median([len(remembered.say(voice, ways_to_say(phrase)[0], PACES[0])) for voice in speakers[:FEW]])
    )
    if length > LONGEST:
        hint = f"{LONGEST / RATE:g} s is the longest; three or four syllables are best."
        raise UsageError(f"“{phrase}” takes too long to say: {length / RATE:.1f} s.", hint=hint)
    return length


def _speakers(phrase: str, voices: Sequence[Voice]) -> list[Voice]:
    """Those who can say the phrase."""
    return [voice for voice in voices if voice.language == language_of(phrase)]


def _divided(background: Sequence[Sound]) -> dict[Role, list[Sound]]:
    """Long recordings in pieces, by what they are for. Who speaks in them nobody knows: these alone are not divided by
    who speaks, but by time."""
    cut = [recording[at : at + _PIECE] for recording in background for at in range(0, len(recording), _PIECE)]
    pieces: dict[Role, list[Sound]] = {"train": [], "tune": [], "test": []}
    for index, piece in enumerate(cut):
        pieces[SHARES[index // _TOGETHER % len(SHARES)]].append(piece)
    return pieces


def _made_of(
    phrase: str, voices: Sequence[Voice], said: Said, mine: Sequence[Sound], background: Sequence[Sound]
) -> str:
    """A sentence about what a head was trained with."""
    parts = roles(voices)
    trainers = [voice.name for voice in _speakers(phrase, voices) if parts.get(voice.name) == "train"]
    return (
        f"{len(said.phrase)} times the phrase by synthetic voices ({', '.join(_engines(trainers))})"
        + (f", {len(mine)} recordings of it" if mine else "")
        + (f", {sum(map(len, background)) / RATE / 3600:.1f} h of recordings of other sound" if background else "")
    )


def _rows_to_learn(
    said: Said,
    pieces: Sequence[Sound],
    embedding: Embedding,
    chance: Chance,
    effort: Effort,
    on_step: Callable[[Stage, int, int], None],
) -> tuple[Stacks, np.ndarray, np.ndarray]:
    """What is shown to the network, what it is to say, and how much each row counts."""
    babble = said.other
    talks = effort.rounds * -(-(len(said.near) + len(said.other)) // _IN_A_ROW)
    alike = effort.phrases // 2
    total, done = effort.phrases + alike + talks + effort.silences + len(pieces), 0
    yes: list[Stacks] = []
    no: list[Stacks] = []

    def embedded(sound: Sound, to: list[Stacks]) -> None:
        nonlocal done
        to.append(embedding.stacks(sound))
        done += 1
        on_step("embedding", done, total)

    for index in range(effort.phrases):
        phrase = said.phrase[index % len(said.phrase)]
        embedded(with_phrase(phrase, chance, [*said.near, *said.other], said.other, babble), yes)
    for index in range(alike):  # said as the phrase is, or it would be known by the silence before it
        word = said.near[index % len(said.near)]
        embedded(with_phrase(word, chance, [*said.near, *said.other], said.other, babble), no)
    for _ in range(effort.rounds):
        everything = [*said.near, *said.other]
        order = chance.permutation(len(everything))
        for at in range(0, len(order), _IN_A_ROW):
            embedded(talk([everything[index] for index in order[at : at + _IN_A_ROW]], chance, babble), no)
    for _ in range(effort.silences):
        embedded(silence(SPAN + 20 * STEP, chance), no)
    for piece in pieces:
        changed = spoilt(piece, chance, babble, loudness(piece)) if chance.random() < 0.5 else piece
        embedded(changed, no)
    positive, negative = np.concatenate(yes), np.concatenate(no)
    wanted = np.concatenate((np.ones(len(positive)), np.zeros(len(negative)))).astype(np.float32)
    weight = _PHRASE_SHARE / (1 - _PHRASE_SHARE) * len(negative) / len(positive)
    weights = np.where(wanted > 0, weight, _TALKS_WEIGHT).astype(np.float32)
    return np.concatenate((positive, negative)), wanted, weights


def _recordings(said: Said, pieces: Sequence[Sound]) -> int:
    """In how many recordings a head is tried with this."""
    return len(CONDITIONS) * len(said.phrase) + len(said.near) + -(-len(said.other) // _IN_A_ROW) + len(pieces)


def _heard(
    head: Head,
    said: Said,
    pieces: Sequence[Sound],
    embedding: Embedding,
    chance: Chance,
    tried: Callable[[], None],
) -> Heard:
    """What the head says to voices that it was not trained on; ``tried`` is called after each recording."""
    babble = said.other

    def stacks(sound: Sound) -> Stacks:
        found = embedding.stacks(sound)
        tried()
        return found

    others = []
    order = chance.permutation(len(said.other))
    for at in range(0, len(order), _IN_A_ROW):
        several = [said.other[index] for index in order[at : at + _IN_A_ROW]]
        others.append(stacks(talk(several, chance, babble)))
    others += [stacks(piece) for piece in pieces]
    phrases = phrase_rows(said.phrase, stacks, chance, babble)
    near = phrase_rows(said.near, stacks, chance, babble, ("clean",))
    return judged(head.probabilities, phrases, near, others)


def _engines(voices: Sequence[str]) -> list[str]:
    names = [name.partition(":")[0] for name in voices]
    return [f"{names.count(engine)} of {engine}" for engine in sorted(set(names))]
