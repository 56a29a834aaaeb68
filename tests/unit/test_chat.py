"""A large model is asked in the protocol that it speaks; whatever it does, the answer is one error or one reply."""

from __future__ import annotations

import asyncio
import base64
import json
import logging
import subprocess
import sys
import traceback
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from pydantic import SecretStr

from engine.llm.chat import ChatError, KeyWanted, Message, Refused, Reply, TooSlow, Unreachable, Unreadable
from engine.llm.openai import MAX_BYTES, OpenAIChat
from tests.model_service import HANGS_UP, SECRET, SILENCE, Service, answer, reply, serving

PNG = b"\x89PNG\r\n\x1a\n..."
QUESTION = (Message("system", "Be brief."), Message("user", "What is this?", PNG))


@pytest.fixture(autouse=True)
def _no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.llm.openai.PAUSE_S", 0)


def with_service(test: Callable[[Service], Awaitable[None]], *answers: bytes) -> None:
    async def run() -> None:
        async with serving(*answers) as service:
            await test(service)

    asyncio.run(run())


def asked(*answers: bytes, requests: int = 1, **changes: Any) -> Reply | ChatError:
    """What becomes of one question to a service that gives these answers."""
    found: list[Reply | ChatError] = []

    async def test(service: Service) -> None:
        try:
            found.append(await OpenAIChat("cloud", service.platform(**changes)).reply(QUESTION))
        except ChatError as error:
            found.append(error)
        assert len(service.asked) == requests

    with_service(test, *answers)
    return found[0]


def test_a_question_with_a_picture_is_sent_as_chat_completions_want_it() -> None:
    async def test(service: Service) -> None:
        found = await OpenAIChat("cloud", service.platform()).reply(QUESTION)
        assert found == Reply("A cup.")
        [request] = service.asked
        assert request.line == "POST /v1/chat/completions HTTP/1.1"
        assert request.headers["authorization"] == f"Bearer {SECRET}"
        assert request.headers["content-type"] == "application/json"
        assert request.body["model"] == "one-that-sees"
        system, user = request.body["messages"]
        assert system == {"role": "system", "content": "Be brief."}
        assert user["role"] == "user"
        text, picture = user["content"]
        assert text == {"type": "text", "text": "What is this?"}
        head, _, data = picture["image_url"]["url"].partition(",")
        assert (picture["type"], head) == ("image_url", "data:image/png;base64")
        assert base64.b64decode(data) == PNG

    with_service(test, answer(" A cup.\n"))


def test_where_no_key_is_set_none_is_sent() -> None:
    async def test(service: Service) -> None:
        await OpenAIChat("home", service.platform(api_key=None)).reply(QUESTION)
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
    assert asked(answer(said)) == Reply(understood)


@pytest.mark.parametrize("first", [reply(429, {}), reply(500, {}), reply(503, b"busy"), HANGS_UP])
def test_what_may_pass_is_tried_once_more(first: bytes) -> None:
    assert asked(first, answer("A cup."), requests=2) == Reply("A cup.")


