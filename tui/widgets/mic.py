"""The microphone: what it hears as one scrolling trace, newest at the right, with marks where something was made of it.

How high a cell is, is how loud it was; solid cells counted as speech, dotted ones did not. One looks and knows why the
robot did or did not hear: too quiet, no speech in it, cut too early, or not understood.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final

from rich.cells import cell_len
from rich.segment import Segment
from rich.style import Style
from textual.content import Content
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from tui.shown.facts import Level
from tui.shown.trace import Mark, Sign, Trace
from tui.shown.turn import VOICE
from tui.words import strings

_FLOOR_DB: Final = -60.0
_TOP_DB: Final = -10.0
_STEPS: Final = "▁▂▃▄▅▆▇█"
_DOTS: Final = "⣀⣤⣶⣿"
_FIGURE: Final = 12
"""Columns between the label and the trace."""
_WORD: Final = 25
SIGNS: Final[dict[Sign, str]] = {"wake": "▼", "endpoint": "◆", "understood": "✓", "rejected": "✗", "stopped": "■"}


class MicStrip(Widget, can_focus=False):
    """`` mic ● −23 dB ⣀⣀▼⣀⣀▂▅▇█▇▅▂⣀⣀◆✓ understood``; or one line about why there is no microphone. Where it is two
    rows high, the second one tells the marks since the last wake in words.

    Runs of one colour are one segment: a moving row costs half a kilobyte, not four.
    """

    ALLOW_SELECT = False
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "mic--label",
        "mic--speech",
        "mic--pause",
        "mic--quiet",
        "mic--rest",
        "mic--warning",
        "mic--wake",
        "mic--endpoint",
        "mic--understood",
        "mic--rejected",
        "mic--stopped",
    }

    def __init__(self) -> None:
        super().__init__()
        self._trace = Trace()
        self._notice = ""
        self._trouble = False
        self._lines: tuple[object, object] = (None, None)

    def update_from(self, trace: Trace, *, notice: str, trouble: bool) -> None:
        """Show the trace; the notice where there is none yet, or where something is wrong (``trouble``)."""
        self._trace, self._notice, self._trouble = trace, notice, trouble
        lines = ((trace, notice, trouble), (_newest_marks(trace), _now(trace), self._idle))
        for y, (new, old) in enumerate(zip(lines, self._lines, strict=True)):
            if new != old:
                self.refresh(Region(0, y, self.size.width, 1))
        self._lines = lines

    def render_line(self, y: int) -> Strip:
        width = self.size.width
        told = self._told(width) if y else self._told_nothing(width) if self._idle else self._heard(width)
        return Strip(told).adjust_cell_length(width, self.rich_style)

    @property
    def _label(self) -> int:
        """Columns before the trace."""
        return cell_len(strings.MIC) + _FIGURE

    @property
    def _idle(self) -> bool:
        """Nothing was heard yet, or nothing can be heard."""
        return not self._trace.listens and (self._trouble or not self._trace.items)

    def _told_nothing(self, width: int) -> list[Segment]:
        text = ("▲ " if self._trouble else "○ ") + self._notice
        text = Content(text).truncate(max(1, width - cell_len(strings.MIC) - 2), ellipsis=True).plain
        style = self.get_component_rich_style("mic--warning" if self._trouble else "mic--quiet")
        return [Segment(f" {strings.MIC} ", self.get_component_rich_style("mic--label")), Segment(text, style)]

    def _heard(self, width: int) -> list[Segment]:
        """The first row: the figure, the trace, and where there is no second row, what was made of it."""
        style, listens = self.get_component_rich_style, self._trace.listens
        levels = [item for item in self._trace.items[-2:] if isinstance(item, Level)]
        figure = f"{max(-99.0, levels[-1].rms_db):4.0f} dB".replace("-", "−") if listens and levels else ""
        parts = [
            Segment(f" {strings.MIC} ", style("mic--label")),
            Segment("● " if listens else "○ ", style("mic--speech" if listens else "mic--quiet")),
            Segment(f"{figure:<8}", style("mic--quiet")),
        ]
        alone = self.size.height < 2
        parts += self._drawn(max(0, width - self._label - _WORD * alone - 1))
        if not alone:
            return parts
        newest = _newest_marks(self._trace)
        if listens or not newest:
            return [*parts, Segment(f"  {_now(self._trace)}", style("mic--quiet"))]
        word = Content(f" {newest[-1].word}").truncate(_WORD, ellipsis=True).plain  # the trace ends with its sign
        return [*parts, Segment(word, style(f"mic--{newest[-1].sign}"))]

    def _told(self, width: int) -> list[Segment]:
        """The second row: the marks since the last wake in words, and what is the case now at the right."""
        style = self.get_component_rich_style
        blank = style("mic--quiet")
        if self._idle:
            return [Segment(" " * width, blank)]
        now = f"{_now(self._trace)} "
        parts, room = [Segment(" " * (self._label - 3), blank)], width - self._label + 3 - cell_len(now)
        for sign, said in _in_words(_newest_marks(self._trace), room):
            text = Content(f"   {SIGNS[sign]}{said}").truncate(max(1, room), ellipsis=True)
            parts += [Segment(text.plain[:4], style(f"mic--{sign}")), Segment(text.plain[4:], blank)]
            room -= text.cell_length
        return [*parts, Segment(" " * max(0, room) + now, blank)]

    def _drawn(self, cells: int) -> Sequence[Segment]:
        """The newest part of the trace; what is over is paler than what is heard now."""
        items = self._trace.items[-cells:] if cells else ()
        runs = [Segment("⣀" * (cells - len(items)), self.get_component_rich_style("mic--rest"))]
        text, style = "", Style.null()
        for item in items:
            its_style = self.get_component_rich_style(_look(item, self._trace.listens))
            if its_style is not style:
                runs.append(Segment(text, style))
                text, style = "", its_style
            text += SIGNS[item.sign] if isinstance(item, Mark) else trace_step(item)
        return [*runs, Segment(text, style)]


def trace_step(level: Level) -> str:
    """The sign that stands for a level: its height is linear in dB, solid where it counted as speech, else dotted."""
    steps = _STEPS if level.speech_probability >= VOICE else _DOTS
    share = (level.rms_db - _FLOOR_DB) / (_TOP_DB - _FLOOR_DB)
    return steps[max(0, min(len(steps) - 1, int(share * len(steps))))]


def _look(item: Level | Mark, listens: bool) -> str:
    if isinstance(item, Mark):
        return f"mic--{item.sign}"
    if item.speech_probability >= VOICE:
        return "mic--speech" if listens else "mic--pause"
    return "mic--pause" if item.in_speech and listens else "mic--quiet" if listens else "mic--rest"


def _now(trace: Trace) -> str:
    """What is the case now, in a word with its sign."""
    if not trace.listens:
        return f"○ {strings.MIC_IDLE}"
    last = trace.items[-1] if trace.items else None
    if not isinstance(last, Level) or not last.in_speech:
        return f"○ {strings.MIC_WAITING}"
    return f"● {strings.MIC_SPEECH}" if last.speech_probability >= VOICE else f"◌ {strings.MIC_QUIET}"


def _in_words(marks: Sequence[Mark], room: int) -> list[tuple[Sign, str]]:
    """What is told of each mark in so many cells: where that is too little, most of the last one."""
    if not marks:
        return []
    whole = [
        (mark.sign, f" {mark.word}{strings.COMMA}{mark.detail}" if mark.detail else f" {mark.word}") for mark in marks
    ]
    less = [*((mark.sign, f" {mark.word}") for mark in marks[:-1]), whole[-1]]
    least = [*((mark.sign, "") for mark in marks[:-1]), whole[-1]]
    return next((told for told in (whole, less) if sum(4 + cell_len(said) for _, said in told) <= room), least)


def _newest_marks(trace: Trace) -> tuple[Mark, ...]:
    """The marks since the last wake, with it."""
    marks: list[Mark] = []
    for item in reversed(trace.items):
        if isinstance(item, Mark):
            marks.insert(0, item)
            if item.sign == "wake":
                break
    return tuple(marks)
