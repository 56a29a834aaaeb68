"""External skills on the real physics, in real processes: a program is a skill like any other, and leaves nothing."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import psutil
import pytest

from config import load
from config.schema import ExternalSkill, Place, Position
from engine.epoch import Epoch
from engine.perception import eyes
from engine.perception.eyes import Eyes
from engine.perception.landmarks import Fix
from engine.perception.memory import WorldMemory
from engine.plan import parse_call
from engine.planner.build import build_registry
from engine.robot.arm import ARM_UP
from engine.robot.geometry import Pose
from engine.robot.sim.robot import SimRobot
from engine.skills.context import SkillContext
from engine.skills.external.host import MAX_UNSPOKEN, external_skill
from engine.skills.outcome import Result
from engine.skills.places import Places
from tests.sim.rig import beating, running, ticks_until

PLACES = load(environ={}).places
DEADLINE_S = 60.0
SPEAK = """
import json, os, signal, sys, time
def say(**message): print(json.dumps(message), flush=True)
def hear(kind):
    for line in sys.stdin:
        message = json.loads(line)
        if kind in message: return message[kind]
    sys.exit()
start = hear("start")
"""
DRIVE_FOR_EVER = """
while True:
    say(drive=[0.3, 0, 0], tick=True)
    say(progress={"message": str(os.getpid())})
    hear("state")
"""


@dataclass
class Rig:
    """A running robot, and what the skills on it said and reported."""

    robot: SimRobot
    places: Places = field(default_factory=lambda: Places(PLACES))
    said: list[str] = field(default_factory=list)
    told: list[str] = field(default_factory=list)
    reported: asyncio.Event = field(default_factory=asyncio.Event)
    speaking: asyncio.Event | None = None  # sentences end when it is set
    more: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.epoch = Epoch(self.robot.stop)
        self._before = psutil.Process().children(recursive=True)  # the robot's own, and those of other tests

    async def run(self, program: str, *, args: Mapping[str, Any] | None = None, **declared: Any) -> Result:
        """Run a program in the language of ``SPEAK`` as a skill of the name ``tried``."""
        command = [sys.executable, "-I", "-S", "-c", SPEAK + program]
        declaration = ExternalSkill.model_validate({"does": "Anything.", "external": command, **declared})
        return await external_skill("tried", declaration).run(self.context(), **(args or {}))

    async def do(self, call: str) -> Result:
        registry = build_registry(load(environ={}), self.places)
        action = registry.resolve(parse_call(call))
        return await registry[action.name].run(self.context(), **action.args)

    def context(self) -> SkillContext:
        world = WorldMemory()
        return SkillContext(
            robot=self.robot,
            epoch=self.epoch.current,
            places=self.places,
            say=self._say,
            progress=self._progress,
            describe_skills=lambda: "",
            see=Eyes(self.robot, world).see,
            world=world,
        )

    @property
    def pose(self) -> Pose:
        return self.robot.state().pose

    def left_behind(self) -> list[psutil.Process]:
        """The processes that have come since the robot stood there, its camera's aside, which comes at a first look."""
        children = psutil.Process().children(recursive=True)
        return [child for child in children if child not in self._before and child.pid != self.robot.camera_pid]

    async def until(self, met: Callable[[], bool], *, doing: asyncio.Task[Any]) -> None:
        """Wait until a report or an end of the action brings it about."""
        while not met():
            assert not doing.done(), doing.result()
            self.reported.clear()
            await asyncio.wait(
                [doing, asyncio.ensure_future(self.reported.wait())], return_when=asyncio.FIRST_COMPLETED
            )

    async def _say(self, text: str) -> None:
        if self.speaking is not None:
            await self.speaking.wait()
        self.said.append(text)

    def _progress(
        self, fraction: float | None, message: str = "", *, path: tuple[tuple[float, float], ...] | None = None
    ) -> None:
        del fraction, path
        self.told.append(message)
        self.reported.set()


def on_the_robot(test: Callable[[Rig], Awaitable[None]]) -> None:
    """Run ``test`` with a robot that stands in the hall."""

    async def run() -> None:
        async with running() as robot, beating(robot), asyncio.timeout(DEADLINE_S):
            await robot.tick()
            rig = Rig(robot)
            await test(rig)
            assert rig.left_behind() == []

    asyncio.run(run())


