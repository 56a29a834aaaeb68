"""Wake modules are understood by their bytes alone: every whole frame is found, only a wake wakes, nothing raises."""

from __future__ import annotations

import gzip
import json
from typing import Any

import msgspec
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from engine.framing import Framer
from engine.wake import ai_voice, iflytek
from engine.wake.ai_voice import AiVoice
from engine.wake.csk4002 import Csk4002
from engine.wake.iflytek import IflytekRing
from engine.wake.module import Called, Frame, Module, Told
from tests.wake_module import AI_VOICE_WAKE, CSK4002_WAKE, ring_wake

RING_WAKE = ring_wake()
MODULES: list[tuple[Module, bytes]] = [
    (AiVoice(), AI_VOICE_WAKE),
    (AiVoice(bilingual=True), bytes.fromhex("AA 55 04 00 FB")),
    (Csk4002(), CSK4002_WAKE),
    (IflytekRing(), RING_WAKE),
]
each_module = pytest.mark.parametrize(("module", "wake"), MODULES, ids=[module.name for module, _ in MODULES])


def heard(module: Module, *pieces: bytes) -> list[Frame]:
    framer = Framer(module)
    return [frame for piece in pieces for frame in framer.push(piece)]


def calls(frames: list[Frame]) -> list[Called]:
    return [frame for frame in frames if isinstance(frame, Called)]


def message(content: Any, number: int = 7, pack: bool = False) -> bytes:
    data = json.dumps(content, separators=(",", ":")).encode()
    return iflytek.frame(iflytek.MESSAGE, number, gzip.compress(data) if pack else data)


def event(info: Any, number: int = 7) -> bytes:
    return message({"type": "aiui_event", "content": {"eventType": 4, "info": info}}, number)


# The stream


@each_module
def test_a_frame_is_found_however_it_is_split(module: Module, wake: bytes) -> None:
    whole = heard(module, wake)
    assert len(calls(whole)) == 1
    assert heard(module, *(wake[i : i + 1] for i in range(len(wake)))) == whole
    for cut in range(1, len(wake)):
        assert heard(module, wake[:cut], wake[cut:]) == whole


@each_module
def test_frames_in_one_piece_are_all_found(module: Module, wake: bytes) -> None:
    assert len(calls(heard(module, wake * 3))) == 3


@each_module
def test_a_frame_that_was_cut_off_does_not_harm_the_next_one(module: Module, wake: bytes) -> None:
    for cut in range(1, len(wake)):
        assert len(calls(heard(module, wake[:cut], wake))) == 1


def alphabet(wake: bytes) -> st.SearchStrategy[bytes]:
    """Garbage that is made to mislead: the bytes of a frame in another order, beginnings, and anything at all."""
    pieces = st.sampled_from([wake[:length] for length in range(1, min(8, len(wake)))])
    scattered = st.lists(st.sampled_from(sorted(set(wake[:8]) | {wake[-1]})), max_size=12).map(bytes)
    return st.lists(st.one_of(pieces, scattered, st.binary(max_size=12)), max_size=5).map(b"".join)


@pytest.mark.parametrize(("module", "wake"), [MODULES[0], MODULES[2]], ids=["ai_voice", "csk4002"])
@given(data=st.data())
def test_every_wake_in_any_garbage_is_found_and_nothing_else_is(
    module: Module, wake: bytes, data: st.DataObject
) -> None:
    garbage = alphabet(wake)
    stream = b"".join(data.draw(garbage) + wake for _ in range(data.draw(st.integers(0, 3)))) + data.draw(garbage)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    assert len(calls(heard(module, *pieces))) == stream.count(wake)


@given(data=st.data())
def test_every_message_of_the_ring_in_any_garbage_is_found_and_nothing_else_is(data: st.DataObject) -> None:
    angles = data.draw(st.lists(st.integers(0, 359), max_size=4))
    garbage = alphabet(RING_WAKE)
    stream = b"".join(data.draw(garbage) + ring_wake(angle, angle) for angle in angles) + data.draw(garbage)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    assert [call.angle_deg for call in calls(heard(IflytekRing(), *pieces))] == angles


@each_module
@given(data=st.data())
def test_where_the_stream_was_cut_makes_no_difference(module: Module, wake: bytes, data: st.DataObject) -> None:
    stream = b"".join(data.draw(st.lists(alphabet(wake) | st.just(wake), max_size=6)))
    assert heard(module, *(stream[i : i + 1] for i in range(len(stream)))) == heard(module, stream)


