"""All tests: ``python -m tests.whole``. What only computes is tried on all cores, and gives way; what acts at the pace
of the world is tried beside it, one after the other: it mostly waits.

What acts in real time is reported when the rest is done: two reports at once would be none.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from typing import Final

REAL_TIME: Final = ("tests/audio", "tests/e2e", "tests/ros", "tests/cli/test_calibrate.py", "tests/cli/test_robot.py")
"""Sound, boards, and whole programs at the pace of the world."""
_GIVES_WAY: Final = 10  # niceness


def main() -> int:
    """Run both; 0 where both have passed, else the exit status of one that has not."""
    pytest = (sys.executable, "-m", "pytest")
    others = ("--numprocesses", "logical", "--dist", "worksteal", *(f"--ignore={path}" for path in REAL_TIME))
    with (
        tempfile.TemporaryFile() as report,
        subprocess.Popen((*pytest, *REAL_TIME), stdout=report, stderr=subprocess.STDOUT) as in_real_time,
    ):
        os.nice(_GIVES_WAY)  # ours, which the other tests inherit
        computed = subprocess.call((*pytest, *others))
        print(f"\nIn real time: {', '.join(REAL_TIME)}", flush=True)
        acted = in_real_time.wait()
        report.seek(0)
        sys.stdout.buffer.write(report.read())
        sys.stdout.flush()
    return computed or acted


if __name__ == "__main__":
    sys.exit(main())
