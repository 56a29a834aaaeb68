"""An application in Dify is asked in Dify's own protocol; whatever it does, the answer is one error or one reply."""

from __future__ import annotations

import asyncio
import logging
import traceback
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any

import pytest

from engine.llm.chat import Ask, ChatError, KeyWanted, Message, Refused, Reply, TooSlow, Unreachable, Unreadable
from engine.llm.dify import CONVERSATIONS, USER, DifyChat
from engine.llm.service import TRIES
from tests.dify_service import Dify, dify
from tests.model_service import HANGS_UP, SECRET, SILENCE, STREAM, Answer, Unfinished, event, reply

PNG = b"\x89PNG\r\n\x1a\n..."
SYSTEM = Message("system", "You plan.")
CUP = Reply("A cup.", "app", "dify", 90, 0, 7)


@pytest.fixture(autouse=True)
def _no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.llm.service.PAUSE_S", 0)


@asynccontextmanager
async def chatting(service: Dify, **changes: Any) -> AsyncIterator[DifyChat]:
    chat = DifyChat("app", service.platform(**changes))
    try:
        yield chat
    finally:
        await chat.close()


def with_dify(
    test: Callable[[Dify, DifyChat], Awaitable[None]], *answers: Answer | tuple[str, ...], **facts: Any
) -> None:
    async def run() -> None:
        async with dify(*answers, **facts) as service, chatting(service) as chat:
            await test(service, chat)

    asyncio.run(run())


def asking(*texts: str, conversation: str = "", system: Message = SYSTEM) -> Ask:
    """A question after a dialogue: what the user said, what was answered, …, and what the user says now."""
    roles = ("user", "assistant")
    said = (Message(roles[index % 2], text) for index, text in enumerate(texts))
    return Ask((system, *said), conversation=conversation)


# One question


@pytest.mark.parametrize("mode", ["chat", "agent-chat"])
def test_a_question_is_put_to_the_application_and_its_answer_heard_piece_by_piece(mode: str) -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        heard: list[str] = []
        assert await chat.reply(asking("What is this?"), heard.append) == CUP
        assert heard == ["A", " cup", "."]
        [message] = service.asked
        assert (message.query, message.inputs, message.user) == ("What is this?", {"instructions": "You plan."}, USER)
        assert (message.conversation_id, message.files) == ("", [])
        assert service.stopped == []

    with_dify(test, ("A", " cup", "."), mode=mode)


def test_a_picture_is_uploaded_as_a_file_of_the_same_user() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        await chat.reply(Ask((SYSTEM, Message("user", "What is this?", PNG))))
        [(number, file)] = service.files.items()
        assert (file.user, file.type, file.data) == (USER, "image/png", PNG)
        [attached] = service.asked[0].files
        assert (attached.type, attached.upload_file_id) == ("image", number)
        with pytest.raises(ValueError, match="PNG or a JPEG"):
            await chat.reply(Ask((Message("user", "?", b"GIF89a"),)))

    with_dify(test, ("A cup.",))


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_an_event_ends_where_the_standard_says_and_nowhere_else(end: bytes) -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        text = "A\u2028cup\x85\x0cof tea."
        told = service.begin(USER, text).removeprefix(STREAM) + service._ends("task-0", "c")
        service.answers = [STREAM + told.replace(b"\n", end)]
        assert (await chat.reply(asking("?"))).text == text

    with_dify(test, ("",))


def test_what_a_moderator_puts_in_place_of_an_answer_is_the_answer() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        said = service.begin(USER, "Something bad.")
        replaced = event({"event": "message_replace", "task_id": "task-0", "answer": "Nothing."})
        end = event({"event": "message_end", "task_id": "task-0", "metadata": {}})
        service.answers = [said + replaced + end]
        assert (await chat.reply(asking("?"))).text == "Nothing."

    with_dify(test, ("",))


# Conversations


def test_a_conversation_goes_on_and_only_what_is_new_is_sent() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        await chat.reply(asking("one", conversation="cycle 1"))
        await chat.reply(asking("one", "A cup.", "two", conversation="cycle 1"))
        await chat.reply(asking("one", "A cup.", "two", "A cup.", "three", conversation="cycle 1"))
        await chat.reply(asking("one", conversation="cycle 2"))
        await chat.reply(asking("one"))
        known = service.asked[1].conversation_id
        assert known in service.conversations
        assert [message.conversation_id for message in service.asked] == ["", known, known, "", ""]
        assert [message.query for message in service.asked] == ["one", "two", "three", "one", "one"]

    with_dify(test, ("A cup.",))


