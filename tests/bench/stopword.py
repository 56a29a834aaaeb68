"""A stop that is said while the robot moves: who hears it, how soon the robot rests and stops, and what else does that.

What is measured are the engine's own parts, frame by frame in the time of the sound: the spotter, which pauses, and the
recogniser, which overhears by itself and confirms what the spotter suspects. *Spotter* is the share of words at which
motion paused, *recogniser* that of those that it heard without being asked, *both* that of those that became a stop.
Latency is from the last sample of the word; the recogniser's part in it is the time that its decodings took
here, one after the other. The robot is told to *rest* by a pause, or by a stop where none came before it.

The voices are those synthetic ones on this machine and in ``--voices`` that the head does not know: it names the
speakers that trained it. Noise is that of a kitchen where the shared data are, else white. False pauses and false stops
are counted over all other recordings (the shared ones, the demo speech, noise, the files of ``--others``) and over talk
of those voices; for Chinese over talk in both languages, of which the Chinese sentences are none that a head was
trained with. Chinese is said by eSpeak NG, of whose tones the recogniser makes little, and by Kokoro in the styles of
Chinese speakers where ``--voices`` has them; these are counted apart, and so are sentences that are full of syllables
like those of a stop.
"""

from __future__ import annotations

import argparse
import asyncio
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import config
from config import paths
from config.schema import Settings
from engine.asr.recogniser import Recogniser, Rejected, Transcript
from engine.audio.source import RATE, Samples
from engine.audio.vad import make_vad
from engine.errors import ModelError
from engine.hearing.overhearing import Alert, Overhearing
from engine.lead import Lead
from engine.parts.loading import make_recogniser
from engine.parts.words import load_spotters
from engine.planner.phrases.stopping import is_stop
from engine.wake.training.texts import COMMANDS, SENTENCES
from engine.wake.training.voices import Remembered, Sound, Voice, find_voices
from engine.wake.words import Spotter
from tests.bench.report import figures, print_report, report
from tests.bench.speech import frames, noise
from tests.bench.talk_zh import EVERYDAY, LIKE_A_STOP
from tests.bench.wake_words import CONDITIONS, SPEECH, natural, others, trained_by, unseen

ENGLISH = (("Stop.", 1.0), ("Stop!", 1.15))
CHINESE = tuple(
    (text, pace) for text in ("停！", "停下！", "停下来！", "停止！", "别动！") for pace in (0.88, 1.0, 1.15)
)
LATE_S = 1.2
"""What comes later after the word is no answer to it."""


class Timed:
    """A recogniser that is known to be busy: when each answer would be there if sound went on meanwhile."""

    def __init__(self, recogniser: Recogniser) -> None:
        self.now = 0.0  # s of the sound
        self.free = 0.0  # s of the sound, when its newest answer is there
        self.decode_s: list[float] = []
        self.name = recogniser.name
        self.takes_lead = recogniser.takes_lead
        self.load = recogniser.load
        self.close = recogniser.close
        self._recogniser = recogniser

    def transcribe(
        self,
        samples: NDArray[np.float32],
        vocabulary: Sequence[str] = (),
        cancelled: Callable[[], bool] = lambda: False,
        *,
        quick: bool = False,
        lead: Lead | None = None,
    ) -> Transcript | Rejected:
        with self._timed():
            return self._recogniser.transcribe(samples, vocabulary, cancelled, quick=quick, lead=lead)

    def likelihood(
        self, samples: NDArray[np.float32], texts: Sequence[str], cancelled: Callable[[], bool] = lambda: False
    ) -> float | None:
        with self._timed():
            return self._recogniser.likelihood(samples, texts, cancelled)

    @contextmanager
    def _timed(self) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self.decode_s.append(time.perf_counter() - began)
        self.free = max(self.now, self.free) + self.decode_s[-1]


@dataclass
class Heard:
    """What became of a piece of sound, s of it."""

    paused: list[float] = field(default_factory=list)
    resumed: int = 0
    stopped: list[float] = field(default_factory=list)


