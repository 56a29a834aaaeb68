"""Nothing of a program survives its tree: not by sessions, orphans, deafness, pauses, storms or murdered supervisors.

Who is alive is told by the kernel (``tests.rollcall``), never by the code under test.
"""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import tracemalloc
from collections.abc import Awaitable, Callable
from pathlib import Path

import psutil
import pytest

from engine.environment import KNOWN
from engine.errors import ExitCode, ProcessError
from engine.process import MARKER, MAX_LINE, ProcessTree
from tests.rollcall import DEADLINE_S, RollCall, roll_call

Attack = Callable[[ProcessTree], None]


def on_a_roll(tmp_path: Path, test: Callable[[RollCall], Awaitable[None]]) -> None:
    async def run() -> None:
        async with roll_call(tmp_path / "roll") as roll, asyncio.timeout(2 * DEADLINE_S):
            await test(roll)

    asyncio.run(run())


def python(program: str) -> list[str]:
    return [sys.executable, "-I", "-S", "-c", program]


def is_gone(pid: int) -> bool:
    """Ended, and buried by whoever is its parent: ours are, orphans' by the system."""
    try:
        process = psutil.Process(pid)
        return bool(process.status() == psutil.STATUS_ZOMBIE and process.ppid() != os.getpid())
    except psutil.NoSuchProcess:
        return True


# Ending


@pytest.mark.parametrize(
    ("shape", "code"),
    [
        ("single", -signal.SIGTERM),
        ("chain", -signal.SIGTERM),
        ("sessions", -signal.SIGTERM),
        ("ignoring", -signal.SIGKILL),
        ("paused", -signal.SIGTERM),
        ("orphans", -signal.SIGTERM),
        ("storm", -signal.SIGKILL),
    ],
)
def test_no_shape_of_tree_survives_the_word(tmp_path: Path, shape: str, code: int) -> None:
    async def test(roll: RollCall) -> None:
        async with ProcessTree(roll.command(shape)) as tree:
            await roll.complete(shape)
            killed = await tree.kill()
            await roll.empty()
            assert killed.survivors == ()
            assert await tree.wait() == code
            assert await tree.kill() == killed
        assert all(map(is_gone, (tree.pid, *tree.supervisors)))

    on_a_roll(tmp_path, test)


def test_leaving_the_block_by_an_error_ends_the_tree(tmp_path: Path) -> None:
    async def test(roll: RollCall) -> None:
        async def work() -> None:
            async with ProcessTree(roll.command("orphans")):
                await roll.complete("orphans")
                raise LookupError

        with pytest.raises(LookupError):
            await work()
        await roll.empty()

    on_a_roll(tmp_path, test)


def test_what_a_program_leaves_behind_is_ended_when_it_ends(tmp_path: Path) -> None:
    async def test(roll: RollCall) -> None:
        async with ProcessTree(roll.command("leaving")) as tree:
            await roll.complete("leaving")
            assert await tree.wait() == 3
            await roll.empty()

    on_a_roll(tmp_path, test)


@pytest.mark.parametrize("steps", range(0, 24, 2))
def test_cancellation_at_any_moment_of_the_start_leaves_nobody(tmp_path: Path, steps: int) -> None:
    async def test(roll: RollCall) -> None:
        async def work() -> None:
            async with ProcessTree(roll.command("ignoring")) as tree:
                await tree.wait()

        working = asyncio.create_task(work())
        for _ in range(steps):
            await asyncio.sleep(0)
        working.cancel()
        with pytest.raises(asyncio.CancelledError):
            await working
        roll.stop_keeping_open()
        await roll.empty()

    on_a_roll(tmp_path, test)


def test_cancelling_the_kill_does_not_spare_the_tree(tmp_path: Path) -> None:
    async def test(roll: RollCall) -> None:
        async with ProcessTree(roll.command("ignoring")) as tree:
            await roll.complete("ignoring")
            killing = asyncio.create_task(tree.kill())
            for _ in range(3):
                await asyncio.sleep(0)
                killing.cancel()
            with pytest.raises(asyncio.CancelledError):
                await killing
            assert roll.members() == []

    on_a_roll(tmp_path, test)


