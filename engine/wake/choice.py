"""Which phrases can be listened for, and by what: the user's own heads, those that ship, and microWakeWord's."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Final, Literal

from engine.errors import ModelError
from engine.wake import micro
from engine.wake.embedding import Embedding
from engine.wake.head import Head
from engine.wake.trained import TrainedSpotter
from engine.wake.words import NO_DOUBTS, Doubts, Spotter

SHIPPED: Final = Path(str(files("assets"))) / "wake"
MODEL: Final = "speech-embedding"
"""The model that all heads need, as the list of models calls it."""
STOPS: Final[Mapping[str, str]] = {"en": "stop", "zh": "停"}
"""What is listened for while the robot moves or speaks, by language: the name of a head, which may know other words
that mean the same."""
SUSPECTED: Final[Mapping[str, Doubts]] = {"stop": Doubts(above=0.5), "停": Doubts(above=0.7)}
"""How sure a head has to be of a stop for somebody to ask the recogniser, and do no more. Each Chinese syllable is like
another one: from 0.5 on it would be asked ten times a minute while people talk, and from 0.7 on three times."""
AMONG_CHINESE: Final = Doubts(above=0.5, below=0.993)
"""The same of "stop" where Chinese is spoken: in 26 minutes of it, the head was sure of five that were none, and from
0.993 on of one."""

DOUBTED: Final[Mapping[str, Doubts]] = {
    "hey jarvis": Doubts(above=0.01, below=0.97),
    "hey sayso": Doubts(above=0.05, below=0.998),
}
"""Of which phrases that wake whoever spots them is not sure, so that the recogniser is asked: 45 and 20 times an hour
while people talk. Who says "Jarvis" without an r, as half of England does, comes to 0.01…0.05, and the recogniser is
certain of it; above 0.8 came four things in 2.6 h of announcements and music that were none, above 0.9 one. Of 282
times "jarvis" alone, nine came above 0.9, and five above 0.97, from which its makers believe it. In 2.3 h of
announcements and music "hey sayso" came to 0.919 and to 0.995, and of what natural voices said 85 % came above 0.998,
and 66 % in noise (10 dB)."""


@dataclass(frozen=True, slots=True)
class Word:
    """A phrase that can be listened for."""

    phrase: str
    by: Literal["yours", "sayso", "microWakeWord"]
    file: Path | None  # of its head


def known_words(own: Path) -> list[Word]:
    """All of them; one's own go before those that ship."""
    found: dict[str, Word] = {}
    for word in _all(own):
        found.setdefault(word.phrase, word)
    return list(found.values())


def file_name(phrase: str) -> str:
    """Of the head of a phrase: ``hey_rosie.npz``."""
    return "_".join(phrase.casefold().split()) + ".npz"


def usual_words(embedding: Path | None) -> list[str]:
    """What is listened for where nobody has said what: what is installed of it."""
    by_library = ["hey jarvis"] if micro.is_installed() else []
    return [*by_library, *(["hey sayso"] if embedding is not None and (SHIPPED / "hey_sayso.npz").is_file() else [])]


def stop_words(languages: Collection[str]) -> list[str]:
    """What stops where these languages are spoken: that of each, and the English word, which everybody knows."""
    return [word for language, word in STOPS.items() if language == "en" or language in languages]


def make_spotters(
    phrases: Sequence[str],
    own: Path,
    embedding: Path | None,
    threshold: float | None = None,
    *,
    stops: Collection[str] = (),
    doubts: bool = False,
) -> list[Spotter]:
    """Spotters for all the phrases. ``own`` is the folder of the user's heads, ``embedding`` that of the model where it
    is there; ``threshold`` is in the place of each phrase's own. They hear the ``stops`` as well, where the model is
    there; of those they tell when they are not sure, too, and with ``doubts`` also of what wakes. Raises
    ``ModelError``."""
    known = {word.phrase: word for word in known_words(own)}
    words = []
    for phrase in phrases:
        if phrase.casefold() not in known:
            hint = f'Train it: sayso wake train "{phrase}". There are: {", ".join(known)}.'
            raise ModelError(f"Nobody knows how “{phrase}” sounds.", hint=hint)
        words.append(known[phrase.casefold()])
    asked = dict(DOUBTED) if doubts and threshold is None else {}
    made: list[Spotter] = [
        micro.MicroSpotter(word.phrase, threshold, asked.get(word.phrase, NO_DOUBTS))
        for word in words
        if word.file is None
    ]
    heads = [Head.load(word.file) for word in words if word.file is not None]
    if threshold is not None:
        heads = [replace(head, threshold=threshold) for head in heads]
    for stop in stops if embedding is not None else ():
        if stop in known and known[stop] not in words and (file := known[stop].file) is not None:
            heads.append(Head.load(file))
            asked[stop] = AMONG_CHINESE if stop == "stop" and STOPS["zh"] in stops else SUSPECTED[stop]
    if heads:
        if embedding is None:
            raise ModelError(
                f"The model that “{heads[0].phrase}” needs is not here.", hint=f"Run: sayso models pull {MODEL}"
            )
        made.append(TrainedSpotter(Embedding(embedding), heads, doubts=asked))
    return made


def _all(own: Path) -> Iterator[Word]:
    for file in sorted(own.glob("*.npz")):
        yield Word(_phrase_of(file), "yours", file)
    for file in sorted(SHIPPED.glob("*.npz")):
        yield Word(_phrase_of(file), "sayso", file)
    for phrase in micro.PHRASES:
        yield Word(phrase, "microWakeWord", None)


def _phrase_of(file: Path) -> str:
    return file.stem.replace("_", " ")
