"""How somebody holds themselves and what they wear, from the points of a picture that show them.

A body is measured from its trunk: heads are in line with it, hips and shoulders at known parts of its height. Whoever
sits has a seat under the trunk; whoever lies is told in :mod:`engine.perception.lying`. An arm that is up or points is
what lies away from the trunk's axis above or beside the shoulders. Left and right are theirs, so that it must be known
where they look: where the knees are of one who sits, else by how much of the head is face and how much hair.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from engine.perception.clothes import colour, is_skin
from engine.perception.colours import Hsv
from engine.perception.loose import Loose
from engine.perception.sighting import Colour
from engine.robot.camera import Points
from engine.robot.company import Gesture, Posture

SEATS: Final = (0.2, 0.75)
"""m above the floor that people sit or lie on."""
HIP, SHOULDER = 0.48, 0.82
"""Parts of the height of somebody who stands; the head ends at 1."""
_OVER_SEAT = 0.08  # m that the hips are above a seat
_TALL = 1.6  # m, where the head does not show
_TALLEST = (0.9, 2.1)  # m that people are tall
_THICK = 0.06  # m of an arm that shows of its 8 cm
_HEAD = 0.12  # m around the trunk's axis that the head is within
_HALF = 0.1  # m from somebody's front to their axis
_HEAD_WIDTH = 0.105  # m that a head is wide at least; arms are narrower
_BESIDE, _BEYOND = 0.17, 0.45  # m from the axis: of a raised arm, and of one that points
_FEWEST = 12  # pixels that tell anything
_EDGE = 5  # rows from the upper edge of a picture that cuts somebody off, where shoulders may go on
_BRIGHT = 0.42  # brightness that parts a face from hair


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """What shows of somebody. Arrays have a row for each pixel."""

    points: Points  # base frame, m
    under: NDArray[np.float32]  # height of what the map has below, m
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    hsv: Hsv
    pixel: float  # m that a pixel covers there
    cut: bool  # the picture's upper edge ends it
    covered: bool  # something nearer hides what is above
    clear: NDArray[np.bool_]  # for each pixel: the robot's hand hides nothing of its line

    @classmethod
    def of(cls, found: Loose, hsv: Hsv, pixel: float, *, covered: bool) -> Body:
        across = slice(int(found.columns.min()), int(found.columns.max()) + 1)
        hidden: NDArray[np.bool_] = np.any(found.own[:, across], axis=1)
        cut = bool(found.rows.min() == 0)
        return cls(
            found.points, found.under, found.rows, found.columns, hsv, pixel, cut, covered, ~hidden[found.rows]
        )  # fmt: skip

    @property
    def z(self) -> NDArray[np.float64]:
        return np.asarray(self.points[:, 2])


@dataclass(frozen=True, slots=True)
class Build:
    """Where in a body what is; heights above the floor, m."""

    posture: Posture | None
    axis: tuple[float, float]  # of the trunk, base frame, m
    hips: float
    tall: float  # as if they stood
    head: bool  # whether it shows
    measured: bool  # whether head or shoulders show, and with them how tall they are

    @property
    def shoulders(self) -> float:
        return self.hips + (SHOULDER - HIP) * self.tall

    @property
    def top(self) -> float:
        return self.hips + (1 - HIP) * self.tall


def seat_under(body: Body) -> float | None:
    """The height of what somebody sits or lies on, m; None when they stand on the floor, or behind a table."""
    high = body.z > np.percentile(body.z, 40)
    over = (body.under[high] > SEATS[0]) & (body.under[high] < SEATS[1])
    if np.count_nonzero(over) < 0.5 * np.count_nonzero(high):
        return None
    return float(np.percentile(body.under[high][over], 20))  # not its arms, nor its back


def build(body: Body, seat: float | None) -> Build:
    """Of somebody upright."""
    away = _away(body)
    low, high = (seat + 0.2, seat + 0.58) if seat is not None else (0.5, 1.1)
    columns = np.bincount(body.columns)
    upright = columns[body.columns] > 0.55 * np.percentile(columns[columns > 0], 90)  # no arm that points
    band = (body.z > low) & (body.z < high) & upright
    if hides := np.count_nonzero(band) < _FEWEST:
        band = body.z > np.percentile(body.z, 30)
    front = np.median(body.points[band, :2], axis=0)
    aside = _from_axis(body, front, away)[0]
    left, right = np.percentile(aside[(body.z > low) & (body.z < high) & (np.abs(aside) < 0.3) | band], (5, 95))
    axis = front + (_HALF if hides else _thickness(float(right - left))) * away
    top = _top_of_head(body, axis, away)
    sits = seat is not None
    hips_at = seat + _OVER_SEAT if seat is not None else 0.0
    tall = _TALL
    shoulders = _top_of_shoulders(body, axis, away) if top is None else None
    if top is not None:
        tall = (top - hips_at) / (1 - HIP) if sits else top
    elif shoulders is not None:
        tall = (shoulders - hips_at) / (SHOULDER - HIP) if sits else shoulders / SHOULDER
    if body.covered or tall < _TALLEST[0]:  # nobody is so small: something hides the rest
        top, shoulders, tall = None, None, _TALL
    tall = min(tall, _TALLEST[1])
    hips = hips_at if sits else HIP * tall
    posture: Posture | None = "sitting" if sits else "standing" if _stands(body, axis) else None
    return Build(posture, (float(axis[0]), float(axis[1])), hips, tall, top is not None, (top or shoulders) is not None)


def _thickness(width: float) -> float:
    """From the front of a trunk that shows so wide to its axis, m: from aside it is narrow and deep."""
    return min(max(0.26 - 0.4 * width, _HALF), 0.18)


def _away(body: Body) -> NDArray[np.float64]:
    """From the robot towards them, on the floor."""
    middle = np.median(body.points[:, :2], axis=0)
    return np.asarray(middle / np.linalg.norm(middle))


def _from_axis(body: Body, axis: NDArray[np.float64], away: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """How far each point is from the axis: to the left as the robot sees it, and away from it, m."""
    off = body.points[:, :2] - axis
    return off @ np.array([-away[1], away[0]]), off @ away


def _top_of_head(body: Body, axis: NDArray[np.float64], away: NDArray[np.float64]) -> float | None:
    """Straight above the trunk, and wider than an arm: one that is up may be before the head or above it."""
    aside, behind = _from_axis(body, axis, away)
    above = (np.abs(aside) < _HEAD) & (np.abs(behind) < 0.2) & (body.z > np.percentile(body.z, 50))
    first, last = np.full(body.rows.max() + 1, 10_000), np.full(body.rows.max() + 1, -1)
    np.minimum.at(first, body.rows[above], body.columns[above])
    np.maximum.at(last, body.rows[above], body.columns[above])
    wide = (last - first + 1) * body.pixel > _HEAD_WIDTH  # an arm before it may part it
    if not wide.any() or (top := int(np.argmax(wide))) == 0:
        return None
    columns = np.unique(body.columns[above & (body.rows == top)])
    nearer = (body.rows < top) & np.isin(body.columns, columns) & (behind < -0.25)
    if np.count_nonzero(nearer) > 0.5 * len(columns):
        return None  # an arm that points at the robot is before it
    edge = (body.rows == 0) & (np.abs(aside) < _HEAD)
    if edge.any() and not is_skin(body.hsv[above & (body.z > body.z[above & (body.rows == top)].max() - 0.1)]).any():
        return None  # it is out of the picture, and an arm is what reaches there
    return float(body.z[above & (body.rows == top)].max() + 0.02)


def _top_of_shoulders(body: Body, axis: NDArray[np.float64], away: NDArray[np.float64]) -> float | None:
    """Beside the neck, inside of the arms."""
    aside, behind = _from_axis(body, axis, away)
    trunk = (np.abs(behind) < 0.16) & (np.abs(aside) < 0.22)
    if not trunk.any() or float(np.ptp(aside[trunk])) < 0.3:
        return None
    found = []
    for side in (-1, 1):
        part = (side * aside > 0.08) & (side * aside < 0.15) & (behind > -0.15) & (behind < 0.16)
        if not part.any():
            continue
        top = int(body.rows[part].min())
        # What goes on above it, nearer to the robot, is trunk as well.
        over = np.isin(body.columns, np.unique(body.columns[part])) & (body.rows < top) & (body.rows >= top - 3)
        if top > (_EDGE if body.cut else 0) and np.count_nonzero(over) < 3:
            found.append(float(body.z[part].max()))
    return min(found, default=None)


def _stands(body: Body, axis: NDArray[np.float64]) -> bool:
    """Whether legs show below the hips that reach down, and no knees before them."""
    legs = (body.z > 0.1) & (body.z < 0.5)
    if np.count_nonzero(legs) < _FEWEST:
        return False
    away = np.hypot(*(body.points[legs, :2] - axis).T)
    return float(np.median(away)) < 0.3


def clothes(body: Body, built: Build) -> tuple[Colour | None, Colour | None]:
    """The colours of shirt and trousers, where enough of them shows."""
    off = np.hypot(*(body.points[:, :2] - built.axis).T)
    z, hips, tall = body.z, built.hips, built.tall
    trunk = (off < 0.24) & (z > hips + 0.08 * tall) & (z < hips + 0.3 * tall)
    if built.posture == "sitting":
        legs = ((off > 0.16) & (z < hips + 0.06)) | (z < hips - 0.14)
        legs &= z > 0.14
    else:
        legs = (off < 0.24) & (z > 0.16) & (z < hips - 0.1 * tall)
    return colour(body.hsv[trunk]), colour(body.hsv[legs]) if built.posture is not None else None


def facing(body: Body, built: Build) -> float | None:
    """Where they look, base frame, rad; None where neither knees nor head show."""
    by_head = _by_head(body, built)
    if built.posture == "sitting":
        off = body.points[:, :2] - built.axis
        knees = (np.abs(body.z - built.hips) < 0.12) & (np.hypot(*off.T) > 0.28)
        if np.count_nonzero(knees) >= _FEWEST:
            x, y = np.median(off[knees], axis=0)
            by_knees = math.atan2(y, x)
            if by_head is None or math.cos(by_knees - by_head) > 0:  # else they are no knees
                return by_knees
    return by_head


def _by_head(body: Body, built: Build) -> float | None:
    axis, away = np.array(built.axis), _away(body)
    if not built.head:
        return None
    aside, behind = _from_axis(body, axis, away)
    head = (body.z > built.top - 0.15 * built.tall) & (body.z < built.top + body.pixel)
    head &= (np.abs(aside) < _HEAD) & (behind > -0.19) & (behind < 0.16)
    if np.count_nonzero(head) < 6:
        return None
    skin = is_skin(body.hsv[head]) & (body.hsv[head][:, 2] > _BRIGHT)
    share = float(np.mean(skin))
    if share in (0.0, 1.0):
        turned = 0.0
    else:
        turned = float(aside[head][skin].mean() - aside[head][~skin].mean()) / 0.07
        turned *= min(1.0, 6 * share * (1 - share))  # a few pixels tell little
    to_us = (share - 0.42) / 0.3
    left = np.array([-away[1], away[0]])
    x, y = turned * left - to_us * away
    return math.atan2(y, x)


def gesture(body: Body, built: Build, looks: float | None) -> tuple[Gesture | None, NDArray[np.float64] | None]:
    """What they do with their arms, and where the hand is, base frame, m."""
    away = _away(body)
    unknown = looks is None
    if looks is None:
        looks = math.atan2(-away[1], -away[0])  # whoever makes a gesture looks at whom it is for
    off = body.points[:, :2] - built.axis
    far = np.hypot(*off.T)
    left = np.array([-math.sin(looks), math.cos(looks)])
    up = (body.z > built.shoulders + (0.1 if built.head else 0.06)) & (far > _BESIDE) & (far < 0.55)
    if built.head:
        up |= (body.z > built.top + 0.08) & (far < 0.55)
    if built.measured and _shows(body, up, 0.12):
        theirs = float(np.mean(off[up] @ left)) > 0
        return "raising the left arm" if theirs else "raising the right arm", _end(body, body.z, up)
    level = (body.z > built.hips + 0.18 * built.tall) & (far > _BEYOND)
    if built.measured:
        level &= np.abs(body.z - built.shoulders + 0.03) < 0.2
    if _shows(body, level, 0.12):
        aside, behind = np.abs(off[level] @ [-away[1], away[0]]), np.abs(off[level] @ away)
        if unknown and aside.mean() < behind.mean():
            return None, None  # at the robot, or away from it: that is to either side
        theirs = float(np.mean(off[level] @ left)) > 0
        return "pointing to the left" if theirs else "pointing to the right", _end(body, far, level)
    return None, None


def _shows(body: Body, part: NDArray[np.bool_], at_least: float) -> bool:
    """Whether so much of an arm, in m, is there."""
    return bool(np.count_nonzero(part) >= max(4, _THICK * at_least / body.pixel**2))


def _end(body: Body, along: NDArray[np.float64], part: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The middle of the outermost part of an arm."""
    last = part & (along > np.max(along[part]) - 0.1)
    return np.asarray(body.points[last].mean(axis=0))
