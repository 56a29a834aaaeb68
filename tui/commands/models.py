"""``sayso models``: which models there are, fetching them, and whether they are what they should be."""

from __future__ import annotations

import contextlib
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence

from config.schema import Settings
from engine.asr.sizes import listed
from engine.errors import ExitCode, SaysoError
from engine.models import ModelStore, Progress
from engine.parts.loading import model_store, voice_to_fetch
from engine.wake.choice import MODEL
from tui.commands.settings import load_settings
from tui.output import data, json_line, say

VERBS = {"wait": "waiting for another download of", "download": "fetching", "join": "writing", "verify": "verifying"}


def run(arguments: Namespace) -> int:
    """The command as the command line gives it."""
    settings = load_settings(arguments)
    store = model_store(settings)
    names = arguments.names or needed(store, settings)
    match arguments.action:
        case "list":
            return models_list(store, json=arguments.json)
        case "pull":
            return models_pull(store, names, json=arguments.json)
        case "verify":
            return models_verify(store, arguments.names or present(store) or names, json=arguments.json)
        case _:
            return models_path(store, names, json=arguments.json)


def needed(store: ModelStore, settings: Settings) -> list[str]:
    """The models that these settings use, but for large ones; the voice's only where there is what it is for. None, if
    they are files of the user's own."""
    # the spotter of a spoken stop listens through MODEL, whatever wakes
    names = (listed(settings.asr.model, store.manifest.models), voice_to_fetch(settings), MODEL)
    return [name for name in names if name is not None and name in store.manifest.models]


def present(store: ModelStore) -> list[str]:
    """The models of which there is something to verify."""
    return [status.model.name for status in store.list() if status.state in {"ready", "damaged"}]


def models_list(store: ModelStore, *, json: bool = False) -> int:
    """One line a model: name, state, size, memory, licence, what it is."""
    for status in store.list():
        model = status.model
        if json:
            json_line(
                {
                    "name": model.name,
                    "kind": model.kind,
                    "state": status.state,
                    "default": model.default,
                    "size_bytes": model.size,
                    "memory_mb": model.memory_mb,
                    "licence": model.licence,
                    "description": model.description,
                    "folder": str(status.folder),
                }
            )
        else:
            size = f"{model.size / 1e6:.0f} MB"
            data(f"{model.name:<20} {status.state:<8} {size:>8}  {model.licence:<11} {model.description}")
    return int(ExitCode.DONE)


def models_pull(store: ModelStore, names: Sequence[str], *, json: bool = False) -> int:
    """Fetch models; prints the folder of each. What is complete is kept when it fails or is interrupted."""
    if not names:
        say("sayso: nothing to pull: the models are files of yours.")
    for name in names:
        try:
            with _shown_progress() as show:
                folder = store.pull(name, show)
        except KeyboardInterrupt:
            say("sayso: interrupted; what was fetched is kept, and the same command goes on from there.")
            return int(ExitCode.INTERRUPTED)
        if json:
            json_line({"name": name, "state": "ready", "folder": str(folder)})
        else:
            data(str(folder))
    return int(ExitCode.DONE)


def models_verify(store: ModelStore, names: Sequence[str], *, json: bool = False) -> int:
    """Compare every byte with the manifest; one line a file. Exit code 3 when a file is not as it should be."""
    wrong = []
    for name in names:
        with _shown_progress() as show:
            result = store.verify(name, show)
        if not result.ok:
            wrong.append(name)
        for file in result.files:
            if json:
                json_line({"name": name, "file": str(file.path), "state": file.state})
            else:
                data(f"{file.state:<10} {file.path}")
    if wrong:
        say(f"sayso: not as it should be: {', '.join(wrong)}. Run: sayso models pull {' '.join(wrong)}")
    return int(ExitCode.MISSING if wrong else ExitCode.DONE)


def models_path(store: ModelStore, names: Sequence[str], *, json: bool = False) -> int:
    """The folder of each model. Exit code 3 when one is not there."""
    code = ExitCode.DONE
    for name in names:
        try:
            folder = store.find(name)
        except SaysoError as error:
            say(f"sayso: {error}")
            code = error.exit_code
        else:
            if json:
                json_line({"name": name, "folder": str(folder)})
            else:
                data(str(folder))
    return int(code)


@contextlib.contextmanager
def _shown_progress() -> Iterator[Callable[[Progress], None]]:
    """A bar on stderr, or one plain line a step where stderr is no terminal."""
    if not sys.stderr.isatty():
        yield _plain_lines()
        return
    from rich.console import Console
    from rich.progress import BarColumn, DownloadColumn, TaskID, TextColumn, TransferSpeedColumn
    from rich.progress import Progress as Bars

    columns = (TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TransferSpeedColumn())
    with Bars(*columns, console=Console(stderr=True), transient=True) as bars:
        tasks: dict[tuple[str, str], TaskID] = {}

        def show(progress: Progress) -> None:
            step = progress.stage, progress.part
            if step not in tasks:
                for task in tasks.values():
                    bars.remove_task(task)
                tasks.clear()
                tasks[step] = bars.add_task(f"{VERBS[progress.stage]} {progress.part}", total=None)
            bars.update(tasks[step], completed=progress.done_bytes, total=progress.total_bytes or None)

        yield show


def _plain_lines() -> Callable[[Progress], None]:
    told: set[tuple[str, str]] = set()

    def show(progress: Progress) -> None:
        step = progress.stage, progress.part
        if step not in told:
            told.add(step)
            say(f"sayso: {VERBS[progress.stage]} {progress.part}")

    return show
