"""How often people are found, and what is told of them is right: over distances, sides, postures and gestures.

    python -m tests.bench.people

One big room with a sofa, an armchair, a chair or a bed; the camera looks at the middle of the person from all sides,
with the pose believed a little wrong. A gesture is told from three pictures 0.35 s apart. Views in which furniture
hides nearly all of somebody are left out; gestures that the body or the picture's edge hides are not.
"""

from __future__ import annotations

import argparse
import itertools
import random
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Final

from engine.perception.gestures import gesture_of
from engine.perception.person import find_people
from engine.perception.sighting import Sighting
from engine.robot.company import Gesture
from tests.sim.people_room import BEDS, SEATS, Case, Onlooker

DISTANCES: Final = (1.5, 2.0, 2.5, 3.0, 4.0)
SIDES: Final = (0, 90, 180, 270)
"""Degrees, from where they look to where the robot stands, counter-clockwise."""
GESTURES: Final[tuple[Gesture | None, ...]] = (
    None, "waving", "raising the left arm", "raising the right arm", "pointing to the left", "pointing to the right",
)  # fmt: skip
COLOURS: Final = ("red", "orange", "yellow", "green", "blue", "purple", "white", "grey", "black")
APART_S: Final = 0.35
COLUMNS: Final = (
    "found", "posture", "shirt", "trousers", "wrong shirt", "wrong trousers", "gesture", "wrong gesture",
)  # fmt: skip


def cases(chosen: random.Random) -> Iterator[Case]:
    def clothes() -> tuple[str, str]:
        shirt, trousers = chosen.sample(COLOURS, 2)
        return shirt, trousers

    for gesture in GESTURES:
        for height in (1.5, 1.8):
            yield Case("standing", "", gesture, *clothes(), height)
        for on in SEATS:
            yield Case("sitting", on, gesture, *clothes())
    for on in (*BEDS, *BEDS):
        yield Case("lying", on, None, *clothes())


def judged(case: Case, looks: list[tuple[Sighting, ...]]) -> dict[str, bool]:
    """What is right, by column."""
    ones = [found[0] for found in looks if len(found) == 1]
    verdicts = {"found": len(looks[-1]) == 1}
    if not ones or (figure := ones[-1].figure) is None:
        return verdicts
    verdicts |= {
        "posture": figure.posture == case.posture,
        "shirt": figure.shirt == case.shirt,
        "trousers": figure.trousers == case.trousers,
        "wrong shirt": figure.shirt not in (None, case.shirt),
        "wrong trousers": figure.trousers not in (None, case.trousers),
    }
    if case.posture != "lying":
        told = gesture_of(ones)
        verdicts |= {"gesture": told == case.gesture, "wrong gesture": told not in (None, case.gesture)}
    return verdicts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--width", type=int, default=160, help="pixels across the picture")
    options = parser.parse_args()
    chosen = random.Random(1)
    right: dict[str, Counter[str]] = defaultdict(Counter)
    for case in cases(chosen):
        onlooker = Onlooker(case, width=options.width)
        for away, side in itertools.product(DISTANCES, SIDES):
            t = chosen.random()
            error = chosen.gauss(0, 0.02), chosen.gauss(0, 0.02), chosen.gauss(0, 0.01)
            pictures = [onlooker.look(away, side, t=t + i * APART_S, error=error) for i in range(3)]
            if onlooker.hidden(pictures[-1]):
                continue
            verdicts = judged(case, [find_people(picture, onlooker.map) for picture in pictures])
            who = f"{case.posture} {case.on}".strip()
            for row in (f"1 {who}", f"2 {away:.1f} m", f"3 from {side:3}°", f"4 {case.gesture}", "5 all"):
                for what, verdict in verdicts.items():
                    right[row][f"n {what}"] += 1
                    right[row][what] += verdict
    print(f"{'':24}" + "".join(f"{column:>16}" for column in COLUMNS))
    for row, counts in sorted(right.items()):
        shares = (f"{counts[c] / counts[f'n {c}']:.0%}" if counts[f"n {c}"] else "" for c in COLUMNS)
        print(f"{row[2:]:24}" + "".join(f"{share:>16}" for share in shares))


if __name__ == "__main__":
    main()
