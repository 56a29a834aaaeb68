"""Talking, and the two ways to be finished."""

from __future__ import annotations

from typing import Annotated

from engine.skills.context import SkillContext
from engine.skills.outcome import Result, ok
from engine.skills.registry import Word, skill


@skill(occupies=["voice"], changes=[])
async def say(context: SkillContext, text: Annotated[str, Word("sentence")]) -> Result:
    """Say a sentence."""
    await context.say(text)
    return ok(f"Said: “{text}”.")


@skill(occupies=["voice"], changes=[])
async def list_skills(context: SkillContext) -> Result:
    """Say what the robot can do."""
    return ok(context.describe_skills())


@skill(changes=[])
async def finishtask(context: SkillContext) -> Result:
    """All steps of the task are done; the robot waits for what comes next in the same conversation."""
    del context
    return ok("The task is finished.")


@skill()
async def finish_dialogue(context: SkillContext) -> Result:
    """End the conversation: stop, put the arm to its initial pose, forget the history, begin anew."""
    del context  # the session does this when the plan is done: a skill cannot end the scope that it runs in
    return ok()  # the plan says goodbye, if anybody does