def test_a_conversation_that_dify_forgot_begins_anew_with_all_that_was_said() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        await chat.reply(asking("one", conversation="cycle"))
        service.conversations.clear()
        assert await chat.reply(asking("one", "A cup.", "two", conversation="cycle")) == CUP
        _, lost, anew = service.asked
        assert (lost.query, bool(lost.conversation_id)) == ("two", True)
        assert (anew.query, anew.conversation_id) == ("user: one\n\nassistant: A cup.\n\nuser: two", "")
        await chat.reply(asking("one", "A cup.", "two", "A cup.", "three", conversation="cycle"))
        assert service.asked[-1].conversation_id in service.conversations
        assert service.asked[-1].query == "three"

    with_dify(test, ("A cup.",))


def test_what_another_model_said_meanwhile_is_told_in_the_next_question() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        await chat.reply(asking("one", conversation="cycle"))
        await chat.reply(asking("one", "A cup.", "two", "B.", "three", conversation="cycle"))
        assert service.asked[-1].conversation_id in service.conversations
        assert service.asked[-1].query == "user: two\n\nassistant: B.\n\nuser: three"

    with_dify(test, ("A cup.",))


def test_instructions_that_changed_are_told_because_a_conversation_keeps_its_variables() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        await chat.reply(asking("one", conversation="cycle"))
        now = Message("system", "You plan in a workshop.")
        await chat.reply(asking("one", "A cup.", "two", conversation="cycle", system=now))
        await chat.reply(asking("one", "A cup.", "two", "A cup.", "three", conversation="cycle", system=now))
        assert [message.query for message in service.asked] == ["one", f"{now.text}\n\ntwo", "three"]
        assert service.asked[1].inputs == {"instructions": now.text}
        assert len({message.conversation_id for message in service.asked[1:]}) == 1

    with_dify(test, ("A cup.",))


def test_what_many_questions_begin_with_is_part_of_the_instructions() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        example = (Message("user", "Go home."), Message("assistant", "go()"))
        head = (SYSTEM, *example)
        first = Ask((*head, Message("user", "one")), shared=3, conversation="cycle")
        second = Ask((*head, *asking("one", "A cup.", "two").messages[1:]), shared=3, conversation="cycle")
        assert [await chat.reply(first), await chat.reply(second)] == [CUP, CUP]
        assert [message.query for message in service.asked] == ["one", "two"]
        for message in service.asked:
            assert message.inputs == {"instructions": "You plan.\n\nuser: Go home.\n\nassistant: go()"}

    with_dify(test, ("A cup.",))


@pytest.mark.parametrize(
    "again",
    [asking("two"), asking("one", "corrected", "two"), asking("cut off before this", "A cup.", "two")],
    ids=["without its past", "with a past in other words", "with a part of its past"],
)
def test_a_conversation_goes_on_however_much_of_it_is_repeated(again: Ask) -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        await chat.reply(asking("one", conversation="cycle"))
        await chat.reply(replace(again, conversation="cycle"))
        await chat.reply(replace(again, conversation="cycle"))
        assert [message.query for message in service.asked] == ["one", "two", "two"]
        assert [message.conversation_id for message in service.asked] == [
            "",
            *service.conversations,
            *service.conversations,
        ]

    with_dify(test, ("A cup.",))


def test_only_the_latest_conversations_are_remembered() -> None:
    async def test(service: Dify, chat: DifyChat) -> None:
        for number in range(CONVERSATIONS + 1):
            await chat.reply(asking("one", conversation=f"cycle {number}"))
        await chat.reply(asking("one", "A cup.", "two", conversation="cycle 1"))
        await chat.reply(asking("one", "A cup.", "two", conversation="cycle 0"))
        kept, forgotten = service.asked[-2:]
        assert (bool(kept.conversation_id), kept.query) == (True, "two")
        assert (forgotten.conversation_id, forgotten.query) == ("", "user: one\n\nassistant: A cup.\n\nuser: two")

    with_dify(test, ("A cup.",))


# Going away


@pytest.mark.parametrize("how", ["cancelled", "too slow"])
def test_whoever_goes_away_closes_the_connection_and_tells_dify_to_stop(how: str) -> None:
    async def run() -> None:
        async with dify(("",)) as service, chatting(service, timeout_s=30 if how == "cancelled" else 0.3) as chat:
            service.answers = [Unfinished(service.begin(USER, "A"))]
            heard = asyncio.Event()
            asking_now = asyncio.create_task(chat.reply(asking("one"), lambda piece: heard.set()))
            await heard.wait()
            if how == "cancelled":
                asking_now.cancel()
                turns = 0
                while not asking_now.done():
                    await asyncio.sleep(0)
                    turns += 1
                assert turns < 20
                assert asking_now.cancelled()
            else:
                with pytest.raises(TooSlow):
                    await asking_now
            await service.left.wait()
            await service.told_to_stop.wait()
            assert service.stopped == ["task-0"]

    asyncio.run(run())


