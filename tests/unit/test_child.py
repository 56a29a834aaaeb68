"""A child that cannot be started is one error, wherever that fails, and leaves nothing open."""

from __future__ import annotations

import gc
import os
import resource
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import pytest

from engine.child import Child
from engine.errors import ProcessError
from tests.open_files import open_files

LIMIT_S = 30.0


@contextmanager
def no_more_files_than(more: int) -> Iterator[None]:
    """Whatever is opened gets the lowest number that is free: at most so many are left.

    What earlier tests left to the garbage collector is collected first: a file of theirs that closes meanwhile would be
    one number more.
    """
    gc.collect()
    lowest = os.dup(0)
    os.close(lowest)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (lowest + more, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def started() -> Child:
    return Child("little", "this")


def test_a_process_for_which_there_are_too_few_descriptors_is_an_error_and_leaves_none_behind() -> None:
    before, failures = open_files(), list[str]()
    for more in count():
        try:
            with no_more_files_than(more):
                child = started()
        except ProcessError as error:
            failures.append(error.message)
        else:
            break
    child.discard()
    assert all("The little process cannot be started: [Errno 24]" in message for message in failures)
    assert len(failures) > 4, "it failed at the link, at the file for its last words, and later"
    assert not Counter(open_files()) - Counter(before), "what others left may be collected meanwhile"


def test_a_full_disk_keeps_no_process_from_starting(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    started().discard()
