"""A setting changed from within sayso: the rest of the file stays as it was written, and nothing is half written."""

from __future__ import annotations

import resource
import signal
import stat
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from config import load
from config.changing import Layers, NotWritten, change, choices, described, give_back, overriding
from config.editing import NotEditable, with_value, without

THEME = ("console", "theme")
WRITTEN = """\
# mine
console:
  fps: 6      # the line is slow
  # theme: sayso-light

  keys: {wake: w}   # and so on
voice:
  when: never
# the end
"""

# The text


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", "console:\n  theme: nord\n"),
        ("# nothing yet", "# nothing yet\nconsole:\n  theme: nord\n"),
        ("console:\n", "console:\n  theme: nord\n"),
        ("console: # look\n  # theme: x\n", "console: # look\n  theme: nord\n  # theme: x\n"),
        ("console:\n    fps: 6  # slow\n\n# end", "console:\n    fps: 6  # slow\n    theme: nord\n\n# end"),
        ("console:\r\n  theme: old # why\r\n", "console:\r\n  theme: nord # why\r\n"),
        ("console:\n  theme:   # none\n  fps: 6", "console:\n  theme: nord   # none\n  fps: 6"),
        ("console: {fps: 6} # one line\n", "console: {fps: 6, theme: nord} # one line\n"),
        ("console: {}\n", "console: {theme: nord}\n"),
        ("{console: {theme: 'a b', fps: 6}}", "{console: {theme: nord, fps: 6}}"),
        ("voice: {when: never}\n", "voice: {when: never}\nconsole:\n  theme: nord\n"),
        ("console:\n  theme: |\n    old\n  fps: 6\n", "console:\n  theme: nord\n  fps: 6\n"),
    ],
)
def test_a_value_is_put_where_it_belongs(before: str, after: str) -> None:
    assert with_value(before, THEME, "nord") == after


def test_a_list_in_lines_becomes_one_in_a_line() -> None:
    before = "wake:\n  words: # calls\n    - hey rosie\n    - hey you\n  # more\n  threshold: 0.5\n"
    after = with_value(before, ("wake", "words"), ["嘿机器人", "hey: you"])
    assert after == "wake:\n  words: [嘿机器人, 'hey: you'] # calls\n  # more\n  threshold: 0.5\n"


@pytest.mark.parametrize("value", ["true", "1e3", "null", "1:30", "", " a", "# b", "no", "a: b", "[x", "😀", "on"])
def test_text_stays_text_whatever_it_looks_like(value: str) -> None:
    assert with_value("", THEME, value) == with_value(with_value("", THEME, "x"), THEME, value)


def test_what_is_taken_out_leaves_the_rest() -> None:
    assert without(WRITTEN, ("console", "fps")) == WRITTEN.replace("  fps: 6      # the line is slow\n", "")
    assert without("console: {fps: 6, theme: x, keys: {}}", THEME) == "console: {fps: 6, keys: {}}"
    assert without("console: {fps: 6, theme: x}", THEME) == "console: {fps: 6}"
    assert without(WRITTEN, ("asr", "model")) == WRITTEN


@pytest.mark.parametrize("text", ["console: 3\n", "a: b: c", "console: &x {fps: 3}\n", "- a\n", "a: 1\na: 2\n"])
def test_what_is_no_such_file_is_left_to_its_writer(text: str) -> None:
    with pytest.raises(NotEditable):
        with_value(text, THEME, "nord")


@given(
    rows=st.lists(
        st.sampled_from(["  theme: a # t", "  fps: 3", "# c1", "", "    # c2", "  keys: {wake: w} # k", "  motion:"]),
        max_size=6,
        unique=True,
    ),
    beside=st.sampled_from(["", "voice: {when: never}", "voice:\n  when: never # quiet", "# only words"]),
    value=st.one_of(st.text(max_size=12), st.integers(-999, 999), st.booleans(), st.none()),
)
@example(rows=["  theme: a # t", "  fps: 3", "# c1", ""], beside="", value="\n")
def test_comments_and_other_values_survive_any_change(rows: list[str], beside: str, value: str | int | None) -> None:
    text = "\n".join(["# first", *([beside] if beside else []), "console: # here", *rows, "# last"])
    try:
        changed = with_value(text, THEME, value)
    except NotEditable:
        assert isinstance(value, str)  # signs that no YAML may hold
        return
    kept = [row for row in text.splitlines() if not row.startswith("  theme")]
    lines = changed.splitlines()
    for row in kept:
        assert row in lines
    assert [row for row in lines if row in kept] == kept or len(set(kept)) < len(kept)
    back = without(changed, THEME).splitlines()
    assert back == kept


