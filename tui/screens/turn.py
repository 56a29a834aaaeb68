"""One turn on a page of its own: the sound, what was understood, what was thought, done and said, and why not.

The page draws from the same frozen turn as the timeline, so that it is up to date while the turn goes on, and a
recording shows what the session showed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar, Final

from textual.app import ComposeResult
from textual.binding import BindingType
from textual.content import Content
from textual.screen import Screen

from tui.keys.bindings import TURN_BINDINGS
from tui.shown.offers import in_pieces, offered
from tui.shown.timeline import Bar, bars
from tui.shown.turn import Answer, Asked, Thought, Turn
from tui.widgets.lines import Drawn
from tui.widgets.page import Piece, Row, drawn_row
from tui.widgets.queue import SIGNS
from tui.widgets.sound import Wave, drawn_wave, wave
from tui.widgets.status import StatusLine
from tui.widgets.timeline import RESULTS, FromTop, Total, asked, drawn_bar, drawn_total, milliseconds, totals
from tui.words import strings
from tui.words.hints import EDGES, Acting, hint_line
from tui.words.language import told

if TYPE_CHECKING:
    from tui.shown.model import ConsoleModel
    from tui.shown.view import View

_DIM: Final = "$foreground 60%"
_THOUGHTS: Final = {
    "decision": ("◆", "$text-primary"),
    "plan": ("◆", "$text-primary"),
    "question": ("?", "$text-warning"),
    "refusal": ("⊘", "$text-error"),
    "rejection": ("✗", "$text-error"),
}
Item = Row | Bar | Total | Wave


class TurnPage(FromTop[Item]):
    """Everything that is known of one turn, from top to bottom."""

    def drawn(self, item: Item) -> Drawn:
        match item:
            case Row():
                return drawn_row(item)
            case Bar():
                return drawn_bar(item, self.size.width)
            case Total():
                return drawn_total(item, self.size.width)
            case Wave():
                return drawn_wave(item, self.size.width)


class TurnScreen(Screen[None]):
    """Not modal, so that every key of the console works here too: above all the one that stops the robot."""

    CSS_PATH = "turn.tcss"
    AUTO_FOCUS = ""
    place: ClassVar[str] = "turn"
    BINDINGS: ClassVar[list[BindingType]] = TURN_BINDINGS

    def __init__(self, acting: Acting, view: View) -> None:
        """``acting`` says which keys act now; ``view`` is shown to begin with."""
        super().__init__()
        self._acting = acting
        self._turn: Turn | None = None  # that is shown
        self._status = StatusLine()
        self._page = TurnPage(classes="pane")
        self._unfolded = False
        self._view = view
        self._number = 0  # of the turn that is shown
        self._titles = ("", "")

    def compose(self) -> ComposeResult:
        yield self._status
        yield self._page

    def on_mount(self) -> None:
        self.show(self._view)

    def show(self, view: View) -> None:
        """Bring the page up to date: the turn that was browsed to, or the newest one. Before it is there, remember."""
        self._view = view
        if not self.is_attached or not self._page.is_attached:
            return
        model, kept = view.model, view.model.turns.kept
        self._status.update_from(view)
        turn = view.turn or (kept[-1] if kept else None)
        self._turn = turn
        number = turn.number if turn is not None else 0
        if number != self._number:
            self._page.follow()
        self._number = number
        title = strings.TURN_TITLE.format(number=number, count=model.turns.count) if turn else ""
        self._title(f"{title} · {strings.NEW_TURNS.format(view.fresh)}" if view.fresh else title)
        nothing = [Row("", ((strings.NO_TURN, _DIM),))]
        if turn is None:
            self._page.show(nothing, matters=0)
            return
        first, *others = rows(turn, view.now, unfolded=self._unfolded)
        self._page.show([first, *_offers(model, turn, self._acting), *others], matters=0)

    def _title(self, title: str) -> None:
        """The border draws itself anew whenever it is told a title, and all the page with it."""
        fold = strings.FOLD if self._unfolded else strings.UNFOLD
        room = max(1, self.size.width - EDGES)
        titles = title, hint_line(strings.TURN_KEYS, self._acting, room, last=2, fold=fold)
        if titles != self._titles:
            self._titles = titles
            self._page.border_title, self._page.border_subtitle = map(Content, titles)

    def on_resize(self) -> None:
        self.show(self._view)

    def reword(self) -> None:
        """Words are in another language now."""
        self._page.redraw()
        self.show(self._view)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        match action:
            case "unfold":
                return (self._turn is not None and any(map(_folds, self._turn.thoughts))) or None
            case "lines_up" | "lines_down":
                return self._page.can_scroll(-1 if action == "lines_up" else 1) or None
        return super().check_action(action, parameters)

    def can_scroll(self, direction: int) -> bool:
        """There is more up (−1) or down (1)."""
        return self._page.can_scroll(direction)

    def action_unfold(self) -> None:
        self._unfolded = not self._unfolded
        self.show(self._view)

    def action_lines_up(self) -> None:
        self._page.scroll_lines(-1)

    def action_lines_down(self) -> None:
        self._page.scroll_lines(1)

    def scroll_page(self, direction: int) -> None:
        """A screenful up (−1) or down (1), less two lines to go on from."""
        self._page.scroll_lines(direction * max(1, self._page.size.height - 2))


def rows(turn: Turn, now: float, *, unfolded: bool) -> Iterator[Item]:
    """The page of a turn, part by part, as of event time ``now``."""
    yield from _title(turn)
    yield Row("")
    yield from wave(turn)
    yield from _heard(turn)
    for number, bar in enumerate(bars(turn, now)):
        if not number:
            yield Row(strings.PART_STAGES)
        yield bar
    yield from totals(turn, now)
    yield Row("")
    yield from _parts(strings.PART_THOUGHTS, (row for thought in turn.thoughts for row in _thought(thought, unfolded)))
    yield from _parts(strings.PART_ACTIONS, _actions(turn))
    yield from _parts(strings.PART_ANSWERS, map(_answer, turn.answers))
    yield from _parts(strings.PART_END, _end(turn))
    yield from _parts(strings.PART_REMARKS, (Row("", ((told(remark), _DIM),)) for remark in turn.remarks))


def _folds(thought: Thought | Asked) -> bool:
    """There is more of it than one sees while it is folded."""
    return isinstance(thought, Asked) or bool(thought.written)


def _offers(model: ConsoleModel, turn: Turn, acting: Acting) -> Iterator[Row]:
    """What may be asked about the turn in a word; and why it cannot be undone, where it cannot."""
    if pieces := in_pieces(offered(model, turn.id), acting):
        yield Row("", pieces)
    if turn.id == model.offers.acted and model.offers.no_undo:
        yield Row("", ((strings.NO_UNDO.format(why=told(model.offers.no_undo)), _DIM),))


def _parts(name: str, found: Iterator[Row]) -> Iterator[Row]:
    """A part of the page: its name stands before its first row, an empty row behind its last."""
    number = 0
    for number, row in enumerate(found, 1):
        yield row._replace(part=name) if number == 1 else row
    if number:
        yield Row("")


def _title(turn: Turn) -> Iterator[Row]:
    sign, style = RESULTS[turn.outcome]
    yield Row("", ((asked(turn), "bold $foreground"),), ((f"{sign} {strings.OUTCOMES[turn.outcome]}", style),))


def _heard(turn: Turn) -> Iterator[Row]:
    """What the recogniser made of it, and how sure it was."""
    how = [strings.WAKE_BY.get(turn.woken, turn.woken)] if turn.woken else []
    figures: list[str] = []
    if (heard := turn.heard) is not None:
        how += filter(None, [strings.HOW_SAID[heard.source]])
        if heard.source == "speech":
            how.append(strings.CONFIDENCE.format(percent=100 * heard.confidence))
            figures = [
                strings.LANGUAGE.format(language=heard.language or "?"),
                strings.DECODED.format(milliseconds=milliseconds(heard.decode_s)),
                strings.LOG_PROBABILITY.format(value=f"{heard.avg_logprob:.2f}".replace("-", "−")),
                strings.NO_SPEECH_SHARE.format(percent=100 * heard.no_speech_probability),
            ]
    elif turn.listened is not None:
        how.append(strings.LISTEN_ENDS[turn.listened.reason])
    yield Row(strings.PART_WORDS_HEARD, ((" · ".join(how), "$foreground"),))
    if figures:
        yield Row("", ((" · ".join(figures), _DIM),))
    if (unheard := turn.unheard) is not None:
        yield Row(
            "",
            (
                ("✗ ", "$text-error"),
                (f"{strings.REJECTED[unheard.reason]}{strings.COLON}{told(unheard.detail)}", "$foreground"),
            ),
        )
    yield Row("")


def _thought(thought: Thought | Asked, unfolded: bool) -> Iterator[Row]:
    if isinstance(thought, Asked):
        yield from _asked(thought, unfolded)
        return
    sign, style = _THOUGHTS[thought.kind]
    by = strings.PLAN_BY.get(thought.source, "")
    if thought.kind == "question" and thought.source:
        by = strings.UNCLEAR.format(what=thought.source)
    word = strings.THOUGHTS[thought.kind]
    yield Row("", ((f"{sign} ", style), (f"{word}  ", _DIM), (_thought_of(thought), "$foreground")), ((by, _DIM),))
    for number, step in enumerate(thought.steps, 1):
        yield Row("", ((f"{number:>3} ", _DIM), (told(step), "$foreground")), indent=2)
    if thought.response:
        yield Row("", ((strings.SAYS.format(text=thought.response), _DIM),), indent=2)
    if thought.written:
        yield Row("", ((f"{'▾' if unfolded else '▸'} {strings.IN_JSON}", "$text-accent"),), indent=2)
        for line in thought.written.splitlines() if unfolded else ():
            yield Row("", ((line, "$foreground 80%"),), indent=4)


def _thought_of(thought: Thought) -> str:
    """What stands beside the word for it; a plan's is what was asked, in the words of whoever did."""
    return thought.text if thought.kind in ("decision", "plan") else told(thought.text)


