"""How many orders in noise lead to the right plan: as the engine listens, and by the same weights in Whisper's own way.

Orders of test sets that no recording has are said by a synthetic voice in the noise of a kitchen. *Ears* listen as the
engine does it (end of speech, short window, second looks, known words; see ``tests.bench.listening``); *whole* decodes
the whole recording in windows of 30 s. Both texts are planned without large models, and right is the plan of the words.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from config import load
from engine.asr.recogniser import Transcript
from engine.audio.source import RATE
from engine.errors import SaysoError
from engine.parts.loading import at_home, make_recogniser, model_store, vocabulary
from engine.wake.training.voices import Piper
from tests.bench.commands import PASS_S
from tests.bench.listening import Clockwork, Ears, planned
from tests.bench.report import Report, print_report, report
from tests.bench.speech import frames, mixed, noise, silence
from tests.bench.turns import LEAD_S, TAIL_S
from tests.eval.commands import load_commands

SETS: Final = ("kept10_en", "kept11_en", "kept12_en", "kept13_en")
"""Those whose plain orders are said; all of them have been read."""
CATEGORIES: Final = ("moves", "places", "things")
LONGEST: Final = 9
"""Words of an order."""
PRE_ROLL_S: Final = 0.3
"""How much of what comes before the voice a whole recording has."""


def run(json: bool, orders: int, snr_db: float, overrides: tuple[str, ...] = ()) -> Report:
    """Measure with the settings in force and ``overrides``: so many ``orders``, so much louder than the noise."""
    return asyncio.run(_run(json, orders, snr_db, overrides))


async def _run(json: bool, orders: int, snr_db: float, overrides: tuple[str, ...]) -> Report:
    settings = load(overrides=overrides)
    ears, nouns = Ears.of(at_home(settings)), vocabulary(settings)
    recogniser = make_recogniser(settings)
    voice = Piper(model_store(settings).folder / "piper-joe" / "en_US-joe-medium.onnx")
    plans = {text: plan for text in _texts() if (plan := await planned(ears.planner, text))}
    texts = list(plans)[:: max(1, len(plans) // orders)][:orders]
    right = {"ears": 0, "whole": 0}
    for seed, text in enumerate(texts):
        said = (voice.say(text, 1.0) * 32767).astype(np.int16)
        sound = np.concatenate((silence(LEAD_S), said, silence(TAIL_S)))
        sound = mixed(sound, noise(len(sound) / RATE, seed), snr_db)
        heard = {"ears": (await ears.listen(Clockwork(lambda found: PASS_S), frames(sound))).text}
        whole = (sound[round((LEAD_S - PRE_ROLL_S) * RATE) :] / 32768).astype(np.float32)
        stretches = [stretch.found for stretch in recogniser.stretches(whole, nouns)]
        heard["whole"] = " ".join(found.text for found in stretches if isinstance(found, Transcript))
        for way, words in heard.items():
            good = await planned(ears.planner, words) == plans[text]
            right[way] += good
            if not good:
                sys.stderr.write(f"{way}: {text!r} was heard as {words!r}\n")
    ratios = {f"right plan, {way}": count / len(texts) for way, count in right.items()}
    result = report(f"orders at {snr_db:g} dB ({ears.recogniser.name})", len(texts), {}, ratios)
    print_report(result, json)
    return result


def _texts() -> Sequence[str]:
    folder = Path(__file__).parents[1] / "eval"
    entries = [entry for name in SETS for entry in load_commands(folder / f"{name}.yaml")]
    return [
        entry.say
        for entry in entries
        if entry.category in CATEGORIES and not entry.context and entry.say[:1].isupper()
        if 3 <= len(entry.say.split()) <= LONGEST
    ]


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench orders", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--orders", type=int, default=77, help="how many are said")
    parser.add_argument("--snr", type=float, default=10.0, metavar="DB", help="how much louder they are than the noise")
    parser.add_argument("--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE")
    arguments = parser.parse_args(argv)
    try:
        run(arguments.json, arguments.orders, arguments.snr, tuple(arguments.overrides))
    except SaysoError as error:
        sys.exit(error.message)


if __name__ == "__main__":
    main()
