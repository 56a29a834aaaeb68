"""``sayso wake``: the phrases that wake the robot. Lists them, tries them on a recording, and trains new ones."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import shlex
import sys
import tempfile
import time
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import soundfile
import soxr

from config import paths
from config.schema import Settings
from engine.audio.source import to_int16
from engine.audio.vad import make_vad
from engine.errors import AudioFormatError, ExitCode, ModelError, SaysoError, StorageError, UsageError
from engine.han import HAN
from engine.models import ModelStore
from engine.parts.loading import make_microphone, model_store
from engine.parts.words import load_spotters, phrases_of
from engine.wake.choice import MODEL, file_name, known_words
from engine.wake.embedding import RATE, Embedding
from engine.wake.head import Head
from engine.wake.training.texts import language_of
from engine.wake.training.trainer import QUICK, USUAL, Stage, check, train
from engine.wake.training.trial import doubts
from engine.wake.training.voices import Sound, Voice, find_voices
from tui.commands.head_plot import described, figures, plot
from tui.commands.own_voice import phrase_in
from tui.commands.recording import recorded
from tui.commands.settings import load_settings
from tui.output import data, json_line, say

SHORT: Final = 3
"""Syllables that a phrase should have, at least."""
RECORDINGS: Final = 3
RECORDING_S: Final = 2.5
TAKES: Final = 4
"""How often one recording is asked for, until the phrase is in it."""
LARGEST: Final = 2 << 20
"""More than a head is, B."""
BEFORE_S: Final = 2.5
QUIET: Final = 3.0
"""How loud a quiet room is, of 32768."""
VOICE_MODEL: Final = "kokoro"
CHINESE_VOICES: Final = "npm pack kokoro-js@1.2.1 && tar xf kokoro-js-1.2.1.tgz"
"""How to come by Kokoro's styles of all languages."""
DOING: Final[dict[Stage, str]] = {
    "speaking": "voices say it, and what is like it",
    "embedding": "listening to it in rooms, noise and silence",
    "learning": "learning the difference",
    "trying": "trying it on other voices",
}


def run(arguments: Namespace) -> int:
    """The command as the command line gives it."""
    settings = load_settings(arguments)
    if arguments.action == "list":
        return _list(settings, json=arguments.json)
    if not arguments.what:
        example = '"hey rosie"' if arguments.action == "train" else "recording.wav"
        raise UsageError(f"There is nothing to {arguments.action}.", hint=f"sayso wake {arguments.action} {example}")
    if arguments.action == "test":
        return _test(settings, Path(arguments.what), json=arguments.json)
    return _train(settings, arguments)


def _list(settings: Settings, *, json: bool) -> int:
    on = phrases_of(settings)
    for word in known_words(paths().words):
        try:
            head = Head.load(word.file) if word.file is not None else None
        except ModelError as error:  # the others are none the worse for it
            say(f"sayso: {error}")
            continue
        trial = head.trial if head is not None else None
        if json:
            file = word.file and str(word.file)
            json_line({"phrase": word.phrase, "by": word.by, "on": word.phrase in on, "file": file, "trial": trial})
        else:
            told = "" if trial is None else figures(trial)
            data(f"{'on ' if word.phrase in on else 'off'}  {word.phrase:<20} {word.by:<14} {told}".rstrip())
    return int(ExitCode.DONE)


