"""The reader of a wake module calls at once, says what is wrong once, and finds its module again."""

from __future__ import annotations

import contextlib
import os
import queue
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
import serial.tools.list_ports  # here, because the reader imports it when it needs it, perhaps as nobody
from pydantic import ValidationError

from config.schema import SerialWake
from engine.commands import Wake
from engine.serial_port import at, attached
from engine.wake import iflytek, ports, reader
from engine.wake.ai_voice import frame
from engine.wake.ports import opened
from engine.wake.reader import Listening, Lost, News, Remark, WakeReader
from tests.wake_module import AI_VOICE_WAKE, CSK4002_WAKE, LIMIT_S, WakeModule, ring_wake


class Heard:
    """What a reader says, in order; and whom it woke."""

    def __init__(self) -> None:
        self.wakes: queue.SimpleQueue[Wake] = queue.SimpleQueue()
        self.news: queue.SimpleQueue[News] = queue.SimpleQueue()
        self.seen: list[News] = []

    def wake(self) -> Wake:
        """The next wake."""
        return self.wakes.get(timeout=LIMIT_S)

    def until(self, met: Callable[[News], bool]) -> News:
        """The next news of which this is true."""
        while True:
            try:
                self.seen.append(self.news.get(timeout=LIMIT_S))
            except queue.Empty:
                raise AssertionError(f"It said no more than {self.seen}.") from None
            if met(self.seen[-1]):
                return self.seen[-1]

    def listening(self) -> str:
        """What it listens to next."""
        news = self.until(lambda one: isinstance(one, Listening))
        assert isinstance(news, Listening)
        return news.detail

    def lost(self) -> str:
        """Why it does not hear any more, or not at all, with what to do."""
        news = self.until(lambda one: isinstance(one, Lost))
        assert isinstance(news, Lost)
        return str(news.error)

    def silent(self) -> bool:
        """Whether nobody has been woken so far."""
        return self.wakes.empty()


@contextlib.contextmanager
def listening(port: Path | str, protocol: str = "auto", phrase: int | None = None) -> Iterator[Heard]:
    heard = Heard()
    settings = SerialWake.model_validate({"port": str(port), "protocol": protocol, "phrase": phrase})
    running = WakeReader(settings, heard.wakes.put, heard.news.put, prompt=False)
    running.start()
    try:
        yield heard
    finally:
        running.close()


@pytest.fixture
def module(tmp_path: Path) -> Iterator[WakeModule]:
    with WakeModule(tmp_path) as plugged:
        yield plugged


# Waking


@pytest.mark.parametrize(
    ("wake", "protocol", "called"),
    [
        (AI_VOICE_WAKE, "ai_voice", Wake("serial")),
        (CSK4002_WAKE, "csk4002", Wake("serial")),
        (ring_wake(137), "iflytek", Wake("serial", "hello", 137.0)),
    ],
)
@pytest.mark.parametrize("named", [True, False])
def test_every_module_wakes_named_or_not_byte_by_byte_or_at_once(
    module: WakeModule, wake: bytes, protocol: str, called: Wake, named: bool
) -> None:
    with listening(module.path, protocol if named else "auto") as heard:
        assert heard.listening() == (f"{protocol} on {module.path}" if named else str(module.path))
        module.say(*(wake[i : i + 1] for i in range(len(wake))))
        assert heard.wake() == called
        module.say(b"\x00\xaa$\xa5\x01" + wake)
        assert heard.wake() == called
        if not named:
            assert heard.listening() == f"{protocol} on {module.path}"


def test_other_frames_wake_nobody_and_are_told(module: WakeModule, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "QUIET_S", 0.0)
    with listening(module.path) as heard:
        heard.listening()
        module.say(frame(1, 0) + frame(4, 0) + frame(2, 0x6F) + b"$B019#")
        heard.until(lambda one: one == Remark("the module said: command word 19"))
        told = [one.text for one in heard.seen if isinstance(one, Remark)]
        assert [text.rpartition(": ")[2] for text in told] == ["welcome", "louder", "sleep", "command word 19"]
        assert heard.silent()