@each_module
@given(noise=st.binary(max_size=3000))
@example(noise=b"\xa5\x01\x04" * 1000)
@example(noise=b"\xa5\x01\x04\xff\x0f\x00\x00" * 400)
@example(noise=b"\xaa\x55" * 1500)
@example(noise=b"$B000" * 600)
def test_no_bytes_raise_wake_or_pile_up(module: Module, wake: bytes, noise: bytes) -> None:
    framer = Framer(module)
    frames = [frame for at in range(0, len(noise), 64) for frame in framer.push(noise[at : at + 64])]
    assert len(framer._bytes) <= module.longest
    if wake not in noise and module.name != "ai_voice_bilingual":
        assert calls(frames) == []
    assert len(calls(framer.push(wake))) == 1, "it hears a wake at once, whatever came before"


def test_a_length_that_lies_does_not_keep_the_next_frame_waiting() -> None:
    liar = b"\xa5\x01\x04\xff\x0f\x07\x00"  # 4095 bytes are to follow
    framer = Framer(IflytekRing())
    assert framer.push(liar) == []
    assert len(calls(framer.push(RING_WAKE[:-1]) + framer.push(RING_WAKE[-1:]))) == 1


# The AI voice module


@pytest.mark.parametrize(
    ("sent", "what"),
    [
        ("AA 55 01 00 FB", "welcome"),
        ("AA 55 02 6F FB", "sleep"),
        ("AA 55 04 00 FB", "louder"),
        ("AA 55 05 00 FB", "quieter"),
        ("AA 55 00 03 FB", "command word 3"),
        ("AA 55 FF 02 FB", "phrase 2"),
        ("AA 55 03 01 FB", "frame 03 01"),
        ("AA 55 11 22 FB", "frame 11 22"),
    ],
)
def test_welcome_volume_sleep_and_the_rest_of_the_ai_voice_module_wake_nobody(sent: str, what: str) -> None:
    assert heard(AiVoice(), bytes.fromhex(sent)) == [Told(what)]


def test_the_wake_of_the_ai_voice_module_is_exactly_one_frame() -> None:
    frames = [ai_voice.frame(what, number) for what in range(256) for number in range(256)]
    assert [frame for frame in frames if calls(heard(AiVoice(), frame))] == [bytes.fromhex("AA 55 03 00 FB")]


def test_the_bilingual_firmware_is_woken_in_two_languages() -> None:
    def phrase(sent: str) -> list[str]:
        return [call.phrase for call in calls(heard(AiVoice(bilingual=True), bytes.fromhex(sent)))]

    assert [phrase(f"AA 55 {what:02X} 00 FB") for what in (1, 2, 3)] == [["Chinese wake word"]] * 3
    assert [phrase(f"AA 55 {what:02X} 00 FB") for what in (4, 5, 9)] == [["English wake word"]] * 3
    assert phrase("AA 55 02 6F FB") == phrase("AA 55 00 01 FB") == phrase("AA 55 FF 01 FB") == []


def test_the_ai_voice_module_plays_a_phrase() -> None:
    assert AiVoice().play(2) == bytes.fromhex("AA 55 FF 02 FB")
    assert AiVoice().play(256) is None


# The CSK4002


def test_only_number_0_of_the_csk4002_is_a_wake() -> None:
    assert heard(Csk4002(), b"$B000#") == [Called()]
    assert heard(Csk4002(), b"$B019#\r\n$A000#") == [Told("command word 19"), Told("phrase 0")]
    assert heard(Csk4002(), b"$b000#$B00#$B0000#$C000#$B00x#B000#") == []


def test_the_csk4002_plays_a_phrase() -> None:
    assert Csk4002().play(19) == b"$A019#"
    assert Csk4002().play(1000) is None


# The ring


def test_the_frames_of_the_ring_are_as_its_makers_write_them() -> None:
    handshake = bytes.fromhex("A5 01 01 04 00 00 00 A5 00 00 00 B0")
    ack = bytes.fromhex("A5 01 FF 04 00 00 00 A5 00 00 00 B2")
    assert IflytekRing().greeting == handshake
    assert heard(IflytekRing(), handshake) == [Told("handshake", ack)]
    assert heard(IflytekRing(), ack) == [Told("acknowledged")]


