"""``sayso plan``: what would be done. Nothing is started that could move."""

from __future__ import annotations

import asyncio
from argparse import Namespace

from ulid import ULID

from engine import events
from engine.bus import Bus
from engine.clock import SystemClock
from engine.errors import ExitCode
from engine.loading import at_home
from engine.planner.build import build_planner
from engine.planner.planner import NoPlan, Planner, PlanRequest
from tui.commands.ask import requests
from tui.commands.output import data, say
from tui.commands.settings import load_settings


def run(arguments: Namespace) -> int:
    """Plan the request, or every line of stdin. Exit code of the first one without a plan."""
    planner = build_planner(at_home(load_settings(arguments)))
    bus = Bus(SystemClock())
    if arguments.json:
        bus.subscribe(lambda event: data(events.to_json(event).decode()))
    code = int(ExitCode.DONE)
    for text in requests(arguments.text):
        planned = int(_plan(planner, bus, text, json=arguments.json))
        code = code or planned
    return code


def _plan(planner: Planner, bus: Bus, text: str, *, json: bool) -> ExitCode:
    emit = bus.bound(turn=str(ULID()), epoch=0)
    plan = asyncio.run(planner.plan(PlanRequest(text)))
    if isinstance(plan, NoPlan):
        emit(plan.as_event())
        if not json:
            say(plan.answer)
        return plan.exit_code
    emit(plan.as_event())
    if not json:
        for action in plan.actions:
            data(str(action))
    return ExitCode.DONE
