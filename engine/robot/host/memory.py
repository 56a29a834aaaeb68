"""The memory that the engine and the robot process share, and the only thing that passes between them.

*Words* are naturally aligned 8-byte values, each with one writer, read and written whole: the stop stamp, the
heartbeat, the tick counter. A stop is one such word, so giving it never waits for anything. *Mailboxes* hold the
newest of a record (a state, a command) in a ring of slots: the writer never waits either, a reader never sees half
a record, and a process killed in the middle of writing leaves the last whole record behind. *Queues* are mailboxes in
which the last records stay until they are read: what the robot says, and what the people around it do.

The file behind it has no name from the moment it exists, so nothing is left over however the processes end. It
outlives the robot process: the next one finds in it where the robot was, and the epoch that is in force.
"""

from __future__ import annotations

import mmap
import os
import threading
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from engine.errors import RobotError
from engine.robot.geometry import Pose, compose, inverse
from engine.robot.lidar import RAYS
from engine.unnamed import unnamed_file

MAX_QPOS = 512
"""Most position coordinates a scene may have."""
LOOP_SAMPLES = 8192
"""How many of the last physics steps keep their timing."""

STATE = np.dtype(
    [
        ("t", "f8"),
        ("epoch", "i8"),
        ("pose", "f8", 3),
        ("twist", "f8", 3),
        ("command", "f8", 3),
        ("joints", "f8", 5),
        ("joint_targets", "f8", 5),
        ("gripper", "f8"),
        ("grip", "f8"),  # what the gripper is told, which is less than it measures when it holds something
        ("light", "i8", 3),
        ("buzzer_until", "f8"),  # robot time
        ("blocked", "S96"),
        ("halted", "S96"),
        ("halted_in", "i8"),  # epoch
        ("paused", "i8"),  # 0 or 1
        ("paused_s", "f8"),  # of ``t``
        ("volts", "f8"),  # of the battery; 0 where nothing measures it
        ("going", "i8"),  # the ticket of a robot that finds its way itself; 0 where it was told to go nowhere
        ("going_how", "S16"),
        ("going_left", "f8"),  # m
        ("going_code", "i8"),
        ("going_why", "S96"),
        ("own_pose", "f8", 3),  # of a robot that adds up by itself, in its own frame
        ("arm_fault", "S96"),  # why an arm that finds its own way did not carry out its last motion
        ("correction", "f8", 3),  # of odometry, in ``pose`` already
        ("true_pose", "f8", 3),  # in a simulation, without odometry noise: for tests and evaluation
        ("qpos", "f8", MAX_QPOS),  # in a simulation, of the whole scene: for its camera
    ]
)
SCAN = np.dtype([("t", "f8"), ("ranges", "f8", RAYS)])
DRIVE = np.dtype([("epoch", "i8"), ("twist", "f8", 3)])
GOAL = np.dtype([("epoch", "i8"), ("ticket", "i8"), ("pose", "f8", 3)])
ARM = np.dtype([("epoch", "i8"), ("joints", "f8", 5), ("speed", "f8")])
GRIPPER = np.dtype([("epoch", "i8"), ("opening", "f8")])
LIGHT = np.dtype([("epoch", "i8"), ("light", "i8", 3)])
BUZZER = np.dtype([("epoch", "i8"), ("seconds", "f8")])
SPEECH = np.dtype([("text", "S512")])  # what the robot says aloud, UTF-8
NEWS = np.dtype([("t", "f8"), ("who", "S64"), ("does", "S16"), ("text", "S512")])  # engine.robot.company.News
CORRECTION = np.dtype([("pose", "f8", 3)])  # of the frame in which odometry adds up, on the map
LOOP = np.dtype([("late", "f4"), ("busy", "f4")])

# Words of the engine.
STOP_EPOCH, HEARTBEAT, WAITERS, QUIT, PAUSE, RESUME, ESTOP, SPEED_LIMIT = range(8)
"""PAUSE and RESUME hold tokens: the newest pause, and the newest that is over. SPEED_LIMIT is a share of the speeds
that the envelope allows; 0: nobody has set one."""
# Words of the robot process.
READY, STOPPED_EPOCH, ZERO_TIME, REST_TIME, TICKS, ALIVE, OVERRUNS, STEPS, SCHEDULING, GUARD = range(8, 18)
"""GUARD is the process id of the guard beside it, or 0."""
_WORDS = 32

_SLOTS: Final = 4
_QUEUED: Final = 64
"""How many records a queue keeps for a reader who is busy."""
Record = Any
"""A record of one of the dtypes above; numpy has no static type for it."""


def pause_token(epoch: int, number: int) -> int:
    """The ``number``-th pause, which only holds in ``epoch``: one word, so that a pause is one store."""
    return epoch << 24 | number & 0xFFFFFF


def epoch_of(token: int) -> int:
    """The epoch of a pause."""
    return token >> 24


def believed(record: Record, correction: Record) -> Pose:
    """The pose of a state or a picture under the correction that is in force by now, of which whoever took it may
    not have known."""
    pose, known, now = (tuple(part.tolist()) for part in (record["pose"], record["correction"], correction["pose"]))
    return Pose(*pose) if known == now else compose(Pose(*now), compose(inverse(Pose(*known)), Pose(*pose)))


