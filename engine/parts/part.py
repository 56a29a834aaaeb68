"""The parts of an engine while they load: each is awaited by whoever needs it first, and watched by the console.

The console is usable while models load because nothing waits for a part that it does not use: a typed command
needs the planner and the robot, a spoken one the recogniser as well.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Generic, Protocol, TypeVar

from engine.errors import ExitCode, SaysoError
from engine.handle import PartName, PartState, PartStatus

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Loading(Protocol[T_co]):
    """A part as those see it who only need it."""

    async def get(self) -> T_co:
        """The part, once loaded. Raises the :class:`SaysoError` that it failed with."""
        ...

    @property
    def value(self) -> T_co | None:
        """The part if it is ready."""
        ...


class Part(Generic[T]):
    """One part that is being loaded, is ready, or could not be had."""

    def __init__(self, name: PartName, report: Callable[[PartStatus], None]) -> None:
        self._report = report
        self._done = asyncio.Event()
        self._value: T | None = None
        self._error: SaysoError | None = None
        self.status = PartStatus(name, "loading")

    async def load(self, loader: Callable[[], Awaitable[T]], describe: Callable[[T], str] = lambda part: "") -> None:
        """Run ``loader`` and keep its result, or what went wrong. Raises nothing but cancellation.

        A part that was lost can be loaded again: whoever asks for it then waits for how that ends.
        """
        self.begin()
        try:
            value = await loader()
        except SaysoError as error:
            self.fail(error)
        except Exception as error:  # noqa: BLE001 - a part that has a fault must not take the others with it
            name = self.status.name
            self.fail(SaysoError(f"The {name} has a fault: {error!r}.", hint="Please report it."))
        else:
            self.succeed(value, describe(value))

    def begin(self) -> None:
        """The part is being loaded, for the first time or again: whoever asks for it waits."""
        self._done.clear()
        self._value = self._error = None
        self.status = PartStatus(self.status.name, "loading")

    def progress(self, detail: str) -> None:
        """The part is still being loaded, so far; whoever looks at its status sees it."""
        self.status = PartStatus(self.status.name, "loading", detail)

    def succeed(self, value: T, detail: str = "") -> None:
        """The part is loaded."""
        self._value = value
        self._change("ready", detail)
        self._done.set()

    def fail(self, error: SaysoError) -> None:
        """The part cannot be had (any more): everybody who asks for it gets ``error``."""
        self._value, self._error = None, error
        self._change("missing" if error.exit_code is ExitCode.MISSING else "failed", str(error))
        self._done.set()

    async def get(self) -> T:
        """The part, once loaded. Raises the :class:`SaysoError` that it failed with."""
        await self._done.wait()
        if self._error is not None:
            raise self._error
        assert self._value is not None, "a part that loaded without an error has a value"
        return self._value

    @property
    def value(self) -> T | None:
        """The part if it is ready."""
        return self._value

    def _change(self, state: PartState, detail: str) -> None:
        self.status = PartStatus(self.status.name, state, detail)
        self._report(self.status)