async def interrupted(action: asyncio.Task[Any]) -> None:
    action.cancel()
    with suppress(asyncio.CancelledError):
        await action
    assert action.cancelled()


# Patrol


def test_a_patrol_visits_its_places_again_and_again_until_it_is_interrupted() -> None:
    async def test(rig: Rig) -> None:
        patrol = asyncio.create_task(rig.do("patrol('kitchen and the hall')"))
        visits = ["E"]

        def visited() -> bool:
            for symbol in "AE":
                place = rig.places.pose(symbol)
                assert place is not None
                if place.distance_to(rig.pose) < 0.03 and visits[-1:] != [symbol]:
                    visits.append(symbol)
            return visits == ["E", "A", "E", "A", "E"]

        await rig.until(visited, doing=patrol)
        await interrupted(patrol)

    on_the_robot(test)


def test_a_patrol_says_what_is_in_the_way_and_goes_on() -> None:
    async def test(rig: Rig) -> None:
        rig.places = Places({**PLACES, "X": Place(name="inside of the sofa", position=Position(x=-4.45, y=1.9))})
        patrol = asyncio.create_task(rig.do("patrol('X, E, A')"))
        kitchen = rig.places.pose("A")
        assert kitchen is not None
        await rig.until(lambda: kitchen.distance_to(rig.pose) < 0.03, doing=patrol)
        assert any("the inside of the sofa" in told and "I go on" in told for told in rig.told)
        await interrupted(patrol)

    on_the_robot(test)


def test_a_patrol_that_reaches_nothing_fails() -> None:
    async def test(rig: Rig) -> None:
        rig.places = Places({"X": Place(name="inside of the sofa", position=Position(x=-4.45, y=1.9))})
        result = await rig.do("patrol()")
        assert (result.outcome, result.error_code) == ("failed", "path_blocked")
        assert "the sofa" in result.message

    on_the_robot(test)


def test_a_patrol_without_places_visits_one_place_in_each_room() -> None:
    async def test(rig: Rig) -> None:
        from engine.skills.external.patrol import one_in_each_room

        assert one_in_each_room(rig.context()) == ("E", "B", "A", "D", "C")

    on_the_robot(test)


def test_patrol_loads_nothing_heavy() -> None:
    heavy = "{'mujoco', 'textual', 'ctranslate2', 'faster_whisper', 'cv2', 'hassil', 'psutil'}"
    check = f"import sys, engine.skills.external.patrol; loaded = {heavy} & set(sys.modules); assert not loaded, loaded"
    subprocess.run([sys.executable, "-c", check], check=True)


# What a program may do


def test_a_program_moves_arm_gripper_and_light_and_sees_what_became_of_it() -> None:
    program = """
say(arm=[0, 0, 0, 0, 0], speed=2.0, gripper=0.0, light=[1, 2, 3])
for _ in range(150):
    say(tick=True)
    state = hear("state")
say(scan=True)
nearest = min(distance for distance in hear("scan")["ranges"] if distance is not None)
say(result={"outcome": "ok", "message": "Up.", "data": {
    "shoulder": state["joints"][1], "gripper": state["gripper"], "red": state["light"][0], "nearest": nearest,
    "seconds": state["t"] - start["state"]["t"]}})
"""

    async def test(rig: Rig) -> None:
        result = await rig.run(program, occupies=["arm"])
        assert (result.outcome, result.message) == ("ok", "Up.")
        assert result.data["shoulder"] == pytest.approx(ARM_UP[1], abs=0.05)
        assert result.data["gripper"] == pytest.approx(0, abs=0.1)
        assert result.data["red"] == 1
        assert result.data["nearest"] == pytest.approx(float(rig.robot.scan().ranges.min()), abs=0.01)
        assert result.data["seconds"] == pytest.approx(3.0)

    on_the_robot(test)


def test_a_program_sees_what_the_robot_sees() -> None:
    program = """
import base64
say(look=True)
picture = hear("picture")
rgb, depth = base64.b64decode(picture["rgb"]), base64.b64decode(picture["depth"])
lens = picture["lens"]
middle = lens["width"] * (lens["height"] // 2) + lens["width"] // 2
say(result={"outcome": "ok", "data": {"bytes": len(rgb), "t": picture["t"], "red": rgb[3 * middle],
    "depth": int.from_bytes(depth[2 * middle : 2 * middle + 2], "little") / 1000}})
"""

    async def test(rig: Rig) -> None:
        result = await rig.run(program, occupies=["camera"])
        picture = await rig.robot.look()
        assert result.ok, result
        assert result.data["bytes"] == picture.rgb.size
        assert result.data["t"] == picture.t
        assert result.data["red"] == picture.rgb[60, 80, 0]
        assert result.data["depth"] == pytest.approx(float(picture.depth[60, 80]), abs=0.001)
        refused = await rig.run(program, occupies=["base"])
        assert refused.error_code == "not_supported"
        assert "camera" in refused.message

    on_the_robot(test)