# The file


@pytest.fixture
def layers(tmp_path: Path) -> Layers:
    return Layers(environ={}, folder=tmp_path / "config")


def test_the_first_setting_makes_the_file_which_is_its_owners_alone(layers: Layers) -> None:
    changed = change(layers, THEME, "nord")
    assert stat.S_IMODE(changed.file.stat().st_mode) == 0o600
    assert (changed.setting.value, changed.setting.origin) == ("nord", f"{changed.file}:2")
    assert layers.load().console.theme == "nord"
    assert not changed.overridden
    assert [path.name for path in changed.file.parent.iterdir()] == ["config.yaml"]


def test_a_file_keeps_its_mode_its_words_and_its_place(layers: Layers, tmp_path: Path) -> None:
    assert layers.folder is not None
    layers.folder.mkdir()
    kept = tmp_path / "dotfiles.yaml"
    kept.write_text(WRITTEN)
    kept.chmod(0o640)
    (layers.folder / "config.yaml").symlink_to(kept)
    change(layers, THEME, "nord")
    assert (layers.folder / "config.yaml").is_symlink()
    assert stat.S_IMODE(kept.stat().st_mode) == 0o640
    assert kept.read_text() == WRITTEN.replace("wake: w}   # and so on\n", "wake: w}   # and so on\n  theme: nord\n")
    give_back(layers, THEME)
    assert kept.read_text() == WRITTEN


def test_a_setting_is_changed_in_the_file_that_says_it(layers: Layers) -> None:
    assert layers.folder is not None
    layers.folder.mkdir()
    other = layers.folder / "robot.yaml"
    other.write_text("console: {theme: nord}\n")
    assert change(layers, THEME, "dracula").file == other
    assert layers.load().console.theme == "dracula"
    assert give_back(layers, THEME).file == other
    assert give_back(layers, THEME).file is None, "nothing is left to be taken out"
    assert layers.load().console.theme == load(environ={}, user_folder=Path("none")).console.theme


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("console", "fps"), 99, "up to 30"),
        (("voice", "volume"), "loud", "a number from 0 up to 1"),
        (("console", "camera"), "sometimes", "auto | on | off"),
        (("audio", "device"), "a\ud800", "YAML cannot be read"),
        (("planner", "profile"), "mine", "there is no profile called mine"),
    ],
)
def test_what_the_schema_does_not_allow_is_not_written(
    layers: Layers, path: tuple[str, ...], value: str | int, words: str
) -> None:
    with pytest.raises(NotWritten, match=words.replace("|", r"\|")):
        change(layers, path, value)
    assert not layers.own[0].exists()


def test_what_goes_before_the_file_is_named(layers: Layers) -> None:
    environ = {"SAYSO_CONSOLE__THEME": "nord"}
    by_variable = Layers(environ=environ, folder=layers.folder)
    changed = change(by_variable, THEME, "dracula")
    assert changed.overridden
    assert overriding(changed.setting, by_variable) == "SAYSO_CONSOLE__THEME"
    assert layers.load().console.theme == "dracula"
    by_option = Layers(overrides=("console.theme=nord",), environ={}, folder=layers.folder)
    assert overriding(by_option.explain()["console.theme"], by_option) == "--set console.theme"
    assert overriding(layers.explain()["console.theme"], layers) == ""
    assert overriding(layers.explain()["console.fps"], layers) == ""


def test_a_full_disk_leaves_the_old_file_and_nothing_else(layers: Layers) -> None:
    file = change(layers, THEME, "nord").file
    file.write_text(before := "# long\n" * 50 + file.read_text())
    limit, ignored = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limit[1]))
    try:
        with pytest.raises(NotWritten, match=r"config\.yaml could not be written: File too large; it is as it was"):
            change(layers, THEME, "dracula")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        signal.signal(signal.SIGXFSZ, ignored)
    assert file.read_text() == before
    assert list(file.parent.iterdir()) == [file]


def test_the_schema_says_what_a_setting_means_and_may_be() -> None:
    assert described(("console", "fps")) == "How often moving panes are redrawn."
    assert choices(("console", "camera")) == ("auto", "on", "off")
    assert choices(("voice", "sounds")) == ("true", "false")
    assert choices(("voice", "volume")) == ()
