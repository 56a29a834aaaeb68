"""How soon after somebody's last word their command is understood, and how often they are cut off.

Every recording is listened to as the engine does it, on a clock of its own (``tests.bench.listening``). *Cut off* is a
turn that ended before the voice did. *Joined*: two whole commands with a pause of 0.25–0.45 s between them.
*Hesitating*: one command with a pause of 0.5–0.9 s in the middle, where "to the" or a number ends.

What a cut-off led to is counted as well. *All heard*: the last sound was cut, and the plan is the right one. *Healed*:
nothing was done, and both pieces were understood as one request when the speaker went on. *Carried on*: the first
command was begun, and the second is done after it, or both in its place. *Half*: the first was begun, and that is all.
*Lost*: nothing was done, and the request has to be said again. *Harmed*: another plan than that of the words was begun.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from config.schema import Settings
from engine.asr.recogniser import Recogniser
from engine.audio.source import RATE, Frame, Samples
from engine.plan import Action
from tests.bench.listening import Clockwork, Ears, Heard, Price, planned
from tests.bench.report import Figure, figures
from tests.bench.speech import Clip, clips, frames, mixed, noise, silence, speech_bounds

LEAD_S, TAIL_S = 0.8, 3.0
LOUDNESS: tuple[float | None, ...] = (None, 10.0, 5.0)
KINDS = ("single", "joined", "hesitating")


@dataclass(frozen=True, slots=True)
class Said:
    """A recording, when its voice ends (s), and what it says."""

    kind: str
    sound: Samples
    end: float
    text: str  # of one plain command; else empty
    parts: tuple[str, ...] = ()  # of several commands


@dataclass(slots=True)
class Cell:
    """What became of the recordings of one kind."""

    n: int = 0
    cut: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)  # of those, see above
    plain: int = 0  # of those that were not cut off
    wrong: int = 0  # of those, planned as another command
    understood: list[float] = field(default_factory=list)  # s from the last word to the transcript of a plain command


async def measure(
    settings: Settings, loudness: Sequence[float | None] = LOUDNESS, kinds: Collection[str] = KINDS
) -> dict[str, Cell]:
    """Listen to every recording of these kinds in every loudness."""
    ears = Ears.of(settings)
    planner, price = ears.planner, Price.of(settings)
    cells: dict[str, Cell] = {}
    for index, said in enumerate(recordings(ears)):
        for snr in loudness if said.kind in kinds else ():
            name = f"{said.kind}, {'clean' if snr is None else f'{snr:.0f} dB'}"
            cell = cells.setdefault(name, Cell())
            sound = said.sound if snr is None else mixed(said.sound, noise(len(said.sound) / RATE, index), snr)
            clock = Clockwork(lambda found: price.paid(found, settings.asr.window_s))
            stream = iter(frames(sound))
            heard = await ears.listen(clock, stream)
            cell.n += 1
            if heard.ended < said.end:
                cell.cut += 1
                outcome, text = await _outcome(ears, clock, said, heard, stream)
                cell.outcomes[outcome] += 1
                sys.stderr.write(f"{name}: cut {said.end - heard.ended:.2f} s early, {outcome}: {text}\n")
            elif said.text:
                cell.plain += 1
                if planner.completeness(heard.text) == "complete":  # else the robot would not move
                    cell.understood.append(heard.ready - said.end)
                    cell.wrong += await planned(planner, heard.text) != await planned(planner, said.text)
    return cells


async def _outcome(ears: Ears, clock: Clockwork, said: Said, heard: Heard, rest: Iterator[Frame]) -> tuple[str, str]:
    """What a cut-off led to, and what was understood."""
    done = await planned(ears.planner, heard.text)
    if done and said.parts:
        return await _carried_on(ears, clock, said, heard, done, rest)
    wanted = await planned(ears.planner, said.text)
    if done:  # a robot that acts is interrupted by a wake alone
        return "all heard" if done == wanted else "harmed", f"{said.text!r} as {heard.text!r}"
    more = await ears.go_on(clock, heard, rest)
    if more is None:
        return "lost", f"{said.text!r} as {heard.text!r}"
    done = await planned(ears.planner, more.text)
    harmed = bool(done and wanted and done != wanted)
    return "harmed" if harmed else "healed", f"{said.text!r} as {heard.text!r}, then {more.text!r}"


async def _carried_on(
    ears: Ears, clock: Clockwork, said: Said, heard: Heard, begun: tuple[Action, ...], rest: Iterator[Frame]
) -> tuple[str, str]:
    """What became of the second of two commands when the first, or what was understood of it, had been ``begun``."""
    first, second = [await planned(ears.planner, part) for part in said.parts]
    more = await ears.add(clock, heard, rest)
    told = f"{' '.join(said.parts)!r} as {heard.text!r}, then {more.text if more is not None else ''!r}"
    if begun != first:
        return "harmed", told
    if more is None:
        return "half", told
    added = await planned(ears.planner, more.text)
    return "carried on" if added == (second if more.adds else (*first, *second)) else "harmed", told


def as_figures(cells: dict[str, Cell]) -> tuple[dict[str, Figure], dict[str, float]]:
    found = {
        f"last word to transcript, {name}": figures(c.understood, "s") for name, c in cells.items() if c.understood
    }
    ratios = {f"cut off with words, {name}": cell.cut / cell.n for name, cell in cells.items()}
    for name, cell in cells.items():
        ratios |= {f"cut off and {outcome}, {name}": count / cell.n for outcome, count in cell.outcomes.items()}
    plain = {name: cell for name, cell in cells.items() if cell.plain}
    ratios |= {f"a plain command, {name}": len(c.understood) / c.plain for name, c in plain.items()}
    return found, ratios | {f"another command, {name}": c.wrong / c.plain for name, c in plain.items()}


def recordings(ears: Ears) -> Iterator[Said]:
    """Clean recordings with a lead and a tail of silence."""
    clean = [clip for clip in clips() if clip.snr_db is None]
    for clip in clean:
        plain = ears.planner.completeness(clip.text) == "complete"
        yield _said("single", clip.samples, clip.text if plain else "")
    random = np.random.default_rng(7)
    for first, second in zip(clean[::2], clean[1::2], strict=False):
        voice = _with_pause(first.samples, second.samples, float(random.uniform(0.25, 0.45)))
        yield _said("joined", voice, parts=(first.text, second.text))
    for clip in clean:
        if (parts := _halves(ears.recogniser, clip)) is not None:
            plain = ears.planner.completeness(clip.text) == "complete"
            pause_s = float(random.uniform(0.5, 0.9))
            yield _said("hesitating", _with_pause(*parts, pause_s), clip.text if plain else "")


def _said(kind: str, voice: Samples, text: str = "", parts: tuple[str, ...] = ()) -> Said:
    _, end = speech_bounds(voice)
    return Said(kind, np.concatenate((silence(LEAD_S), voice, silence(TAIL_S))), LEAD_S + end, text, parts)


def _halves(recogniser: Recogniser, clip: Clip) -> tuple[Samples, Samples] | None:
    """Cut before the last word of a recording that has an article before it, or before what follows a number."""
    model = recogniser._model  # type: ignore[attr-defined]
    model.window_frames, model.compares = 3000, False
    segments, _ = model.transcribe(clip.samples.astype(np.float32) / 32768, language="en", word_timestamps=True)
    words = [word for segment in segments for word in segment.words]
    for before, after in reversed(list(pairwise(words))):
        said = before.word.strip().casefold()
        if said in ("the", "me") or said.isdigit():
            at = round((before.end + after.start) / 2 * RATE)
            return clip.samples[:at], clip.samples[at:]
    return None


def _with_pause(first: Samples, second: Samples, pause_s: float) -> Samples:
    begin, end = speech_bounds(second)[0], speech_bounds(first)[1]
    return np.concatenate((first[: round(end * RATE)], silence(pause_s), second[round(begin * RATE) :]))
