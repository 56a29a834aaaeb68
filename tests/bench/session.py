"""Random conversations: does a session keep its rules of interruption, whatever happens in whatever order?

Hypothesis plays people, models, skills and a robot that wake, interrupt, answer late, fail and refuse to let go, under
virtual time; after every step the invariants of ``tests.session.machine`` are checked. A violation is printed with the
shortest sequence that shows it, and the benchmark fails.
"""

from __future__ import annotations

import argparse
import random
import sys
import time

from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import run_state_machine_as_test

from tests.bench.report import figures, print_report, report
from tests.session.machine import SessionMachine, counts

LENGTH = 60
"""Steps of one conversation, at most."""


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench session", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--steps", type=int, default=10_000, help="how many steps at least")
    parser.add_argument("--seed", type=int, default=None, help="repeat a run; default: another one each time")
    args = parser.parse_args(argv)
    numbers = random.Random(args.seed)
    durations: list[float] = []
    violations = 0

    class Timed(SessionMachine):
        """Measures how long one conversation takes."""

        def __init__(self) -> None:
            super().__init__()
            self._began = time.perf_counter()

        def teardown(self) -> None:
            super().teardown()
            durations.append(time.perf_counter() - self._began)

    while counts["steps"] < args.steps and not violations:
        machine = seed(numbers.getrandbits(64))(Timed)
        missing = max(20, (args.steps - counts["steps"]) // LENGTH)
        try:
            run_state_machine_as_test(
                machine,
                settings=settings(
                    max_examples=missing,
                    stateful_step_count=LENGTH,
                    deadline=None,
                    database=None,
                    phases=(Phase.generate, Phase.shrink),
                    suppress_health_check=list(HealthCheck),
                ),
            )
        except Exception as error:  # noqa: BLE001 - whatever it is, it is what was looked for
            violations += 1
            print(f"{error!r}\n" + "\n".join(getattr(error, "__notes__", ())), file=sys.stderr)
    found = {
        "one conversation": figures([1e3 * duration for duration in durations], "ms"),
        "one step": figures([1e3 * duration / LENGTH for duration in durations], "ms"),
    }
    ratios = {"violations": float(violations)} | {name: float(number) for name, number in sorted(counts.items())}
    print_report(report("session", counts["steps"], found, ratios), args.json)
    sys.exit(1 if violations else 0)


if __name__ == "__main__":
    main()