def _asked(asked: Asked, unfolded: bool) -> Iterator[Row]:
    """A call of a large model; unfolded, what it was told and what it wrote."""
    call = asked.call
    about = filter(None, (strings.LAYERS[call.layer], call.model, strings.AGAIN if call.round > 1 else ""))
    tokens = strings.TOKENS.format(prompt=call.prompt_tokens, reply=call.reply_tokens) if call.prompt_tokens else ""
    figures = " · ".join(filter(None, (tokens, f"{call.duration_s:.2f} s")))
    yield Row(
        "",
        (
            ("▾ " if unfolded else "▸ ", "$text-accent"),
            (f"{strings.ASKED}  ", _DIM),
            (call.platform, "$foreground"),
            (f"  {' · '.join(about)}", _DIM),
            _how_it_ended(asked),
        ),
        ((figures, _DIM),),
    )
    if call.error:
        yield Row("", ((call.error, _DIM),), indent=2)
    if not unfolded:
        return
    if call.head:
        head = strings.HEAD.format(length=call.head_length, digest=call.head)
        yield Row("", ((head, _DIM),), indent=2)
    for name, text in (*((message.role, message.text) for message in call.messages), (strings.REPLY, call.reply)):
        yield Row("", ((name, "$text-accent"),), indent=2)
        for line in text.splitlines() or (strings.NOTHING_CAME,):
            yield Row("", ((line, "$foreground 80%"),), indent=4)


