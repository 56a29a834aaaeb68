"""What is sent over a line, and when: the clock of the reports, and what is left out while they come late."""

from __future__ import annotations

from tests.tui.desk import console
from tui.terminal.link import LIMIT_S, TRIES, Link, LinkFigures, Reports, Thrift
from tui.widgets.figures import link_words


def reporting() -> Reports:
    """Of a terminal that has reported once, at time 0."""
    reports = Reports()
    assert reports.sent(0.0)
    assert reports.came(0.0) == 0.0
    return reports


def test_the_next_frame_waits_for_the_report_of_the_last() -> None:
    reports = reporting()
    assert not reports.busy(1.0)
    assert reports.sent(1.0)
    assert reports.busy(1.3)
    assert reports.came(1.4) == 1.4 - 1.0
    assert not reports.busy(1.4)


def test_a_line_that_stalls_gets_a_frame_ever_more_rarely() -> None:
    reports, now, frames = reporting(), 1.0, []
    while now < 60:
        if not reports.busy(now):
            assert reports.sent(now)
            frames.append(now)
        now += 0.25
    assert frames == [1.0, 2.0, 4.0, 8.0, 16.0, 32.0]
    for _ in frames[:-1]:  # it goes on: the frames come through one after another
        assert reports.came(60.0) is not None
        assert reports.busy(60.1), "another one is still on its way"
    assert reports.came(60.2) is not None
    assert not reports.busy(60.2)


def test_a_report_that_is_lost_costs_one_wait_and_not_one_for_every_frame() -> None:
    reports = reporting()
    assert reports.sent(1.0)  # its report is lost
    late = 1.0 + LIMIT_S
    assert not reports.busy(late)
    assert reports.sent(late)
    assert reports.came(late + 0.1) is not None
    assert reports.busy(late + 0.2), "that one was taken for the lost one's"
    later = late + 0.1 + LIMIT_S
    assert reports.sent(later)
    assert reports.came(later + 0.1) is not None
    assert not reports.busy(later + 0.1)


def test_a_report_from_before_the_newest_frame_is_not_taken_for_that_one() -> None:
    link = Link()
    assert link.sent(0.0)
    link.reported(0.0)
    assert link.sent(1.0)
    link.reported(0.9)  # of a frame that was given up: it lay in the queue of a console that had much to do
    assert link.busy(1.1), "its own is still to come"
    assert not link.look(1.1, 0)
    link.reported(1.2)
    assert not link.busy(1.2)


def test_a_terminal_that_never_reports_is_asked_a_few_times_and_never_waited_for() -> None:
    reports, asked = Reports(), 0
    for step in range(400):
        assert not reports.busy(step / 20)
        asked += reports.sent(step / 20)
    assert asked == TRIES


def test_a_terminal_far_away_is_waited_for_before_it_has_ever_reported_but_not_for_ever() -> None:
    reports, frames = Reports(patient=True), 0
    for step in range(400):
        if not reports.busy(step / 20):
            reports.sent(step / 20)
            frames += 1
    assert frames == TRIES + 400 - 20 * TRIES * LIMIT_S


def test_a_report_that_nobody_asked_for_means_nothing() -> None:
    reports = Reports()
    assert reports.came(1.0) is None
    assert not reports.come


def changes(thrift: Thrift, start: float, seconds: float, delay: float | None) -> list[tuple[float, str]]:
    """When the fare changed and to what, looking twice a second."""
    times = [start + step / 2 for step in range(int(2 * seconds))]
    return [(t, thrift.fare) for t in times if thrift.look(t, delay)]


def test_a_bad_line_is_spared_at_once_and_gets_everything_back_step_by_step() -> None:
    thrift = Thrift()
    assert changes(thrift, 0, 5, 0.05) == []
    assert changes(thrift, 5, 5, 0.5) == [(5.0, "spare")]
    assert changes(thrift, 10, 5, 3.0) == [(10.0, "bare")]
    assert changes(thrift, 15, 60, 0.05) == [(25.0, "spare"), (35.5, "full")]


def test_a_delay_about_the_threshold_does_not_make_it_flicker() -> None:
    thrift = Thrift()
    assert thrift.look(0, 0.45)
    assert [t for step in range(200) if thrift.look(t := step / 2, 0.35 if step % 2 else 0.45)] == []


def test_a_line_that_is_bad_whenever_it_gets_everything_is_tried_ever_more_rarely() -> None:
    thrift, waits, sank, now = Thrift(), [], 0.0, 0.0
    while now < 300:
        if thrift.look(now, 0.5 if thrift.fare == "full" else 0.1):
            if thrift.fare == "full":
                waits.append(now - sank)
            else:
                sank = now
        now += 0.5
    assert waits == sorted(waits)
    assert waits[3] >= 4 * waits[0]


def test_who_knows_nothing_changes_nothing() -> None:
    thrift = Thrift()
    assert thrift.look(0, 2.0)
    assert changes(thrift, 1, 600, None) == []


def test_the_meter_tells_what_was_sent_in_the_last_seconds() -> None:
    link, written = Link(), 0
    for step in range(100):  # ten frames of 500 bytes a second, each of which takes 40 ms
        now = step / 10
        link.sent(now)
        link.reported(now + 0.04)
        written += 500
        if step % 5 == 4:
            assert not link.look(now, written)
    figures = link.figures(9.95)
    assert round(figures.delay or 0.0, 3) == 0.04
    assert (round(figures.bytes_per_s), round(figures.frames_per_s, 1)) == (5000, 10.0)
    assert link_words(figures, 40) == "delay 40 ms · 5.0 kB/s · 10.0/s"
    assert link_words(figures, 28) == "40 ms · 5.0 kB/s · 10.0/s", "on little room without words"
    assert link_words(figures, 20) == "40 ms · 5.0 kB/s", "and never with a figure that is cut"
    for step in range(20, 40):  # nothing more
        link.look(step / 2, written)
    assert link_words(link.figures(20.0), 40) == "delay – ms · 0.0 kB/s · 0.0/s"


def test_a_terminal_that_does_not_report_has_no_delay_and_no_worse_fare() -> None:
    link = Link()
    for step in range(200):
        link.sent(step / 10)
        assert not link.look(step / 10, 100_000 * step)
    assert link.figures(20.0).delay is None
    assert link_words(link.figures(20.0), 40).startswith("delay unknown")


def test_a_report_that_is_long_awaited_is_a_bad_line_before_it_comes() -> None:
    link = Link()
    link.sent(0.0)
    link.reported(0.01)
    link.sent(1.0)
    assert not link.look(2.0, 100)
    assert link.look(3.5, 100)
    assert link.fare == "bare"
    assert link.figures(3.5) == LinkFigures(2.5, 0.0, 0.0, True)


async def test_i_shows_how_good_the_line_is_and_takes_it_away() -> None:
    async with console() as desk:
        assert "delay unknown" not in desk.text
        await desk.press("i")
        assert "delay unknown" in desk.text
        await desk.press("i")
        assert "delay unknown" not in desk.text
