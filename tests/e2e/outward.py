"""Which addresses a program and its children turn to, in native code too.

The kernel reports every ``connect`` and every addressed ``sendto`` of the program to this process and waits for the
answer (seccomp user notifications, Linux 5.8): what leads off this machine is noted and refused, everything else goes
on. No rights are needed, nothing is preloaded, and no process of the tree can leave the filter.

Run as a program, this file puts the filter on itself, sends its descriptor to who watches, and becomes the program.
"""

from __future__ import annotations

import array
import contextlib
import ctypes
import fcntl
import ipaddress
import os
import platform
import select
import socket
import struct
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

_CALLS = {"x86_64": (0xC000003E, 317, 42, 44), "aarch64": (0xC00000B7, 277, 203, 206)}
"""Of each machine: how the kernel names it (linux/audit.h), and its numbers of seccomp, connect and sendto."""
_NEW_LISTENER, _SET_FILTER, _IS_AVAILABLE, _NO_NEW_PRIVS = 8, 1, 2, 38
_ALLOW, _NOTIFY = 0x7FFF0000, 0x7FC00000
_RECEIVE, _ANSWER, _IS_VALID = 0xC0502100, 0xC0182101, 0x40082102
_GO_ON, _UNREACHABLE = 1, -101
_NOTICE = struct.Struct("=QIIiIQ6Q")  # id, pid, flags, call, machine, instruction, arguments
_DOMAIN_PORT = 53


def missing() -> str:
    """Why nothing can be watched here, or ""."""
    if sys.platform != "linux" or platform.machine() not in _CALLS:
        return "only Linux on x86-64 and aarch64 tells which addresses a program turns to"
    notify = ctypes.c_uint32(_NOTIFY)
    if _libc().syscall(_CALLS[platform.machine()][1], _IS_AVAILABLE, 0, ctypes.byref(notify)) != 0:
        return "this kernel does not tell which addresses a program turns to (seccomp user notifications)"
    return ""


@dataclass
class Watch:
    """What has been watched so far."""

    name: str
    outward: list[str] = field(default_factory=list)
    """Each address off this machine that was turned to, and each name server, wherever it is."""
    seen: int = 0
    """How many connections there were in all."""

    def command(self, argv: Sequence[str]) -> list[str]:
        """The command line that runs this one below the filter."""
        return [sys.executable, __file__, self.name, *argv]


@contextmanager
def watching() -> Iterator[Watch]:
    """Watch the program that is started as :meth:`Watch.command` says; to be left when it has ended."""
    with socket.socket(socket.AF_UNIX) as meeting:
        meeting.bind(b"")  # a name that the kernel chooses
        meeting.listen()
        watch = Watch(meeting.getsockname()[1:].decode())
        thread = threading.Thread(target=_watch, args=(meeting, watch))
        thread.start()
        try:
            yield watch
        finally:
            meeting.shutdown(socket.SHUT_RDWR)  # in case nobody came
            thread.join()


def _watch(meeting: socket.socket, watch: Watch) -> None:
    try:
        link, _ = meeting.accept()
    except OSError:
        return
    with link:
        _, data, _, _ = link.recvmsg(1, socket.CMSG_LEN(4))
    listener = array.array("i", data[0][2])[0]
    poll = select.poll()
    poll.register(listener, select.POLLIN)
    while poll.poll()[0][1] & select.POLLIN:  # else the last process has ended
        notice = bytearray(_NOTICE.size)
        with contextlib.suppress(FileNotFoundError):  # the call was given up meanwhile
            fcntl.ioctl(listener, _RECEIVE, notice)
            number, pid, _, call, _, _, *arguments = _NOTICE.unpack(notice)
            outward = _outward(_address(pid, call, arguments))
            fcntl.ioctl(listener, _IS_VALID, struct.pack("=Q", number))  # what was read is of this process
            watch.seen += 1
            if outward:
                program = Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode()
                watch.outward.append(f"{outward}, by {program}")
            answer = (number, 0, _UNREACHABLE, 0) if outward else (number, 0, 0, _GO_ON)
            fcntl.ioctl(listener, _ANSWER, struct.pack("=QqiI", *answer))
    os.close(listener)


def _address(pid: int, call: int, arguments: Sequence[int]) -> bytes:
    """The socket address that a call names."""
    first = 1 if call == _CALLS[platform.machine()][2] else 4
    with Path(f"/proc/{pid}/mem").open("rb", buffering=0) as memory:
        memory.seek(arguments[first])
        return memory.read(min(arguments[first + 1], 128))


def _outward(address: bytes) -> str:
    """The address, for people, if it leads off this machine or to a name server; else ""."""
    family = struct.unpack_from("=H", address)[0] if len(address) >= 2 else socket.AF_UNSPEC
    if family == socket.AF_UNIX:
        path = address[2:].split(b"\0")[0].decode(errors="replace")
        return path if "resolve" in path else ""
    if family not in (socket.AF_INET, socket.AF_INET6):
        return ""
    port = struct.unpack_from("!H", address, 2)[0]
    host = ipaddress.ip_address(address[4:8] if family == socket.AF_INET else address[8:24])
    mapped = getattr(host, "ipv4_mapped", None) or host
    here = mapped.is_loopback or mapped.is_unspecified  # the latter is connected to as loopback
    return "" if here and port != _DOMAIN_PORT else f"{host} port {port}"


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _filter() -> int:
    """Put the filter on this process; returns the descriptor at which its notices arrive."""
    machine, seccomp, connect, sendto = _CALLS[platform.machine()]
    load, equal, give = 0x20, 0x15, 0x06  # BPF: a word of the call's data, a jump, the verdict
    program = [
        (load, 0, 0, 4),  # the machine
        (equal, 0, 5, machine),
        (load, 0, 0, 0),  # the call
        (equal, 4, 0, connect),
        (equal, 0, 2, sendto),
        (load, 0, 0, 16 + 5 * 8),  # length of the address; 0 on a connected socket
        (equal, 0, 1, 0),
        (give, 0, 0, _ALLOW),
        (give, 0, 0, _NOTIFY),
    ]
    code = b"".join(struct.pack("=HBBI", *instruction) for instruction in program)
    buffer = ctypes.create_string_buffer(code)
    header = struct.pack("@HP", len(program), ctypes.addressof(buffer))
    if _libc().prctl(_NO_NEW_PRIVS, 1, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl")
    listener: int = _libc().syscall(seccomp, _SET_FILTER, _NEW_LISTENER, header)
    if listener < 0:
        raise OSError(ctypes.get_errno(), "seccomp")
    return listener


def _become(name: str, argv: Sequence[str]) -> None:
    with socket.socket(socket.AF_UNIX) as link:
        link.connect(b"\0" + name.encode())
        listener = _filter()
        link.sendmsg([b"."], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [listener]))])
    os.execv(argv[0], list(argv))


if __name__ == "__main__":
    _become(sys.argv[1], sys.argv[2:])
