"""A large model is asked in the protocol that it speaks; whatever it does, the answer is one error or one reply."""

from __future__ import annotations

import asyncio
import base64
import json
import logging
import subprocess
import sys
import traceback
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from pydantic import SecretStr

import engine.llm.openai
from config.schema import Platform
from engine.llm.chat import Ask, ChatError, KeyWanted, Message, Refused, Reply, TooSlow, Unreachable, Unreadable
from engine.llm.openai import OpenAIChat
from engine.llm.service import LONGEST_PAUSE_S, PAUSE_S, TRIES, back_off
from engine.llm.service import Service as PlatformService
from engine.llm.transport import MAX_BYTES
from tests.model_service import (
    HANGS_UP,
    SECRET,
    SILENCE,
    STREAM,
    Answer,
    Service,
    Unfinished,
    answer,
    chunk,
    event,
    reply,
    serving,
    streamed,
)

PNG = b"\x89PNG\r\n\x1a\n..."
QUESTION = Ask((Message("system", "Be brief."), Message("user", "What is this?", PNG)))
CUP = Reply("A cup.", "cloud")


@pytest.fixture(autouse=True)
def _no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.llm.service.PAUSE_S", 0)


def with_service(test: Callable[[Service], Awaitable[None]], *answers: Answer) -> None:
    async def run() -> None:
        async with serving(*answers) as service:
            await test(service)

    asyncio.run(run())


@asynccontextmanager
async def chatting(service: Service, **changes: Any) -> AsyncIterator[OpenAIChat]:
    chat = OpenAIChat("cloud", service.platform(**changes))
    try:
        yield chat
    finally:
        await chat.close()


def asked(*answers: Answer, requests: int = 1, ask: Ask = QUESTION, **changes: Any) -> Reply | ChatError:
    """What becomes of one question to a service that gives these answers."""
    found: list[Reply | ChatError] = []

    async def test(service: Service) -> None:
        async with chatting(service, **changes) as chat:
            try:
                found.append(await chat.reply(ask))
            except ChatError as error:
                found.append(error)
        assert len(service.asked) == requests

    with_service(test, *answers)
    return found[0]


def test_a_question_with_a_picture_is_sent_as_chat_completions_want_it() -> None:
    async def test(service: Service) -> None:
        async with chatting(service) as chat:
            assert await chat.reply(QUESTION) == CUP
        [request] = service.asked
        assert request.line == "POST /v1/chat/completions HTTP/1.1"
        assert request.headers["authorization"] == f"Bearer {SECRET}"
        assert request.headers["content-type"] == "application/json"
        assert request.body["model"] == "one-that-sees"
        assert (request.body["temperature"], request.body["seed"], request.body["max_tokens"]) == (0, 0, 512)
        assert "response_format" not in request.body
        system, user = request.body["messages"]
        assert system == {"role": "system", "content": "Be brief."}
        assert user["role"] == "user"
        text, picture = user["content"]
        assert text == {"type": "text", "text": "What is this?"}
        head, _, data = picture["image_url"]["url"].partition(",")
        assert (picture["type"], head) == ("image_url", "data:image/png;base64")
        assert base64.b64decode(data) == PNG

    with_service(test, answer(" A cup.\n"))


