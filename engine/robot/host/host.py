"""The host of a robot: takes stops, heartbeats and commands from shared memory, and shows readings there.

In real time it steps every 2 ms against absolute deadlines; the first thing of every step is the stop stamp, the
second the heartbeat. At full speed it stands still until the engine asks for the next tick over a socket, so that
time passes only while somebody waits for it (a simulation can do that).

It stands by itself when the engine falls silent. An engine that was merely busy finds it ready to go on; one that was
away for longer must not go on where it was: the robot has *halted*, and nothing moves it but a new epoch. A *pause*
that nobody ends makes it halt as well, and so do the emergency stop and trouble of the body. When the socket closes,
its parent is gone or it is told to end, it brings the robot to rest first and leaves a last state that says so.

Memory that holds a state already is that of a robot that was lost: it goes on from there. Which body is driven, none of
this knows.
"""

from __future__ import annotations

import contextlib
import os
import socket
import time
from collections.abc import Callable

from config.schema import Robot as RobotSettings
from engine.robot.geometry import Pose, Twist
from engine.robot.host import memory as m
from engine.robot.host.body import STEP_S
from engine.robot.host.company import Relay
from engine.robot.host.controller import Controller
from engine.robot.host.memory import Mailbox, Memory
from engine.robot.robot import EMERGENCY_STOP, PAUSE_LIMIT_S, UNDECIDED

TICK_STEPS = 10
"""Steps per tick (20 ms)."""
DEBT = 0.05
"""s that real time may run ahead before the host stops trying to catch up."""
BRAKE_PART = 0.7
"""Of the silence that is allowed: then the base brakes. From full speed it needs 0.1 s to stand, and 0.3 s after the
engine's last sign of life it must."""
HALT_S = 1.0
"""s of silence after which the robot has halted. Anything that computes can hold up an engine for half of that where
the machine is slow and busy, and the robot stands meanwhile."""
LAST_LOOK = 3.0
"""s in which a body that is out of reach may come back, to be told to stand, before the process ends."""
SETTLE_LIMIT = 0.5
"""s of robot time in which the base comes to rest before the process ends; from full speed it needs 0.1."""


