"""Whether somebody asked for what a plan does where it needs no word of its own: a dance, a nod, a beep.

Such actions have no arguments that could be looked for in what was said, and a small model that knows nothing to do
likes them. So each needs a word that may stand for it somewhere in the task.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from engine.plan import Action

_GREETS: Final = r"wav(?:e|ing)\b|greet|hello|\bhi\b|goodbye|\bbye|welcom"
_DRIVES: Final = (
    r"\b(?:go|going|move|moving|driv\w+|drive|roll|walk|run|come|step|inch|creep|crawl|advance|reverse|retreat|"
    r"back\w*|forward\w*|ahead|straight|closer|nearer|further|farther|approach|left|right|sideways|strafe|slide|shift|"
    r"scoot|nudge|met(?:re|er)s?|cm|m|centimet\w+|feet|foot|inch(?:es)?|yards?|square|circle|triangle|zigzag|figure)\b"
    r"|走|开|退|进|移|挪|前|后|左|右|米|靠近|离|圈|方"
)
_TURNS: Final = (
    r"\b(?:turn\w*|rotat\w*|spin\w*|fac(?:e|ing)|left|right|around|round|clockwise|anticlockwise|counterclockwise|"
    r"degrees?|pivot|swivel|swing|circle|square|triangle|corner|twirl|behind|back\w*|opposite|other way)\b"
    r"|转|左|右|度|圈|回头|身后|后面|掉头|方"
)
_WORDS: Final = {
    **dict.fromkeys(("move_forward", "move_sideways"), _DRIVES),
    **dict.fromkeys(("move_left", "move_right"), _TURNS),
    "set_cmdvel": f"{_DRIVES}|{_TURNS}",
    "dance": r"danc|\bmoves?\b|boogie|groove|jig|twist|wiggle|party|perform|show|celebrat|spin|twirl|跳|舞|表演|扭",
    "drift": r"drift|slid|skid|漂|滑",
    "arm_nod": r"nod|\byes\b|agree|approv|\bbow|affirm|confirm|thumbs|点|同意|是|鞠躬",
    "arm_shake": rf"shak|\bno\b|refus|disagree|deny|disapprov|wag|{_GREETS}|摇|挥|招|不|打招呼|再见|问好",
    "arm_applaud": r"clap|applau|bravo|cheer|congrat|celebrat|prais|hands|well done|ovation|鼓|掌|喝彩|祝贺|拍手",
    "arm_up": rf"\barms?\b|\bhands?\b|rais|lift|\bup\b|reach|stretch|salut|claw|gripper|limb|point|{_GREETS}|手|"
              rf"臂|举|抬|伸",
    "arm_down": r"\barms?\b|\bhands?\b|lower|\bdown\b|drop|relax|rest|away|claw|gripper|limb|\bit\b|手|臂|放|落|收",
    "beep": r"beep|honk|horn|hoot|toot|tone|sound|nois|signal|alarm|alert|ring|buzz|chirp|peep|bleep|ping|"
            r"call|times|twice"
            r"|thrice|once|响|鸣|叫|嘀|滴|喇叭|声|提示|警|信号",
    "person_follow": r"follow|behind|along|with (?:me|us|him|her|them)|accompan|stick|after (?:me|us|him|her|"
                     r"them|that)|chase|"
                     r"tail|escort|shadow|close to|by my side|heel|keep up|跟|随|陪|追",
    "qr_follow": r"\bqr\b|code|二维码|码",
    "follow_line": r"line|stripe|track|trail|tape|path|mark|band|strip|线|条|轨|带",
    "follow_line_clear": r"line|stripe|track|trail|tape|path|mark|band|strip|线|条|轨|带",
    "patrol": r"patrol|round|guard|tour|watch|visit|every|each|\ball\b|whole|loop|circuit|between|"
              r"back and forth|house|"
              r"keep|巡|逻|转|各|每|所有|全|走一圈|来回",
}  # fmt: skip
_ASKED: Final = {name: re.compile(words, re.IGNORECASE) for name, words in _WORDS.items()}
_AGAIN: Final = re.compile(r"\b(?:again|repeat|same|once more|more|that|this|it)\b|再|又|同样|一样|还")
"""What may stand for a deed that was asked for before."""


def asked_for(actions: Sequence[Action], said: Sequence[str]) -> tuple[Action, ...]:
    """``actions`` without those that nothing in what was ``said`` (newest last) may stand for."""
    words = " ".join(said)
    if len(said) > 1 and _AGAIN.search(said[-1]) is not None:
        return tuple(actions)
    return tuple(a for a in actions if a.name not in _ASKED or _ASKED[a.name].search(words) is not None)