class Ears:
    """What listens while a robot moves, without the engine around it."""

    def __init__(self, settings: Settings, spotter: Spotter | None, recogniser: Timed) -> None:
        self._settings = settings
        self._spotter = spotter
        self._recogniser = recogniser
        self._worker = ThreadPoolExecutor(1)

    async def hear(self, samples: Samples, *, asking: bool = True) -> Heard:
        """Listen to a piece of sound from silence on; ``asking``: the recogniser is asked what the spotter suspects."""
        heard, resting = Heard(), False
        recogniser = self._recogniser
        recogniser.now = recogniser.free = 0.0
        alert = Alert(make_vad(self._settings.vad), is_stop, lambda words: heard.stopped.append(recogniser.free))
        overhearing = Overhearing(alert, recogniser, self._worker)
        overhearing.switch(True)
        if self._spotter is not None:
            self._spotter.reset()

        def settled() -> None:
            nonlocal resting
            heard.resumed += resting and (not heard.stopped or heard.stopped[-1] < heard.paused[-1])
            resting = False

        def rest(at: float) -> None:
            nonlocal resting
            if not resting:
                resting = True
                heard.paused.append(at)

        for frame in frames(samples):
            recogniser.now = frame.end
            overhearing.push(frame)
            for spotted in self._spotter.push(frame.samples) if self._spotter is not None else ():
                if spotted.sure:
                    rest(frame.end)
                if asking:
                    overhearing.suspect(spotted.phrase, settled, lambda: rest(recogniser.free), sure=spotted.sure)
                else:
                    resting = False
            while overhearing.busy:
                await asyncio.get_running_loop().run_in_executor(self._worker, lambda: None)
                await asyncio.sleep(0)
        overhearing.switch(False)
        return heard

    def close(self) -> None:
        self._worker.shutdown()


def in_a_room(word: Sound, snr: float | None, seed: int) -> tuple[Samples, float]:
    """A word after two seconds of nothing, in noise; and when it ends, s."""
    loud = word * np.float32(SPEECH / np.sqrt(np.mean(word**2)))
    clean = np.concatenate((np.zeros(2 * RATE + seed * 211 % 1280, np.float32), loud, np.zeros(2 * RATE, np.float32)))
    kitchen = noise(len(clean) / RATE, seed)[: len(clean)].astype(np.float32)
    level = SPEECH * 10 ** (-(60.0 if snr is None else snr) / 20)
    sound = clean + kitchen * np.float32(level / np.sqrt(np.mean(kitchen**2)))
    return (np.clip(sound, -1, 1) * 32767).astype(np.int16), (len(clean) - 2 * RATE) / RATE


@dataclass
class Tally:
    """What words came to, in one condition."""

    spotted: list[bool] = field(default_factory=list)
    alone: list[bool] = field(default_factory=list)
    found: list[bool] = field(default_factory=list)
    pause_ms: list[float] = field(default_factory=list)
    stop_ms: list[float] = field(default_factory=list)
    rest_ms: list[float] = field(default_factory=list)  # of those that became a stop


async def listen(ears: Ears, words: Sequence[Sound], *, spotter: bool) -> dict[str, Tally]:
    """Say the words in every condition."""
    tallies = {condition: Tally() for condition in CONDITIONS}
    for seed, word in enumerate(words):
        for condition, snr in CONDITIONS.items():
            tally = tallies[condition]
            sound, end = in_a_room(word, snr, seed)
            heard = await ears.hear(sound)
            alone = await ears.hear(sound, asking=False) if spotter else heard
            paused = [at - end for at in heard.paused if at - end < LATE_S]
            stopped = [at - end for at in heard.stopped if at - end < LATE_S]
            tally.spotted.append(bool(paused))
            tally.alone.append(any(at - end < LATE_S for at in alone.stopped))
            tally.found.append(bool(stopped))
            tally.pause_ms += [1000 * at for at in paused[:1]]
            tally.stop_ms += [1000 * at for at in stopped[:1]]
            tally.rest_ms += [1000 * min(paused[:1] + stopped[:1])] if stopped else []
    return tallies


