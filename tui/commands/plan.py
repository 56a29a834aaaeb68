"""``sayso plan``: what would be done. Nothing is started that could move."""

from __future__ import annotations

import asyncio
import sys
from argparse import Namespace
from collections.abc import Iterator, Mapping
from dataclasses import replace

from rich.cells import cell_len
from ulid import ULID

from config.schema import Settings
from engine import events
from engine.bus import Bus, Emit
from engine.clock import SystemClock
from engine.errors import ExitCode, UsageError
from engine.parts.loading import at_home, make_models
from engine.plan import Plan
from engine.planner.build import build_planner
from engine.planner.intent import with_intent
from engine.planner.planner import NoPlan, Planner, PlanRequest
from engine.planner.text.language import language_of
from engine.planner.worlds.world import World
from engine.planner.worlds.world_file import load_world
from engine.wording import Wording, build_wording
from tui.commands.ask import requests
from tui.commands.settings import load_settings
from tui.output import data, say
from tui.words.widths import left


def run(arguments: Namespace) -> int:
    """Plan the request, or every line of stdin, each as the beginning of a task of its own. Exit code of the first one
    without a plan."""
    settings = load_settings(arguments)
    world = None if arguments.world is None else load_world(arguments.world, say)
    return _plan_all(settings if world else at_home(settings), world, arguments)


def _plan_all(settings: Settings, world: World | None, arguments: Namespace) -> int:
    models = make_models(settings, say)
    planner = build_planner(settings, models=models, world=world)
    places = world.places if world is not None else settings.places
    names = {symbol: place.name for symbol, place in places.items()}
    wording = build_wording(settings)
    bus = Bus(SystemClock())
    made: list[events.Event] = []
    if arguments.json:
        bus.subscribe(made.append)
    code = int(ExitCode.DONE)
    with asyncio.Runner() as loop:
        try:
            for text in requests(arguments.text):  # outside of the loop, which would hold an interrupt back meanwhile
                planned = int(loop.run(_told(planner, bus, text, names, wording, json=arguments.json)))
                for event in made:
                    data(events.to_json(event).decode())
                made.clear()
                code = code or planned
        finally:
            if models is not None:
                loop.run(models.close())
    return code


async def _told(
    planner: Planner, bus: Bus, text: str | UsageError, names: Mapping[str, str], wording: Wording, *, json: bool
) -> ExitCode:
    """Tell the plan for one request, or why there is none."""
    emit = bus.bound(turn=str(ULID()), epoch=0)
    if isinstance(text, UsageError):
        plan: Plan | NoPlan = NoPlan("", text.code, str(text), text.exit_code)
    else:
        plan = await _plan(planner, emit, text, json=json)
    if isinstance(plan, NoPlan):
        plan = replace(plan, answer=wording.worded(plan.answer, language_of(plan.text)))
    emit(with_intent(plan, names))
    if isinstance(plan, NoPlan):
        if not json:
            say(plan.answer)
        return plan.exit_code
    if not json:
        for line in _lines(planner, plan):
            data(line)
        if not plan.actions:
            data(plan.response)
    return ExitCode.DONE


def _lines(planner: Planner, plan: Plan) -> Iterator[str]:
    """The actions as programs write them; on a terminal with words beside them."""
    calls = list(map(str, plan.actions))
    if not sys.stdout.isatty():
        yield from calls
        return
    same = len(plan.steps) == len(calls)
    words = plan.steps if same else [planner.in_words(action).step for action in plan.actions]
    width = max(map(cell_len, calls), default=0) + 2
    for one, step in zip(calls, words, strict=True):
        yield f"{left(one, width)}{step}"


async def _plan(planner: Planner, emit: Emit, text: str, *, json: bool) -> Plan | NoPlan:
    request = PlanRequest(
        text,
        decide=lambda steps, source: _decided(emit, steps, source, json=json),
        read=emit,
        warn=say,
        record=emit,
    )
    try:
        return await planner.plan(request)
    except Exception as error:  # noqa: BLE001 - a fault over one line must not take the others with it
        return NoPlan(text, "internal", f"A fault in sayso itself: {error!r}.")


def _decided(emit: Emit, steps: tuple[str, ...], source: events.PlanSource, *, json: bool) -> None:
    emit(events.DecisionMade(steps, source))
    if not json:
        for step in steps:
            say(f"decided: {step}")
