"""The panel about what failed: what, why, and what to do next. It goes away with the next request."""

from __future__ import annotations

from textual.content import Content
from textual.widgets import Static

from tui.shown.facts import Problem
from tui.words import strings
from tui.words.language import told


class ProblemPanel(Static):
    """Shown while there is a problem, and takes no room otherwise."""

    ALLOW_SELECT = True

    def __init__(self) -> None:
        super().__init__(markup=False)
        self._problem: Problem | None = None
        self.display = False

    def update_from(self, problem: Problem | None) -> None:
        if problem == self._problem:
            return
        self._problem = problem
        self.display = problem is not None
        if problem is not None:
            self.border_title = Content(f"✗ {problem.title or strings.SOMETHING_FAILED}")
            hint = Content.assemble("\n", (told(problem.hint), "$foreground 60%")) if problem.hint else Content("")
            self.update(Content.assemble((told(problem.message), "$foreground"), hint))

    def reword(self) -> None:
        """Words are in another language now."""
        problem, self._problem = self._problem, None
        self.update_from(problem)
