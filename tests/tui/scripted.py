"""An engine that follows a script, for tests and pictures of the console, and to look at it by hand:

``python -m tests.tui.scripted [--loading] [--broken] [--idle]``

It is no model of the real engine: it holds the handle's protocol, replays events, and remembers the commands it got.
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from config.schema import Place, Position
from engine import events as ev
from engine.bus import Subscriber
from engine.commands import Command, Interrupt
from engine.errors import DeviceError, SaysoError
from engine.handle import PartStatus
from engine.offer import Offer
from engine.perception.memory import World
from engine.perception.sighting import Colour, Kind, Sight, Sighting
from engine.plan import Action
from engine.planner.phrases.phrases import Phrases
from engine.planner.validation import as_call
from engine.robot.arm import ARM_INITIAL
from engine.robot.camera import Lens, Mount, Picture
from engine.robot.floor_map import FloorMap, Furniture, Room
from engine.robot.geometry import ZERO, Pose, Twist
from engine.robot.robot import RobotState, Scan
from engine.skills.library import LIBRARY

PARTS_READY = tuple(PartStatus(name, "ready") for name in ("robot", "microphone", "recogniser", "planner", "voice"))
PARTS_LOADING = (
    PartStatus("robot", "ready"),
    PartStatus("microphone", "missing", "No sound card was found."),
    PartStatus("recogniser", "loading"),
    PartStatus("planner", "loading"),
    PartStatus("voice", "ready"),
)
PLACES = {
    symbol: Place(name=name, position=Position(x=x, y=y))
    for symbol, name, x, y in (
        ("A", "kitchen", 0.2, 2.0),
        ("B", "living room", -3.0, 0.0),
        ("C", "bedroom", 0.5, -2.0),
        ("D", "study", 3.0, 2.0),
        ("E", "hall", 0.0, 0.0),
        ("F", "charging dock", 4.2, -0.3),
    )
}


def flat() -> FloorMap:
    """A flat of five rooms with doors and some furniture, 10 m × 8 m."""
    resolution = 0.05
    occupied = np.zeros((160, 200), dtype=np.bool_)

    def fill(x_min: float, y_min: float, x_max: float, y_max: float, value: bool = True) -> None:
        rows = slice(round((y_min + 4) / resolution), round((y_max + 4) / resolution))
        occupied[rows, round((x_min + 5) / resolution) : round((x_max + 5) / resolution)] = value

    fill(-5, -4, 5, 4)
    rooms = (
        Room("hall", -1.5, -0.9, 5.0, 0.9),
        Room("living room", -5.0, -4.0, -1.5, 4.0),
        Room("kitchen", -1.5, 0.9, 1.8, 4.0),
        Room("study", 1.8, 0.9, 5.0, 4.0),
        Room("bedroom", -1.5, -4.0, 5.0, -0.9),
    )
    for room in rooms:
        fill(room.x_min + 0.05, room.y_min + 0.05, room.x_max - 0.05, room.y_max - 0.05, False)
    for door in ((-1.6, -0.45, -1.4, 0.45), (-0.3, 0.8, 0.6, 1.0), (2.6, 0.8, 3.5, 1.0), (0.1, -1.0, 1.0, -0.8)):
        fill(*door, False)
    furniture = (
        Furniture("sofa", -4.9, -1.0, -4.1, 1.0),
        Furniture("table", -3.6, 2.2, -2.4, 3.0),
        Furniture("counter", -1.4, 3.4, 1.7, 3.9),
        Furniture("desk", 3.6, 3.2, 4.9, 3.9),
        Furniture("bed", 2.6, -3.9, 4.6, -2.2),
        Furniture("wardrobe", -1.4, -3.9, -0.2, -3.4),
    )
    for thing in furniture:
        fill(thing.x_min, thing.y_min, thing.x_max, thing.y_max)
    return FloorMap(resolution, (-5.0, -4.0), occupied, rooms, furniture)


def robot_at(x: float, y: float, yaw: float, *, t: float = 0.0, speed: float = 0.0) -> RobotState:
    """A snapshot of the robot, driving forwards at ``speed`` m/s."""
    twist = Twist(speed, 0.0, 0.0) if speed else ZERO
    return RobotState(t, 1, Pose(x, y, yaw), twist, twist, ARM_INITIAL, ARM_INITIAL, 1.0, (0, 0, 0), None, None)


def scanned(floor: FloorMap, robot: RobotState) -> Scan:
    """What a lidar sees in this flat: each ray ends where the map is occupied."""
    angles = np.radians(np.arange(0.0, 360.0, 1.0))
    reach = np.arange(0.1, 8.0, 0.02)
    directions = angles + robot.pose.yaw
    x = robot.pose.x + reach[None, :] * np.cos(directions)[:, None]
    y = robot.pose.y + reach[None, :] * np.sin(directions)[:, None]
    rows, columns = floor.occupied.shape
    row = np.clip(((y - floor.origin[1]) / floor.resolution).astype(int), 0, rows - 1)
    column = np.clip(((x - floor.origin[0]) / floor.resolution).astype(int), 0, columns - 1)
    hit = floor.occupied[row, column]
    ranges = np.where(hit.any(axis=1), reach[hit.argmax(axis=1)], np.inf)
    return Scan(robot.t, angles, ranges)


def sight_of(picture: str = "view") -> Sight:
    """What the camera of the simulated robot once saw, and what was recognised in it."""
    from PIL import Image

    here = Path(__file__).parent / "sights"
    rgb = np.asarray(Image.open(here / f"{picture}.png").convert("RGB"))
    height, width = rgb.shape[:2]
    lens, mount = Lens.of_view(width, height, math.radians(48)), Mount(np.eye(3), np.zeros(3))
    shown = Picture(0.0, rgb, np.full((height, width), np.inf, dtype=np.float32), lens, mount, Pose(0, 0, 0))
    boxes = json.loads((here / f"{picture}.json").read_text())
    things = [_sighting(box["kind"], box["colour"], tuple(box["box"])) for box in boxes]
    return Sight(shown, tuple(things), ())


def _sighting(kind: Kind, colour: Colour, box: tuple[int, int, int, int]) -> Sighting:
    return Sighting(kind, colour, box, (0.0, 0.0, 0.0), 0.01, (0.05, 0.05), 0.5, 0.0)


@dataclass(frozen=True, slots=True)
class Step:
    """Something that happens ``after`` seconds after the step before."""

    after: float
    body: ev.Body


class ScriptedEngine:
    """An ``EngineHandle`` without an engine."""

    def __init__(
        self,
        *,
        parts: Sequence[PartStatus] = PARTS_READY,
        robot: RobotState | None = None,
        floor: FloorMap | None = None,
        seen: World | None = None,
        lidar: bool = False,
    ) -> None:
        self.sent: list[Command] = []
        self.parts = tuple(parts)
        self.robot = robot
        self.floor = floor
        self.silence = 0.0
        self.seen = seen or World()
        self.lidar = lidar
        self.offers = Offer()
        self.looks: list[Callable[[Sight | SaysoError], object]] = []
        self.on_look: Callable[[Callable[[Sight | SaysoError], object]], None] = lambda deliver: None
        self.on_command: Callable[[Command], None] = lambda command: None
        self._subscribers: list[Subscriber] = []
        self._seq = 0
        self.t = 0.0

    def send(self, command: Command) -> None:
        self.sent.append(command)
        self.on_command(command)

    def join(self, timeout: float | None = None) -> bool:
        return True

    def subscribe(self, subscriber: Subscriber) -> Callable[[], None]:
        self._subscribers.append(subscriber)
        return lambda: self._subscribers.remove(subscriber)

    def status(self) -> tuple[PartStatus, ...]:
        return self.parts

    def pulse(self) -> float:
        return self.silence

    def robot_state(self) -> RobotState | None:
        return self.robot

    def scan(self) -> Scan | None:
        return scanned(self.floor, self.robot) if self.lidar and self.floor and self.robot else None

    def look(self, deliver: Callable[[Sight | SaysoError], object]) -> None:
        self.looks.append(deliver)
        self.on_look(deliver)

    def floor_map(self) -> FloorMap | None:
        return self.floor

    def places(self) -> Mapping[str, Place]:
        return PLACES

    def offer(self) -> Offer:
        return self.offers

    def world(self) -> World:
        return self.seen

    def publish(self, body: ev.Body, *, after: float = 0.0, turn: str | None = "T1", epoch: int = 1) -> ev.Event:
        """One event, ``after`` seconds of event time after the one before; delivered at once."""
        self._seq += 1
        self.t += after
        event = ev.Event(self._seq, self.t, "2026-01-01T00:00:00.000Z", "S1", turn, epoch, body)
        for subscriber in tuple(self._subscribers):
            subscriber(event)
        return event

    def play(self, steps: Sequence[Step]) -> None:
        """All steps at once, in event time."""
        for step in steps:
            self.publish(step.body, after=step.after)


# Scenes

PATH = ((-3.0, -1.6), (-2.2, -0.6), (-1.5, 0.0), (-0.6, 0.1), (0.1, 0.5), (0.15, 1.0), (0.2, 1.5), (0.2, 2.0))

OPENING = (
    Step(0.0, ev.SessionStarted("0.1.0", "voice", "simulated robot (flat)", 4242)),
    Step(0.9, ev.Log("info", "robot", "ready: simulated robot (flat)")),
    Step(0.8, ev.Log("info", "recogniser", "ready: whisper-base (int8, 1 thread)")),
    Step(0.1, ev.Log("info", "planner", "ready")),
)


def listening() -> list[Step]:
    """A person is speaking."""
    levels = [
        Step(0.1, ev.ListenLevel(rms, rms + 9, probability, probability > 0.5)) for rms, probability in _voice(62)
    ]
    return [
        *OPENING,
        Step(2.0, ev.WakeHeard("key")),
        Step(0.0, ev.StateChanged("IDLE", "LISTENING", "wake")),
        Step(0.0, ev.ListenStarted("microphone")),
        *levels,
        Step(0.0, ev.TranscriptPartial("go to the kitchen and", 4)),
    ]


@cache
def _phrases() -> Phrases:
    return Phrases(PLACES)


def in_words(name: str, args: Mapping[str, ev.Value]) -> str:
    """What is to be done, as the engine tells it."""
    skill = next((skill for skill in LIBRARY if skill.name == name), None)
    if skill is None:
        return ""
    given = {parameter.name: args.get(parameter.name, parameter.default) for parameter in skill.parameters}
    call = as_call(skill, Action(name, {key: value for key, value in given.items() if value is not None}))
    return _phrases().told([call]).steps[0].removesuffix(".")


def queued(action: str, index: int, total: int, name: str, args: Mapping[str, ev.Value]) -> ev.ActionQueued:
    return ev.ActionQueued(action, index, total, name, args, in_words(name, args))


def started(action: str, index: int, total: int, name: str, args: Mapping[str, ev.Value]) -> ev.ActionStarted:
    return ev.ActionStarted(action, index, total, name, args, in_words(name, args))


def acting() -> list[Step]:
    """The robot is on its way, with more to do."""
    calls = (
        ("get_current_pose", {}),
        ("navigation", {"place": "A"}),
        ("move_left", {"angle": 90.0, "angular_speed": 1.0}),
        ("wait", {"seconds": 2.0}),
    )
    return [
        *listening(),
        Step(0.7, ev.ListenEnded("silence", 2.4, 1.7)),
        Step(0.0, ev.StateChanged("LISTENING", "TRANSCRIBING", "silence")),
        Step(
            0.3,
            ev.TranscriptFinal(
                "Go to the kitchen and turn left 90 degrees", "speech", "en", 0.94, -0.12, 0.02, 2.4, 0.28
            ),
        ),
        Step(0.0, ev.StateChanged("TRANSCRIBING", "PLANNING", "transcript")),
        Step(
            0.1,
            ev.PlanMade(
                "go to the kitchen and turn left 90 degrees",
                (
                    "Remember this place.",
                    "Go to the kitchen.",
                    "Turn left 90 degrees.",
                    "Wait 2 seconds.",
                ),
                tuple(ev.ActionView(name, args) for name, args in calls),
                "Going to the kitchen.",
                "phrases",
            ),
        ),
        *(Step(0.0, queued(f"a{n}", n, len(calls), *calls[n - 1])) for n in range(1, len(calls) + 1)),
        Step(0.0, ev.SpeechStarted("Going to the kitchen.", False)),
        Step(0.0, ev.SpeechEnded("Going to the kitchen.", "Going to the kitchen.", "ok")),
        Step(0.0, ev.StateChanged("PLANNING", "ACTING", "plan")),
        Step(0.0, started("a1", 1, 4, *calls[0])),
        Step(0.1, ev.ActionFinished("a1", *calls[0], "ok", None, "", 0.1, {"x": -3.0, "y": -1.6})),
        Step(0.0, started("a2", 2, 4, *calls[1])),
        Step(0.1, ev.ActionProgress("a2", "navigation", 0.0, "", PATH)),
        Step(4.6, ev.ActionProgress("a2", "navigation", 0.42, "2.9 m to the kitchen")),
    ]


def done() -> list[Step]:
    """Everything asked for is done."""
    calls = {
        "a2": ("navigation", {"place": "A"}),
        "a3": ("move_left", {"angle": 90.0, "angular_speed": 1.0}),
        "a4": ("wait", {"seconds": 2.0}),
    }
    steps = [*acting(), Step(4.1, ev.ActionFinished("a2", *calls["a2"], "ok", None, "", 8.8))]
    for number, (action, seconds) in enumerate((("a3", 1.2), ("a4", 2.0)), 3):
        steps += [
            Step(0.0, started(action, number, 4, *calls[action])),
            Step(seconds, ev.ActionFinished(action, *calls[action], "ok", None, "", seconds)),
        ]
    answer = "I am in the kitchen, and I have turned left 90 degrees."
    return [
        *steps,
        Step(0.0, ev.SpeechStarted(answer, False)),
        Step(0.0, ev.SpeechEnded(answer, answer, "ok")),
        Step(0.0, ev.StateChanged("ACTING", "WAITING", "done", ev.TurnResult(0, "done", "4 actions in 12.1 s"))),
    ]


def tidying() -> list[Step]:
    """A room is being cleaned: two things are in the bin, one is in the gripper."""
    request, args = "clean the room", {"room": ""}
    names = "red box, green bottle, blue cup"
    return [
        *OPENING,
        Step(3.0, ev.TranscriptFinal(request, "text", "", 1.0, 0.0, 0.0, 0.0, 0.0)),
        Step(0.0, ev.StateChanged("IDLE", "PLANNING", "a request was understood")),
        Step(0.0, ev.PlanMade(request, ("Clean the room.",), (ev.ActionView("clean_room", args),), "", "phrases")),
        Step(0.0, queued("a1", 1, 1, "clean_room", args)),
        Step(0.0, ev.StateChanged("PLANNING", "ACTING", "1 actions")),
        Step(0.0, started("a1", 1, 1, "clean_room", args)),
        Step(41.0, ev.CameraFrame(160, 120)),
        Step(0.0, ev.PerceptionResult(names)),
        Step(22.0, ev.ActionProgress("a1", "clean_room", None, "2 put into the bin, now the blue cup", PATH)),
    ]


def driving() -> list[Step]:
    """The robot is on its way; where it came from is known."""
    came = ((-3.0, -1.6), (-2.8, -1.3), (-2.5, -1.0), (-2.2, -0.6), (-1.9, -0.3), (-1.5, 0.0), (-1.35, 0.05))
    return [*acting(), *(Step(0.0, _moved(x, y)) for x, y in came)]


def _moved(x: float, y: float) -> ev.RobotStateView:
    return ev.RobotStateView(200.0, ev.PoseView(x, y, 0.4), ev.TwistView(0.5, 0, 0), ARM_INITIAL, 1.0, True, None)


def waiting() -> list[Step]:
    """While it is on its way, three requests wait."""
    texts = ("bring me the red box", "turn around", "go to the charging dock")
    requests = tuple(ev.WaitingRequest(f"R{number}", text) for number, text in enumerate(texts, 1))
    return [*acting(), Step(0.0, ev.RequestsWaiting(texts, requests))]


def stopped() -> list[Step]:
    """It was stopped on its way, and all that can be offered is."""
    args = {"place": "A"}
    return [
        *acting(),
        Step(0.5, ev.InterruptRaised("interrupt", "interrupt", "ACTING")),
        Step(0.0, ev.ActionFinished("a2", "navigation", args, "interrupted", "cancelled", "", 5.1)),
        Step(
            0.0, ev.StateChanged("ACTING", "WAITING", "interrupted", ev.TurnResult(130, "interrupted", "Interrupted."))
        ),
        Step(0.0, ev.OffersMade("T1", "T1", "T1", "T1")),
    ]


def queueing() -> list[Step]:
    """Of a long plan one action is done, one has failed, one was cut off, one runs, and two wait."""
    calls = (
        ("pick_object", {"object": "red box"}),
        ("navigation", {"place": "B"}),
        ("pick_object", {"object": "blue cup"}),
        ("carry", {"object": "green bottle", "place": "A"}),
        ("navigation", {"place": "F"}),
        ("arm_down", {}),
    )
    found = "I could not find a red box in the living room, the hall and the kitchen."
    held = "The wheel slipped; where I stand is uncertain."
    request = "collect the red box, the cup and the bottle, then go to the charger"
    return [
        *OPENING,
        Step(2.0, ev.TranscriptFinal(request, "text", "", 1.0, 0.0, 0.0, 0.0, 0.0)),
        Step(0.0, ev.StateChanged("IDLE", "PLANNING", "a request was understood")),
        Step(
            0.2,
            ev.PlanMade(
                request,
                (
                    "Look for the red box.",
                    "Go to the living room.",
                    "Pick up the cup.",
                    "Carry the bottle.",
                    "Go and charge.",
                ),
                tuple(ev.ActionView(name, args) for name, args in calls),
                "",
                "local",
            ),
        ),
        *(Step(0.0, queued(f"q{n}", n, len(calls), *calls[n - 1])) for n in range(1, len(calls) + 1)),
        Step(0.0, ev.StateChanged("PLANNING", "ACTING", "plan")),
        Step(0.0, started("q1", 1, 6, *calls[0])),
        Step(18.2, ev.ActionFinished("q1", *calls[0], "failed", "object_not_found", found, 18.2)),
        Step(0.0, started("q2", 2, 6, *calls[1])),
        Step(7.5, ev.ActionFinished("q2", *calls[1], "uncertain", None, held, 7.5)),
        Step(0.0, started("q3", 3, 6, *calls[2])),
        Step(9.1, ev.ActionFinished("q3", *calls[2], "ok", None, "", 9.1)),
        Step(0.0, started("q4", 4, 6, *calls[3])),
        Step(12.4, ev.ActionProgress("q4", "carry", 0.62, "holding the green bottle, 1.8 m to the kitchen", PATH)),
    ]


def failed() -> list[Step]:
    """An action failed, and then the robot was lost."""
    action = ("navigation", {"place": "A"})
    message = "I stopped 2.9 m before the kitchen: obstacle 0.05 m ahead."
    return [
        *acting(),
        Step(
            1.4,
            ev.ActionFinished(
                "a2",
                *action,
                "failed",
                "path_blocked",
                "I stopped 2.9 m before the kitchen: obstacle 0.05 m ahead.",
                6.1,
            ),
        ),
        Step(0.0, ev.SpeechStarted(message, False)),
        Step(0.0, ev.SpeechEnded(message, message, "ok")),
        Step(0.0, ev.StateChanged("ACTING", "WAITING", "failed", ev.TurnResult(1, "failed", message))),
        Step(
            0.3,
            ev.ErrorRaised(
                "robot_lost",
                "The robot process does not answer any more (no state for 1.0 s).",
                "Quit and start sayso again. The robot has stopped by itself.",
                fatal=True,
            ),
        ),
    ]


def _voice(count: int) -> Iterator[tuple[float, float]]:
    """Loudness (dB) and probability of speech of a sentence between two silences."""
    for n in range(count):
        speaking = 14 <= n % 60 < 50
        swell = 0.5 + 0.5 * math.sin(n * 0.9) * math.cos(n * 0.37)
        yield (-34 + 16 * swell, 0.72 + 0.27 * swell) if speaking else (-55 + 4 * swell, 0.04 + 0.1 * swell)


# By hand


class LiveEngine(ScriptedEngine):
    """Drives up and down the path in real time until it is interrupted, and begins again when spoken to."""

    def __init__(self, *, idle: bool = False) -> None:
        super().__init__(robot=robot_at(*PATH[0], 0.9), floor=flat(), lidar=True)
        self._stop = threading.Event()
        self._idle = idle
        self._scanned: Scan | None = None
        self._began = time.monotonic()
        self.on_command = self._commanded

    def begin(self) -> None:
        """Begin to act."""
        if not self._idle:
            self._stop.clear()
            threading.Thread(target=self._act, daemon=True).start()

    def publish(self, body: ev.Body, *, after: float = 0.0, turn: str | None = "T1", epoch: int = 1) -> ev.Event:
        self.t = time.monotonic() - self._began
        return super().publish(body, turn=turn, epoch=epoch)

    def scan(self) -> Scan | None:
        """Twice a second: to cast rays takes this process longer than to draw them."""
        robot = self.robot
        if robot is not None and (self._scanned is None or abs(robot.t - self._scanned.t) >= 0.5):
            self._scanned = super().scan()
        return self._scanned

    def look(self, deliver: Callable[[Sight | SaysoError], object]) -> None:
        """What the camera might see from there: a part of a picture that shifts as the robot turns and comes nearer."""
        sight, robot = sight_of(), self.robot or robot_at(0, 0, 0)
        left = round(40 + 40 * math.sin(robot.pose.yaw + robot.pose.x))
        top = round(15 + 15 * math.cos(robot.pose.y))
        rgb = np.ascontiguousarray(sight.picture.rgb[top : top + 90, left : left + 80]).repeat(2, axis=1)
        picture = replace(sight.picture, rgb=rgb)
        threading.Timer(0.03, deliver, (replace(sight, picture=picture, objects=sight.objects[:1]),)).start()

    def _commanded(self, command: Command) -> None:
        if isinstance(command, Interrupt):
            self._stop.set()
            self.publish(ev.InterruptRaised("interrupt", "key", "ACTING"))
            self.publish(ev.StateChanged("ACTING", "WAITING", "interrupt"))
        else:
            self.begin()

    def _act(self) -> None:
        for step in listening()[len(OPENING) :]:
            if self._stop.wait(step.after):
                return
            self.publish(step.body)
        for step in acting()[len(listening()) : -1]:
            self.publish(step.body)
        leg, way = 0.0, (*PATH, *PATH[-2:0:-1])
        while not self._stop.wait(0.05):  # 20 Hz, as the engine does
            leg += 0.05 * 0.5 / 0.7
            (x0, y0), (x1, y1) = way[int(leg) % len(way)], way[(int(leg) + 1) % len(way)]
            share = leg % 1
            yaw = math.atan2(y1 - y0, x1 - x0)
            state = robot_at(x0 + (x1 - x0) * share, y0 + (y1 - y0) * share, yaw, t=leg, speed=0.5)
            self.robot = state
            pose, twist = state.pose, state.twist
            self.publish(
                ev.RobotStateView(
                    leg,
                    ev.PoseView(pose.x, pose.y, pose.yaw),
                    ev.TwistView(twist.vx, 0, 0),
                    ARM_INITIAL,
                    1.0,
                    True,
                    None,
                )
            )
            if int(leg * 28) % 10 == 0:
                self.publish(ev.ActionProgress("a2", "navigation", leg % 20 / 20, "on the way"))
        self.robot = replace(self.robot, twist=ZERO, command=ZERO) if self.robot else None
        self.publish(ev.ActionFinished("a2", "navigation", {"place": "A"}, "interrupted", "interrupted", "", leg))


def engine_for(arguments: Sequence[str]) -> ScriptedEngine:
    """The engine that the command line asks for."""
    if "--broken" in arguments:
        raise DeviceError("The robot on /dev/ttyUSB0 does not answer.", hint="Check its cable and its power.")
    engine = LiveEngine(idle="--idle" in arguments)
    if "--loading" in arguments:
        engine.parts = PARTS_LOADING
    if "--act" in arguments:
        threading.Timer(1.0, engine.begin).start()
    return engine


if __name__ == "__main__":
    from tui.app import run_console

    sys.exit(run_console(lambda dress: engine_for(sys.argv[1:])))