def test_a_module_that_never_stops_talking_does_not_fill_the_log(module: WakeModule) -> None:
    with listening(module.path) as heard:
        heard.listening()
        module.say(*[frame(4, 0)] * 200, AI_VOICE_WAKE)
        heard.wake()
        module.unplug()
        heard.lost()
        assert len([one for one in heard.seen if isinstance(one, Remark)]) < 10  # one a second


def test_of_several_wakes_that_come_together_the_newest_counts(module: WakeModule) -> None:
    with listening(module.path, "iflytek") as heard:
        heard.listening()
        module.say(ring_wake(10) + ring_wake(20) + ring_wake(30))
        assert heard.wake().angle_deg == 30
        module.say(ring_wake(40))
        assert heard.wake().angle_deg == 40


def test_the_wake_comes_before_everything_else_in_the_readers_own_thread(module: WakeModule) -> None:
    order: list[str] = []
    done = threading.Event()

    def wake(command: Wake) -> None:
        order.append(f"wake in {threading.current_thread().name}")
        done.set()

    def tell(news: News) -> None:
        if isinstance(news, Listening):
            order.append(news.detail)
            up.set()

    up = threading.Event()
    settings = SerialWake(port=str(module.path), protocol="auto", phrase=None)
    running = WakeReader(settings, wake, tell, prompt=False)
    running.start()
    assert up.wait(LIMIT_S)
    module.say(AI_VOICE_WAKE)
    assert done.wait(LIMIT_S)
    running.close()
    assert order == [str(module.path), "wake in wake-module", f"ai_voice on {module.path}"]


# What is sent


def test_the_phrase_is_played_after_the_wake(module: WakeModule) -> None:
    with listening(module.path, phrase=7) as heard:
        heard.listening()
        module.say(AI_VOICE_WAKE)
        assert module.hear(b"\xaa\x55\xff\x07\xfb") == b"\xaa\x55\xff\x07\xfb"
        module.say(CSK4002_WAKE)
        assert module.hear(b"$A007#") == b"$A007#"


def test_the_ring_is_greeted_where_it_is_named_and_only_answered_where_it_is_not(module: WakeModule) -> None:
    greeting = iflytek.IflytekRing().greeting
    ack = iflytek.frame(iflytek.ACK, 7, iflytek.CONFIRM)
    with listening(module.path, "iflytek") as heard:
        heard.listening()
        assert module.hear(greeting) == greeting
    with listening(module.path) as heard:
        heard.listening()
        module.say(ring_wake(number=7))
        assert module.hear(ack) == ack, "nothing was sent before it"


def test_a_module_that_takes_nothing_is_heard_all_the_same(module: WakeModule) -> None:
    with listening(module.path, phrase=1) as heard:
        heard.listening()
        for _ in range(5000):  # its answers pile up until the line takes no more
            module.say(AI_VOICE_WAKE)
            heard.wake()
            if any(isinstance(one, Remark) for one in _now(heard.news)):
                break
        else:
            pytest.fail("the line took everything")
        module.say(ring_wake(99))
        assert heard.wake().angle_deg == 99


def _now(news: queue.SimpleQueue[News]) -> list[News]:
    found: list[News] = []
    with contextlib.suppress(queue.Empty):
        while True:
            found.append(news.get_nowait())
    return found


# Unplugging


def test_a_module_that_is_unplugged_is_told_once_and_found_again(module: WakeModule) -> None:
    with listening(module.path) as heard:
        heard.listening()
        for _ in range(2):
            module.say(AI_VOICE_WAKE[:3])
            module.unplug()
            assert "The wake module is gone" in heard.lost()
            module.plug()
            assert str(module.path) in heard.listening()
            module.say(AI_VOICE_WAKE)
            heard.wake()
        assert len([one for one in heard.seen if isinstance(one, Lost)]) == 2


