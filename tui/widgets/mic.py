"""The microphone in one row: how loud it is, and the trace of voice activity, newest at the right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final

from rich.segment import Segment
from rich.style import Style
from textual.content import Content
from textual.strip import Strip
from textual.widget import Widget

from tui import strings
from tui.facts import Level
from tui.model import ConsoleModel

_METER: Final = 16
_FLOOR_DB: Final = -60.0
_STEPS: Final = "▁▂▃▄▅▆▇█"
_LABEL: Final = 5
_WORD: Final = 10


class MicStrip(Widget, can_focus=False):
    """`` mic ━━━━━━━──────  −23 dB ▁▁▂▅▇█▇▅▂▁ speech``; or one line about why there is no microphone.

    Runs of one colour are one segment: a moving row costs two hundred bytes, not two thousand.
    """

    ALLOW_SELECT = False
    COMPONENT_CLASSES: ClassVar[set[str]] = {
        "mic--loud",
        "mic--rest",
        "mic--speech",
        "mic--quiet",
        "mic--label",
        "mic--warning",
    }

    def __init__(self) -> None:
        super().__init__()
        self._trace: tuple[Level, ...] = ()
        self._listening = False
        self._notice = ""
        self._trouble = False

    def update_from(self, model: ConsoleModel, *, notice: str, trouble: bool) -> None:
        """Show the trace while listening, else the notice (``trouble``: it is about something that is wrong)."""
        trace = model.trace if model.listening else ()
        shown = (trace, model.listening, notice, trouble)
        if shown != (self._trace, self._listening, self._notice, self._trouble):
            self._trace, self._listening, self._notice, self._trouble = shown
            self.refresh()

    def render_line(self, y: int) -> Strip:
        width = self.size.width
        style = self.get_component_rich_style
        parts = [Segment(f" {strings.MIC} ".ljust(_LABEL), style("mic--label"))]
        if not self._listening:
            sign = "▲ " if self._trouble else "○ "
            text = Content(sign + self._notice).truncate(max(1, width - _LABEL), ellipsis=True).plain
            parts.append(Segment(text, style("mic--warning" if self._trouble else "mic--quiet")))
        else:
            last = self._trace[-1] if self._trace else Level(_FLOOR_DB, 0.0, False)
            filled = meter_cells(last.rms_db)
            word = strings.MIC_SPEECH if last.in_speech else strings.MIC_QUIET
            parts += [
                Segment("━" * filled, style("mic--loud")),
                Segment("━" * (_METER - filled), style("mic--rest")),
                Segment(f" {max(-99.0, last.rms_db):4.0f} dB ", style("mic--quiet")),
                *self._traced(max(0, width - _LABEL - _METER - 9 - _WORD)),
                Segment(f" {'●' if last.in_speech else '○'} {word}", style(_voice(last))),
            ]
        return Strip(parts).adjust_cell_length(width, self.rich_style)

    def _traced(self, cells: int) -> Sequence[Segment]:
        levels = self._trace[-cells:] if cells else ()
        runs: list[Segment] = [Segment("▁" * (cells - len(levels)), self.get_component_rich_style("mic--rest"))]
        text, style = "", Style.null()
        for level in levels:
            its_style = self.get_component_rich_style(_voice(level))
            if its_style is not style:
                runs.append(Segment(text, style))
                text, style = "", its_style
            text += trace_step(level.speech_probability)
        return [*runs, Segment(text, style)]


def meter_cells(rms_db: float) -> int:
    """Cells of the meter that are lit, linear in dB from −60 dB up."""
    share = (rms_db - _FLOOR_DB) / -_FLOOR_DB
    return round(_METER * max(0.0, min(1.0, share)))


def trace_step(probability: float) -> str:
    """The block that stands for a probability of speech."""
    return _STEPS[min(len(_STEPS) - 1, int(max(0.0, probability) * len(_STEPS)))]


def _voice(level: Level) -> str:
    return "mic--speech" if level.in_speech else "mic--quiet"
