"""The engine's side of an external skill: runs the program and does what it asks, under the invocation's own epoch.

So whatever holds for a built-in skill holds for a program: its motion goes through the safety envelope, a command of
an epoch that is over moves nothing, a drive that is not repeated dies, and its end is one typed result. Cancellation
kills the program with everything that it started.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sys
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import engine
from config.schema import ExternalParameter, ExternalSkill, SkillRecord
from engine.errors import ProcessError, RobotError
from engine.events import Value
from engine.process import ProcessTree
from engine.robot.geometry import ZERO, Pose
from engine.robot.relocation import impossible
from engine.skills.context import SkillContext
from engine.skills.external.facts import picture_facts, scan_facts, start_facts, state_facts
from engine.skills.external.protocol import (
    NEEDS,
    Arm,
    Beep,
    Drive,
    Finished,
    Gripper,
    Light,
    Look,
    Message,
    NotUnderstood,
    Relocate,
    Report,
    ScanWish,
    Speech,
    Tick,
    plain,
    read,
)
from engine.skills.outcome import Result, fail, ok
from engine.skills.registry import Parameter, Skill

MAX_UNSPOKEN = 10
"""Sentences of one program that may wait to be spoken; more are dropped and counted as not understood."""


def external_skill(name: str, declaration: ExternalSkill) -> Skill:
    """The skill of this declaration."""

    async def run(context: SkillContext, **args: Value) -> Result:
        return await _host(name, declaration, context, args)

    parameters = tuple(_parameter(key, parameter) for key, parameter in declaration.parameters.items())
    occupies = frozenset(declaration.occupies)
    words = declaration.words if declaration.words != SkillRecord() else None  # a program of ours has a file of them
    return Skill(
        name,
        declaration.does,
        parameters,
        occupies,
        run,
        declaration.endless,
        own_words=words,
        flat=not declaration.depth,
    )


def _parameter(name: str, declared: ExternalParameter) -> Parameter:
    if declared.unit is not None:
        return Parameter(name, "number", declared.unit, declared.min, declared.max, None, declared.default)
    return Parameter(name, "text", "", None, None, declared.kind, declared.default)


async def _host(name: str, declaration: ExternalSkill, context: SkillContext, args: Mapping[str, Value]) -> Result:
    program, *arguments = declaration.external
    argv = [sys.executable if program == "python" else program, *arguments]
    try:
        python_path = {"PYTHONPATH": _python_path()}
        async with ProcessTree(argv, env=python_path, inherits=declaration.environment) as tree:
            host = _Host(name, declaration, context, tree)
            try:
                return await host.run(args)
            finally:
                host.leave()
    except ProcessError as error:
        return fail("not_supported", str(error))


def _python_path() -> str:
    """This very package first, for programs that build on it."""
    root = str(Path(engine.__file__).resolve().parents[1])
    return os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH", ""))))


class _Host:
    """One run of one program."""

    def __init__(self, name: str, declaration: ExternalSkill, context: SkillContext, tree: ProcessTree) -> None:
        self._name = name
        self._occupies = frozenset(declaration.occupies)
        self._silence = declaration.silence_s
        self._context = context
        self._tree = tree
        self._not_understood = 0
        self._unspoken: deque[str] = deque()
        self._speaking: asyncio.Task[None] | None = None

    async def run(self, args: Mapping[str, Value]) -> Result:
        """Talk with the program until it has a result, ends, or breaks the rules. Raises ``RobotError``."""
        result = await self._talk(args)
        if self._speaking is not None:
            await self._speaking
        unread = self._not_understood + self._tree.overlong
        if unread:
            result = Result(
                result.outcome, result.error_code, result.message, {**result.data, "not_understood": unread}
            )
        return result

    def leave(self) -> None:
        """The program is given up: nothing of it goes on."""
        if self._speaking is not None:
            self._speaking.cancel()
        if "base" in self._occupies:
            with contextlib.suppress(RobotError):  # it stands still then, too
                self._context.drive(ZERO)

    async def _talk(self, args: Mapping[str, Value]) -> Result:
        try:
            await self._send({"start": start_facts(self._name, args, self._context, self._occupies)})
            lines = self._tree.lines()
            while (line := await self._patiently(anext(lines, None))) is not None:
                if (result := await self._obey(line)) is not None:
                    return result
            return self._epitaph(await self._patiently(self._tree.wait()))
        except TimeoutError:
            return fail("no_progress", f"{self._name} has said nothing for {self._silence:g} s.")

    async def _patiently(self, what: Any) -> Any:
        """What the program does next. Raises ``TimeoutError`` when it does nothing for too long.

        Measured in the engine's time: at full speed the robot's stands still while nobody ticks.
        """
        async with asyncio.timeout(self._silence):
            return await what

    async def _send(self, message: Mapping[str, Any]) -> None:
        await self._patiently(self._tree.write(json.dumps(message, separators=(",", ":"))))

    async def _obey(self, line: str) -> Result | None:
        """Do what the line asks for; a result when it was the last."""
        try:
            messages = read(line)
        except NotUnderstood:
            self._puzzled(f"{self._name} wrote what I do not understand: {plain(line)[:80]}")
            return None
        for message in messages:
            need = NEEDS.get(type(message))
            if need is not None and need not in self._occupies:
                kind = type(message).__name__.lower()
                hint = f"add {need} to skills.{self._name}.occupies in the configuration if it may"
                return fail("not_supported", f"{self._name} asked for {kind} without occupying the {need}; {hint}.")
            if (result := await self._do(message)) is not None:
                return result
        return None

    async def _do(self, message: Message) -> Result | None:
        context, robot = self._context, self._context.robot
        match message:
            case Tick():
                await self._send({"state": state_facts(await robot.tick())})
            case ScanWish():
                await self._send({"scan": scan_facts(robot.scan())})
            case Look():
                await self._send({"picture": picture_facts(await robot.look())})
            case Relocate(believed, true):
                self._relocate(believed, true)
            case Drive(twist):
                context.drive(twist)
            case Arm(joints, speed):
                robot.move_arm(joints, context.epoch, speed=speed)
            case Gripper(opening):
                robot.set_gripper(opening, context.epoch)
            case Light(rgb):
                robot.set_light(rgb, context.epoch)
            case Beep(seconds):
                robot.beep(seconds, context.epoch)
            case Report(fraction, words, path):
                context.progress(fraction, words, path=path)
            case Speech(text):
                self._say(text)
            case Finished(result):
                return result
        return None

    def _relocate(self, believed: Pose, true: Pose) -> None:
        """Believe it, if it can be; a pose that cannot be would stay wrong until the next start."""
        robot = self._context.robot
        if why := impossible(believed, true, robot.state().pose, robot.floor_map):
            self._puzzled(f"{self._name} does not know where the robot is: {why}.")
        else:
            robot.relocate(believed, true)

    def _say(self, text: str) -> None:
        """In order, and beside whatever the program does meanwhile: a drive must not wait for a sentence."""
        if len(self._unspoken) >= MAX_UNSPOKEN:
            self._not_understood += 1
            return
        self._unspoken.append(text)
        if self._speaking is None or self._speaking.done():
            self._speaking = asyncio.create_task(self._speak())

    async def _speak(self) -> None:
        while self._unspoken:
            await self._context.say(self._unspoken.popleft())

    def _puzzled(self, why: str) -> None:
        """Something that it said does nothing: told once, and counted."""
        self._not_understood += 1
        if self._not_understood == 1:
            self._context.progress(None, why)

    def _epitaph(self, code: int) -> Result:
        """It ended without a result."""
        if code == 0:
            return ok(f"{self._name} is done.")
        cause = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        words = plain(self._tree.last_words[-500:])
        return fail("crashed", f"{self._name} {cause}{f': {words}' if words else '.'}")
