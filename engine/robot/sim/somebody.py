"""One of the people of a scene: what they are about (a way to walk, something to hand over), what they hold, and what
they can do and say.
"""

from __future__ import annotations

import math

from engine.robot.company import Happening
from engine.robot.geometry import Pose
from engine.robot.sim.handing import Giving, Hands, Taking
from engine.robot.sim.heard import COLOURS_ZH, Heard
from engine.robot.sim.person import Mover, in_hand
from engine.robot.sim.scene_parts import Person, Point
from engine.robot.sim.walking import Following, Leading, Rounds, SteppingAside, Way

_IN_HAND = 0.05  # m from a hand, of what is in it


class Somebody:
    """What one person is about, and what they can do and say."""

    def __init__(self, mover: Mover, key: str, person: Person) -> None:
        self.key, self.person = key, person
        self.name = person.called or key
        self.way: Way | None = Rounds(person)
        self.then: Way | None = None  # what they were about before they stepped aside
        self.handing: Giving | Taking | None = None
        self.holds: list[str] = []
        self.strayed = False
        self.attends_until = -math.inf  # robot time, s
        self._mover = mover
        self._followed = 0.0  # m behind the robot
        self._strays = person.strays

    def begin(self, hands: Hands, things: list[str], *, again: bool) -> None:
        """Hold what the scene says, or what is in the hand already."""
        if not again:
            self.holds = [self.person.holds] if self.person.holds is not None else []
            return
        for thing in things:
            if math.dist(hands.middle(thing), self._hand(len(self.holds))) < _IN_HAND:
                self.holds.append(thing)
        if isinstance(self.way, Rounds) and not self.way.rejoin(self.at):
            self.way = None

    @property
    def descriptions(self) -> tuple[str, ...]:
        """How they are spoken to by who does not know their name, in English and Chinese."""
        shirt = self.person.shirt
        return f"you in {shirt}", f"穿{COLOURS_ZH.get(shirt, shirt)}色衣服的那位"

    @property
    def pose(self) -> Pose:
        return self._mover.pose

    @property
    def at(self) -> Point:
        pose = self._mover.pose
        return pose.x, pose.y

    def can(self, heard: Heard) -> bool:
        """Whether they could do what is asked: who sits goes nowhere, who lies has no hand free."""
        stands = self.person.posture == "standing"
        follows = isinstance(self.way, Following) or isinstance(self.then, Following)
        return {
            "follow": stands,
            "come along": self.strayed or follows,
            "arrived": self.strayed or follows,
            "lead": stands and bool(self.person.leads or (self.person.gives_tasks and heard.goal)),
            "name": not self.person.gives_tasks,
            "answer": not self.person.gives_tasks,
            "pass": stands and not follows,
            "take": self.person.posture != "lying",
            "give": self.person.posture != "lying" and bool(self.holds),
        }.get(heard.wish, True)

    def answer(self, heard: Heard) -> str:
        """What they say to a question."""
        if heard.wish == "name":
            me = f"我是{self.name}。" if heard.chinese else f"I am {self.name}."
            if heard.are_you is None:
                return me
            if heard.are_you == self.name.casefold():
                return "是的。" if heard.chinese else "Yes."
            return f"不是，{me}" if heard.chinese else f"No, {me}"
        known = (reply for word, reply in self.person.replies.items() if heard.mentions(word))
        return next(known, "我不知道。" if heard.chinese else "I do not know.")

    def what_is_meant(self, heard: Heard) -> str:
        """Which of the things that they hold."""
        return next((thing for thing in self.holds if heard.mentions(thing)), self.holds[-1])

    def follow(self, way: Following, *, again: bool = False) -> None:
        """Walk behind the robot; ``again`` after having strayed, which they do once."""
        self.way, self.then, self.strayed, self._followed = way, None, False, 0.0
        if again:
            self._strays = None

    def stay(self) -> None:
        """Stand where they are from now on."""
        self.way, self.then, self.strayed = None, None, False

    def step(self, hands: Hands, robot: Pose, t: float, seconds: float) -> list[tuple[Happening, str]]:
        """Go on for so long; returns what they have begun to do."""
        did: list[tuple[Happening, str]] = []
        if self.way is not None:
            did += self._walk(robot, t, seconds)
        else:
            self._mover.step(None, seconds)
        if self.handing is not None:
            did += self._hand_over(self.handing, hands, t)
        given = self.handing.thing if isinstance(self.handing, Giving) and self.handing.given else None
        for index, thing in enumerate(self.holds):
            if thing != given:
                hands.put(thing, self._hand(index), self.pose.yaw)
        return did

    def _walk(self, robot: Pose, t: float, seconds: float) -> list[tuple[Happening, str]]:
        way, pose = self.way, self.pose
        assert way is not None, "they walk"
        attends = isinstance(way, Rounds) and (t < self.attends_until or self.handing is not None)
        metres = self._mover.step(None if attends else way.next(pose, robot, t), seconds)
        if isinstance(way, Following):
            self._followed += metres
            if self._strays is not None and self._followed >= self._strays:
                self.stay()
                self.strayed = True
                return [("stays", "")]
        elif isinstance(way, Leading) and way.ended:
            self.stay()
            return [("stays", "")]
        elif isinstance(way, SteppingAside) and way.passed(pose, robot, t):
            self.way, self.then = self.then, None
        return []

    def _hand_over(self, handing: Giving | Taking, hands: Hands, t: float) -> list[tuple[Happening, str]]:
        begun = isinstance(handing, Giving) and handing.given
        goes_on = handing.step(hands, self.at, t)
        did: list[tuple[Happening, str]] = []
        if isinstance(handing, Giving) and handing.given and not begun:
            did.append(("gives", handing.thing))
        if not goes_on:
            self.handing = None
            if isinstance(handing, Giving) and handing.given:
                self.holds.remove(handing.thing)
            if isinstance(handing, Taking) and handing.taken and handing.thing is not None:
                self.holds.append(handing.thing)
                did.append(("takes", handing.thing))
        return did

    def _hand(self, index: int) -> tuple[float, float, float]:
        return in_hand(self.person, self.pose, index)
