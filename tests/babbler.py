"""A stand-in for the recogniser process that says what no recogniser says: ``--folder`` names it, in hexadecimal."""

from __future__ import annotations

import argparse
import socket
import sys
from pathlib import Path


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--link", type=int)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--settings")
    args = parser.parse_args(argv)
    with socket.socket(fileno=args.link) as link:
        link.sendall(bytes.fromhex(args.folder.name))
        link.recv(1)  # until the engine has had enough
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