@pytest.mark.parametrize(
    ("told", "requests", "kind", "words"),
    [
        (reply(429, {"error": {"message": "Slow down."}}), 2, Refused, "429: Slow down. Wait a while"),
        (reply(500, {"detail": "Out of memory"}), 2, Refused, "500: Out of memory. Try again later."),
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
        (HANGS_UP, 2, Unreachable, "cannot be reached at 127.0.0.1"),
        (reply(200, b"\xff<html>"), 1, Unreadable, "not what a chat completion looks like"),
        (reply(200, {"choices": "none"}), 1, Unreadable, "not what a chat completion looks like"),
        (reply(200, {"choices": []}), 1, Unreadable, "there is nothing in it"),
        (answer(None), 1, Unreadable, "there is nothing in it"),
        (answer("x" * MAX_BYTES), 1, Unreadable, "longer than 1 MB"),
        (b"SSH-2.0-somebody else\r\n", 2, Unreachable, "cannot be reached at 127.0.0.1"),
    ],
)
def test_every_failure_says_what_happened_and_what_to_do(
    told: bytes, requests: int, kind: type[ChatError], words: str
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
            platform = service.platform()
        with pytest.raises(Unreachable, match=r"platforms\.cloud\.base_url"):
            await OpenAIChat("cloud", platform).reply(QUESTION)

    asyncio.run(run())


def test_an_answer_that_does_not_come_is_given_up_in_time() -> None:
    async def test(service: Service) -> None:
        with pytest.raises(TooSlow, match=r"within 0\.1 s"):
            await OpenAIChat("cloud", service.platform(timeout_s=0.1)).reply(QUESTION)

    with_service(test, SILENCE)


def test_a_redirect_is_not_followed() -> None:
    async def run() -> None:
        async with serving(answer("I am somebody else.")) as other:
            away = reply(307, {}, Location=f"http://127.0.0.1:{other.port}/v1/chat/completions")
            async with serving(away) as service:
                with pytest.raises(Refused, match="sends one elsewhere"):
                    await OpenAIChat("cloud", service.platform()).reply(QUESTION)
            assert not other.asked

    asyncio.run(run())


def test_a_proxy_of_the_environment_gets_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    async def run() -> None:
        async with serving(answer("I am a proxy.")) as proxy, serving(answer("A cup.")) as service:
            for name in ("http_proxy", "all_proxy"):
                monkeypatch.setenv(name, f"http://127.0.0.1:{proxy.port}")
            assert await OpenAIChat("cloud", service.platform()).reply(QUESTION) == Reply("A cup.")
            assert not proxy.asked

    asyncio.run(run())


def test_cancelling_closes_the_connection_before_anything_else_happens() -> None:
    async def test(service: Service) -> None:
        there = asyncio.Event()
        service.on_request = there.set
        asking = asyncio.create_task(OpenAIChat("cloud", service.platform()).reply(QUESTION))
        await there.wait()
        asking.cancel()
        turns = 0
        while not asking.done():
            await asyncio.sleep(0)
            turns += 1
        assert asking.cancelled()
        assert turns < 20
        await service.left.wait()  # and not after a timeout: 30 s are longer than this test may take

    with_service(test, SILENCE)


@pytest.mark.parametrize(
    "told", [answer(f"It is {SECRET}"), reply(401, {"error": SECRET}), reply(500, SECRET.encode()), HANGS_UP, SILENCE]
)
def test_the_key_is_in_nothing_that_can_be_shown(told: bytes, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    shown = ""

    async def test(service: Service) -> None:
        nonlocal shown
        chat = OpenAIChat("cloud", service.platform(timeout_s=2 if told != SILENCE else 0.1))
        shown += f"{chat!r} {vars(chat)!r} {service.platform()!r}"
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


@pytest.mark.parametrize("key", [f"{SECRET}\r\nX: y", f"{SECRET} {SECRET}", f"{SECRET}é"])
def test_a_key_that_no_header_can_carry_is_told_without_showing_it(key: str) -> None:
    found = asked(answer("A cup."), requests=0, api_key=SecretStr(key))
    assert type(found) is KeyWanted
    assert SECRET not in str(found)


def test_a_line_break_at_the_end_of_a_key_does_no_harm() -> None:
    assert asked(answer("A cup."), api_key=SecretStr(f"{SECRET}\n")) == Reply("A cup.")


def test_a_picture_is_sent_as_what_it_is() -> None:
    async def test(service: Service) -> None:
        chat = OpenAIChat("cloud", service.platform())
        await chat.reply([Message("user", "?", b"\xff\xd8\xff\xe0")])
        assert '"data:image/jpeg;base64,' in json.dumps(service.asked[0].body)
        with pytest.raises(ValueError, match="PNG or a JPEG"):
            await chat.reply([Message("user", "?", b"GIF89a")])

    with_service(test, answer("A cup."))


def test_whoever_asks_nothing_does_not_wait_for_the_http_library() -> None:
    program = "import sys, engine.llm.openai; sys.exit('httpx' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0
