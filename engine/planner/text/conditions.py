"""Words that show that a request depends on something, and polite forms that only look like it."""

from __future__ import annotations

import re
from typing import Final

IF_POLITE: Final = re.compile(
    r"\b(?:obliged|grateful|glad|happy|great|nice|lovely|good|kind|brilliant|wonderful|love it|appreciate it|like it|"
    r"help) if you(?:'d| would| could| can| might)?\b|"
    r"\bif you(?:'d| would) (?:be so (?:kind|good)|please|like to|care to)\b|"
    r"\bif (?:you (?:don't mind|do not mind|can|could|would|like|please|want to|have (?:time|a (?:moment|minute)))|"
    r"(?:that|it)(?:'s| is) (?:ok|okay|all right|alright|possible|no trouble|not too much trouble))\b"
    r"|\b(?:whether|if) or not\b|\b(?:no matter|regardless(?: of)?|irrespective of|even) (?:whether|if)\b"
    r"|(?:如果|要是)?(?:您|你)?(?:不麻烦|方便|可以|有空|愿意)的话|不管(?:是否|有没有)|无论(?:是否|有没有)",
    re.IGNORECASE,
)
"""A condition by its form alone: politeness, and what makes no difference."""
CONDITION: Final = re.compile(
    r"\b(?:if|whether|unless|in case|should there|as long as|provided|whenever|otherwise)\b"
    r"|\bis there\b.*\bthen\b|如果|要是|假如|是否|有没有|否则|的话|除非|只有.{1,20}才|"
    r"(?:没有?|有|不|还)(?:在|人|[^，。]{0,3})(?:[，, ]|你|您|那)*就(?!好|行|可以|算)",
    re.IGNORECASE,
)
"""What shows that a request depends on something."""