def test_nothing_of_the_environment_and_of_this_machine_goes_to_the_service(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("API_KEY", "ADMIN_KEY", "ORG_ID", "PROJECT_ID", "CUSTOM_HEADERS"):
        monkeypatch.setenv(f"OPENAI_{name}", "X-Mine: mine")
    monkeypatch.setenv("OPENAI_BASE_URL", "http://127.0.0.1:1/v1")

    async def test(service: Service) -> None:
        async with chatting(service, api_key=None) as chat:
            await chat.reply(QUESTION)
        headers = service.asked[0].headers
        assert "mine" not in str(headers)
        assert headers.keys() <= {
            *("host", "connection", "accept", "accept-encoding", "content-type", "content-length", "user-agent")
        }

    with_service(test, answer("A cup."))


def test_where_no_key_is_set_none_is_sent() -> None:
    async def test(service: Service) -> None:
        async with chatting(service, api_key=None) as chat:
            await chat.reply(QUESTION)
        assert "authorization" not in service.asked[0].headers

    with_service(test, answer("A cup."))


@pytest.mark.parametrize(
    ("said", "understood"),
    [
        ([{"type": "text", "text": "A cup"}, {"type": "text", "text": " of tea."}], "A cup of tea."),
        ("<think>Is it a cup?\nIt is.</think>\n\nA cup.", "A cup."),
        (f"Your key is {SECRET}.", "Your key is ********."),
    ],
)
def test_an_answer_is_read_in_every_usual_form(said: Any, understood: str) -> None:
    assert asked(answer(said)) == Reply(understood, "cloud")


@pytest.mark.parametrize("first", [reply(429, {}), reply(500, {}), reply(503, b"busy"), HANGS_UP])
def test_what_may_pass_is_tried_again(first: bytes) -> None:
    assert asked(first, answer("A cup."), requests=2) == CUP
    assert asked(first, first, answer("A cup."), requests=3) == CUP


@pytest.mark.parametrize(
    ("told", "requests", "kind", "words"),
    [
        (reply(429, {"error": {"message": "Slow down."}}), TRIES, Refused, "429: Slow down. Wait a while"),
        (reply(500, {"detail": "Out of memory"}), TRIES, Refused, "500: Out of memory. Try again later."),
        (
            reply(401, {"error": {"message": f"Wrong key {SECRET}"}}),
            1,
            Refused,
            "401: Wrong key ********. Check the key",
        ),
        (
            reply(404, b"<html>\x1b[31mnot\nhere"),
            1,
            Refused,
            "404: <html> [31mnot here. Check platforms.cloud.base_url",
        ),
        (reply(400, {"error": "x" * 5000}), 1, Refused, "xxx…. Check platforms.cloud.model"),
        (reply(200, {"error": {"message": "No such model"}}), 1, Refused, "No such model"),
        (HANGS_UP, TRIES, Unreachable, "cannot be reached at 127.0.0.1"),
        (reply(200, b"\xff<html>"), 1, Unreadable, "not what a chat completion looks like"),
        (reply(200, {"choices": "none"}), 1, Unreadable, "not what a chat completion looks like"),
        (reply(200, {"choices": []}), 1, Unreadable, "there is nothing in it"),
        (answer(None), 1, Unreadable, "there is nothing in it"),
        (answer("x" * MAX_BYTES), 1, Unreadable, "longer than 8 MB"),
        (b"SSH-2.0-somebody else\r\n", TRIES, Unreachable, "cannot be reached at 127.0.0.1"),
        (answer("\ud800"), 1, Unreadable, "not what a chat completion looks like"),
        (reply(200, b"[" * 100_000), 1, Unreadable, "not what a chat completion looks like"),
        (reply(200, {"choices": [], "usage": {"prompt_tokens": 10**400}}), 1, Unreadable, "not what a chat completion"),
        (reply(400, {"code": 10**400, "error": {"message": "\ud800"}}), 1, Refused, "status 400"),
    ],
)
def test_every_failure_says_what_happened_and_what_to_do(
    told: Answer, requests: int, kind: type[ChatError], words: str
) -> None:
    found = asked(told, requests=requests)
    assert type(found) is kind
    assert words in str(found)
    assert found.hint
    assert len(str(found)) < 400
    assert str(found).isprintable()


def test_a_service_that_wants_a_key_says_where_to_give_it_one() -> None:
    found = asked(reply(401, {"error": {"message": "No key"}}), api_key=None)
    assert type(found) is KeyWanted
    assert "platforms.cloud.api_key" in found.hint


def test_nobody_at_the_address_is_unreachable() -> None:
    async def run() -> None:
        async with serving(answer("")) as service:
            pass
        async with chatting(service) as chat:
            with pytest.raises(Unreachable, match=r"platforms\.cloud\.base_url"):
                await chat.reply(QUESTION)

    asyncio.run(run())


def test_a_redirect_is_not_followed() -> None:
    async def run() -> None:
        async with serving(answer("I am somebody else.")) as other:
            away = reply(307, {}, Location=f"http://127.0.0.1:{other.port}/v1/chat/completions")
            async with serving(away) as service, chatting(service) as chat:
                with pytest.raises(Refused, match="sends one elsewhere"):
                    await chat.reply(QUESTION)
            assert not other.asked

    asyncio.run(run())


def test_a_proxy_of_the_environment_gets_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    async def run() -> None:
        async with serving(answer("I am a proxy.")) as proxy, serving(answer("A cup.")) as service:
            for name in ("http_proxy", "all_proxy"):
                monkeypatch.setenv(name, f"http://127.0.0.1:{proxy.port}")
            async with chatting(service) as chat:
                assert await chat.reply(QUESTION) == CUP
            assert not proxy.asked

    asyncio.run(run())


def test_a_model_of_this_machine_is_asked_at_its_socket(tmp_path: Path) -> None:
    async def run() -> None:
        uds = tmp_path / "model"
        async with serving(streamed("A cup."), HANGS_UP, uds=uds) as service:
            platform = service.platform(kind="local", base_url=None, api_key=None)
            chat = OpenAIChat("home", platform, kind="local", uds=uds, extra={"id_slot": 1})
            assert await chat.reply(QUESTION) == Reply("A cup.", "home", "local")
            assert service.asked[0].line == "POST /v1/chat/completions HTTP/1.1"
            assert service.asked[0].body["id_slot"] == 1
            with pytest.raises(Unreachable, match=r"home cannot be reached at its socket: .*\. Ask again\."):
                await chat.reply(QUESTION)
            await chat.close()

    asyncio.run(run())


# What comes piece by piece


def heard(*answers: Answer, requests: int = 1, **changes: Any) -> tuple[list[str], Reply | ChatError]:
    """The pieces of an answer as they were heard, and what became of it."""
    pieces: list[str] = []
    found: list[Reply | ChatError] = []

    async def test(service: Service) -> None:
        async with chatting(service, **changes) as chat:
            try:
                found.append(await chat.reply(QUESTION, pieces.append))
            except ChatError as error:
                found.append(error)
        assert len(service.asked) == requests

    with_service(test, *answers)
    return pieces, found[0]


def test_an_answer_is_heard_while_it_comes() -> None:
    async def test(service: Service) -> None:
        first = asyncio.Event()
        async with chatting(service) as chat:
            asking = asyncio.create_task(chat.reply(QUESTION, lambda piece: first.set()))
            await first.wait()  # and the service goes on only when whoever asks goes away
            assert not asking.done()
            asking.cancel()
            await service.left.wait()

    with_service(test, Unfinished(STREAM + chunk({"role": "assistant", "content": "A"})))
    assert heard(streamed("A", " cu", "p.")) == (["A", " cu", "p."], CUP)


def test_tokens_are_counted_where_the_service_counts_them() -> None:
    usage = {"prompt_tokens": 90, "completion_tokens": 7, "prompt_tokens_details": {"cached_tokens": 80}}
    assert asked(streamed("A cup.", usage=usage)) == Reply("A cup.", "cloud", "openai", 90, 80, 7)
    few = {"prompt_tokens": 90, "completion_tokens": 7, "prompt_tokens_details": None}
    assert asked(streamed("A cup.", usage=few)) == Reply("A cup.", "cloud", "openai", 90, 0, 7)


def test_an_answer_that_ran_out_of_tokens_says_so() -> None:
    found = asked(streamed("A cu", end="length"))
    assert isinstance(found, Reply)
    assert found.cut_off


@pytest.mark.parametrize(
    ("pieces", "passed_on"),
    [
        (("<think>Is it?", " It is.</think>\n", "A cup."), "A cup."),
        ((" ", "<th", "ink>x</th", "ink>A", " cup."), "A cup."),
        (("<", "b>A cup.</b>"), "<b>A cup.</b>"),
        (("A cup. <think>", "No.</think>"), "A cup. <think>No.</think>"),
        (("It is ", SECRET[:6], SECRET[6:9], SECRET[9:], "."), "It is ********."),
        (("It is ", SECRET[:6], "ething else."), f"It is {SECRET[:6]}ething else."),
        ((f"It is {SECRET[:6]}",), f"It is {SECRET[:6]}"),
    ],
)
def test_neither_thoughts_nor_the_key_are_heard(pieces: tuple[str, ...], passed_on: str) -> None:
    told, found = heard(streamed(*pieces))
    assert "".join(told).strip() == passed_on
    assert found == Reply(passed_on, "cloud")


def test_thoughts_without_an_answer_are_no_answer() -> None:
    told, found = heard(streamed("<think>Well, ", "let me see", end="length"))
    assert told == []
    assert type(found) is Unreadable
    assert "more tokens" in str(found)


def halves(*pieces: str) -> bytes:
    """A completion in pieces, with the halves of characters as JSON writes them."""
    return b"".join(event(json.dumps({"choices": [{"delta": {"content": piece}}]})) for piece in pieces)


def test_a_character_that_comes_in_two_halves_is_heard_as_one() -> None:
    pieces, found = heard(STREAM + halves("A cup \ud83d", "\ude00!") + chunk({}, "stop"))
    assert found == Reply("A cup 😀!", "cloud")
    assert "".join(pieces) == "A cup 😀!"


@pytest.mark.parametrize(
    ("told", "kind", "words"),
    [
        (streamed("A cu", end=None), Unreachable, "broke off in the middle"),
        (
            STREAM.replace(b"close\r\n", b"close\r\nContent-Length: 999\r\n") + chunk({"content": "A"}),
            Unreachable,
            "broke",
        ),
        (STREAM + chunk({"content": "A"}) + event("{nonsense"), Unreadable, "not what a chat completion looks like"),
        (STREAM + chunk({"content": "A"}) + b"data: \xff\n\n", Unreadable, "not what a chat completion looks like"),
        (STREAM + chunk("nonsense"), Unreadable, "not what a chat completion looks like"),
        (STREAM + event('"nonsense"'), Unreadable, "not what a chat completion looks like"),
        (STREAM + event("[DONE]"), Unreadable, "there is nothing in it"),
        (STREAM + b"nonsense\n\n", Unreadable, "there is nothing in it"),
        (
            STREAM + chunk({"content": "A"}) + event({"error": {"message": "No memory", "code": 503}}),
            Refused,
            "503: No memory",
        ),
        (STREAM + b"data: " + b"x" * MAX_BYTES, Unreadable, "longer than 8 MB"),
        (STREAM + halves("\ud83d") + chunk({}, "stop"), Unreadable, "half a character"),
        (STREAM + halves("\ude00", "\ud83d") + chunk({}, "stop"), Unreadable, "half a character"),
        (STREAM + halves("\ud83d", "", "x"), Unreadable, "half a character"),
        (streamed("A", usage={"completion_tokens": 10**400}), Unreadable, "not what a chat completion looks like"),
        (STREAM + event({"error": {"message": "No", "code": "9" * 5000}}), Refused, "status 200: No"),
    ],
)
def test_an_answer_that_goes_wrong_on_the_way_is_not_asked_for_again(
    told: bytes, kind: type[ChatError], words: str
) -> None:
    pieces, found = heard(told)
    assert len(pieces) <= 1
    assert type(found) is kind
    assert words in str(found)
    assert found.hint


def test_a_stream_that_breaks_before_the_first_word_is_asked_for_again() -> None:
    cut = STREAM.replace(b"close\r\n", b"close\r\nContent-Length: 999\r\n")
    assert heard(cut, streamed("A cup."), requests=2) == (["A cup."], CUP)
    busy = STREAM + event({"error": {"message": "Overloaded", "code": 503}})
    assert heard(busy, streamed("A cup."), requests=2) == (["A cup."], CUP)


# What a service may not be able to do

FORM = Ask(QUESTION.messages, schema={"type": "object"}, grammar='root ::= "A"')


def bodies(*answers: Answer, ask: Ask = FORM, times: int = 1, **changes: Any) -> list[dict[str, Any]]:
    """What a service that gives these answers is sent when it is asked so many times."""
    sent: list[dict[str, Any]] = []

    async def test(service: Service) -> None:
        async with chatting(service, **changes) as chat:
            for _ in range(times):
                await chat.reply(ask)
        sent.extend(request.body for request in service.asked)

    with_service(test, *answers)
    return sent


def test_the_form_of_an_answer_is_asked_for_in_the_way_the_service_understands() -> None:
    [body] = bodies(streamed("{}"))
    assert body["response_format"]["type"] == "json_schema"
    assert body["response_format"]["json_schema"]["schema"] == {"type": "object"}
    assert "grammar" not in body
    [body] = bodies(streamed("{}"), grammar=True)
    assert body["grammar"] == 'root ::= "A"'
    assert "response_format" not in body


@pytest.mark.parametrize("status", [400, 422, 501])
def test_a_service_that_knows_no_forms_is_asked_without_from_then_on(status: int) -> None:
    sent = bodies(reply(status, {"error": "This is not available now"}), streamed("{}"), times=2)
    assert ["response_format" in body for body in sent] == [True, False, False]


def test_a_service_is_spared_what_it_says_it_does_not_take() -> None:
    seed = reply(400, {"error": {"message": "Unknown parameter: 'seed'."}})
    tokens = reply(400, {"error": {"message": "Unsupported parameter: 'max_tokens'; use 'max_completion_tokens'"}})
    sent = bodies(seed, tokens, streamed("{}"), times=2)
    assert len(sent) == 4
    assert ["seed" in body for body in sent] == [True, False, False, False]
    assert [body.get("max_completion_tokens") for body in sent] == [None, None, 512, 512]
    assert all("response_format" in body for body in sent)


def test_a_form_that_was_not_the_trouble_is_asked_for_again() -> None:
    async def test(service: Service) -> None:
        async with chatting(service) as chat:
            with pytest.raises(Refused, match="too long"):
                await chat.reply(FORM)
            await chat.reply(FORM)
        assert ["response_format" in request.body for request in service.asked] == [True, False, True]

    long = reply(400, {"error": "The question is too long"})
    with_service(test, long, long, streamed("{}"))


# How long and how often


@pytest.mark.parametrize(
    "told",
    [
        SILENCE,
        Unfinished(STREAM + chunk({"content": "A"})),
        Unfinished(STREAM, drip=chunk({"content": "A"})),
        Unfinished(STREAM, drip=b": wait\n\n"),
    ],
    ids=["silence", "hangs", "drips", "only keeps alive"],
)
def test_an_answer_that_does_not_come_to_its_end_is_given_up_in_time(told: Unfinished) -> None:
    async def test(service: Service) -> None:
        async with chatting(service, timeout_s=0.3) as chat:
            with pytest.raises(TooSlow, match=r"within 0\.3 s"):
                await chat.reply(QUESTION)
            await service.left.wait()

    with_service(test, told)


def test_a_service_says_how_long_it_wants_to_be_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.llm.service.PAUSE_S", 1000)  # which nobody would wait for
    soon = reply(429, {}, **{"Retry-After": "0"})
    long_ago = reply(503, {}, **{"Retry-After": "Fri, 20 Nov 2026 08:00:00 GMT"})
    assert asked(soon, long_ago, answer("A cup."), requests=3) == CUP
    later = reply(429, {}, **{"Retry-After": f"{LONGEST_PAUSE_S + 1}"})
    assert type(asked(later, answer("A cup."), requests=1)) is Refused


@pytest.mark.parametrize(
    ("wish", "requests"),
    [
        ("Fri, 20 Nov 99999999999 08:00:00 GMT", 1),
        ("Fri, 20 Nov 9999 08:00:00 -2359", 1),
        ("9" * 5000, 1),
        ("1e999", 1),
        ("nan", TRIES),
        ("-1", TRIES),
        ("soon", TRIES),
    ],
)
def test_a_wish_to_be_left_alone_that_makes_no_sense_is_only_a_refusal(wish: str, requests: int) -> None:
    found = asked(reply(429, {"error": "busy"}, **{"Retry-After": wish}), requests=requests)
    assert type(found) is Refused
    assert "429: busy" in str(found)


def test_no_pause_is_begun_that_goes_beyond_the_time_of_the_question(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.llm.service.PAUSE_S", 1000)
    assert type(asked(reply(503, {}), answer("A cup."), requests=1, timeout_s=60)) is Refused


def test_pauses_grow_and_differ(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.llm.service.PAUSE_S", PAUSE_S)
    pauses = [back_off(failures, None, 0.5) for failures in range(3)]
    assert pauses == [PAUSE_S, 2 * PAUSE_S, 4 * PAUSE_S]
    assert back_off(0, None, 0.0) != back_off(0, None, 0.9)
    assert back_off(2, 1.5, 0.9) == 1.5
    assert back_off(0, LONGEST_PAUSE_S + 1, 0.0) is None


@pytest.mark.parametrize("told", [SILENCE, Unfinished(STREAM + chunk({"content": "A"}))], ids=["waiting", "hearing"])
def test_cancelling_closes_the_connection_before_anything_else_happens(told: Unfinished) -> None:
    async def test(service: Service) -> None:
        there = asyncio.Event()
        async with chatting(service) as chat:
            if told == SILENCE:
                service.on_request = there.set
            asking = asyncio.create_task(chat.reply(QUESTION, lambda piece: there.set()))
            await there.wait()
            asking.cancel()
            turns = 0
            while not asking.done():
                await asyncio.sleep(0)
                turns += 1
            assert asking.cancelled()
            assert turns < 20
            await service.left.wait()  # and not after a timeout: 30 s are longer than this test may take

    with_service(test, told)


# What nobody may see


@pytest.mark.parametrize(
    "told",
    [
        answer(f"It is {SECRET}"),
        streamed("It is ", SECRET),
        STREAM + event({"error": {"message": SECRET}}),
        STREAM + event(SECRET),
        STREAM + event({"error": {"message": SECRET, "code": "9" * 5000}}),
        STREAM + event({"error": {"message": SECRET, "code": "\u0669" * 5000}}),
        STREAM + event({"error": {"message": SECRET, "code": [[SECRET]]}}),
        reply(401, {"error": SECRET}),
        reply(429, {"error": SECRET}, **{"Retry-After": "Mon, 01 Jan 999999999 00:00:00 GMT"}),
        reply(500, SECRET.encode()),
        HANGS_UP,
        SILENCE,
    ],
)
def test_the_key_is_in_nothing_that_can_be_shown(told: Answer, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    shown = ""

    async def test(service: Service) -> None:
        nonlocal shown
        async with chatting(service, timeout_s=2 if told != SILENCE else 0.3) as chat:
            shown += f"{chat!r} {vars(chat)!r} {vars(chat._service)!r} {service.platform()!r}"
            try:
                shown += repr(await chat.reply(QUESTION))
            except ChatError as error:
                ours = (
                    error.__traceback__ and error.__traceback__.tb_next
                )  # without the frame of this test, which knows the key
                report = traceback.TracebackException(type(error), error, ours, capture_locals=True)
                shown += f"{error!r} {error} {error.hint} {error.__context__!r} {''.join(report.format())}"

    with_service(test, told)
    assert "cloud" in shown
    assert caplog.text
    assert SECRET not in shown
    assert SECRET not in caplog.text


def test_whatever_a_service_brings_about_is_an_error_of_the_platform_and_short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also a fault in reading what it sent; a library's, for instance."""

    def faulty(*_: object) -> bytes:
        raise LookupError(f"{SECRET} {'9' * 5000}")

    monkeypatch.setattr(engine.llm.openai, "_said", faulty)
    found = asked(STREAM + event({"error": {"message": SECRET}}))
    assert isinstance(found, Unreadable)
    assert "LookupError" in found.message
    assert len(str(found)) < 800
    assert SECRET not in "".join(traceback.format_exception(found))


def test_credentials_in_an_address_are_in_no_message() -> None:
    url = "http://me:hunter22@127.0.0.1/v1?api_key=t%6fken99"
    service = PlatformService("cloud", Platform(kind="openai", base_url=url, model="m"), "a service", "Look at it.")
    failure = service.refused(400, b"no: hunter22, t%6fken99, token99", {})
    assert "no: ********, ********, ********" in str(failure.error)


@pytest.mark.parametrize("key", [f"{SECRET}\r\nX: y", f"{SECRET} {SECRET}", f"{SECRET}é"])
def test_a_key_that_no_header_can_carry_is_told_without_showing_it(key: str) -> None:
    found = asked(answer("A cup."), requests=0, api_key=SecretStr(key))
    assert type(found) is KeyWanted
    assert SECRET not in str(found)


def test_a_line_break_at_the_end_of_a_key_does_no_harm() -> None:
    assert asked(answer("A cup."), api_key=SecretStr(f"{SECRET}\n")) == CUP


def test_a_picture_is_sent_as_what_it_is() -> None:
    async def test(service: Service) -> None:
        async with chatting(service) as chat:
            await chat.reply(Ask((Message("user", "?", b"\xff\xd8\xff\xe0"),)))
            assert '"data:image/jpeg;base64,' in json.dumps(service.asked[0].body)
            with pytest.raises(ValueError, match="PNG or a JPEG"):
                await chat.reply(Ask((Message("user", "?", b"GIF89a"),)))

    with_service(test, answer("A cup."))


def test_whoever_asks_nothing_does_not_wait_for_the_libraries() -> None:
    program = (
        "import sys, engine.llm.openai, engine.llm.dify, engine.llm.chain;"
        "sys.exit(bool({'httpx', 'httpx2', 'openai', 'certifi'} & sys.modules.keys()))"
    )
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0