class Host:
    """Between shared memory and the controller of a body."""

    def __init__(self, memory: Memory, controller: Controller, settings: RobotSettings) -> None:
        self._memory = memory
        self._controller = controller
        self._allowed = settings.heartbeat_s if settings.speed == "real" else float("inf")
        self._epoch = memory.ints[m.STOP_EPOCH]
        self._halted = ""
        self._halted_in = 0  # the epoch that was in force when the robot halted
        self._braked = False  # the engine is late
        self._paused_at: float | None = None  # since when somebody has it paused
        self._paused_s = float(memory.state.get()["paused_s"]) if memory.state.count else 0.0
        self._stopping = False
        self._motions = (memory.drive, memory.goal, memory.arm, memory.gripper)
        self._seen = {box: box.count for box in (*self._motions, memory.light, memory.buzzer)}
        self._seen[memory.correction] = 0  # what came while there was no robot process holds all the same
        self._scanned = -1.0
        company = controller.company
        self._company = Relay(company, memory.speech, memory.news) if company is not None else None

    def step(self, now: float) -> None:
        """One step of the body; ``now`` is ``time.monotonic()``."""
        memory = self._memory
        epoch = memory.ints[m.STOP_EPOCH]
        if epoch != self._epoch:
            self._controller.stop()
            self._stamp_zero()
            self._epoch, self._paused_at = epoch, None
            memory.ints[m.STOPPED_EPOCH] = epoch
            self.publish()
        if (why := self._hindrance()) and (not self._halted or self._is_commanded()):
            self._halt(why)
        self._watch(now, memory.times[m.HEARTBEAT])
        self._heed_pause(now, memory.ints[m.PAUSE])
        if not (self._halted or self._braked or self._paused_at is not None):
            self._take_motions()
        self._controller.limit_speed(memory.times[m.SPEED_LIMIT] or 1.0)
        self._take_signals()
        self._take_correction()
        if self._company is not None:
            self._company.take()
        self._advance()

    def settle(self, why: str, pace: Callable[[], object] = lambda: None) -> None:
        """The last thing of all: come to rest, whatever was commanded, and leave that as the last state."""
        self._halt(why)
        for step in range(round(LAST_LOOK / STEP_S)):
            out_of_reach = bool(self._controller.body.trouble)
            if not out_of_reach and (not self._stopping or step > SETTLE_LIMIT / STEP_S):
                break
            pace()
            self._advance()
        self.publish()

    def come_back(self) -> None:
        """This process was away for so long that nobody knows any more what it was about."""
        if not self._halted:
            self._halt("the robot process did not respond")

    def publish(self) -> None:
        """Show the readings of now."""
        controller, box = self._controller, self._memory.state
        controller.fill(box.scratch)
        self._memory.ints[m.GUARD] = controller.body.guard_pid
        box.scratch["epoch"] = self._epoch
        box.scratch["halted"], box.scratch["halted_in"] = self._halted.encode(), self._halted_in
        box.scratch["paused"], box.scratch["paused_s"] = self._paused_at is not None, self._paused_s
        box.put()
        if controller.scan_time != self._scanned:
            self._scanned = controller.scan_time
            scan = self._memory.scan
            scan.scratch["t"], scan.scratch["ranges"] = controller.scan_time, controller.ranges
            scan.put()
        if self._company is not None:
            self._company.show()

    def _watch(self, now: float, heartbeat: float) -> None:
        """Stand while the engine is silent; after long, halt until it beats again *and* a new epoch has begun."""
        silence = now - heartbeat if heartbeat > 0 else 0.0
        if self._halted:
            if silence <= self._allowed and self._epoch != self._halted_in and not self._hindrance():
                self._halted = ""
                self._controller.stop(anew=True)  # the arm holds where it is by now, not where it was then
                self.publish()
        elif silence > max(HALT_S, self._allowed):
            self._halt("heartbeat lost")
        elif (late := silence > BRAKE_PART * self._allowed) != self._braked:
            self._braked = late
            if late:
                self._controller.pause()
                self._stamp_zero()
            elif self._paused_at is None:
                self._controller.resume()

    def _heed_pause(self, now: float, token: int) -> None:
        """Rest while a pause of this epoch lasts; halt when nobody ends it."""
        lasts = token != self._memory.ints[m.RESUME] and m.epoch_of(token) == self._epoch and not self._halted
        if not lasts:
            if self._paused_at is not None:
                self._paused_at = None
                self._seen[self._memory.drive] = self._memory.drive.count  # that was for then
                if not self._braked:
                    self._controller.resume()
                self.publish()
        elif self._paused_at is None:
            self._paused_at = now
            self._controller.rest()
            self.publish()
        elif now - self._paused_at > PAUSE_LIMIT_S:
            self._halt(UNDECIDED)
        else:
            self._paused_s += STEP_S

    def _halt(self, why: str) -> None:
        self._halted, self._halted_in = why, self._epoch
        self._controller.stop()
        if not self._braked:
            self._stamp_zero()
        self._braked = False
        self.publish()

    def _stamp_zero(self) -> None:
        """The motors have just been told to stand."""
        self._memory.times[m.ZERO_TIME] = time.monotonic()
        self._stopping = True

    def _advance(self) -> None:
        self._controller.step()
        if self._stopping and self._controller.at_rest:
            self._memory.times[m.REST_TIME] = time.monotonic()
            self._stopping = False

    def _take_motions(self) -> None:
        memory, controller = self._memory, self._controller
        if (box := memory.drive).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                controller.drive(Twist(*record["twist"].tolist()))
        if (box := memory.goal).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                controller.go(Pose(*record["pose"].tolist()), int(record["ticket"]))
        if (box := memory.arm).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                controller.move_arm(record["joints"].tolist(), float(record["speed"]))
        if (box := memory.gripper).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                controller.grip(float(record["opening"]))

    def _take_signals(self) -> None:
        """Light and sound move nothing: a robot that stands may use them."""
        memory, controller = self._memory, self._controller
        if (box := memory.light).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                red, green, blue = record["light"].tolist()
                controller.shine((red, green, blue))
        if (box := memory.buzzer).count != self._seen[box]:
            record = box.get()
            if self._is_ours(box, record):
                controller.beep(float(record["seconds"]))

    def _take_correction(self) -> None:
        """Where the robot is on the map is so in every epoch."""
        if (box := self._memory.correction).count != self._seen[box]:
            self._seen[box] = box.count
            self._controller.correct(Pose(*box.get()["pose"].tolist()))

    def _hindrance(self) -> str:
        """Why nothing may move now; empty where it may."""
        return EMERGENCY_STOP if self._memory.ints[m.ESTOP] else self._controller.body.trouble

    def _is_commanded(self) -> bool:
        """Whether somebody wants it to move in an epoch that has not heard yet why it does not."""
        if self._epoch == self._halted_in:
            return False
        return any(box.count != self._seen[box] and box.get()["epoch"] == self._epoch for box in self._motions)

    def _is_ours(self, box: Mailbox, record: m.Record) -> bool:
        """Whether a command is of the epoch in force. One of a coming epoch is left for when its stop has arrived:
        the stop stamp was read before, so both may have come in between."""
        if record["epoch"] != self._epoch:
            return False
        self._seen[box] = box.count
        return True