def test_a_program_that_knows_better_where_it_is_corrects_odometry() -> None:
    program = """
say(relocate={"believed": [0, 0, 0], "true": [0.5, 0.2, 0]}, tick=True)
x, y, yaw = hear("state")["pose"]
say(result={"outcome": "ok", "data": {"x": x, "y": y}})
"""

    async def test(rig: Rig) -> None:
        result = await rig.run(program, occupies=["base"])
        assert (result.data["x"], result.data["y"]) == pytest.approx((0.5, 0.2), abs=0.001)

    on_the_robot(test)


@pytest.mark.parametrize(
    ("believed", "true", "why"),
    [
        ((0, 0, 0), (1e308, 0, 0), "what I do not understand"),
        ((0, 0, 0), (0, 0, float("nan")), "what I do not understand"),
        ((1e5, 1e5, 0), (1e5, 1e5 + 1, 0), "not believed to be at 1e+05, 1e+05 lately"),
        ((0, 0, 0), (1e5, 0, 0), "not on the map"),
        ((0, 0, 0), (0, 2.2, 0), "wrong by more than 2 m"),
        ((0, 0, 0), (0.1, 0, 3), "wrong by more than 2 m or 90°"),
    ],
)
def test_a_program_cannot_put_the_robot_where_it_cannot_be(
    believed: tuple[float, ...], true: tuple[float, ...], why: str
) -> None:
    program = f"""
nan, inf = float("nan"), float("inf")
say(relocate={{"believed": {list(believed)}, "true": {list(true)}}})
say(tick=True)
x, y, yaw = hear("state")["pose"]
say(result={{"outcome": "ok", "data": {{"x": x, "y": y, "yaw": yaw}}}})
"""

    async def test(rig: Rig) -> None:
        result = await rig.run(program, occupies=["base"])
        assert result.data["not_understood"] == 1
        assert [result.data[number] for number in ("x", "y", "yaw")] == pytest.approx([0, 0, 0], abs=0.01)
        assert why in rig.told[0]
        assert (await rig.do("move_forward(0.2)")).ok, "it still knows where it is"

    on_the_robot(test)


def test_a_landmark_that_hangs_where_it_cannot_is_not_believed() -> None:
    """Its fix is off the map; two pictures agree on it."""

    async def test(rig: Rig) -> None:
        fix = Fix(Pose(40.0, 0.0, 0.0), np.diag([1e-4] * 3), 1)
        see = rig.context().see
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(eyes, "where", lambda *_: fix)
            for _ in range(3):
                await see()
        assert rig.pose.distance_to(Pose(0, 0, 0)) < 0.05

    on_the_robot(test)


def test_a_program_sees_the_variables_that_its_declaration_names(monkeypatch: pytest.MonkeyPatch) -> None:
    program = """
say(result={"outcome": "ok", "message": " ".join(sorted(set(os.environ) & {"PATH", "BASE_URL", "GH_PAT"}))})
"""

    async def test(rig: Rig) -> None:
        monkeypatch.setenv("BASE_URL", "http://127.0.0.1")
        monkeypatch.setenv("GH_PAT", "s3cret")
        assert (await rig.run(program)).message == "PATH"
        assert (await rig.run(program, environment=["BASE_URL"])).message == "BASE_URL PATH"

    on_the_robot(test)


def test_an_ordinary_skill_function_runs_as_a_program() -> None:
    async def test(rig: Rig) -> None:
        program = """
from engine.skills.external.guest import main
from engine.skills.library.motion import move_forward

async def ahead(context, distance):
    print("no message, but for people")
    return await move_forward.run(context, distance)

main(ahead)
"""
        declaration = ExternalSkill(does="Drive.", external=("python", "-P", "-c", program), occupies=("base",))
        result = await external_skill("ahead", declaration).run(rig.context(), distance=0.5)
        assert (result.outcome, result.message) == ("ok", "Moved 0.50 m forward.")
        assert rig.pose.x == pytest.approx(0.5, abs=0.015)
        assert result.data == {"moved": pytest.approx(rig.pose.x, abs=0.01)}

    on_the_robot(test)