def _how_it_ended(asked: Asked) -> Piece:
    if asked.call.cancelled:
        return f"  ■ {strings.BROKEN_OFF}", "$text-warning"
    if asked.late:
        return f"  ■ {strings.CAME_LATE}", "$text-warning"
    if asked.call.error_code is not None:
        return f"  ✗ {asked.call.error_code}", "$text-error"
    return (f"  {strings.TOO_LONG}", "$text-warning") if asked.call.cut_off else ("", _DIM)


def _actions(turn: Turn) -> Iterator[Row]:
    for action in turn.actions:
        sign, style = SIGNS[action.phase]
        seconds = "" if action.duration_s is None else f"{action.duration_s:.2f} s"
        never = action.duration_s is None and action.phase == "interrupted"
        why = strings.NOT_STARTED if never else action.error_code
        body = (
            (f"{sign} ", style),
            (f"{action.index} ", _DIM),
            (told(action.call), "$foreground"),
            (f"  {why}", style),
        )
        yield Row("", body, ((seconds, "$foreground"),))
        for more in filter(None, (told(action.message), action.data)):
            yield Row("", ((more, _DIM),), indent=4)


def _answer(answer: Answer) -> Row:
    if answer.heard is None:
        came = ("", _DIM)
    elif answer.heard == answer.text:
        came = (f"✓ {strings.HEARD_ALL if answer.audible else strings.ON_SCREEN}", _DIM)
    else:
        part = strings.HEARD_PART.format(heard=answer.heard) if answer.heard else strings.HEARD_NOTHING
        came = (f"■ {part}", "$text-warning")
    return Row("", ((f"“{answer.text}”", "$foreground"),), (came,))


def _end(turn: Turn) -> Iterator[Row]:
    """Who cut it short, and how the turn is reported."""
    if (cut := turn.cut) is not None:
        state = strings.STATE_WORDS[cut.state].lower()
        scope, source = (strings.REASONS.get(why, why) for why in (cut.scope, cut.source))
        words = strings.CUT if scope == source else strings.CUT_BY
        text = words.format(scope=scope, source=source, state=state)
        yield Row("", (("■ ", "$text-warning"), (text, "$foreground")))
    if (result := turn.result) is not None:
        sign, style = RESULTS[result.outcome]
        yield Row("", ((f"{sign} ", style), (told(result.message) or strings.OUTCOMES[result.outcome], "$foreground")))
