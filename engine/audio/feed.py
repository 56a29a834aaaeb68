"""The door for sound from outside: somebody else's microphone, handed to the sayso that runs on this machine.

A sayso that hears keeps a local socket in this user's state folder, which nobody else may open and no network leads to
(``ssh`` does: ``arecord … | ssh robot sayso mic``). Whoever connects says in one JSON line where the sound comes from,
gets one JSON line back, and is heard like a microphone until they leave. There is one guest at a time. One from
whom nothing comes any more is let go, and told so in another such line.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import fcntl
import os
import select
import socket
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType

import msgspec

from config.private import private_folder
from engine.audio.pipe import READ_BYTES, GuestSource
from engine.errors import AudioFormatError, DeviceError, SaysoError, StorageError

GREETING_S = 5.0
"""How long either side may take for its first line, s."""

IDLE_S = 5.0
"""A guest who has sent nothing for so long gives way to a new one, s: a connection can hang for minutes."""

SILENT_S = 30.0
"""A guest who has sent nothing for so long is let go, s: raw sound in which nobody speaks is bytes all the same, and an
SSH connection that dies does so without a word."""

_LINE_BYTES = 500
_NAME_SIGNS = 60
_LONGEST_PATH = 100  # bytes; systems allow 104 or 108


class Greeting(msgspec.Struct, frozen=True):
    """What a guest says first."""

    source: str  # for people: ssh microphone
    pauses: bool = False  # nothing may come for as long as nobody speaks


class Welcome(msgspec.Struct, frozen=True):
    """The answer; with a ``refusal`` the guest is not heard, or not any more, and that is why."""

    pid: int
    refusal: str = ""


class Door:
    """Lets in one guest at a time and tells ``on_guest``, in the loop's thread; the source ends when they leave.

    Entering raises ``DeviceError`` when another sayso of this user has a door already, and ``StorageError`` where none
    can be made.
    """

    def __init__(self, path: Path, on_guest: Callable[[GuestSource], None]) -> None:
        self._path = path
        self._on_guest = on_guest
        self._guest: GuestSource | None = None
        self._visit: asyncio.Task[None] | None = None  # of the guest
        self._visits: set[asyncio.Task[None]] = set()  # of everybody who has knocked
        self._closing = contextlib.ExitStack()

    async def __aenter__(self) -> Door:
        with contextlib.ExitStack() as opened:
            try:
                private_folder(self._path.parent)
                opened.enter_context(_locked(self._path.with_suffix(".lock")))
                self._path.unlink(missing_ok=True)  # of a sayso that was killed: its lock went with it
                opened.callback(self._path.unlink, missing_ok=True)
                server = await asyncio.start_unix_server(self._knock, sock=_listening(self._path))
            except BlockingIOError as error:
                raise DeviceError("Another sayso of yours already gets the sound of `sayso mic`.") from error
            except OSError as error:
                why = f"{self._path}: {error.strerror or error}"
                raise StorageError(f"Sound from outside (`sayso mic`) cannot be taken: {why}.") from error
            opened.callback(server.close)
            self._closing = opened.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._closing.close()
        for visit in self._visits:
            visit.cancel()
        await asyncio.gather(*self._visits, return_exceptions=True)

    def _knock(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        visit = asyncio.get_running_loop().create_task(self._receive(reader, writer), name="guest")
        self._visits.add(visit)
        visit.add_done_callback(self._visits.discard)

    async def _receive(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One guest, from the first word to the last."""
        guest: GuestSource | None = None
        try:
            if not _is_ours(writer.get_extra_info("socket")):
                raise OSError("it is of another user")
            async with asyncio.timeout(GREETING_S):
                greeting = msgspec.json.decode(await reader.readline(), type=Greeting)
            refusal = self._refusal()
            writer.write(_line(Welcome(os.getpid(), refusal)))
            await writer.drain()
            if not refusal:
                guest = self._let_in(greeting)
                try:
                    while sound := await _next(reader, None if greeting.pauses else SILENT_S):
                        guest.push(sound)
                except TimeoutError:
                    writer.write(_line(Welcome(os.getpid(), f"no sound has come for {SILENT_S:g} s")))
        except (OSError, ValueError, msgspec.MsgspecError):  # gone, or never a guest
            pass
        finally:
            if guest is not None:
                guest.finish()
                self._guest = None if self._guest is guest else self._guest
            writer.close()

    def _let_in(self, greeting: Greeting) -> GuestSource:
        if self._visit is not None:
            self._visit.cancel()  # the one who said nothing any more
        name = "".join(sign for sign in greeting.source[:_NAME_SIGNS] if sign.isprintable())
        self._guest, self._visit = GuestSource(name or "somebody's microphone"), asyncio.current_task()
        self._on_guest(self._guest)
        return self._guest

    def _refusal(self) -> str:
        if self._guest is None or self._guest.idle_s > IDLE_S:
            return ""
        return f"it hears somebody else already ({self._guest.name})"