def test_a_loop_that_is_torn_down_in_mid_kill_leaves_nobody(tmp_path: Path) -> None:
    async def test(roll: RollCall) -> None:
        def another_loop() -> None:
            async def work() -> None:
                async with ProcessTree(roll.command("ignoring")) as tree:
                    await tree.wait()

            async def cut() -> None:
                working = asyncio.create_task(work())
                await asyncio.to_thread(complete.result, DEADLINE_S)
                working.cancel()
                await asyncio.sleep(0)  # now it waits for the kill; run() cancels every task there is

            asyncio.run(cut())

        loop = asyncio.get_running_loop()
        complete = asyncio.run_coroutine_threadsafe(roll.complete("ignoring"), loop)
        await asyncio.to_thread(another_loop)
        await roll.empty()

    on_a_roll(tmp_path, test)


# Supervisors and the engine under attack


def kill_warden(tree: ProcessTree) -> None:
    os.kill(tree.supervisors[1], signal.SIGKILL)


def kill_guard(tree: ProcessTree) -> None:
    os.kill(tree.supervisors[0], signal.SIGKILL)


def ask_guard_to_end(tree: ProcessTree) -> None:
    os.kill(tree.supervisors[0], signal.SIGTERM)


@pytest.mark.parametrize("attack", [kill_warden, kill_guard, ask_guard_to_end])
@pytest.mark.parametrize("shape", ["orphans", "storm"])
def test_the_end_of_one_supervisor_ends_the_tree(tmp_path: Path, attack: Attack, shape: str) -> None:
    async def test(roll: RollCall) -> None:
        async with ProcessTree(roll.command(shape)) as tree:
            await roll.complete(shape)
            attack(tree)
            await roll.empty()
            await tree.wait()
            assert (await tree.kill()).survivors == ()
        assert is_gone(tree.supervisors[0])

    on_a_roll(tmp_path, test)


def test_with_both_supervisors_dead_the_engine_finds_the_rest(tmp_path: Path) -> None:
    async def test(roll: RollCall) -> None:
        async with ProcessTree(roll.command("sessions")) as tree:
            await roll.complete("sessions")
            for supervisor in tree.supervisors:
                os.kill(supervisor, signal.SIGSTOP)
            for supervisor in tree.supervisors:
                os.kill(supervisor, signal.SIGKILL)
            assert await tree.wait() == -signal.SIGKILL
            assert (await tree.kill()).survivors == ()
            await roll.empty()

    on_a_roll(tmp_path, test)


def test_paused_supervisors_are_woken_up_for_the_kill(tmp_path: Path) -> None:
    async def test(roll: RollCall) -> None:
        async with ProcessTree(roll.command("orphans")) as tree:
            await roll.complete("orphans")
            for supervisor in tree.supervisors:
                os.kill(supervisor, signal.SIGSTOP)
            assert (await tree.kill()).survivors == ()
            await roll.empty()

    on_a_roll(tmp_path, test)


@pytest.mark.parametrize("shape", ["orphans", "storm"])
@pytest.mark.parametrize("pause_warden", [False, True])
def test_the_death_of_the_engine_ends_the_tree(tmp_path: Path, shape: str, pause_warden: bool) -> None:
    async def test(roll: RollCall) -> None:
        host = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "tests.host", *roll.command(shape), stdout=asyncio.subprocess.PIPE
        )
        assert host.stdout is not None
        pids = list(map(int, (await host.stdout.readline()).split()))
        await roll.complete(shape)
        if pause_warden:
            os.kill(pids[2], signal.SIGSTOP)
        host.kill()
        await host.wait()
        await roll.empty()

    on_a_roll(tmp_path, test)


# Starting


def test_a_program_that_does_not_exist_is_named() -> None:
    async def test() -> None:
        with pytest.raises(ProcessError, match=r"no-such-program cannot be started: No such file") as caught:
            async with ProcessTree(["no-such-program"]):
                pass
        assert caught.value.exit_code is ExitCode.MISSING

    asyncio.run(test())


def test_a_folder_that_does_not_exist_is_named(tmp_path: Path) -> None:
    async def test() -> None:
        with pytest.raises(ProcessError, match="absent"):
            async with ProcessTree(python("pass"), cwd=tmp_path / "absent"):
                pass

    asyncio.run(test())


