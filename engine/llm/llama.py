"""The local model as its owner has it: a child process with llama.cpp in it, listening on a private UNIX socket.

A child, because native code that runs out of memory or crashes must not take the engine with it. It can be *paused*: a
process that is stopped computes nothing from that moment on, while llama.cpp alone would finish its batch. It goes on
when it is needed again, and drops first what nobody waits for any more.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import signal
import socket
import stat
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec
import psutil

from engine.child import Child
from engine.errors import ExitCode, ProcessError
from engine.llm.chat import ChatError
from engine.llm.llama_worker import WORDS, Up

BATCH: Final = 64
"""Tokens of a prompt that are computed at a time: fewer are slower, more make a stale batch hold up the next
question for longer."""
LOAD_LIMIT_S: Final = 180.0
"""s after which a process that has not loaded its model counts as lost; a slow disk needs half of it."""
SOCKET: Final = "model.sock"
"""llama.cpp knows a UNIX socket by this ending."""
_FOLDER: Final = "sayso-"  # how the names of the folders begin in which the sockets are
_WORKER: Final = "engine.llm.llama_worker"
_EPITAPH_S: Final = 1.0  # from the end of the link to the end of the process
_LINE: Final = 1 << 16
_SPINS: Final = 800  # looks at a barrier before a thread sleeps, 10 µs
_STEADY_MB: Final = 350  # llama.cpp and its buffers, without weights and contexts
_CONTEXT_MB: Final = 0.03  # a token of context of a model of two billion parameters
_WEIGHTS: Final = 1.1  # they are rearranged for the processor, file by file


class NotRunning(ChatError):
    """The local model cannot be had, or was lost."""

    code = "model_missing"
    exit_code = ExitCode.MISSING


@dataclass(frozen=True, slots=True)
class Shape:
    """What is loaded, and how large."""

    gguf: Path
    states: Path  # folder of saved prompts
    threads: int
    slots: int = 2  # conversations that are kept at a time
    context: int = 6144  # tokens of each

    @property
    def memory_mb(self) -> float:
        """What it needs, roughly."""
        weights = self.gguf.stat().st_size / 1e6
        return weights * _WEIGHTS + self.slots * self.context * _CONTEXT_MB + _STEADY_MB


class LlamaProcess:
    """One running model. Whoever starts it ends it (:meth:`kill`)."""

    def __init__(self, child: Child, folder: Path) -> None:
        self._child = child
        self._folder = folder
        self._pausable = False
        self._paused = False
        self._over = False

    @classmethod
    async def start(cls, shape: Shape, remedy: str) -> LlamaProcess:
        """Load the model; ``remedy`` is the hint where its file is at fault. Raises :class:`NotRunning`."""
        _require_memory(shape)
        await asyncio.to_thread(_sweep)
        folder = Path(tempfile.mkdtemp(prefix=_FOLDER))  # 0700
        arguments = {"gguf": shape.gguf, "socket": folder / SOCKET, "states": shape.states, "slots": shape.slots}
        arguments |= {"context": shape.context, "batch": BATCH, "threads": shape.threads}
        try:
            child = Child(
                "model",
                _WORKER,
                [f"--{name}={value}" for name, value in arguments.items()],
                environment=_threading(shape.threads),
            )
        except ProcessError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise NotRunning(error.message, hint=error.hint) from error
        process = cls(child, folder)
        try:
            await process._come_up(shape, remedy)
        except BaseException:
            process.kill()
            raise
        return process

    @property
    def socket(self) -> Path:
        """Where it listens, for HTTP."""
        return self._folder / SOCKET

    @property
    def pid(self) -> int:
        return self._child.pid

    def epitaph(self, *, wait: bool = False) -> str | None:
        """What it died of; None while it lives. ``wait``: it may take a moment, its connections have ended."""
        if (died := self._child.epitaph(wait=_EPITAPH_S if wait else 0.0)) is None:
            return None
        if "SIGKILL" in died:
            return "The model process was killed: perhaps there was too little memory for it."
        return died

    def pause(self) -> None:
        """Be silent at once, until :meth:`resume`."""
        if self._pausable and not self._over:
            self._signal(signal.SIGSTOP)
            self._paused = True

    def resume(self) -> None:
        """Work again."""
        if self._paused:
            self._signal(signal.SIGCONT)
            self._paused = False

    def kill(self) -> None:
        """End it at once and leave nothing behind."""
        if self._over:
            return
        self._over = True
        self._child.discard()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _signal(self, number: signal.Signals) -> None:
        if self._child.epitaph() is None:  # else its number may be somebody else's
            os.kill(self._child.pid, number)

    async def _come_up(self, shape: Shape, remedy: str) -> None:
        """Wait for the process to say that it listens. Raises :class:`NotRunning`."""
        loop = asyncio.get_running_loop()
        self._child.link.setblocking(False)
        said = b""
        try:
            async with asyncio.timeout(LOAD_LIMIT_S):
                while not said.endswith(b"\n") and (piece := await loop.sock_recv(self._child.link, _LINE)):
                    said += piece
        except TimeoutError:
            message = f"The model {shape.gguf.name} has not loaded within {LOAD_LIMIT_S:g} s."
            raise NotRunning(message, hint="Take a smaller model, or close other programs.") from None
        except OSError:
            said = b""  # it died with something unread
        try:
            word = WORDS.decode(said)
        except msgspec.DecodeError:
            why = await asyncio.to_thread(self.epitaph, wait=True) or "The model process closed its connection."
            raise NotRunning(f"{shape.gguf.name} cannot be loaded. {why}", hint=remedy) from None
        if isinstance(word, Up):
            self._pausable = word.pausable
        elif word.library:
            hint = "Install it with pip install xllamacpp; on Linux it needs libgomp1 (apt install libgomp1)."
            raise NotRunning(f"llama.cpp cannot be used: {word.reason}.", hint=hint)
        else:
            message = f"{shape.gguf} cannot be loaded: it is damaged, or no model that llama.cpp knows."
            raise NotRunning(message, hint=remedy)


def _sweep() -> None:
    """Remove what is left where an engine and its model were killed together: folders of this user with a socket to
    which nobody listens, and which have been there longer than it takes to load a model."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_FOLDER}*"):
        with contextlib.suppress(OSError):
            about = folder.lstat()
            ours = stat.S_ISDIR(about.st_mode) and about.st_uid == os.getuid()
            if ours and time.time() - about.st_mtime > LOAD_LIMIT_S and _is_deserted(folder / SOCKET):
                shutil.rmtree(folder, ignore_errors=True)


