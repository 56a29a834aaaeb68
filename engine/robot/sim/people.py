"""The people of a scene as those who hear the robot, and do what it asks of them (the table in ``docs/people.md``).

Whoever is within 3 m hears. Who is spoken to by name is the one who is meant, else the nearest of those who can do what
is asked, and of these rather one whom no wall hides. They answer after a moment. What they hear and do is kept as news.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from typing import Any, Final

from engine.robot.company import Happening, News
from engine.robot.geometry import Pose, wrap
from engine.robot.sim.destinations import Destinations
from engine.robot.sim.free_floor import FreeFloor, direction
from engine.robot.sim.handing import Giving, Hands, Taking
from engine.robot.sim.heard import Heard, names_of, understood
from engine.robot.sim.person import Mover
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import Point
from engine.robot.sim.somebody import Somebody
from engine.robot.sim.walking import Following, Leading, SteppingAside, Trail

HEARING: Final = 3.0
"""m from the robot's middle."""
REPLY_S: Final = 0.8
"""s of robot time until somebody does something about what they have heard."""

_ASIDE = 0.8  # m that somebody counts as farther away, per rad that the robot does not look at them
_BEFORE = 0.6  # rad off where the robot looks that somebody still stands before it
_ATTENDS_S = 6.0  # that somebody who walks about stands when they are spoken to
_KEPT = 200  # news that nobody has asked for


class People:
    """A :class:`engine.robot.company.Company`: everybody in a scene. Belongs to the thread of the simulation."""

    def __init__(self, model: Any, data: Any, scene: Scene, *, again: bool = False) -> None:
        """Everybody is where the scene has them; with ``again`` where ``data`` has them, and what they were about is
        forgotten."""
        self._data = data
        self._floor = FreeFloor(scene)
        self._destinations = Destinations(scene)
        self._trail = Trail()
        self._hands = Hands(model, data, scene.objects)
        self._people = [
            Somebody(Mover(model, data, name, person), name, person) for name, person in scene.people.items()
        ]
        words = Counter(word for one in self._people for word in one.descriptions)
        unique = {word: one for one in self._people for word in one.descriptions if words[word] == 1}
        self._called = {**unique, **{one.name: one for one in self._people}}
        self._names = names_of(self._called)
        self._robot = scene.start.pose
        self._news: deque[News] = deque(maxlen=_KEPT)
        self._due: deque[tuple[float, Somebody, Heard]] = deque()  # what they will do something about, and when
        for somebody in self._people:
            somebody.begin(self._hands, list(scene.objects), again=again)

    # A company

    def tell(self, text: str) -> None:
        """The robot says this now."""
        heard = understood(text, self._names)
        near = [one for one in self._people if one.pose.distance_to(self._robot) <= HEARING]
        if heard.to is not None:
            near = [one for one in near if one is self._called[heard.to]]
        if not near:
            return
        listener = min(near, key=lambda one: self._rank(one, heard))
        if heard.to is None and not self._in_sight(listener):  # whoever is spoken to is no one behind a wall
            before = (
                one for one in near if one.person.gives_tasks and self._in_sight(one) and self._off(one) < _BEFORE
            )
            listener = next(before, listener)
        listener.attends_until = self._t + _ATTENDS_S
        self._tell_of(listener, "hears", text)
        self._due.append((self._t + REPLY_S, listener, heard))

    def news(self) -> tuple[News, ...]:
        """What they have done since this was last asked, the oldest first."""
        found = tuple(self._news)
        self._news.clear()
        return found

    # Time

    def step(self, seconds: float, robot: Pose) -> None:
        """Everybody goes on for so long."""
        self._robot = robot
        self._trail.add((robot.x, robot.y))
        t = self._t
        while self._due and t >= self._due[0][0]:
            _, listener, heard = self._due.popleft()
            self._react(listener, heard)
        for somebody in self._people:
            for does, text in somebody.step(self._hands, robot, t, seconds):
                self._tell_of(somebody, does, text)

    @property
    def _t(self) -> float:
        return float(self._data.time)

    def _tell_of(self, somebody: Somebody, does: Happening, text: str = "") -> None:
        self._news.append(News(self._t, somebody.key, does, text))

    def _led_to(self, one: Somebody, goal: str) -> tuple[Point, ...]:
        """The way that somebody walks ahead of the robot."""
        if not one.person.gives_tasks or not goal:
            return one.person.leads
        return self._destinations.way(one.at, goal, [other.at for other in self._people if other is not one])

    def _rank(self, one: Somebody, heard: Heard) -> tuple[bool, bool, float]:
        """Less for who reacts rather: somebody who can, who sees the robot, and who is near, or looked at by it."""
        off = self._off(one)
        can = one.can(heard) and (heard.wish != "pass" or off < math.pi / 2)
        return not can, not self._in_sight(one), one.pose.distance_to(self._robot) + _ASIDE * off

    def _off(self, one: Somebody) -> float:
        """How far the robot would have to turn to look at somebody, rad."""
        robot = self._robot
        return abs(wrap(direction((robot.x, robot.y), one.at) - robot.yaw))

    def _in_sight(self, one: Somebody) -> bool:
        """Whether no wall is between somebody and the robot."""
        return self._floor.can_see((self._robot.x, self._robot.y), one.at)

    # What they do

    def _react(self, one: Somebody, heard: Heard) -> None:
        wish, t = heard.wish, self._t
        if wish == "nothing" and one.strayed and heard.to is not None:
            wish = "come along"  # their name alone is enough
        if not one.can(heard):
            return
        if wish in ("name", "answer"):
            self._tell_of(one, "says", one.answer(heard))
        elif wish == "follow":
            one.follow(Following(self._trail, self._floor))
            self._tell_of(one, "follows")
        elif wish == "come along" and one.strayed:
            one.follow(Following(self._trail, self._floor), again=True)
            self._tell_of(one, "follows")
        elif wish == "arrived":
            one.stay()
            self._tell_of(one, "stays")
        elif wish == "lead":
            if points := self._led_to(one, heard.goal):
                one.way = Leading(points, one.person.speed or 0.4, self._floor)
                self._tell_of(one, "leads")
        elif wish == "pass":
            aside = SteppingAside(one.pose, self._robot, self._floor, t)
            if aside.to is not None:
                one.way, one.then = aside, one.then if isinstance(one.way, SteppingAside) else one.way
                self._tell_of(one, "steps aside")
        elif wish == "take":
            one.handing = Taking(t)
        elif wish == "give":
            one.handing = Giving(one.what_is_meant(heard), t)
