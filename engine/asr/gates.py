"""The gates that a text passes before it counts as said.

Recognisers write *something* for any sound, above all in silence: they learnt from subtitles. A text is only let
through past gates on its mean log-probability and its no-speech probability, where the recogniser tells them, and
unless it is one of the phrases that are known to be invented.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from config.schema import Asr
from engine.asr.recogniser import Decoding, Rejected, Transcript
from engine.han import SIMPLER

ARTEFACTS = frozenset(
    (
        "amara org",
        "bye",
        "bye bye",
        "i",
        "music",
        "oh",
        "please subscribe",
        "silence",
        "so",
        "subtitles by the amara org community",
        "thank you",
        "thank you for watching",
        "thank you so much for watching",
        "thank you very much",
        "thanks for watching",
        "the",
        "uh",
        "um",
        "you",
        "请订阅",
        "谢谢",
        "谢谢大家",
        "谢谢收看",
        "谢谢观看",
        "字幕由amara org社区提供",
        "中文字幕志愿者杨栋梁",
    )
)
"""What Whisper writes in noise and silence (normalised): credits and small talk of the subtitles it learnt from, and
single words that are no command."""


def judge(text: str, decoding: Decoding, settings: Asr, vocabulary: Sequence[str]) -> Transcript | Rejected:
    """Let a text through as a transcript, or say why it is none."""
    words = _normalised(text)
    if not words:
        return Rejected("empty", "No words were recognised.", text, decoding)
    if decoding.no_speech_probability > settings.max_no_speech:
        detail = f"The sound is no speech with probability {decoding.no_speech_probability:.2f}."
        return Rejected("no_speech", detail, text, decoding)
    if decoding.avg_logprob < settings.min_logprob:
        detail = f"Too uncertain: mean log-probability {decoding.avg_logprob:.2f} is below {settings.min_logprob:g}."
        return Rejected("low_confidence", detail, text, decoding)
    if words in ARTEFACTS:
        return Rejected("artefact", f"{text!r} is what the recogniser writes in noise.", text, decoding)
    if _echoes(words, vocabulary):
        return Rejected("artefact", "Only the list of expected words came back.", text, decoding)
    return Transcript(text, math.exp(min(0.0, decoding.avg_logprob)), decoding)


def _normalised(text: str) -> str:
    """Lower-case words without punctuation and stage directions such as ``[Music]``."""
    spoken = re.sub(r"\[[^\]]*\]|\([^)]*\)|♪[^♪]*♪?", " ", text)
    return " ".join(re.findall(r"[^\W_]+(?:['’][^\W_]+)*", spoken.casefold().translate(SIMPLER)))


def _echoes(words: str, vocabulary: Sequence[str]) -> bool:
    """Whether ``words`` are three or more of the expected ones with nothing but articles between them."""
    nouns = sorted((_normalised(noun) for noun in vocabulary), key=len, reverse=True)
    if not nouns:
        return False
    left, count = re.subn(rf"\b(?:{'|'.join(map(re.escape, nouns))})\b", " ", words)
    return count >= 3 and not set(left.split()) - {"the", "a", "and"}
