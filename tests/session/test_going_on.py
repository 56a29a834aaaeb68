"""Somebody goes on who was taken to have ended: what has begun because of that is given up; both pieces are heard."""

from __future__ import annotations

from engine import events
from engine.commands import Say, Wake
from engine.errors import ExitCode
from engine.robot.arm import ARM_UP
from tests.session.conversation import Conversation, SlowVoice, converse


def test_a_question_about_half_a_command_gives_way_to_the_other_half_and_nothing_else_moves() -> None:
    async def test(talk: Conversation) -> None:
        talk.send(Say("raise your arm"))
        await talk.result(1)
        await talk.wake_and_say("go forward")
        await talk.until_state("CLARIFYING")
        question = talk.epoch.current
        talk.send(Wake("speech", ago_s=0.3))
        assert talk.epoch.current == question + 1
        await talk.until_state("LISTENING")
        await talk.pass_time(0.1)
        talk.hearing.speak("go forward 1 metre")
        result = await talk.result(3)
        assert result.exit_code == ExitCode.DONE
        assert talk.robot.state().joints == ARM_UP  # nobody has called it away from what it does
        assert [body.name for body in talk.bodies(events.ActionStarted)] == ["arm_up", "move_forward"]
        assert [body.outcome for body in talk.bodies(events.SpeechEnded) if "how far" in body.text.casefold()] == [
            "interrupted"
        ]

    converse(test, voice=SlowVoice())
