"""What a graph is told of what happens here: transcripts, intents, answers, plans and outcomes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import msgspec

from engine import events
from engine.events import Body, Event, IntentView
from engine.graph.messages import action_over, as_json, call_told, plan_made, turn_over
from engine.skills.registry import SkillRegistry


@dataclass(slots=True)
class _Turn:
    """What is known of a turn that has not ended."""

    text: str = ""
    queued: dict[str, str] = field(default_factory=dict)  # calls that have not started, by their ids
    ended: list[dict[str, Any]] = field(default_factory=list)


class News:
    """Follows what happens; :meth:`see` is for the bus. The others publish a text."""

    def __init__(
        self,
        registry: SkillRegistry,
        *,
        transcript: Callable[[str], None],
        intent: Callable[[str], None],
        feedback: Callable[[str], None],
        plan: Callable[[str], None],
        outcome: Callable[[str], None],
    ) -> None:
        self._registry = registry
        self._transcript = transcript
        self._intent = intent
        self._feedback = feedback
        self._plan = plan
        self._outcome = outcome
        self._turns: dict[str | None, _Turn] = {}

    def see(self, event: Event) -> None:
        match event.body:
            case events.TranscriptFinal(text=text, source=source):
                self._turn(event).text = text
                if source != "text":
                    self._transcript(text)
            case events.SpeechStarted(text=text):
                self._feedback(text)
            case events.PlanMade() as plan:
                self._plan(as_json({"turn": event.turn, **plan_made(plan, self._registry)}))
            case events.ActionQueued(action=action, name=name, args=args):
                self._turn(event).queued[action] = call_told(name, args, self._registry)
            case events.ActionStarted(action=action):
                self._turn(event).queued.pop(action, None)
            case events.ActionFinished() as done:
                over = action_over(done, self._registry)
                self._turn(event).ended.append(over)
                self._outcome(as_json({"kind": "action", "turn": event.turn, **over}))
            case events.StateChanged(result=result) if result is not None:
                turn = self._turns.pop(event.turn, _Turn())
                over = turn_over(result, turn.ended, tuple(turn.queued.values()))
                self._outcome(as_json({"kind": "turn", "turn": event.turn, "request": turn.text, **over}))
        if (intent := intent_in(event.body)) is not None:
            self._intent(as_json(msgspec.to_builtins(intent)))

    def _turn(self, event: Event) -> _Turn:
        return self._turns.setdefault(event.turn, _Turn())


def intent_in(body: Body) -> IntentView | None:
    """The intent that an event tells of, also where it is to refuse, or not to know."""
    match body:
        case events.PlanMade(intent=intent) | events.ClarificationAsked(intent=intent):
            return intent
        case events.RefusalMade():
            return IntentView("refuse", goal="refuse")
        case events.PlanRejected(code=code) if code != "late":
            return IntentView("error", goal="error")
    return None