def test_a_name_that_goes_away_while_it_is_looked_at_is_one_that_is_not_there(
    module: WakeModule, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = os.readlink

    def gone(path: str, **options: int) -> str:
        module.unplug()
        return found(path, **options)

    monkeypatch.setattr(os, "readlink", gone)
    with pytest.raises(ports.PortError, match="There is no serial port"):
        ports.wanted(str(module.path))


def test_a_module_that_is_not_there_yet_is_found_when_it_comes(tmp_path: Path) -> None:
    module = WakeModule(tmp_path)
    with listening(module.path) as heard:
        assert heard.lost().startswith(f"There is no serial port {module.path}. Plug the wake module in")
        with module:
            heard.listening()
            module.say(CSK4002_WAKE)
            assert heard.wake() == Wake("serial")


def test_closing_ends_at_once_whether_there_is_a_module_or_not(module: WakeModule) -> None:
    with listening(module.path) as heard:
        heard.listening()
    with opened(str(module.path)):  # nobody holds it any more
        pass
    with listening("/dev/there/is/none") as heard:
        heard.lost()
    assert "wake-module" not in {thread.name for thread in threading.enumerate()}


def test_what_keeps_a_module_from_coming_back_is_told_too(module: WakeModule, tmp_path: Path) -> None:
    with listening(module.path) as heard:
        heard.listening()
        module.unplug()
        assert "is gone" in heard.lost()
        (tmp_path / "new").mkdir()
        with WakeModule(tmp_path / "new") as new, opened(str(new.path)) as other:
            module.path.symlink_to(device(new))
            assert "Another program has the serial port" in heard.lost()
            other.close()
            heard.listening()
            new.say(AI_VOICE_WAKE)
            heard.wake()


# What is wrong


@contextlib.contextmanager
def nobody() -> Iterator[None]:
    """Somebody who may open nothing."""
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(0)


def test_a_port_that_one_may_not_open_says_which_group_to_join(module: WakeModule) -> None:
    device = Path(os.path.realpath(module.path))
    device.chmod(0)
    with nobody(), listening(device) as heard:
        said = heard.lost()
    assert said == (
        f"You may not open the serial port {device}. "
        f"Join the group that may, and log in again: sudo usermod -aG {device.group()} $USER"
    )


def test_a_port_that_another_program_has_is_left_to_it(module: WakeModule) -> None:
    with opened(str(module.path)) as other, listening(module.path) as heard:
        assert "Another program has the serial port" in heard.lost()
        other.close()
        heard.listening()


def test_what_is_no_serial_port_says_so(tmp_path: Path) -> None:
    file = tmp_path / "notes.txt"
    file.write_text("no port")
    with listening(file) as heard:
        assert f"{file} cannot be used as a serial port" in heard.lost()


def test_a_port_on_which_something_else_talks_is_told_once(module: WakeModule) -> None:
    with listening(module.path) as heard:
        heard.listening()
        talk = [b"$GPGGA,123519,4807.038,N\r\n"] * 80
        module.say(*talk)
        heard.until(lambda one: isinstance(one, Remark))
        module.say(*talk, AI_VOICE_WAKE)
        heard.wake()
        module.unplug()
        heard.lost()
        odd = [one.text for one in heard.seen if isinstance(one, Remark) and one.odd]
        assert odd == [
            f"What comes from {module.path} are no frames of a wake module; is wake.serial.port the right one?"
        ]


@pytest.mark.parametrize(
    "wrong",
    [
        {"port": "ttyUSB0"},
        {"port": "1a86"},
        {"port": ""},
        {"protocol": "iflytek", "phrase": 1},
        {"protocol": "ai_voice", "phrase": 256},
        {"phrase": 1000},
        {"protocol": "other"},
    ],
)
def test_settings_that_cannot_be_meant_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        SerialWake.model_validate({"port": "/dev/ttyUSB0", "protocol": "auto", "phrase": None} | wrong)


# USB, of which this machine has none: what pyserial tells of it is played by the test


class Usb:
    """The USB serial ports that pyserial finds."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.ports: list[SimpleNamespace] = []
        self.looks = 0
        self.faults: list[Exception] = []
        self._looked = threading.Condition()
        monkeypatch.setattr(serial.tools.list_ports, "comports", self._comports)

    def _comports(self) -> list[SimpleNamespace]:
        with self._looked:
            self.looks += 1
            self._looked.notify_all()
        if self.faults:
            raise self.faults.pop()
        return list(self.ports)

    def until_looked(self) -> None:
        """Wait until all that is there now has been seen and dealt with."""
        with self._looked:
            until = self.looks + 3  # one may have begun, and the next may not be done
            assert self._looked.wait_for(lambda: self.looks >= until, LIMIT_S)

    def add(
        self, module: WakeModule, vid: int | None = 0x1A86, pid: int = 0x7523, number: str = "", location: str = "1-1"
    ) -> None:
        facts = {
            "vid": vid,
            "pid": pid,
            "serial_number": number or None,
            "description": "USB Serial",
            "location": location,
        }
        self.ports.append(SimpleNamespace(device=os.path.realpath(module.path), **facts))


@pytest.fixture
def usb(monkeypatch: pytest.MonkeyPatch) -> Usb:
    return Usb(monkeypatch)


@pytest.fixture
def modules(tmp_path: Path) -> Iterator[tuple[WakeModule, WakeModule]]:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
    with WakeModule(tmp_path / "one") as one, WakeModule(tmp_path / "two") as two:
        yield one, two


def device(module: WakeModule) -> str:
    return os.path.realpath(module.path)


def test_a_usb_device_is_found_by_its_numbers(usb: Usb, modules: tuple[WakeModule, WakeModule]) -> None:
    other, ours = modules
    usb.add(other, 0x10C4, 0xEA60)
    usb.add(ours, 0x1A86, 0x7523, "A7")
    for name in ("1a86:7523", "1A86:7523:A7"):
        with listening(name) as heard:
            assert heard.listening() == device(ours)
            ours.say(AI_VOICE_WAKE)
            heard.wake()
    for name in ("1a86:7522", "1a86:7523:A8"):
        with listening(name) as heard:
            assert heard.lost().startswith(f"There is no serial port of a USB device {name}.")


def test_auto_listens_to_every_usb_port_and_keeps_the_one_that_wakes(
    usb: Usb, modules: tuple[WakeModule, WakeModule]
) -> None:
    board, ours = modules
    usb.add(board)
    usb.add(ours)
    with listening("auto") as heard:
        assert heard.listening() == f"{device(board)}, {device(ours)}"
        board.say(b"\xff\xfb\x0a\x0c" * 100)
        ours.say(CSK4002_WAKE)
        heard.wake()
        assert heard.listening() == f"csk4002 on {device(ours)}"
        with opened(device(board)):  # it has been let go
            pass
        ours.say(CSK4002_WAKE)
        heard.wake()


def test_auto_leaves_other_ports_alone_and_waits_for_one_to_come(
    usb: Usb, modules: tuple[WakeModule, WakeModule]
) -> None:
    console, ours = modules
    usb.add(console, None)
    with listening("auto") as heard:
        assert heard.lost().startswith("There is no USB serial port.")
        usb.add(ours)
        assert heard.listening() == device(ours)


def test_nobody_looks_for_ports_because_something_came(
    usb: Usb, module: WakeModule, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reader, "PAUSES_S", (2 * LIMIT_S,))
    usb.add(module)
    with listening("auto") as heard:
        heard.listening()
        looks = usb.looks
        module.say(frame(1, 0))
        heard.until(lambda one: isinstance(one, Remark))
        module.say(AI_VOICE_WAKE)
        heard.wake()
        assert usb.looks == looks


@pytest.mark.parametrize(
    "fault", [TypeError("int() can't convert"), ValueError("invalid literal"), OSError(19, "gone")]
)
def test_a_look_while_a_device_is_being_unplugged_finds_nothing_and_the_next_one_does(
    usb: Usb, module: WakeModule, fault: Exception
) -> None:
    usb.add(module)
    usb.faults.append(fault)
    with listening("auto") as heard:
        assert heard.lost().startswith("There is no USB serial port.")
        assert heard.listening() == device(module)
        module.say(AI_VOICE_WAKE)
        heard.wake()


@pytest.mark.parametrize("setting", ["auto", "path"])
def test_a_usb_module_is_known_again_under_another_name(
    usb: Usb, tmp_path: Path, modules: tuple[WakeModule, WakeModule], setting: str
) -> None:
    board, ours = modules
    usb.add(board, 0x10C4)
    usb.add(ours, number="A7")
    with listening("auto" if setting == "auto" else device(ours)) as heard:
        heard.listening()
        ours.say(AI_VOICE_WAKE)
        heard.wake()
        old = device(ours)
        usb.ports.pop()
        ours.unplug()
        assert "is gone" in heard.lost()
        with WakeModule(tmp_path):  # something else has its name now
            if setting == "path":
                assert f"{old} is another device now" in heard.lost()
            assert device(ours.plug()) != old
            usb.add(ours, number="A7")
            heard.until(lambda one: isinstance(one, Listening) and one.detail == device(ours))
            ours.say(ring_wake(5))
            assert heard.wake().angle_deg == 5
    assert not any(device(board) in str(news) for news in heard.seen[2:]), "what is not it is not taken for it"


def unplugged(usb: Usb, heard: Heard, module: WakeModule) -> None:
    """The module is gone, and that has been noticed."""
    usb.ports = [port for port in usb.ports if port.device != device(module)]
    module.unplug()
    assert "is gone" in heard.lost()


SAME_CHIP = pytest.mark.parametrize(
    ("setting", "number"),
    [("auto", ""), ("1a86:7523", ""), ("path", ""), ("auto", "0001"), ("1a86:7523:0001", "0001"), ("path", "0001")],
)
"""Chips without a serial number, and those that all have the same."""


@SAME_CHIP
def test_a_board_with_the_modules_chip_is_never_taken_for_it(
    usb: Usb, modules: tuple[WakeModule, WakeModule], monkeypatch: pytest.MonkeyPatch, setting: str, number: str
) -> None:
    monkeypatch.setattr(reader, "PAUSES_S", (0.01,))
    board, ours = modules
    usb.add(ours, number=number)
    with listening(device(ours) if setting == "path" else setting, "iflytek") as heard:
        heard.listening()
        usb.add(board, number=number, location="1-2")  # later, so that it is not even greeted once
        ours.say(ring_wake(5))
        heard.wake()
        unplugged(usb, heard, ours)
        usb.until_looked()
        with opened(device(board)) as robot:
            assert robot.read(4096) == b"", "nothing was sent to it"
            usb.until_looked()
        board.say(ring_wake(99))
        usb.until_looked()
        usb.add(ours.plug(), number=number)
        assert heard.listening() == f"iflytek on {device(ours)}"
        ours.say(ring_wake(6))
        assert heard.wake().angle_deg == 6
        assert board.heard() == b""


@pytest.mark.parametrize("setting", ["auto", "1a86:7523", "path"])
def test_a_module_without_a_serial_number_that_is_plugged_in_elsewhere_is_found_when_it_calls(
    usb: Usb, modules: tuple[WakeModule, WakeModule], monkeypatch: pytest.MonkeyPatch, setting: str
) -> None:
    monkeypatch.setattr(reader, "PAUSES_S", (0.01,))
    board, ours = modules
    usb.add(ours)
    with listening(device(ours) if setting == "path" else setting, "iflytek") as heard:
        heard.listening()
        ours.say(ring_wake(5))
        heard.wake()
        unplugged(usb, heard, ours)
        board.unplug()
        usb.add(ours.plug(), location="1-3")
        usb.add(board.plug(), location="1-2")  # it comes anew, and may be the module as well
        usb.until_looked()
        assert ours.heard() == b"", "nothing is written to what may be a motor board"
        ours.say(ring_wake(6))
        assert heard.wake().angle_deg == 6
        assert heard.listening() == f"iflytek on {device(ours)}"
        assert board.heard() == b""
        with opened(device(board)):  # it has been let go
            pass


def test_a_link_to_whatever_has_the_modules_chip_does_not_make_a_board_the_module(
    usb: Usb, modules: tuple[WakeModule, WakeModule]
) -> None:
    board, ours = modules
    usb.add(ours)
    usb.add(board, location="1-2")
    link = ours.path.parent / "usb-1a86_USB_Serial"  # the same for both of them
    link.symlink_to(device(ours))
    with listening(link) as heard:
        heard.listening()
        ours.say(AI_VOICE_WAKE)
        heard.wake()
        link.unlink()
        link.symlink_to(device(board))
        unplugged(usb, heard, ours)
        assert f"{link} is another device now" in heard.lost()


def test_ports_are_listed_with_how_a_setting_names_them(usb: Usb, module: WakeModule) -> None:
    usb.add(module)
    (port,) = attached()
    assert (port.path, port.named) == (device(module), "USB Serial 1a86:7523")
    assert at(str(module.path)) == port
