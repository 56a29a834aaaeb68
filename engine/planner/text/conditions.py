"""Words that show that a request depends on something, and polite forms that only look like it."""

from __future__ import annotations

import re
from typing import Final

IF_POLITE: Final = re.compile(
    r"\b(?:obliged|grateful|glad|happy|great|nice|lovely|good|kind|brilliant|wonderful|love it|appreciate it|like it|"
    r"help) if you(?:'d| would| could| can| might)?\b|"
    r"\b(?:i|we)(?:'d| would| should) (?:be |feel )?(?:so |very |ever so |most |really )*"
    r"(?:obliged|grateful|glad|happy|pleased|delighted|like it|love it|appreciate it) if\b|"
    r"\bif you(?:'ve| have)(?: got)? (?:nothing (?:else|better)(?: to do| on)?|(?:some |any )?(?:spare |free )?time|"
    r"nothing (?:to do|on))\b|"
    r"\bif you(?:'d| would) (?:be so (?:kind|good)|please|like to|care to)\b|"
    r"\bif (?:you (?:don't mind|do not mind|can|could|would|like|please|want to|have (?:time|a (?:moment|minute)))|"
    r"(?:that|it)(?:'s| is) (?:ok|okay|all right|alright|possible|no trouble|not too much trouble))\b"
    r"|\b(?:whether|if) or not\b|\b(?:no matter|regardless(?: of)?|irrespective of|even) (?:whether|if)\b"
    r"|(?:如果|要是)?(?:您|你)?(?:不麻烦|方便|可以|有空|愿意)的话|不管(?:是否|有没有)|无论(?:是否|有没有)",
    re.IGNORECASE,
)
"""A condition by its form alone: politeness, and what makes no difference."""
_ELSE: Final = (
    r"(?:otherwise|or else|else|if not|"
    r"(?:if|when) (?:it|he|she|they|that|there|you)(?:'s not| isn't| is not|'re not| aren't| are not| doesn't| don't|"
    r" can't| cannot| haven't)(?: (?:there|one|any|find (?:it|any|one)))*|"
    r"if there(?:'s| is| are)? ?(?:none|nothing|nobody|no one)|if (?:i'm|i am) (?:wrong|mistaken)|"
    r"(?:nobody|no one|none|nothing)(?:'s| is)?(?: there| here| around)?,? then|"
    r"if (?:none|nothing|nobody))"
)
_NOTHING: Final = (
    r"(?:(?:then|just|please|you can|simply|do)[ ,]+)*"
    r"(?:leave (?:it|them|that|everything|things)(?: all)?(?: alone| be| there| where (?:it|they)"
    r"(?: is| are|'s|'re)| as (?:it|they)(?: is| are|'s|'re))?|let (?:it|them|that) be|do nothing|nothing|never ?mind|"
    r"forget (?:it|about it)|don't bother|don't worry(?: about it)?|that's (?:fine|ok|okay|all right)|"
    r"it's (?:fine|ok|okay)|no worries|whatever|skip it|"
    r"stay (?:put|where you are)|it stays?(?: there| put| where it is)?)"
)
_EMPTY_BRANCH: Final = re.compile(
    rf"[\s,.;:–—-]*(?:\b(?:and|but) )?\b{_ELSE}[\s,:–-]+{_NOTHING}(?=\W*(?:$|[.;!?]))|"
    r"[，,。；; ]*(?:要是|如果)?"
    r"(?:不[\u3400-\u9fff]{1,3}?(?=的话|[，,]|就|那)|没有?|没看到|不然|否则|要不|没人|在别处)"
    r"(?:的话)?[，, ]?(?:那?就|也)?"
    r"(?:算了|不用管|不管(?:它|了)?|别管|没事|别动|不用了|放着|什么[也都]不用?做)(?:吧|了)?(?=[。！!]?$|[，。])",
    re.IGNORECASE,
)


_OF_ITS_OWN: Final = re.compile(
    r"\W*(?:(?:and|but) )?(?:if|when|nobody|no one|none|nothing|要是|如果|没人|不.{1,3}就)", re.IGNORECASE
)
"""What is a condition without one before it."""


def without_empty_branches(text: str) -> str:
    """The text with blanks in place of what is to be done with nothing where a condition does not hold: "…; otherwise
    leave it". As long as before."""
    plain = text.replace("’", "'")
    for found in _EMPTY_BRANCH.finditer(plain):
        before = plain[: found.start()]
        if CONDITION.search(before) or (before.strip() and _OF_ITS_OWN.match(found[0])):
            text = f"{text[: found.start()]}{' ' * (found.end() - found.start())}{text[found.end() :]}"
    return text


CONDITION: Final = re.compile(
    r"\b(?:if|whether|unless|in case|should there|as long as|provided|whenever|otherwise)\b"
    r"|\bis there\b.*\bthen\b|如果|要是|假如|是否|有没有|否则|的话|除非|只有.{1,20}才|"
    r"(?:没有?|有|不|还)(?:在|人|[^，。]{0,3})(?:[，, ]|你|您|那)*就(?!好|行|可以|算)",
    re.IGNORECASE,
)
"""What shows that a request depends on something."""
