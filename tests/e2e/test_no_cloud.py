"""Nothing of sayso turns to another machine that is not configured, and no library of its leaves its own traces."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from config.folders import paths
from tests.e2e.engine import engine
from tests.e2e.outward import Watch, missing, watching
from tests.e2e.sayso import LIMIT_S, environment
from tests.e2e.terminal import TO_THE_PANES, console

GRAPHICS = "mesa_shader_cache"
"""What OpenGL keeps for itself."""


@pytest.fixture
def watch() -> Iterator[Watch]:
    if reason := missing():
        pytest.skip(reason)
    with watching() as watch:
        yield watch


@pytest.fixture
def home(tmp_path: Path) -> Path:
    home = tmp_path / "home"
    home.mkdir()
    return home


def new_user(home: Path) -> dict[str, str]:
    """The environment of a user who has the models, and nothing else."""
    folders = {"HOME": home, "XDG_CACHE_HOME": home / ".cache", "SAYSO_CACHE_DIR": paths().cache}
    return {name: str(folder) for name, folder in folders.items()} | {"ORT_DISABLE_TELEMETRY": "0"}


def left_in(home: Path) -> list[Path]:
    return [path for path in home.rglob("*") if path.is_file() and GRAPHICS not in path.parts]


@pytest.mark.model
def test_the_engine_turns_to_no_other_machine(tmp_path: Path, home: Path, watch: Watch) -> None:
    environ = new_user(home) | {"SAYSO_ROBOT__SPEED": "max", "SAYSO_VOICE__WHEN": "always"}
    with engine(tmp_path, environ=environ, source="demo", below=watch.command) as running:
        running.until_loaded("wake words", "camera")
        running.send(do="say", text="patrol")  # a program
        running.until("robot.state", lambda state: state["moving"])
        running.send(do="quit")
        running.rest()
        assert running.process.wait(LIMIT_S) == 0
    assert left_in(home) == []
    assert watch.outward == []


@pytest.mark.model
def test_the_console_turns_to_no_other_machine(tmp_path: Path, home: Path, watch: Watch) -> None:
    with console("--demo", state=tmp_path, below=watch.command, environ=new_user(home)) as terminal:
        terminal.until(lambda: any(event["kind"] == "action.finished" for event in terminal.events()))
        terminal.type(TO_THE_PANES + "q")
        assert terminal.wait() == 0
    assert left_in(home) == []
    assert watch.outward == []


@pytest.mark.parametrize(
    "module",
    [
        "tui.cli",
        "engine.tts.worker",
        "engine.asr.worker",
        "engine.perception.onlooker_worker",
        "engine.skills.external.guest",
    ],
)
def test_no_program_of_ours_lets_onnxruntime_write_a_device_id(tmp_path: Path, home: Path, module: str) -> None:
    pytest.importorskip("onnxruntime")
    code = f"import {module}, onnxruntime, huggingface_hub.constants as hub; print(hub.HF_HUB_DISABLE_TELEMETRY)"
    environ = environment(tmp_path, new_user(home))
    done = subprocess.run([sys.executable, "-c", code], env=environ, capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
    assert left_in(home) == []


def test_the_watch_sees_a_name_that_is_looked_up_and_an_address_in_a_child(watch: Watch) -> None:
    looks_up = "import socket, contextlib\nwith contextlib.suppress(OSError): socket.getaddrinfo('sayso.invalid', 80)"
    connects = "import socket\nwith socket.socket() as link: link.connect_ex(('192.0.2.1', 80))"  # RFC 5737: nobody's
    code = f"{looks_up}\nimport subprocess, sys\nsubprocess.run([sys.executable, '-c', {connects!r}])"
    subprocess.run(watch.command([sys.executable, "-c", code]), check=True, timeout=LIMIT_S)
    assert any(" port 53," in address or "resolve" in address for address in watch.outward)
    assert any(address.startswith("192.0.2.1 port 80,") for address in watch.outward)