def test_a_program_knows_its_folder_and_the_variables_that_are_named_and_no_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = ("OPENAI_API_KEY", "github_token", "SAYSO_PLATFORMS__CLOUD__MODEL", "DATABASE_URL", "GH_PAT", "LC_PAT")
    doors = ("SSH_AUTH_SOCK", "DBUS_SESSION_BUS_ADDRESS", "HTTPS_PROXY", "XAUTHORITY", "LD_PRELOAD_", "path")
    for name in (*ours, *doors, "LC_TIME", "ROS_DOMAIN_ID"):
        monkeypatch.setenv(name, "s3cret")

    async def test() -> None:
        program = "import os; print(os.getcwd()); print(*sorted(os.environ), sep=chr(10))"
        async with ProcessTree(
            python(program), env={"COLOUR": "red"}, inherits=["ROS_DOMAIN_ID", "ABSENT"], cwd=tmp_path
        ) as tree:
            folder, *names = [line async for line in tree.lines()]
            assert await tree.wait() == 0
        assert folder == str(tmp_path)
        assert {"COLOUR", "PATH", "LC_TIME", "ROS_DOMAIN_ID", "ORT_DISABLE_TELEMETRY"} <= set(names)
        assert set(names) <= KNOWN | {"COLOUR", "ROS_DOMAIN_ID", MARKER}
        assert not set(names) & {*ours, *doors}

    asyncio.run(test())


def test_a_program_that_ends_at_once_is_not_missed() -> None:
    async def test() -> None:
        for _ in range(25):
            async with ProcessTree(["true"]) as tree, asyncio.timeout(DEADLINE_S):
                assert await tree.wait() == 0

    asyncio.run(test())


def test_a_program_inherits_no_deafness() -> None:
    async def test() -> None:
        async with ProcessTree(["grep", "SigIgn", "/proc/self/status"]) as tree:
            [ignored] = [line async for line in tree.lines()]
        assert int(ignored.split()[1], 16) & 0x7FFFFFFF == 0  # signals 1 to 31; the C library has 32 and 33 for itself

    asyncio.run(test())


# Talking


def test_lines_go_both_ways() -> None:
    async def test() -> None:
        async with ProcessTree(["cat"]) as tree:
            lines = tree.lines()
            for text in ("first", "zweite ä", ""):
                await tree.write(text)
                assert await anext(lines) == text

    asyncio.run(test())


def test_a_program_that_has_ended_hears_nothing_and_that_is_no_error() -> None:
    async def test() -> None:
        async with ProcessTree(python("pass")) as tree:
            assert await tree.wait() == 0
            for _ in range(100):
                await tree.write("x" * 10_000)

    asyncio.run(test())


def test_bad_bytes_long_lines_and_half_lines_are_survived() -> None:
    program = f"""
import sys
out = sys.stdout.buffer
out.write(b"good\\n\\xff\\xfe\\x00bad\\n")
out.write(b"x" * {MAX_LINE + 1} + b"\\n" + b"y" * {5 * MAX_LINE} + b"\\n")
out.write(b"after\\nhalf a li")
"""

    async def test() -> None:
        async with ProcessTree(python(program)) as tree:
            lines = [line async for line in tree.lines()]
        assert lines == ["good", "\ufffd\ufffd\x00bad", "after", "half a li"]
        assert tree.overlong == 2

    asyncio.run(test())


def test_a_line_without_end_takes_bounded_memory() -> None:
    program = f"""
import os
for _ in range(512): os.write(1, b"x" * {1 << 16})
os.write(1, b"\\nover\\n")
"""

    async def test() -> None:
        async with ProcessTree(python(program)) as tree:
            assert await anext(tree.lines()) == "over"

    tracemalloc.start()
    asyncio.run(test())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 4 * MAX_LINE  # of the 32 that were written


def test_the_last_words_are_kept_and_nobody_is_ever_kept_waiting_for_them() -> None:
    program = """
import sys
for number in range(200_000): print("complaint", number, file=sys.stderr)
print("did not block")
sys.exit(5)
"""

    async def test() -> None:
        async with ProcessTree(python(program)) as tree:
            assert [line async for line in tree.lines()] == ["did not block"]
            assert await tree.wait() == 5
            assert tree.last_words.endswith("complaint 199999")
            assert len(tree.last_words) <= 2000

    asyncio.run(test())


def test_who_leaves_as_asked_is_given_the_time_and_his_last_words_are_kept(tmp_path: Path) -> None:
    async def test(roll: RollCall) -> None:
        async with ProcessTree(roll.command("polite"), grace=DEADLINE_S) as tree:
            await roll.complete("polite")
            killed = await tree.kill()
            await roll.empty()
            assert killed.survivors == ()
            assert await tree.wait() == 7
            assert tree.last_words == "leaving as asked"

    on_a_roll(tmp_path, test)