def test_a_program_speaks_in_order_and_its_end_waits_for_the_last_word() -> None:
    program = f"""
for number in range({MAX_UNSPOKEN + 5}): say(say=f"sentence {{number}}")
say(tick=True)
hear("state")
"""

    async def test(rig: Rig) -> None:
        rig.speaking = asyncio.Event()
        running = asyncio.create_task(rig.run(program + "say(progress={'message': 'not held up'})", occupies=["voice"]))
        await rig.until(lambda: "not held up" in rig.told, doing=running)
        assert rig.said == []
        rig.speaking.set()
        result = await running
        spoken = len(rig.said)
        assert rig.said == [f"sentence {number}" for number in range(spoken)]
        assert MAX_UNSPOKEN <= spoken <= MAX_UNSPOKEN + 1
        assert result.data["not_understood"] == MAX_UNSPOKEN + 5 - spoken

    on_the_robot(test)


def test_what_a_program_did_not_declare_is_refused_and_ends_it() -> None:
    async def test(rig: Rig) -> None:
        for message, need in (
            ("drive=[0.3, 0, 0]", "base"),
            ("arm=[0, 0, 0, 0, 0]", "arm"),
            ("gripper=1", "arm"),
            ("say='x'", "voice"),
        ):
            others = sorted({"base", "arm", "voice", "camera"} - {need})
            result = await rig.run(f"say({message}, tick=True)\nhear('state')\nhear('nothing')", occupies=others)
            assert (result.outcome, result.error_code) == ("failed", "not_supported"), message
            assert f"add {need} to skills.tried.occupies" in result.message
        assert rig.robot.state().command.is_zero
        assert rig.said == []

    on_the_robot(test)


# What a program cannot do


def test_nothing_of_a_program_moves_anything_after_its_epoch() -> None:
    async def test(rig: Rig) -> None:
        driving = asyncio.create_task(rig.run(DRIVE_FOR_EVER, occupies=["base"]))
        await rig.until(lambda: rig.pose.x > 0.2, doing=driving)
        rig.epoch.advance()
        await ticks_until(rig.robot, lambda state: not state.moving)
        where, told = rig.pose, len(rig.told)
        await rig.until(lambda: len(rig.told) > told + 50, doing=driving)  # it drives on, and nothing comes of it
        assert rig.pose.distance_to(where) < 0.005
        await interrupted(driving)

    on_the_robot(test)


def test_a_paused_program_in_mid_drive_stands_still_and_fails() -> None:
    async def test(rig: Rig) -> None:
        driving = asyncio.create_task(rig.run(DRIVE_FOR_EVER, occupies=["base"], silence_s=0.5))
        await rig.until(lambda: rig.pose.x > 0.2, doing=driving)
        os.kill(int(rig.told[-1]), signal.SIGSTOP)
        result = await driving
        assert (result.outcome, result.error_code) == ("failed", "no_progress")
        assert "said nothing for 0.5 s" in result.message
        await ticks_until(rig.robot, lambda state: not state.moving)

    on_the_robot(test)


def test_cancellation_ends_a_deaf_program_and_all_that_it_started() -> None:
    program = """
signal.signal(signal.SIGTERM, signal.SIG_IGN)
for _ in range(3):
    if os.fork() == 0:
        os.setsid()
        signal.pause()
"""

    async def test(rig: Rig) -> None:
        driving = asyncio.create_task(rig.run(program + DRIVE_FOR_EVER, occupies=["base"]))
        await rig.until(lambda: rig.pose.x > 0.1, doing=driving)
        assert len(rig.left_behind()) >= 6  # two supervisors and four of its own
        rig.epoch.advance()
        await interrupted(driving)

    on_the_robot(test)


FOLLOW_THE_CAMERA = """
import subprocess
script = "import os, time\\nwhile True: os.write(1, b'.'); time.sleep(0.01)"
camera = subprocess.Popen([sys.executable, "-I", "-S", "-c", script], stdout=subprocess.PIPE)
say(progress={"message": str(camera.pid)})
while os.read(camera.stdout.fileno(), 65536):  # drives while there are pictures, and on nothing else
    say(drive=[0.3, 0, 0], tick=True)
    say(progress={"message": str(camera.pid)})
    hear("state")
say(result={"outcome": "failed", "error_code": "no_progress", "message": "The camera is gone."})
"""


