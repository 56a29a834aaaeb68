"""What somebody wants somewhere: "I need the red box on the desk".

The grammar leaves open whether the place is a part of the name (the box that is on the desk: bring it) or of the wish
(the box is to be on the desk: put it there). People who want it brought have plainer words for that ("from the desk",
"that's on the desk"), and name no other goal here. So the place is the goal, unless the thing was seen there already:
then there would be nothing left to wish for.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from engine.planner.readings.rewording import Rewordings, names
from engine.planner.readings.several import thing_of
from engine.skills.vocabulary import Vocabulary

_ARTICLE: Final = re.compile(r"^\w+ ")


class Wishes:
    """Knows the places of one house."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        known = (*vocabulary.places(), *vocabulary.surfaces(), *vocabulary.rooms())
        spots = {name.casefold() for name in known if len(name) > 1 and name.isascii()}
        self._thing = thing_of(vocabulary)
        self._wish = Rewordings("en", {"spot": names(spots)}).pattern("wish")

    def order(self, text: str, seen: Sequence[str]) -> str:
        """``text`` as an order, with what was ``seen`` (a sentence each); unchanged where it is no such wish."""
        found = self._wish.fullmatch(text.strip())
        if found is None or self._thing.fullmatch(found["thing"]) is None:
            return text
        thing, spot = found["thing"], found["spot"]
        name = _ARTICLE.sub("", thing).casefold()
        if found["there"] or any(name in told.casefold() and spot.casefold() in told.casefold() for told in seen):
            return f"bring me {thing} from the {spot}"
        return f"put {thing} {found['on']} the {spot}"