def _test(settings: Settings, file: Path, *, json: bool) -> int:
    """Where in a recording each phrase is heard. Exit code 1 when none is, or 3 when not all were listened for."""
    sound = to_int16(read_sound(file))
    # A spotter that has just begun is deaf for as long as it looks back: whoever says it at once is heard as well.
    before = np.random.default_rng(0).normal(0, QUIET, round(BEFORE_S * RATE)).astype(np.int16)
    heard = np.concatenate((before, sound, np.zeros(RATE // 2, np.int16)))
    phrases, missed, count = [], 0, 0
    for word in known_words(paths().words):
        phrase = word.phrase
        try:
            (spotter,) = load_spotters(settings, [phrase])
        except SaysoError as error:
            say(f"sayso: {error}")
            missed += 1
            continue
        phrases.append(phrase)
        for spotted in spotter.push(heard):
            count += 1
            ended_s, at_s = (max(0.0, round(sample / RATE - BEFORE_S, 2)) for sample in (spotted.ended, spotted.at))
            if json:
                json_line({"phrase": phrase, "ended_s": ended_s, "at_s": at_s})
            else:
                data(f"{ended_s:8.2f} s  {phrase}")
    if count:
        return int(ExitCode.DONE)
    if phrases and not json:
        say(f"sayso: none of {', '.join(phrases)} in {file}.")
    return int(ExitCode.MISSING if missed else ExitCode.FAILED)


def _train(settings: Settings, arguments: Namespace) -> int:
    """Train a head and keep it, unless whoever is asked does not want it."""
    phrase = " ".join(arguments.what.casefold().split())
    english = phrase.isascii() and phrase.replace(" ", "").replace("'", "").isalpha()
    if not english and not re.fullmatch(f"(?:{HAN} ?)+", phrase):
        hint = 'For example: sayso wake train "hey rosie", or sayso wake train 小叽小叽'
        raise UsageError(f"“{phrase}” is neither in English letters nor in Chinese characters.", hint=hint)
    if len(re.findall("[aeiouy]+" if english else HAN, phrase)) < SHORT:
        say(f"sayso: “{phrase}” is short, and what is short is misheard more often. Three or four syllables are best.")
    store = model_store(settings)
    embedding = Embedding(store.find(MODEL))
    folders = arguments.voices or []
    kokoro = _folder(store, VOICE_MODEL)
    styles = [file for folder in folders for kind in ("*.bin", "*.npz") for file in sorted(folder.glob(kind))]
    if kokoro is not None and not styles:
        styles = [kokoro / "voices_ja.npz"]
    piper = [file for folder in folders for file in sorted(folder.glob("*.onnx"))]
    voices = _voices(phrase, kokoro, styles, piper)
    if kokoro is None:
        say(f"sayso: with natural voices it gets better: sayso models pull {VOICE_MODEL}")
    elif language_of(phrase) == "zh" and not any(file.stem.startswith("z") for file in styles):
        say(f"sayso: with Chinese voices it gets better: {CHINESE_VOICES}, and then --voices package/voices")
    target = arguments.to or paths().words / file_name(phrase)
    _check_target(target)
    others = [read_sound(file) for file in arguments.others or ()]
    check(phrase, voices, paths().cache / "wake")
    mine = _mine(settings, phrase, arguments.mine)
    began = time.monotonic()
    with _shown_progress() as show:
        trained = train(
            phrase,
            voices,
            embedding,
            paths().cache / "wake",
            mine=mine,
            background=others,
            effort=QUICK if arguments.quick else USUAL,
            on_step=show,
        )
    head = trained.head
    assert head.trial is not None, "training ends with a trial"
    against = doubts(head.trial)
    if arguments.json:
        figures_of = {"threshold": head.threshold, "delay_s": head.delay_s, "trial": head.trial, "doubts": against}
        json_line({"phrase": phrase, **figures_of})
    else:
        say(f"“{phrase}”, trained in {_duration(time.monotonic() - began)}, tried on voices that it had not heard:")
        data(plot(trained))
        data(described(head))
    for doubt in against:
        say(f"sayso: {doubt}")
    if against:
        say(f"sayso: this is not good enough to rely on. {_advice(arguments, often=head.trial.alarms > 1)}")
    asked = sys.stdin.isatty() and not arguments.json
    good = not against
    if not (arguments.yes or (_wanted(target, good=good) if asked else good)):
        say("sayso: not kept." + ("" if asked else " With --yes it is kept all the same."))
        return int(ExitCode.FAILED if against else ExitCode.DONE)
    _keep(head, target)
    usual = paths().words / file_name(phrase)
    where = "" if target.resolve() == usual.resolve() else f"Copy it to {usual} to listen for it: "
    way = f"--set 'wake.words=[{phrase}]', or wake.words in your config.yaml."
    say(f"sayso: {target}. {where or 'Listen for it: '}{way}")
    return int(ExitCode.DONE)


def _check_target(target: Path) -> None:
    """Whether a head can be kept there, before anybody has worked for it. Raises ``UsageError``, ``StorageError``."""
    try:
        if target.exists() and not target.is_file():
            raise UsageError(f"{target} is no file.", hint="Name the file of the head: --to hey_rosie.npz")
        folder = next(parent for parent in target.absolute().parents if parent.exists())
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(LARGEST))
    except OSError as error:
        hint = "Name another place: --to FILE"
        raise StorageError(f"{target} cannot be written: {error.strerror or error}.", hint=hint) from error


def _keep(head: Head, target: Path) -> None:
    """Save it there; where that fails it is not lost. Raises ``StorageError``, which says where it is then."""
    try:
        head.save(target)
    except StorageError as error:
        if (spare := _spared(head)) is None:
            raise
        hint = f"It is kept in {spare}. When that is mended: mv {shlex.quote(str(spare))} {shlex.quote(str(target))}"
        raise StorageError(error.message, hint=hint) from error


def _spared(head: Head) -> Path | None:
    """Where the head is kept for now; None where nothing can be written at all."""
    for folder in (paths().cache / "wake", Path(tempfile.gettempdir()) / f"sayso-{os.getpid()}"):
        with contextlib.suppress(StorageError):
            head.save(folder / file_name(head.phrase))
            return folder / file_name(head.phrase)
    return None


def _voices(phrase: str, kokoro: Path | None, styles: Sequence[Path], piper: Sequence[Path]) -> list[Voice]:
    """Who says it; and for a Chinese phrase, who speaks English beside it."""
    if language_of(phrase) == "en":
        return find_voices(kokoro, styles, piper)
    english = [file for file in styles if file.stem[:1] in "ab"]
    others = find_voices(kokoro if english else None, english, piper)
    return [*find_voices(kokoro, styles, piper, "zh"), *others]


def _advice(arguments: Namespace, *, often: bool) -> str:
    """What may make it better. ``often``: it wakes by itself."""
    ways = []
    if arguments.quick:
        ways.append("leave out --quick")
    if often and not arguments.others:
        ways.append("add an hour of talk without the phrase, such as a podcast (--others FILE)")
    if arguments.mine is None:
        ways.append("add your own voice (--mine record)")
    ways.append("choose a phrase of three or four syllables that is like no other")
    return f"Try this: {'; '.join(ways)}."


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def read_sound(file: Path) -> Sound:
    """A recording at 16 kHz. Raises ``AudioFormatError``."""
    if not file.is_file():
        raise AudioFormatError(f"There is no file {file}.", hint="A WAV file is needed.")
    try:
        sound, rate = soundfile.read(file, dtype="float32", always_2d=True)
    except (soundfile.LibsndfileError, OSError) as error:
        why = str(error).rstrip(".")
        raise AudioFormatError(f"{file} cannot be read: {why}.", hint="A WAV file is needed.") from error
    return np.asarray(soxr.resample(sound[:, 0], rate, RATE), np.float32)


def _mine(settings: Settings, phrase: str, mine: str | None) -> Sequence[Sound]:
    """The phrase as its user says it. Raises ``UsageError``, ``DeviceError``."""
    if mine is None:
        return ()
    if mine == "record":
        return [asyncio.run(_record(settings, phrase, number)) for number in range(1, RECORDINGS + 1)]
    found = sorted(Path(mine).glob("*.wav"))
    if not found:
        raise UsageError(
            f"There are no WAV files in {mine}.", hint="Each of them holds the phrase once, or: --mine record"
        )
    vad = make_vad(settings.vad)
    return [phrase_in(read_sound(file), str(file), vad) for file in found]


async def _record(settings: Settings, phrase: str, number: int) -> Sound:
    """One recording of the phrase, from the microphone; who is not heard is asked again. Raises ``UsageError`` once
    that has been in vain, ``DeviceError``."""
    vad = make_vad(settings.vad)
    async with make_microphone(settings) as microphone:
        for take in range(1, TAKES + 1):
            say(f"{number} of {RECORDINGS}: say “{phrase}” now")  # not before it listens
            frames = await recorded(microphone, RECORDING_S)
            sound = np.concatenate([frame.samples for frame in frames]) / np.float32(32768)
            try:
                return phrase_in(np.asarray(sound, np.float32), f"recording {number}", vad)
            except UsageError as error:
                error.hint += " `sayso doctor --mic` shows what the microphone hears."
                if take == TAKES:
                    raise
                say(f"sayso: {error}")
    raise AssertionError("the last take is kept, or refused")


def _folder(store: ModelStore, name: str) -> Path | None:
    try:
        return store.find(name)
    except SaysoError:
        return None


def _wanted(target: Path, *, good: bool) -> bool:
    """Ask whoever sits there."""
    before = ", in the place of the one that is there" if target.exists() else ""
    say(f"Keep it as {target}{before}? [{'Y/n' if good else 'y/N'}]")
    answer = sys.stdin.readline().strip().casefold()
    return answer in ("y", "yes") or (good and not answer)


@contextlib.contextmanager
def _shown_progress() -> Iterator[Callable[[Stage, int, int], None]]:
    """A bar on stderr, or a line a stage where stderr is no terminal."""
    if not sys.stderr.isatty():
        told: set[Stage] = set()

        def tell(stage: Stage, done: int, total: int) -> None:
            if stage not in told:
                told.add(stage)
                say(f"sayso: {DOING[stage]}")

        yield tell
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description:<44}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        tasks = {stage: bars.add_task(doing, start=False, total=1) for stage, doing in DOING.items()}

        def show(stage: Stage, done: int, total: int) -> None:
            bars.start_task(tasks[stage])
            bars.update(tasks[stage], completed=done, total=total)

        yield show