def test_closing_does_not_wait_for_a_service_that_is_not_there_any_more() -> None:
    async def run() -> None:
        async with dify(("",)) as service:
            chat = DifyChat("app", service.platform())
            service.answers = [Unfinished(service.begin(USER, "A"))]
            heard = asyncio.Event()
            asking_now = asyncio.create_task(chat.reply(asking("one"), lambda piece: heard.set()))
            await heard.wait()
            asking_now.cancel()
            await asyncio.wait([asking_now])
        await chat.close()

    asyncio.run(run())


# What goes wrong


def asked(*answers: Answer | tuple[str, ...], requests: int = 1, **changes: Any) -> Reply | ChatError:
    """What becomes of one question to an application that gives these answers."""
    found: list[Reply | ChatError] = []

    async def run() -> None:
        async with dify(*answers) as service, chatting(service, **changes) as chat:
            try:
                found.append(await chat.reply(asking("one")))
            except ChatError as error:
                found.append(error)
            assert len(service.asked) == requests

    asyncio.run(run())
    return found[0]


def no(status: int, code: str, message: str) -> bytes:
    return reply(status, {"status": status, "code": code, "message": message})


def failing(status: int, code: str, message: str, *before: bytes) -> bytes:
    """A stream that ends with an error; its status is that of a success."""
    facts = {"event": "error", "message_id": "m", "status": status, "code": code, "message": message}
    return b"".join((STREAM, *before, event(facts)))


SAID = event({"event": "message", "task_id": "t", "answer": "A"})


@pytest.mark.parametrize(
    "first",
    [
        no(429, "too_many_requests", "Too many requests."),
        no(500, "internal_server_error", "Internal server error."),
        failing(503, "unavailable", "Overloaded"),
        HANGS_UP,
    ],
)
def test_what_may_pass_is_tried_again(first: bytes) -> None:
    assert asked(first, ("A cup.",), requests=2) == CUP


@pytest.mark.parametrize(
    ("told", "requests", "kind", "words"),
    [
        (no(429, "too_many_requests", "Too many requests."), TRIES, Refused, "429: Too many requests. Wait a while"),
        (no(400, "app_unavailable", "App unavailable"), 1, Refused, "400: App unavailable. Look at the application"),
        (no(404, "not_found", "Conversation Not Exists."), 1, Refused, "404"),
        (failing(400, "invalid_param", f"Wrong: {SECRET}"), 1, Refused, "400: Wrong: ********"),
        (failing(503, "unavailable", "Overloaded", SAID), 1, Refused, "503: Overloaded"),
        (HANGS_UP, TRIES, Unreachable, "cannot be reached at 127.0.0.1"),
        (STREAM + SAID, 1, Unreachable, "broke off in the middle"),
        (STREAM + SAID + SAID[:30], 1, Unreachable, "broke off in the middle"),
        (STREAM + SAID + event("{nonsense"), 1, Unreadable, "not what Dify sends"),
        (STREAM + b"data: \xff\n\n", 1, Unreadable, "not what Dify sends"),
        (STREAM + b"<html>", 1, Unreadable, "there is nothing in it"),
        (("",), 1, Unreadable, "there is nothing in it"),
        (STREAM + b"data: " + b"x" * (9 << 20), 1, Unreadable, "longer than 8 MB"),
    ],
)
def test_every_failure_says_what_happened_and_what_to_do(
    told: bytes | tuple[str, ...], requests: int, kind: type[ChatError], words: str
) -> None:
    found = asked(told, requests=requests)
    assert type(found) is kind
    assert words in str(found)
    assert found.hint
    assert len(str(found)) < 400


def test_an_application_wants_a_key() -> None:
    found = asked(("A cup.",), requests=0, api_key=None)
    assert type(found) is KeyWanted
    assert "platforms.app.api_key" in found.hint


def test_an_answer_that_does_not_come_is_given_up_in_time() -> None:
    assert type(asked(SILENCE, timeout_s=0.2)) is TooSlow


@pytest.mark.parametrize(
    "told",
    [(f"It is {SECRET}",), failing(500, "x", SECRET), no(400, "x", SECRET), STREAM + event(SECRET), HANGS_UP]
    + [STREAM + event({"event": "error", "status": code, "message": SECRET}) for code in (int("9" * 4000), "9" * 5000)],
)
def test_the_key_is_in_nothing_that_can_be_shown(
    told: bytes | tuple[str, ...], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    shown = ""

    async def test(service: Dify, chat: DifyChat) -> None:
        nonlocal shown
        shown += f"{chat!r} {vars(chat)!r} {vars(chat._service)!r}"
        try:
            shown += repr(await chat.reply(asking("one")))
        except ChatError as error:
            ours = error.__traceback__ and error.__traceback__.tb_next  # the frame of this test knows the key
            report = traceback.TracebackException(type(error), error, ours, capture_locals=True)
            shown += f"{error!r} {error} {error.hint} {error.__context__!r} {''.join(report.format())}"

    with_dify(test, told)
    assert "app" in shown
    assert SECRET not in shown
    assert SECRET not in caplog.text