def test_the_ring_tells_who_called_from_where_and_is_answered_under_the_same_number() -> None:
    (call,) = heard(IflytekRing(), ring_wake(137, number=0x0102))
    assert call == Called("hello", 137.0, iflytek.frame(iflytek.ACK, 0x0102, iflytek.CONFIRM))


@pytest.mark.parametrize(
    ("info", "angle"),
    [
        ('{"ivw":{"angle":0}}', 0),
        ('{"ivw":{"angle":359.5}}', 359.5),
        ('{"ivw":{"angle":360}}', 0),
        ({"ivw": {"angle": 90}}, 90),
        ({"angle": 135, "beam": 3}, 135),
        ('{"ivw":{"angle":-1}}', None),
        ('{"ivw":{"angle":361}}', None),
        ('{"ivw":{"angle":1e300}}', None),
        ('{"ivw":{"angle":true}}', None),
        ('{"ivw":{"angle":"north"}}', None),
        ('{"ivw":{"angle":' + "9" * 3000 + "}}", None),
        ('{"ivw":7}', None),
        ("not JSON", None),
        ("[" * 1000, None),
        (None, None),
    ],
)
def test_a_wake_without_a_believable_angle_is_a_wake_all_the_same(info: Any, angle: float | None) -> None:
    (call,) = heard(IflytekRing(), event(info))
    assert isinstance(call, Called)
    assert call.angle_deg == angle


@pytest.mark.parametrize(
    ("sent", "what"),
    [
        ({"type": "aiui_event", "content": {"eventType": 5}}, "event 5"),
        ({"type": "aiui_event", "content": {"eventType": "4"}}, "event 4"),
        ({"type": "aiui_event", "content": {"eventType": True}}, "event True"),
        ({"type": "aiui_event", "content": 4}, "message aiui_event"),
        ({"type": "wifi_status", "content": {"eventType": 4}}, "message wifi_status"),
        ({"type": [[]]}, "message of an unknown kind"),
        ({"type": 10**100}, "message of an unknown kind"),
        ({"type": "x" * 500}, "message " + "x" * 60),
        ({}, "message of an unknown kind"),
    ],
)
def test_other_messages_of_the_ring_wake_nobody_and_are_acknowledged(sent: Any, what: str) -> None:
    ack = iflytek.frame(iflytek.ACK, 7, iflytek.CONFIRM)
    assert heard(IflytekRing(), message(sent)) == [Told(what, ack)]


def test_messages_that_are_packed_are_unpacked() -> None:
    wake = {"type": "aiui_event", "content": {"eventType": 4, "info": '{"ivw":{"angle":45}}'}}
    (call,) = calls(heard(IflytekRing(), message(wake, pack=True)))
    assert call.angle_deg == 45


def test_a_message_that_unpacks_to_too_much_is_no_message() -> None:
    bomb = message({"type": "aiui_event", "content": {"eventType": 4, "info": " " * 200_000}}, pack=True)
    assert len(bomb) < iflytek.MAX_DATA
    assert heard(IflytekRing(), bomb) == []


@pytest.mark.parametrize(
    "data", [b"", b"7", b"[]", b"null", b"\xff\xfe", b"\x1f\x8b", b"\x1f\x8b\x08\x00rubbish", b"{"]
)
def test_what_is_no_json_object_is_no_message(data: bytes) -> None:
    assert heard(IflytekRing(), iflytek.frame(iflytek.MESSAGE, 7, data)) == []


def test_a_wrong_check_is_no_frame() -> None:
    for at in range(len(RING_WAKE)):
        broken = bytearray(RING_WAKE)
        broken[at] ^= 0x10
        assert calls(heard(IflytekRing(), bytes(broken))) == []


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: (
            st.lists(inner)
            | st.dictionaries(
                st.sampled_from(["type", "content", "eventType", "info", "ivw", "angle", "keyword"]), inner
            )
        ),
    )
)
def test_no_message_raises(content: Any) -> None:
    for sent in (content, {"type": "aiui_event", "content": {"eventType": 4, "info": content}}):
        data = msgspec.json.encode(sent)
        if len(data) <= iflytek.MAX_DATA:
            heard(IflytekRing(), iflytek.frame(iflytek.MESSAGE, 1, data))
