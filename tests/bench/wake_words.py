"""What each wake word hears, what else it takes for one, how late it is, and what listening costs.

The voices are those synthetic ones on this machine and in ``--voices`` that none of these heads knows: each head names
the speakers that trained it, and one that does not is not tried. Noise is that of a kitchen where the shared data are,
else white. False alarms are counted over all other recordings: the shared ones, the demo speech, and the files of
``--others``. What a spotter is not sure of counts where the recogniser confirms it, as in the engine; *sure* are those
of which it need not be asked.

Latency is from the last sample of the word to a wake that is sure; *cost* is processor time for a second of sound, and
*push* what the reader of the microphone waits when it hands a frame over. Ratios are shares of the words that were
heard, and how often an hour there was a false alarm, or the recogniser was asked for nothing.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import config
from config import paths
from engine.asr.recogniser import Recogniser
from engine.audio.source import FRAME_SAMPLES
from engine.audio.wav import read_wav
from engine.errors import ModelError, SaysoError
from engine.han import is_chinese
from engine.hearing.transcriber import ends_with
from engine.parts.loading import make_recogniser, model_store
from engine.parts.words import load_spotters
from engine.wake.choice import known_words
from engine.wake.head import Head
from engine.wake.training.voices import Remembered, Sound, Voice, find_voices
from engine.wake.words import RATE, Spotted, Spotter, WordListener, asked_about
from tests.bench.report import figures, print_report, report
from tests.bench.speech import DEMO, clips, noise
from tui.commands.wake import read_sound

CONDITIONS = {"clean": None, "10 dB": 10.0, "5 dB": 5.0}
SPEECH = 0.08
"""How loud a word is, root of the mean square of ±1."""
LATE_S = 0.7
AHEAD_S = 0.5


@dataclass
class Tally:
    """What one phrase came to."""

    heard: dict[str, list[bool]] = field(default_factory=lambda: {name: [] for name in CONDITIONS})
    sure: dict[str, list[bool]] = field(default_factory=lambda: {name: [] for name in CONDITIONS})
    late_ms: list[float] = field(default_factory=list)
    alarms: int = 0
    asked: int = 0
    cost_ms: float = 0.0


def natural(folders: Sequence[Path]) -> tuple[Path | None, list[Path], list[Path]]:
    """The folder of Kokoro where there are styles for it, those, and models of piper."""
    styles = [file for folder in folders for file in sorted(folder.glob("*.bin"))]
    piper = [file for folder in folders for file in sorted(folder.glob("*.onnx"))]
    try:
        return model_store(config.load()).find("kokoro") if styles else None, styles, piper
    except SaysoError:
        return None, styles, piper


def trained_by(phrase: str) -> frozenset[str]:
    """The speakers whom the head of a phrase knows; none, where microWakeWord listens for it. Raises ``ModelError``."""
    (file,) = (word.file for word in known_words(paths().words) if word.phrase == phrase)
    if file is None:
        return frozenset()
    if not (known := Head.load(file).trained_by):
        raise ModelError(f"{file} does not say who trained it.", hint=f'Train it again: sayso wake train "{phrase}"')
    return frozenset(known)


def unseen(voices: Sequence[Voice], known: Collection[str]) -> list[Voice]:
    """Those in which one hears none of the speakers who are known."""
    return [voice for voice in voices if not set(voice.speakers) & set(known)]


def frames(sound: NDArray[np.int16]) -> Iterator[NDArray[np.int16]]:
    for at in range(0, len(sound), FRAME_SAMPLES):
        yield sound[at : at + FRAME_SAMPLES]


def confirmed(recogniser: Recogniser, spotted: Spotted, sound: NDArray[np.int16]) -> bool:
    """Whether the recogniser, asked about a doubt in ``sound``, would wake for it."""
    return bool(ends_with(recogniser, spotted.phrase, asked_about(sound, spotted.at), likely=spotted.likely))


def say(spotter: Spotter, recogniser: Recogniser, phrase: str, words: Sequence[Sound], tally: Tally) -> None:
    """Words, each in every condition."""
    for index, word in enumerate(words):
        loud = word * np.float32(SPEECH / np.sqrt(np.mean(word**2)))
        before, after = np.zeros(2 * RATE, np.float32), np.zeros(RATE, np.float32)
        clean = np.concatenate((before, loud, after))
        end = len(before) + len(loud)
        for condition, snr in CONDITIONS.items():
            kitchen = noise(len(clean) / RATE, index)[: len(clean)].astype(np.float32)
            level = SPEECH * 10 ** (-(60.0 if snr is None else snr) / 20)
            sound = clean + kitchen * np.float32(level / np.sqrt(np.mean(kitchen**2)))
            samples = (np.clip(sound, -1, 1) * 32767).astype(np.int16)
            spotter.reset()
            found = [
                spotted
                for piece in frames(samples)
                for spotted in spotter.push(piece)
                if spotted.phrase == phrase and -AHEAD_S * RATE < spotted.at - end < LATE_S * RATE
            ]
            late = [spotted.at - end for spotted in found if spotted.sure]
            tally.sure[condition].append(bool(late))
            doubts = (spotted for spotted in found if not spotted.sure)
            tally.heard[condition].append(bool(late) or any(confirmed(recogniser, doubt, samples) for doubt in doubts))
            if late and condition == "clean":
                tally.late_ms.append(late[0] / RATE * 1000)


def others(files: Sequence[Path]) -> Iterator[tuple[NDArray[np.int16], str]]:
    """Recordings, and what is said in them as far as that is known."""
    for clip in clips():
        yield clip.samples, clip.text.casefold()
    for file in sorted(DEMO.glob("*.wav")):
        yield read_wav(file), file.stem.replace("_", " ")
    yield noise(25.0, 0), ""
    for file in files:
        yield (read_sound(file) * 32767).astype(np.int16), ""


def mishear(spotter: Spotter, recogniser: Recogniser, phrase: str, files: Sequence[Path], tally: Tally) -> float:
    """Count false alarms; gives the hours."""
    seconds, spent = 0.0, 0.0
    for samples, text in others(files):
        if phrase in text:
            continue
        spotter.reset()
        began = time.process_time()
        found = [spotted for piece in frames(samples) for spotted in spotter.push(piece)]
        spent += time.process_time() - began
        doubts = [spotted for spotted in found if not spotted.sure]
        tally.asked += len(doubts)
        tally.alarms += len(found) - len(doubts) + sum(confirmed(recogniser, doubt, samples) for doubt in doubts)
        seconds += len(samples) / RATE
    tally.cost_ms = spent / seconds * 1000
    return seconds / 3600


def pushed(spotter: Spotter) -> list[float]:
    """What handing a frame over takes, µs."""
    listener = WordListener([spotter], lambda wake: None, lambda error: None, prompt=False)
    listener.start()
    frame, taken = np.zeros(FRAME_SAMPLES, np.int16), []
    try:
        for _ in range(500):
            began = time.perf_counter()
            listener.push(frame)
            taken.append((time.perf_counter() - began) * 1e6)
    finally:
        listener.close()
    return taken


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench wake_words", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=60, help="voices at most")
    parser.add_argument("--phrase", action="append", help="only this one; default: all that can be listened for")
    parser.add_argument(
        "--voices", type=Path, action="append", default=[], help="a folder with voices of piper or Kokoro"
    )
    parser.add_argument("--others", type=Path, action="append", default=[], help="a recording without wake words")
    args = parser.parse_args(argv)
    settings = config.load()
    remembered = Remembered(paths().cache / "wake")
    found, ratios = {}, {}
    # what is not asked for is what these voices can say: they are English
    asked = args.phrase or [word.phrase for word in known_words(paths().words) if not is_chinese(word.phrase)]
    recogniser = make_recogniser(settings)
    recogniser.load()
    spotters: dict[str, Spotter] = {}
    known: set[str] = set()
    for phrase in asked:
        try:
            (spotters[phrase],) = load_spotters(settings, [phrase], doubts=True)
            known |= trained_by(phrase)
        except SaysoError as error:
            spotters.pop(phrase, None)
            print(f"{phrase}: {error}")
    voices = unseen(find_voices(*natural(args.voices)), known)[: args.n]
    for phrase, spotter in spotters.items():
        tally = Tally()
        say(spotter, recogniser, phrase, [remembered.say(voice, f"{phrase}.", 1.0) for voice in voices], tally)
        hours = mishear(spotter, recogniser, phrase, args.others, tally)
        for condition, heard in tally.heard.items():
            ratios[f"{phrase}: heard, {condition}, of {len(heard)}"] = float(np.mean(heard))
            ratios[f"{phrase}: sure, {condition}"] = float(np.mean(tally.sure[condition]))
        ratios[f"{phrase}: false alarms an hour, in {hours:.2f} h"] = tally.alarms / hours
        ratios[f"{phrase}: asked for nothing an hour"] = tally.asked / hours
        if tally.late_ms:
            found[f"{phrase}: end of the word → wake"] = figures(tally.late_ms, "ms")
        found[f"{phrase}: cost of a second"] = figures([tally.cost_ms], "ms")
        found[f"{phrase}: push"] = figures(pushed(spotter), "µs")
    print_report(report("wake_words", len(voices), found, ratios), args.json)


if __name__ == "__main__":
    main()