def run_in_real_time(memory: Memory, host: Host, link: socket.socket) -> None:
    """Step every 2 ms until the engine closes the link; then come to rest."""
    ints, times, loop = memory.ints, memory.times, memory.loop
    parent = os.getppid()
    link.setblocking(False)
    pace = Pace()
    step, linked = 0, True
    while linked and not ints[m.QUIT]:
        late = pace.wait()
        now = time.monotonic()
        if late > DEBT:
            ints[m.OVERRUNS] += 1
        if late > HALT_S:
            host.come_back()
        host.step(now)
        times[m.ALIVE] = now
        step += 1
        if step % TICK_STEPS == 0:
            host.publish()
            ints[m.TICKS] += 1
            linked = _still_linked(link, wake=ints[m.WAITERS] != 0) and os.getppid() == parent
        loop[step % m.LOOP_SAMPLES] = (late, time.monotonic() - now)
        ints[m.STEPS] = step
    host.settle(_why_it_ends(memory), pace.wait)


def run_on_demand(memory: Memory, host: Host, link: socket.socket) -> None:
    """Step one tick per request until the engine closes the link; then come to rest."""
    link.setblocking(True)
    with contextlib.suppress(OSError):  # an engine that was killed between asking and hearing
        while link.recv(1):
            for _ in range(TICK_STEPS):
                host.step(time.monotonic())
            host.publish()
            memory.ints[m.TICKS] += 1
            link.send(b".")
    host.settle(_why_it_ends(memory))


class Pace:
    """Absolute deadlines, one for every step."""

    def __init__(self) -> None:
        self._deadline = time.monotonic()

    def wait(self) -> float:
        """Sleep to the next deadline and return how late it has become, s; what is much too late is let go."""
        self._deadline += STEP_S
        left = self._deadline - time.monotonic()
        if left > 0:
            time.sleep(left)
        late = time.monotonic() - self._deadline
        if late > DEBT:
            self._deadline += late
        return late


def _why_it_ends(memory: Memory) -> str:
    return "switched off" if memory.ints[m.QUIT] else "engine gone"


def _still_linked(link: socket.socket, *, wake: bool) -> bool:
    """Whether the engine holds its end; wakes those who wait for a tick."""
    try:
        if wake:
            link.send(b".")
        return link.recv(1) != b""
    except BlockingIOError:
        return True  # nothing to read, or an engine that reads slowly: both are fine
    except OSError:
        return False