def feed(path: Path, sound: int, source: str, on_welcome: Callable[[int], None], *, pauses: bool = False) -> None:
    """Hand raw sound from a file descriptor over until it ends; blocks. ``source`` is its name for people;
    ``on_welcome`` gets the process id of the sayso that hears it. ``pauses``: nothing may come while nobody speaks, and
    whoever calls this sees to it that it ends when its other side has gone.

    Raises ``DeviceError`` when no sayso runs here, it does not take the sound, or it ends meanwhile, and
    ``AudioFormatError`` when the sound is not raw.
    """
    with _connected(path) as link:
        welcome = _welcome(link, Greeting(source, pauses))
        if welcome.refusal:
            hint = "Wait until they have finished, or end their `sayso mic`."
            raise DeviceError(f"The sayso here (process {welcome.pid}) refuses: {welcome.refusal}.", hint=hint)
        on_welcome(welcome.pid)
        data = b""
        while True:
            ready, _, _ = select.select([link.fileno(), sound], [], [])
            if link.fileno() in ready:  # it has nothing more to say but goodbye
                raise _goodbye(link)
            began, data = bool(data), os.read(sound, READ_BYTES)
            if not data:
                return
            if not began and data.startswith((b"RIFF", b"RF64")):
                hint = "Without a header it is right: add -t raw to arecord, or use `sayso hear` for a recording."
                raise AudioFormatError("This is a WAV file, and `sayso mic` takes raw sound.", hint=hint)
            try:
                link.sendall(data)
            except OSError as error:
                raise _ended() from error


def _line(words: Greeting | Welcome) -> bytes:
    return msgspec.json.encode(words) + b"\n"


async def _next(reader: asyncio.StreamReader, silent_s: float | None) -> bytes:
    """What a guest sends next, nothing at the end. Raises ``TimeoutError`` where nothing has come for so long."""
    async with asyncio.timeout(silent_s):
        return await reader.read(READ_BYTES)


def _connected(path: Path) -> socket.socket:
    link = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        with _address(path) as address:
            link.connect(address)
        if not _is_ours(link):
            raise PermissionError(errno.EPERM, "another user takes the sound there", str(path))
    except OSError as error:
        link.close()
        if isinstance(error, FileNotFoundError | ConnectionRefusedError):
            hint = "Start one first: sayso, or sayso engine. It takes a moment to load."
            raise DeviceError("No sayso that hears runs on this machine for this user.", hint=hint) from error
        raise DeviceError(f"The sayso here cannot be reached: {path}: {error.strerror or error}.") from error
    return link


def _welcome(link: socket.socket, greeting: Greeting) -> Welcome:
    line = b""
    link.settimeout(GREETING_S)
    try:
        link.sendall(_line(greeting))
        while not line.endswith(b"\n"):
            if not (data := link.recv(_LINE_BYTES)):
                raise _ended()
            line += data
        return msgspec.json.decode(line, type=Welcome)
    except ConnectionError as error:
        raise _ended() from error
    except (OSError, msgspec.MsgspecError) as error:
        raise DeviceError(f"The sayso here does not answer: {error}.", hint="Is it paused?") from error
    finally:
        link.settimeout(None)


def _goodbye(link: socket.socket) -> SaysoError:
    """What it said last, where it said anything."""
    try:
        told = msgspec.json.decode(link.recv(_LINE_BYTES), type=Welcome)
    except (OSError, msgspec.MsgspecError):
        return _ended()
    hint = "Look after the microphone and the connection to it, and start `sayso mic` again."
    return DeviceError(f"The sayso here (process {told.pid}) does not hear this any more: {told.refusal}.", hint=hint)


def _ended() -> SaysoError:
    return DeviceError("The sayso that heard this has ended, or hears somebody else now.")


def _listening(path: Path) -> socket.socket:
    """A socket that only its owner can open."""
    made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        with _address(path) as address, _born_private(made):
            made.bind(address)
        path.chmod(0o600)
    except OSError:
        made.close()
        raise
    return made


def peer_uid(link: socket.socket) -> int:
    """The user at the other end of a local socket, as the kernel knows it. Raises ``OSError``."""
    if hasattr(socket, "SO_PEERCRED"):  # Linux
        user: int = struct.unpack("3i", link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))[1]  # pid, uid, gid
        return user
    # struct xucred (sys/ucred.h): version, uid, groups; level SOL_LOCAL, option LOCAL_PEERCRED (sys/un.h)
    _, user = struct.unpack_from("2I", link.getsockopt(0, 1, 76))
    return user


def _is_ours(link: socket.socket) -> bool:
    """Whether the other end is this user's, or root's, who may do anything."""
    return peer_uid(link) in (os.geteuid(), 0)


@contextlib.contextmanager
def _born_private(made: socket.socket) -> Iterator[None]:
    """Within this the file of a socket is its owner's alone from its first moment."""
    before = None
    try:
        os.fchmod(made.fileno(), 0o600)  # on Linux the file is born with it
    except OSError:  # elsewhere a socket has no mode; the umask is that of all threads, hence not everywhere
        before = os.umask(0o077)
    try:
        yield
    finally:
        if before is not None:
            os.umask(before)


@contextlib.contextmanager
def _address(path: Path) -> Iterator[str]:
    """A name for the socket that is short enough, by way of its folder where that must be (Linux)."""
    if len(os.fsencode(path)) <= _LONGEST_PATH or not Path("/proc/self/fd").is_dir():
        yield str(path)
        return
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock that ends with this process, however that ends. Raises ``BlockingIOError`` when somebody holds it."""
    lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(lock)
