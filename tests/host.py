"""A stand-in for the engine: a process of its own that runs one program in a tree, to be killed in mid-run.

``python -m tests.host PROGRAM ARGUMENT…`` writes the pids of program, guard and warden, and waits for the program.
"""

from __future__ import annotations

import asyncio
import sys

from engine.process import ProcessTree


async def main(argv: list[str]) -> int:
    async with ProcessTree(argv) as tree:
        print(tree.pid, *tree.supervisors, flush=True)
        return await tree.wait()


if __name__ == "__main__":
    sys.exit(asyncio.run(main(sys.argv[1:])))