class Mailbox:
    """The newest record of one kind: one writer, any number of readers, nobody waits.

    Writing fills the slot after the newest and then counts it. A reader copies the newest slot and takes the copy
    only if the writer has not come round to that slot meanwhile, which at 50 records a second takes 60 ms.
    """

    slots: ClassVar[int] = _SLOTS

    def __init__(self, buffer: mmap.mmap, offset: int, dtype: np.dtype[Any]) -> None:
        self._count = memoryview(buffer)[offset : offset + 8].cast("q")
        self._slots: NDArray[Any] = np.ndarray((self.slots,), dtype, buffer, offset + 8)
        self._fence = threading.Lock()
        self.scratch: Record = np.zeros((), dtype)
        """What :meth:`put` writes next; belongs to the writer."""

    @classmethod
    def size(cls, dtype: np.dtype[Any]) -> int:
        """Bytes in shared memory."""
        return 8 + cls.slots * dtype.itemsize

    @property
    def count(self) -> int:
        """How many records have been put."""
        return self._count[0]

    def put(self) -> None:
        """Publish ``scratch``."""
        count = self._count[0] + 1
        self._slots[count % self.slots] = self.scratch
        self._order_writes()
        self._count[0] = count

    def get(self) -> Record:
        """A copy of the newest record; all zero before the first."""
        while True:
            count = self._count[0]
            record = self._slots[count % self.slots].copy()
            if self._count[0] - count < self.slots - 1:
                return record

    def _order_writes(self) -> None:
        """The slot must be seen before its count. x86 keeps the order of writes; ARM does not, and Python has no
        memory barrier but this: two turns of a lock that nobody else wants (0.1 µs)."""
        for _ in range(2):
            with self._fence:
                pass


class Queue(Mailbox):
    """The last 64 records of one kind, for a reader who wants them all: one writer, who never waits, and a reader who
    keeps count of what they have read. One who falls further behind misses the oldest."""

    slots = _QUEUED

    def since(self, seen: int) -> tuple[list[Record], int]:
        """Copies of what was put after the first ``seen`` records, the oldest first, and how many there are by now."""
        newest = self.count
        found = []
        for number in range(max(seen, newest - self.slots + 1) + 1, newest + 1):
            record = self._slots[number % self.slots].copy()
            if self._count[0] - number < self.slots - 1:  # else the writer has come round to it
                found.append(record)
        return found, newest


def clipped(text: str, dtype: np.dtype[Any], field: str) -> bytes:
    """As much of a text as this field of a record holds, UTF-8."""
    return text.encode()[: dtype[field].itemsize].decode(errors="ignore").encode()


class Memory:
    """All words and mailboxes, over a file descriptor that both processes have."""

    def __init__(self, fd: int) -> None:
        self.fd = fd
        self._map = mmap.mmap(fd, _layout_size())
        words = memoryview(self._map)[: 8 * _WORDS]
        self.ints = words.cast("q")
        self.times = words.cast("d")
        """The same words as seconds of ``time.monotonic()``, which all processes of a machine share."""
        offset = 8 * _WORDS
        boxes = []
        for dtype in _MAILBOXES:
            boxes.append(Mailbox(self._map, offset, dtype))
            offset += _aligned(Mailbox.size(dtype))
        queues = []
        for dtype in _QUEUES:
            queues.append(Queue(self._map, offset, dtype))
            offset += _aligned(Queue.size(dtype))
        self.speech, self.news = queues
        self.state, self.scan, self.drive, self.goal, self.arm, self.gripper, self.light, *rest = boxes
        self.buzzer, self.correction = rest
        self.loop: NDArray[Any] = np.ndarray((LOOP_SAMPLES,), LOOP, self._map, offset)

    @classmethod
    def create(cls) -> Memory:
        """New, zeroed memory behind a file without a name. The caller closes ``fd``. Raises :class:`RobotError`."""
        try:
            fd = unnamed_file("sayso-robot", _layout_size())
            try:
                memory = cls(fd)
            except BaseException:
                os.close(fd)
                raise
        except OSError as error:
            why = os.strerror(error.errno) if error.errno else str(error)
            message = f"The memory that the engine and the robot share cannot be had: {why}."
            raise RobotError(message, hint="Close other programs, or raise the limits (ulimit -n, -v).") from error
        memory.ints[STOP_EPOCH] = 1
        return memory

    def begin_again(self) -> None:
        """Ready for another robot process, after the last one has gone: what it left as its state stays, and so does
        the epoch; the rest is as new. Nobody beats for a robot that is not there yet."""
        for word in (HEARTBEAT, WAITERS, QUIT, READY, ALIVE):
            self.ints[word] = 0  # zero seconds, too


_MAILBOXES = (STATE, SCAN, DRIVE, GOAL, ARM, GRIPPER, LIGHT, BUZZER, CORRECTION)
_QUEUES = (SPEECH, NEWS)


def _aligned(size: int) -> int:
    return -(-size // 64) * 64


def _layout_size() -> int:
    boxes = sum(_aligned(Mailbox.size(dtype)) for dtype in _MAILBOXES)
    queues = sum(_aligned(Queue.size(dtype)) for dtype in _QUEUES)
    return 8 * _WORDS + boxes + queues + LOOP_SAMPLES * LOOP.itemsize
