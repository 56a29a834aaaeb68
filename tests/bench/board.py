"""From a blow to the zero frame on the wire of a motor board, and from stop() to it.

A robot turns on the spot through an emulated board on a pseudo-terminal. The board itself stamps when it was told to
stand. With a cable that is pulled out, the time counts from when it is back: before, nobody can tell it anything.
"""

from __future__ import annotations

import argparse
import signal
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.bench.report import Figure, figures, print_report, report
from tests.board import Emulator, Turning
from tests.e2e.test_board_faults import stands, turn

LIMIT_MS = 300


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="sayso bench board", description=__doc__)
    parser.add_argument("--json", action="store_true", help="one JSON object instead of a table")
    parser.add_argument("--n", type=int, default=20, help="how many blows of each kind")
    args = parser.parse_args(argv)
    found: dict[str, Figure] = {}
    over = count = 0
    with tempfile.TemporaryDirectory() as folder, Emulator(Path(folder), f"--lidar={folder}/lidar") as board:
        for name, strike in STRIKES.items():
            samples = [strike(board) for _ in range(args.n)]
            found[name] = figures(samples, "ms")
            over += sum(sample > LIMIT_MS for sample in samples)
            count += len(samples)
        found["stop() → zero frame"] = figures(stops(board, 10 * args.n), "ms")
        found["… with a lidar"] = figures(stops(board, 10 * args.n, Path(folder) / "lidar"), "ms")
    print_report(report("board", args.n, found, {f"later than {LIMIT_MS} ms": over / count}), args.json)


def struck(process: str, number: signal.Signals) -> Callable[[Emulator], float]:
    """A blow to one of the processes."""

    def strike(board: Emulator) -> float:
        with Turning(board.path) as turning:
            turn(board, turning)
            victim = getattr(turning, process)
            blow = time.monotonic()
            victim.send_signal(number)
            return _since(blow, board)

    return strike


def failed(begin: str, end: str, *, counted_from_end: bool = False) -> Callable[[Emulator], float]:
    """A fault of the line."""

    def strike(board: Emulator) -> float:
        with Turning(board.path) as turning:
            turn(board, turning)
            blow = time.monotonic()
            board.tell(begin)
            turning.until("halted")
            if counted_from_end:
                blow = time.monotonic()
                board.tell(end)
            found = _since(blow, board)
            board.tell(end)
            return found

    return strike


STRIKES = {
    "engine killed": struck("engine", signal.SIGKILL),
    "engine stopped": struck("engine", signal.SIGSTOP),
    "host killed": struck("host", signal.SIGKILL),
    "host stopped": struck("host", signal.SIGSTOP),
    "guard killed": struck("guard", signal.SIGKILL),
    "guard stopped": struck("guard", signal.SIGSTOP),
    "board silent": failed("silence on", "silence off"),
    "cable back": failed("unplug", "plug", counted_from_end=True),
}


def stops(board: Emulator, n: int, lidar: Path | None = None) -> list[float]:
    """From stop() to the zero frame, ms; with a lidar that is read beside it where one is named."""
    samples = []
    with Turning(board.path, lidar=lidar) as turning:
        for _ in range(n):
            turn(board, turning)
            turning.say("stop")
            stopped = turning.until("stop")["at"]
            board.until(stands)
            samples.append(1e3 * (board.state["zero_at"] - stopped))
    return samples


def _since(blow: float, board: Emulator) -> float:
    """ms from the blow to the zero frame."""
    found: float = board.until(lambda state: state["zero_at"] > blow)["zero_at"]
    return 1e3 * (found - blow)


if __name__ == "__main__":
    main()
