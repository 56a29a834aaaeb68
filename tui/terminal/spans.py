"""What is sent to the terminal of a change: the changed characters, and not all of the line before them.

Textual knows exactly which cells have changed, but writes each widget's line from its left edge up to them. On a map,
or on a picture, that is most of what goes over the line. Here a span begins where it begins.

And no character of two columns is torn: Textual cuts a line wherever any widget ends, also one that lies under another,
and leaves two blanks of a character that a cut goes through.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import accumulate

from rich.cells import cell_len
from rich.console import Console, RenderableType
from rich.control import Control
from textual._compositor import ChopsUpdate, Compositor, LayoutUpdate
from textual.geometry import Region
from textual.strip import Strip


class SpansUpdate(ChopsUpdate):
    """The same update, cropped at both ends."""

    def render_segments(self, console: Console) -> str:
        """Everything that is written, with the moves of the cursor in between."""
        written: list[str] = []
        for y, first, last in self.spans:
            for cut, (x, strip) in zip(self.chop_ends[y], self.chops[y].items(), strict=False):
                if strip is None or not strip.cell_length:
                    continue
                end = max(cut, x + strip.cell_length)
                if x >= last or end <= first:
                    continue
                begin, until = _whole(strip, max(x, first) - x, min(end, last) - x)
                written += [Control.move_to(x + begin, y).segment.text, strip.crop(begin, until).render(console)]
        return "".join(written)


class WholeCompositor(Compositor):
    """Textual's, but that a line is not cut in a character with all of it in sight."""

    def _render_chops(self, crop: Region, is_rendered_line: Callable[[int], bool]) -> Sequence[Mapping[int, Strip]]:
        cuts = self.cuts
        chops: list[dict[int, Strip]] = [{} for _ in cuts]
        for region, clip, strips in self._get_renders(crop):  # from front to back: the first one there stays
            shown = region.intersection(clip)
            left, right = shown.column_span
            for y, strip in zip(shown.line_range, strips, strict=False):
                if not is_rendered_line(y):
                    continue
                here = [cut for cut in cuts[y] if left <= cut <= right]
                pieces = _divided(strip, shown.x, here, [cut for cut in here if cut not in chops[y]])
                for cut, piece in zip(here, pieces, strict=False):
                    chops[y].setdefault(cut, piece)
        return [
            {cut: line.get(cut) for cut in line_cuts[:-1]}  # type: ignore[misc]
            for line, line_cuts in zip(chops, cuts, strict=True)
        ]


def _divided(strip: Strip, x: int, cuts: Sequence[int], free: Sequence[int]) -> Iterable[Strip]:
    """The strip, which begins at column ``x``, between neighbours of ``cuts``. Where a cut goes through a character and
    what is on both sides of it is ``free`` for this strip, the left piece goes on to the next cut."""
    ends = [cut - x for cut in cuts[1:]]
    if ends[:1] == [strip.cell_length]:
        return (strip,)  # divide() would keep it in its own cache: a cycle for each line of each picture
    if len(ends) < 2 or len(text := strip.text) == strip.cell_length:
        return strip.divide(ends)
    whole = set(accumulate(map(cell_len, text)))
    torn = {
        number
        for number, end in enumerate(ends[:-1])
        if end < strip.cell_length and end not in whole and cuts[number] in free and cuts[number + 1] in free
    }
    pieces = iter(strip.divide([end for number, end in enumerate(ends) if number not in torn]))
    return _with_gaps(pieces, torn, len(ends))


def _with_gaps(pieces: Iterator[Strip], torn: Collection[int], count: int) -> Iterator[Strip]:
    """The pieces, and nothing behind each whose end was torn; a strip may end before the last cut."""
    for number in range(count):
        piece = Strip([], 0) if number - 1 in torn else next(pieces, None)
        if piece is None:
            return
        yield piece


def _whole(strip: Strip, begin: int, end: int) -> tuple[int, int]:
    """From and to which column of a strip nothing is torn that lies in these columns."""
    text = strip.text
    if len(text) == strip.cell_length:
        return begin, end
    edges = (0, *accumulate(map(cell_len, text)))
    return (begin if begin in edges else begin - 1), (end if end in edges else end + 1)


def cropped(renderable: RenderableType | None) -> RenderableType | None:
    """Whatever is to be displayed, as it is to be written."""
    if isinstance(renderable, ChopsUpdate):
        return SpansUpdate(renderable.chops, renderable.spans, renderable.chop_ends)
    return renderable


def regions(renderable: RenderableType | None) -> frozenset[Region]:
    """The parts of the screen that the update was to change, so that they can be drawn later, as they are then."""
    if isinstance(renderable, ChopsUpdate):
        return frozenset(Region(first, y, last - first, 1) for y, first, last in renderable.spans)
    return frozenset([renderable.region]) if isinstance(renderable, LayoutUpdate) else frozenset()