def talk(
    voices: Sequence[Voice], remembered: Remembered, texts: int, known: Sequence[str] = (*SENTENCES, *COMMANDS)
) -> Iterator[Samples]:
    """Each voice says some of what people say, sentence after sentence."""
    chance = np.random.default_rng(0)
    for voice in voices:
        parts: list[Sound] = [np.zeros(RATE, np.float32)]
        for index in chance.permutation(len(known))[:texts]:
            said = remembered.say(voice, known[index], 1.0)
            parts += [said * np.float32(SPEECH / np.sqrt(np.mean(said**2))), np.zeros(RATE // 3, np.float32)]
        sound = np.concatenate(parts)
        sound += chance.normal(0, 3e-4, len(sound)).astype(np.float32)
        yield (np.clip(sound, -1, 1) * 32767).astype(np.int16)


async def mishear(ears: Ears, sounds: Iterator[Samples]) -> tuple[int, int, float]:
    """False pauses, false stops, and the hours in which they were."""
    pauses, stops, seconds = 0, 0, 0.0
    for sound in sounds:
        heard = await ears.hear(sound)
        pauses, stops, seconds = pauses + heard.resumed, stops + len(heard.stopped), seconds + len(sound) / RATE
    return pauses, stops, seconds / 3600


def people(folders: Sequence[Path], count: int) -> list[Voice]:
    """Voices that the head for "stop" does not know; the natural ones first, for they sound more like people."""
    voices = unseen(find_voices(*natural(folders)), trained_by("stop"))
    return sorted(voices, key=lambda voice: not _is_natural(voice))[:count]


def chinese_people(folders: Sequence[Path], count: int) -> dict[str, list[Voice]]:
    """Likewise, of those who speak Chinese, by who they are."""
    voices = unseen(find_voices(*natural(folders), "zh"), trained_by("停"))
    kinds = {
        "natural voices": [voice for voice in voices if _is_natural(voice)],
        "eSpeak": [voice for voice in voices if not _is_natural(voice)],
    }
    return {kind: several[:count] for kind, several in kinds.items() if several}


def _is_natural(voice: Voice) -> bool:
    return voice.name.startswith(("kokoro:", "piper:"))


async def run(args: argparse.Namespace) -> None:
    settings = config.load()
    remembered = Remembered(paths().cache / "wake")
    voices = people(args.voices, args.n)
    chinese = chinese_people(args.voices, args.n)
    found, ratios = {}, {}
    for language, takes, kinds in (("en", ENGLISH, {"stop": voices}), ("zh", CHINESE, chinese)):
        if args.language not in (None, language):
            continue
        spoken = config.load(overrides=[f"asr.language={language}"])
        recogniser = Timed(make_recogniser(spoken))
        recogniser.load()
        try:
            spotter = next(iter(load_spotters(spoken, (), stops=True)), None)
        except ModelError as error:
            print(error)
            spotter = None
        ears = Ears(settings, spotter, recogniser)
        for kind, speakers in kinds.items():
            name = kind if language == "en" else f"停 ({kind})"
            words = [remembered.say(voice, text, pace) for voice in speakers for text, pace in takes]
            for condition, tally in (await listen(ears, words, spotter=spotter is not None)).items():
                for who, share in (("spotter", tally.spotted), ("recogniser", tally.alone), ("both", tally.found)):
                    ratios[f"{name}: {who}, {condition}, of {len(share)}"] = float(np.mean(share))
                for what, late_ms in (("pause", tally.pause_ms), ("stop", tally.stop_ms), ("rest", tally.rest_ms)):
                    if late_ms:
                        found[f"{name}, {condition}: end of the word → {what}"] = figures(late_ms, "ms")
        found[f"{language}: a decoding"] = figures([1000 * s for s in recogniser.decode_s], "ms")
        if not args.no_others:
            rest = {
                "recordings": (sound for sound, text in others(args.others) if not is_stop(text)),
                "talk of these voices": talk(voices, remembered, args.texts),
            }
            if language == "zh":
                rest |= {
                    f"{what} in Chinese by {kind}": talk(speakers, remembered, len(texts), texts)
                    for kind, speakers in kinds.items()
                    for what, texts in (("everyday talk", EVERYDAY), ("talk that is like a stop", LIKE_A_STOP))
                }
            for title, sounds in rest.items():
                pauses, stops, hours = await mishear(ears, sounds)
                ratios[f"{language}: false pauses an hour, in {hours:.2f} h of {title}"] = pauses / hours
                ratios[f"{language}: false stops an hour, in {hours:.2f} h of {title}"] = stops / hours
        ears.close()
        recogniser.close()
    print_report(report("stopword", len(voices), found, ratios), args.json)


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench stopword", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=60, help="voices at most")
    parser.add_argument("--language", choices=("en", "zh"), help="only this one; default: both")
    parser.add_argument(
        "--voices", type=Path, action="append", default=[], help="a folder with other voices of piper or Kokoro"
    )
    parser.add_argument("--others", type=Path, action="append", default=[], help="a recording without a stop")
    parser.add_argument("--texts", type=int, default=12, help="sentences that each voice says besides")
    parser.add_argument("--no-others", action="store_true", help="only words, nothing that is to be told from them")
    asyncio.run(run(parser.parse_args(argv)))


if __name__ == "__main__":
    main()
