"""The panel about what failed: what, why, and what to do next. It goes away with the next request, or when somebody
goes back from it or clicks on it."""

from __future__ import annotations

from textual.content import Content
from textual.widgets import Static

from tui.shown.facts import Problem
from tui.words import strings
from tui.words.hints import Acting, hint_line
from tui.words.language import told


class ProblemPanel(Static):
    """Shown while there is a problem, and takes no room otherwise."""

    ALLOW_SELECT = True

    def __init__(self, acting: Acting) -> None:
        """``acting`` says which keys act now."""
        super().__init__(markup=False)
        self._acting = acting
        self._problem: Problem | None = None
        self.display = False

    def hint(self) -> None:
        """Say below it how to go back."""
        words = hint_line(strings.PROBLEM_KEYS, self._acting)
        if str(self.border_subtitle or "") != words:  # another one repaints the frame
            self.border_subtitle = Content(words)

    def close(self) -> bool:
        """Go back from it; False when it is not shown."""
        there, self.display = self.display, False
        self.screen.remove_class("-trouble")  # the panes below have its room
        return there

    def on_click(self) -> None:
        self.close()

    def update_from(self, problem: Problem | None) -> None:
        if problem is self._problem:
            return
        self._problem = problem
        self.display = problem is not None
        if problem is not None:
            self.border_title = Content(f"✗ {problem.title or strings.SOMETHING_FAILED}")
            hint = Content.assemble("\n", (told(problem.hint), "$foreground 60%")) if problem.hint else Content("")
            self.update(Content.assemble((told(problem.message), "$foreground"), hint))

    def reword(self) -> None:
        """Words are in another language now."""
        there, problem, self._problem = self.display, self._problem, None
        self.update_from(problem)
        self.display = there
