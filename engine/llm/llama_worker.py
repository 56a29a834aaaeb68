"""The process of the local model: ``python -m engine.llm.llama_worker``, started by ``engine.llm.llama.LlamaProcess``.

It loads a GGUF file with llama.cpp and lets llama.cpp's own server listen on a UNIX socket in a folder that only this
user can enter: no port, no network. Over the link it says once how that went, one line of JSON, and it ends when the
link does. Models go after everybody else: they may take long, and a robot that moves may not wait for them.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import os
import shutil
import signal
import socket
import sys
from pathlib import Path

import msgspec

NICENESS = 5
"""Below the recogniser, which has to hear a "stop" while the model thinks."""
_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
_ERRORS = 1  # llama.cpp's verbosity: what it says of every request would fill the disk one day
_HTTP_THREADS = 3


class Up(msgspec.Struct, frozen=True, tag=True):
    """The model is loaded and listens. ``pausable``: it ends with the engine also while it is paused."""

    pausable: bool


class Failed(msgspec.Struct, frozen=True, tag=True):
    """It cannot be loaded; ``reason`` completes "cannot be loaded: …"."""

    reason: str
    library: bool = False
    """The fault is llama.cpp's own, not the model's."""


Word = Up | Failed
WORDS: msgspec.json.Decoder[Word] = msgspec.json.Decoder(Word)


def load(arguments: argparse.Namespace) -> object | Failed:
    """The running server. Its threads listen from now on."""
    try:
        import xllamacpp
    except ImportError as error:
        return Failed(str(error), library=True)
    params = xllamacpp.CommonParams()
    params.model.path = str(arguments.gguf)
    params.hostnames = [str(arguments.socket)]
    params.slot_save_path = f"{arguments.states}{os.sep}"
    params.endpoint_slots = True  # saving and restoring
    params.n_parallel = arguments.slots
    params.n_ctx = arguments.context * arguments.slots
    params.kv_unified = False  # each slot has a context of its own
    # A prompt is computed in batches, and nothing is asked or cancelled within one.
    params.n_batch = params.n_ubatch = arguments.batch
    params.cpuparams.n_threads = params.cpuparams_batch.n_threads = arguments.threads
    # On a processor, and for few new tokens behind many known ones, the plain way is a fifth faster.
    params.flash_attn_type = xllamacpp.llama_flash_attn_type.LLAMA_FLASH_ATTN_TYPE_DISABLED
    params.n_threads_http = _HTTP_THREADS
    params.cache_ram_mib = 0  # copies of prompts in memory: the slots are enough
    params.n_ctx_checkpoints = 0
    params.fit_params = False  # as told, or not at all
    params.warmup = False
    params.ui = False
    params.verbosity = _ERRORS
    try:
        server: object = xllamacpp.Server(params)
    except (RuntimeError, MemoryError, ValueError) as error:
        return Failed(str(error) or repr(error))
    return server


def wake_without_the_engine() -> bool:
    """Have the kernel let this process go on, should it be paused, when the thread that started it ends: it finds the
    end of its link then. Whether that can be had (Linux)."""
    if sys.platform != "linux":
        return False
    done: int = ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, ctypes.c_ulong(signal.SIGCONT))
    return done == 0


def main(argv: list[str]) -> int:
    """Load the model, say how it went, and stay until the engine goes."""
    parser = argparse.ArgumentParser(prog="python -m engine.llm.llama_worker", description="Internal to sayso.")
    parser.add_argument("--link", type=int, required=True, help="an inherited file descriptor")
    parser.add_argument("--gguf", type=Path, required=True)
    parser.add_argument("--socket", type=Path, required=True, help="where it will listen; its folder goes at the end")
    parser.add_argument("--states", type=Path, required=True, help="folder of saved prompts")
    parser.add_argument("--slots", type=int, required=True, help="conversations that it keeps at a time")
    parser.add_argument("--context", type=int, required=True, help="tokens of each of them")
    parser.add_argument("--batch", type=int, required=True, help="tokens that are computed at a time")
    parser.add_argument("--threads", type=int, required=True)
    arguments = parser.parse_args(argv)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the engine's business
    pausable = wake_without_the_engine()
    os.umask(0o077)
    with contextlib.suppress(OSError):
        os.nice(NICENESS)
    link = socket.socket(fileno=arguments.link)
    try:
        server = load(arguments)
        word: Word = server if isinstance(server, Failed) else Up(pausable)
        with contextlib.suppress(OSError):  # the engine may have gone: the link tells
            link.sendall(msgspec.json.encode(word) + b"\n")
        if isinstance(word, Up):
            while link.recv(1):  # nothing is ever sent: this is the end of the link
                pass
    finally:
        shutil.rmtree(arguments.socket.parent, ignore_errors=True)
    os._exit(0 if isinstance(word, Up) else 1)  # without llama.cpp's own tidying up, which waits for its threads


if __name__ == "__main__":
    main(sys.argv[1:])
