"""How long sayso takes to be there: the console with the real engine on a pseudo-terminal, and the commands.

``python -m tests.bench.startup [--json] [--n 5]``. *First paint* is the first pane on the terminal, of the picture
from an earlier start (``tui.terminal.launch``), *drawn* the first one that Textual draws, *usable* the whole status
line, *robot* the robot ready behind it, all from the start of the process. *First plan* is from a request,
made at the moment in which the robot of a new engine is ready, or its model, to what comes of the answer that the
model of this machine gives. The first start of each is not counted: it leaves what later ones have in memory, and what
the model has read.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from typing import Any

from tests.bench.report import figures, print_report, report
from tests.bench.tui import USABLE, console, environment

CONSOLE = "import sys; from tui.cli import main; sys.exit(main(sys.argv[1:]))"
COMMANDS = {
    "version": ["--version"],
    "skills": ["skills"],
    "plan": ["plan", "go to the kitchen"],
    "ask, simulated time at full speed": ["--set", "robot.speed=max", "ask", "go to the kitchen"],
}

FRAME = "╭".encode()
MOMENTS = {
    "first paint": (b"\x1b[?1049h", FRAME),
    "drawn": (b"\x1b[?2004h", FRAME),  # bracketed paste: Textual has the terminal
    "usable": (b"\x1b[?1049h", USABLE),
    "robot": (b"\x1b[?1049h", b"at rest"),
}
"""What is on the terminal then, and what was written some time before it."""
REQUEST = "allez dans la cuisine et klaxonnez"
"""In a language that the reader does not know, and short for a model, whatever comes of what that answers."""
PLANNED = ("plan.made", "plan.rejected", "clarification.asked", "refusal.made")
READ_ANEW_S = 300.0
"""How long a model may take that has to read its instructions first, s."""


def console_times() -> tuple[float, ...]:
    """Seconds to each of the moments of :data:`MOMENTS`."""
    with console(120, 40, program=CONSOLE) as terminal:
        found = []
        for name, (after, wanted) in MOMENTS.items():
            come = lambda seen, after=after, wanted=wanted: wanted in seen.partition(after)[2]  # noqa: E731
            when = terminal.read(30, come)
            if when is None:
                raise SystemExit(f"The console was not there within 30 s ({name}).")
            found.append(when)
        return tuple(found)


def first_plan(*, asked_with: str) -> float:
    """Seconds from a request, made as soon as this part of a new engine is ready, to the model's plan."""
    command = [sys.executable, "-c", CONSOLE, "--set", f"platforms.local.timeout_s={READ_ANEW_S}"]
    command += ["--set", "planner.profile=local", "engine", "--source", "none"]
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(command, env=environment(), text=True, **streams) as engine:  # type: ignore[call-overload]
        asked, by_model = None, False
        for line in engine.stdout:
            event = json.loads(line)
            if is_ready(asked_with, event) and asked is None:
                asked = time.monotonic()
                print(json.dumps({"do": "say", "text": REQUEST}), file=engine.stdin, flush=True)
            by_model = by_model or event["kind"] == "model.asked"
            if event["kind"] in PLANNED and asked is not None:
                took = time.monotonic() - asked
                print(json.dumps({"do": "quit"}), file=engine.stdin, flush=True)
                if not by_model:
                    break
                return took
    raise SystemExit(f"The model was not asked about {REQUEST!r}.")


def is_ready(part: str, event: dict[str, Any]) -> bool:
    """Whether an engine's event says so."""
    body = event["body"]
    return event["kind"] == "log" and body["source"] == part and str(body["message"]).startswith("ready")


def command_time(arguments: list[str]) -> float:
    """Seconds that a command takes from start to end."""
    began = time.monotonic()
    subprocess.run([sys.executable, "-c", CONSOLE, *arguments], check=True, capture_output=True, env=environment())
    return time.monotonic() - began


def main() -> None:
    parser = argparse.ArgumentParser(description="Start-up times.")
    parser.add_argument("--n", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    starts = [console_times() for _ in range(arguments.n + 1)][1:]
    found = {name: figures([start[place] for start in starts], "s") for place, name in enumerate(MOMENTS)}
    for name, command in COMMANDS.items():
        found[name] = figures([command_time(command) for _ in range(arguments.n + 1)][1:], "s")
    for part in ("robot", "model"):
        plans = [first_plan(asked_with=part) for _ in range(arguments.n + 1)]
        found[f"first plan, asked as soon as the {part} is ready"] = figures(plans[1:], "s")
    print_report(report("startup", arguments.n, found), arguments.json)


if __name__ == "__main__":
    main()
