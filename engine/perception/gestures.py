"""What somebody does with their arms, told from several looks at them: a hand that is up and moves waves."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Final

from engine.perception.sighting import Sighting
from engine.robot.company import Gesture

LASTS_S: Final = 1.5
"""s that looks at one gesture may lie apart."""
MOVES: Final = 0.08
"""m by which a hand that waves has moved, from one look to another."""
_RAISED: Final[frozenset[Gesture | None]] = frozenset({"raising the left arm", "raising the right arm", "waving"})


def gesture_of(looks: Sequence[Sighting]) -> Gesture | None:
    """The gesture of somebody who was seen several times within ``LASTS_S``, the newest last; None when they make none,
    or it does not show. Two looks 0.3 to 0.4 s apart tell waving from an arm that is held up; one does not."""
    figures = [look.figure for look in looks if look.figure is not None]
    shown = [figure.gesture for figure in figures]
    if not shown:
        return None
    hands = [
        tuple(hand - middle for hand, middle in zip(figure.hand, look.position, strict=True))
        for look in looks
        if (figure := look.figure) is not None and figure.hand is not None and figure.gesture in _RAISED
    ]
    if any(math.dist(one, other) > MOVES for i, one in enumerate(hands) for other in hands[:i]):
        return "waving"
    if shown[-1] is None:
        return None
    newest = [gesture for gesture in shown if gesture is not None]
    most = Counter(newest).most_common()
    return next(gesture for gesture in reversed(newest) if Counter(newest)[gesture] == most[0][1])