def _is_deserted(path: Path) -> bool:
    """Whether there is a socket to which nobody listens."""
    with socket.socket(socket.AF_UNIX) as link:
        link.setblocking(False)
        try:
            link.connect(str(path))
        except ConnectionRefusedError:
            return True
        except OSError:  # there is none, or its owner is busy
            return False
    return False


def _require_memory(shape: Shape) -> None:
    """Say so before the system does, which would end some process or other. Raises :class:`NotRunning`."""
    need, free = shape.memory_mb, psutil.virtual_memory().available / 1e6
    if free < need:
        message = f"There is too little memory for the model {shape.gguf.name}: it needs about {need:.0f} MB"
        hint = "Close other programs, or choose a smaller model or one in the cloud (planner.profile)."
        raise NotRunning(f"{message}, and {free:.0f} MB are free.", hint=hint)


def _threading(threads: int) -> Mapping[str, str]:
    """Threads that soon sleep while they wait for each other: those that spin on would steal the recogniser's time.

    A round of :data:`_SPINS` spares most waits a sleep: 25 tokens/s instead of 18 alone, and 12 instead of 15 beside a
    recogniser that never stops. With four times as many it would be 8 there, with as many as are usual 2.
    """
    return {"OMP_NUM_THREADS": str(threads), "OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": str(_SPINS)}
