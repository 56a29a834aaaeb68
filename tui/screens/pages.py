"""What pages over the main screen may do, for whoever only knows that one is shown."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Protocol, runtime_checkable

if TYPE_CHECKING:
    from tui.shown.view import View


@runtime_checkable
class Following(Protocol):
    """It follows what happens."""

    def show(self, view: View) -> None:
        """Bring it up to date."""
        ...


@runtime_checkable
class Paged(Protocol):
    """There may be no room for all of it."""

    def scroll_page(self, direction: int) -> None:
        """A screenful up (−1) or down (1)."""
        ...

    def can_scroll(self, direction: int) -> bool:
        """There is more up (−1) or down (1)."""
        ...


@runtime_checkable
class Placed(Protocol):
    """It has keys of its own."""

    place: ClassVar[str]
    """How the help page calls it."""


@runtime_checkable
class Stepped(Protocol):
    """There are steps back on it, before it is left."""

    def step_back(self) -> bool:
        """Go one; False where there is none."""
        ...


@runtime_checkable
class Copied(Protocol):
    """It can be taken along as text."""

    def plain(self) -> str:
        """All of it; empty while there is nothing."""
        ...