@pytest.mark.parametrize(
    ("number", "says"), [(signal.SIGKILL, "The camera is gone."), (signal.SIGSTOP, "said nothing for 0.5 s")]
)
def test_a_follower_whose_camera_dies_or_freezes_leaves_a_robot_that_stands(number: signal.Signals, says: str) -> None:
    async def test(rig: Rig) -> None:
        following = asyncio.create_task(rig.run(FOLLOW_THE_CAMERA, occupies=["base", "camera"], silence_s=0.5))
        await rig.until(lambda: rig.pose.x > 0.2, doing=following)
        os.kill(int(rig.told[-1]), number)
        began = rig.robot.state().t
        result = await following
        assert (result.outcome, result.error_code) == ("failed", "no_progress")
        assert says in result.message
        state = await ticks_until(rig.robot, lambda state: not state.moving)
        assert state.t - began <= 0.3, "s of robot time"

    on_the_robot(test)


# Ends that nobody wished for


ENDS = [
    ("say(progress={'fraction': 1})", "ok", None, "tried is done."),
    ("raise RuntimeError('no map')", "failed", "crashed", "tried ended with exit code 1: Traceback"),
    ("os.kill(os.getpid(), signal.SIGKILL)", "failed", "crashed", "tried was ended by SIGKILL."),
    (
        "say(result={'outcome': 'failed', 'error_code': 'path_blocked', 'message': 'A box.'})",
        "failed",
        "path_blocked",
        "A box.",
    ),
    ("say(result={'outcome': 'failed', 'error_code': 'mood', 'message': 'No.'})", "failed", "crashed", "No."),
    ("say(result='great')", "failed", "crashed", "It ended with a result that I cannot read."),
    ("os.close(1); time.sleep(60)", "failed", "no_progress", "tried has said nothing for 1 s."),
]


def test_every_end_of_a_program_is_one_typed_outcome() -> None:
    async def test(rig: Rig) -> None:
        for program, outcome, code, message in ENDS:
            result = await rig.run(program, silence_s=1)
            assert (result.outcome, result.error_code) == (outcome, code), program
            assert result.message.startswith(message)

    on_the_robot(test)


def test_the_last_words_of_a_crash_are_in_the_message() -> None:
    async def test(rig: Rig) -> None:
        result = await rig.run("raise RuntimeError('the battery is empty')")
        assert result.message.endswith("RuntimeError: the battery is empty")

    on_the_robot(test)


def test_garbage_is_counted_and_told_once_and_does_no_harm() -> None:
    program = r"""
sys.stdout.buffer.write(b"\x00\xff\x1b[2J{{{\nnull\n[]\n{}\n" + b"x" * 3_000_000 + b"\n")
say(drive="fast", tick=True)
say(drive=[float("nan"), 0, 0])
say(drive=[1e999, 0, 0])
say(teleport=True)
say(drive=[0.3, 0, 0], tick=True)
hear("state")
sys.stdout.write('{"result": {"outcome": "fai')
"""

    async def test(rig: Rig) -> None:
        result = await rig.run(program, occupies=["base"])
        assert (result.outcome, result.message) == ("ok", "tried is done.")
        assert result.data["not_understood"] == 10
        [told] = rig.told
        assert told.startswith("tried wrote what I do not understand:")
        assert told.isprintable()

    on_the_robot(test)


def test_a_program_that_does_not_exist_is_a_typed_failure() -> None:
    async def test(rig: Rig) -> None:
        declaration = ExternalSkill(does="Nothing.", external=("no-such-program",))
        result = await external_skill("absent", declaration).run(rig.context())
        assert (result.outcome, result.error_code) == ("failed", "not_supported")
        assert "no-such-program cannot be started" in result.message

    on_the_robot(test)


def test_a_program_that_floods_does_not_hold_up_the_engine() -> None:
    async def test(rig: Rig) -> None:
        flooding = asyncio.create_task(rig.run("while True: say(progress={'message': 'x'})"))
        await rig.until(lambda: bool(rig.told), doing=flooding)
        for _ in range(50):
            await rig.robot.tick()
        await interrupted(flooding)

    on_the_robot(test)
