"""Settings come from their layers in order, and every mistake is told with its place and its remedy."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml
from faster_whisper.tokenizer import _LANGUAGE_CODES
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from config import ConfigError, Problem, check, explain, load, paths, show
from config.source import MAX_BYTES, Node, SourceError, parse
from tui.commands.config import config_check, config_path, config_show

NOWHERE = Path("no-such-folder")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path


@pytest.fixture
def problems(tmp_path: Path) -> Callable[..., list[str]]:
    """The problems of one user file, without its folder's name."""

    def found(text: str | bytes, **environ: str) -> list[str]:
        (tmp_path / "config.yaml").write_bytes(text.encode() if isinstance(text, str) else text)
        told = check(environ=environ, user_folder=tmp_path)
        return [str(problem).replace(f"{tmp_path}/", "") for problem in told]

    return found


# Layers


def test_the_packaged_defaults_are_complete_and_right() -> None:
    loaded = load(environ={}, user_folder=NOWHERE)
    assert loaded.asr.model == "whisper-base"
    assert loaded.places["A"].name == "kitchen"


def test_each_layer_wins_over_the_one_before(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("endpoint: {start_s: 0.2, silence_s: 0.2, no_speech_s: 2, max_length_s: 2}")
    given_file = tmp_path / "given.yaml"
    given_file.write_text("endpoint: {silence_s: 0.3, no_speech_s: 3, max_length_s: 3}")
    loaded = load(
        files=[given_file],
        overrides=["endpoint.max_length_s=5"],
        environ={"SAYSO_ENDPOINT__NO_SPEECH_S": "4", "SAYSO_ENDPOINT__MAX_LENGTH_S": "4"},
        user_folder=tmp_path,
    ).endpoint
    assert loaded.pre_roll_s == 0.3
    assert (loaded.start_s, loaded.silence_s, loaded.no_speech_s, loaded.max_length_s) == (0.2, 0.3, 4, 5)


def test_any_user_file_may_hold_any_section(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text("audio: {device: 3}")
    (tmp_path / "platforms.yaml").write_text("robot: {limits: {linear_speed: 0.2}}")
    loaded = load(environ={"SAYSO_CONFIG_DIR": str(tmp_path)})
    assert loaded.audio.device == 3
    assert loaded.robot.limits.linear_speed == 0.2
    assert loaded.robot.limits.angular_speed == 3.2


def test_a_section_whose_lines_are_all_commented_out_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("asr:\n#  model: other\nrobot:\n  limits:\nplaces:\n")
    assert load(environ={}, user_folder=tmp_path) == load(environ={}, user_folder=NOWHERE)


def test_a_place_that_is_set_to_null_is_gone(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text("places: {A: null}")
    assert "A" not in load(environ={}, user_folder=tmp_path).places
    assert "B" not in load(environ={"SAYSO_PLACES__B": "null"}, user_folder=NOWHERE).places
    assert "C" not in load(overrides=["places.C=null"], environ={}, user_folder=NOWHERE).places


def test_a_whole_new_place_inherits_no_names_from_the_one_it_replaces(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text("places: {B: {name: boat house, position: {x: 1, y: 2}}}")
    place = load(environ={}, user_folder=tmp_path).places["B"]
    assert (place.name, place.aliases, place.orientation.w) == ("boat house", (), 1)


def test_a_part_of_a_place_amends_it(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text("places: {B: {position: {x: -2}}}")
    place = load(environ={"SAYSO_PLACES__b__NAME": "salon"}, user_folder=tmp_path).places["B"]
    assert (place.name, place.position.x, place.position.y) == ("salon", -2, 0)
    assert "lounge" in place.aliases


def test_a_skill_is_amended_replaced_added_and_removed_like_a_place(tmp_path: Path) -> None:
    (tmp_path / "skills.yaml").write_text("skills: {patrol: {silence_s: null}, follow: {does: Follow., external: [f]}}")
    skills = load(environ={}, user_folder=tmp_path).skills
    assert skills["patrol"].silence_s is None
    assert skills["patrol"].external[0] == "python"
    assert skills["follow"].external == ("f",)
    (tmp_path / "skills.yaml").write_text("skills: {patrol: {does: March., external: [march]}}")
    patrol = load(environ={}, user_folder=tmp_path).skills["patrol"]
    assert (patrol.external, patrol.occupies, patrol.parameters) == (("march",), (), {})
    (tmp_path / "skills.yaml").write_text("skills: {patrol: null}")
    assert "patrol" not in load(environ={}, user_folder=tmp_path).skills


def test_a_variable_can_name_a_new_place() -> None:
    loaded = load(environ={"SAYSO_PLACES__shed": "{name: boat house, position: {x: 1, y: 2}}"}, user_folder=NOWHERE)
    assert loaded.places["shed"].name == "boat house"


@pytest.mark.parametrize(
    ("text", "value"),
    [("3", 3), ("USB: Mic #2", "USB: Mic #2"), ('"3"', "3"), ("no", "no"), ("", None), ("null", None)],
)
def test_a_variable_is_read_as_a_yaml_scalar(text: str, value: object) -> None:
    assert load(environ={"SAYSO_AUDIO__DEVICE": text}, user_folder=NOWHERE).audio.device == value


def test_folders_and_foreign_variables_are_no_settings(tmp_path: Path) -> None:
    environ = {"SAYSO_CONFIG_DIR": str(tmp_path), "SAYSO_STATE_DIR": "s", "SAYSO_CACHE_DIR": "c", "SAYSO_DEBUG": "1"}
    assert check(environ=environ) == ()
    assert paths(environ).models == Path("c/models")
    assert paths(environ).logs == Path("s/logs")
    assert paths(environ).config == tmp_path


def test_the_norwegian_language_is_a_language(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("asr: {language: no}")
    assert load(environ={}, user_folder=tmp_path).asr.language == "no"


def test_all_languages_of_whisper_may_be_chosen_among() -> None:
    names = ",".join(_LANGUAGE_CODES)
    assert len(load(overrides=[f"asr.languages=[{names}]"], environ={}, user_folder=NOWHERE).asr.languages) == 100


def test_a_relative_path_in_a_file_is_relative_to_that_file(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("models: {folder: weights}")
    assert load(environ={}, user_folder=tmp_path).models.folder == tmp_path / "weights"


# Mistakes


def test_an_unknown_key_is_told_with_its_line_the_keys_there_and_the_nearest(
    problems: Callable[..., list[str]],
) -> None:
    [told] = problems("asr:\n  model: whisper-base\nendpoint:\n  silence: 1\n")
    assert told.startswith("config.yaml:4: endpoint.silence: ")
    assert "allowed: pre_roll_s, start_s, silence_s" in told
    assert told.endswith("did you mean 'silence_s'?")


def test_a_wrong_value_is_told_with_what_is_allowed(problems: Callable[..., list[str]]) -> None:
    [told] = problems("endpoint:\n  silence_s: 9\n")
    assert told.startswith(
        "config.yaml:2: endpoint.silence_s: 9 is not allowed here; allowed: a number above 0 up to 5"
    )
    [told] = problems("robot:\n  speed: rael\n")
    assert "allowed: real | max" in told
    assert told.endswith("did you mean 'real'?")


def test_all_mistakes_are_told_at_once_and_in_reading_order(problems: Callable[..., list[str]]) -> None:
    told = problems("endpoint:\n  silence_s: x\n  start: 1\nrobt: 1\nasr: 3\n", SAYSO_ROBOT__SPEED="fast")
    assert [line.split(": ")[0] for line in told] == [
        "config.yaml:2",
        "config.yaml:3",
        "config.yaml:4",
        "config.yaml:5",
        "SAYSO_ROBOT__SPEED",
    ]


def test_no_mistake_hides_another_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SAYSO_CONFIG_DIR", str(tmp_path))
    lines = {
        "asr:": "",
        "  modle: x": "asr.modle: modle is not a key",
        "  model: nope": "asr.model: There is no model 'nope'",
        "endpoint:": "",
        "  silence_s: 9": "endpoint.silence_s: 9 is not allowed",
        "voice:": "voice: the backend wyoming needs voice.server",
        "  backend: wyoming": "",
        "  foo: 1": "voice.foo: foo is not a key",
        "planner:": "",
        "  profile: nope": "planner.profile: there is no profile called nope",
        "robot:": "",
        "  scene: nowhere": "robot.scene: There is no scene called 'nowhere'",
        "console: {theme: pink, keys: {wake: zz9}}": "console.keys.wake: zz9 is not a key",
        "places:": "",
        "  zero: {name: q, position: {x: 1, y: 1, z: 0}}": "places: zero is the pose",
        "  shed: {position: {x: 1, y: 1, z: 0}}": "places.shed.name: is missing",
        "platforms:": "",
        "  openai: {kind: nope}": "platforms.openai.kind: this value is not allowed",
    }
    (tmp_path / "config.yaml").write_text("\n".join(lines))
    assert config_check() == 2
    told = [line.partition("config.yaml:")[2] for line in capsys.readouterr().out.splitlines()]
    for number, message in enumerate(lines.values(), 1):
        assert not message or [line for line in told if line.startswith(f"{number}: {message}")], (message, told)
    assert len(told) == len([message for message in lines.values() if message]) + 1  # the theme
    assert told == sorted(told, key=lambda line: int(line.partition(":")[0]))


@pytest.mark.parametrize(
    "text",
    [
        "platforms:\n  openai: {kind: nope}\nplanner: {profile: international}\nvoice: {backend: openai}",
        "places:\n  A: {name: 5, position: {x: 1, y: 1, z: 0}}",
        "profiles:\n  mine: {execution: [5]}\nplanner: {profile: mine}",
        "places:\n  shed: {name: q, position: 5}",
        "asr: {backend: wyoming, server: somewhere}",
    ],
)
def test_what_only_follows_from_a_mistake_is_not_told(problems: Callable[..., list[str]], text: str) -> None:
    assert len(problems(text)) == 1


@pytest.mark.parametrize(
    ("text", "place", "reason"),
    [
        ("a: [1", "config.yaml:1", "YAML cannot be read"),
        ("asr: [\n", "config.yaml:1", "YAML cannot be read"),
        ("asr:\n  model: {\n\n\n", "config.yaml:2", "YAML cannot be read"),
        ("# a comment\u2028 of one line\nfoo: 1", "config.yaml:2", "foo is not a section"),
        ("asr:\n  model: 'a\x85b'\n  foo: 1", "config.yaml:3", "foo is not a key of asr"),
        ("asr:\n\tmodel: x", "config.yaml:2", "not tabs"),
        ("asr:\n  model: a\n  model: b", "config.yaml:3", "'model' is given twice, first on line 2"),
        ("asr: {}\naudio: {}\nasr: {}", "config.yaml:3", "given twice"),
        ("- a\n- b", "config.yaml:1", "a list where sections are expected"),
        ("just words", "config.yaml:1", "'just words' where sections are expected"),
        (b"asr:\n  model: \xff\xfe", "config.yaml:2", "not UTF-8"),
        ("asr:\n  model: \x07", "config.yaml:2", "YAML cannot be read"),
        ("asr: &a {model: x}\nvad: *a", "config.yaml:1", "anchors and aliases"),
        ("asr: {model: !!python/object:os.system x}", "config.yaml:1", "tags"),
        ("asr: {}\n---\nvad: {}", "config.yaml:2", "a second document"),
        ("asr: " + "[" * 100_000, "config.yaml:1", "nested more than"),
        ("? [a]\n: b", "config.yaml:1", "a key must be a word"),
        ("#" * (MAX_BYTES + 1), "config.yaml", "larger than 1 MiB"),
        ("k: 1\n" + "".join(f"k{n}: 1\n" for n in range(50_000)), "config.yaml:25000", "too many values"),
        ("asr: 3", "config.yaml:1", "3 is not allowed here; allowed: a section with backend"),
        ("endpoint: {start_s: true}", "config.yaml:1", "true is not allowed here; allowed: a number"),
        ("endpoint: {start_s: .nan}", "config.yaml:1", "nan is not allowed"),
        ("places:\n  zero: {name: z, position: {x: 1, y: 1}}", "config.yaml:2", "get_current_pose"),
        ("places:\n  shed: {name: kitchen, position: {x: 1, y: 1}}", "config.yaml:2", "names both A and shed"),
        ("places:\n  shed:\n    name: q", "config.yaml:2", "places.shed.position: is missing"),
        ("places: {A: {orientation: {w: 3}}}", "config.yaml:1", "length"),
        ("asr:\n  languages: [en, cn]", "config.yaml:2", "asr.languages: 'cn' is no language of Whisper; write zh"),
        ("asr:\n  languages: [zh-CN]", "config.yaml:2", "asr.languages: 'zh-CN' is no language of Whisper; write zh"),
        ("asr:\n  languages: [tlh]", "config.yaml:2", "no language of Whisper; write ISO 639-1 codes"),
        (
            "audio:\n  device: tcp://kitchen",
            "config.yaml:2",
            "audio.device: this is no address of a satellite; write tcp",
        ),
        ("audio:\n  device: http://kitchen:10700", "config.yaml:2", "for example tcp://kitchen:10700"),
        ("skills:\n  patrol:\n    silense_s: 3", "config.yaml:3", "did you mean 'silence_s'?"),
        ("skills:\n  patrol:\n    silence_s: 0", "config.yaml:3", "a number above 0"),
        ("skills:\n  patrol:\n    occupies: [legs]", "config.yaml:3", "base | arm | camera | voice"),
        ("skills:\n  patrol:\n    external: patrol.sh", "config.yaml:3", "a list of text"),
        ("skills:\n  patrol:\n    external: []", "config.yaml:3", "skills.patrol.external: a list is not allowed here"),
        ("skills:\n  follow:\n    external: [follow]", "config.yaml:2", "skills.follow.does: is missing"),
        ("skills:\n  Follow me:\n    {does: x, external: [x]}", "config.yaml:2", "'Follow me' is no name for a skill"),
        ("skills: {f: {does: x, external: [x], parameters: {2m: {kind: place}}}}", "config.yaml:1", "no name for a p"),
        ("skills: {f: {does: x, external: [x], parameters: {d: {}}}}", "config.yaml:1", "(unit, min, max) or words"),
        ("skills: {f: {does: x, external: [x], parameters: {d: {unit: m}}}}", "config.yaml:1", "needs limits"),
        ("skills: {f: {does: x, external: [x], parameters: {d: {unit: mile}}}}", "config.yaml:1", "m | deg | s"),
        (
            "skills:\n  f:\n    does: x\n    external: [x]\n    parameters:\n      d:\n"
            "        {unit: m, min: 0, max: 2, default: 3}",
            "config.yaml:6",
            "the default is a number from 0 to 2",
        ),
        ("places:\n  A:\n    aliases:\n      - a\n      - 3", "config.yaml:5", "places.A.aliases.1: 3 is not allowed"),
    ],
)
def test_every_kind_of_mistake_is_told_with_its_line(
    problems: Callable[..., list[str]], text: str | bytes, place: str, reason: str
) -> None:
    [told] = problems(text)
    assert told.startswith(f"{place}: ")
    assert reason in told


def test_a_variable_between_braces_without_quotes_is_told_to_have_some(problems: Callable[..., list[str]]) -> None:
    [told] = problems("platforms:\n  cloud: {api_key: ${KEY}, kind: openai}\n")
    assert told.startswith("config.yaml:2: ")
    assert 'needs quotes: "${NAME}"' in told


def test_a_setting_in_the_wrong_section_names_the_right_one(problems: Callable[..., list[str]]) -> None:
    [told] = problems("silence_s: 1")
    assert told.endswith("did you mean 'endpoint.silence_s'?")


def test_a_file_with_the_other_ending_is_not_silently_ignored(tmp_path: Path) -> None:
    (tmp_path / "config.yml").write_text("asr: {}")
    [problem] = check(environ={}, user_folder=tmp_path)
    assert (problem.message, problem.nearest) == ("is not read", "config.yaml")


def test_a_given_file_must_exist_and_be_a_file(tmp_path: Path) -> None:
    told = [str(problem) for problem in check([tmp_path / "absent.yaml", tmp_path], environ={}, user_folder=NOWHERE)]
    assert told == [
        f"{tmp_path}/absent.yaml: does not exist",
        f"{tmp_path}: cannot be read: Is a directory",
    ]


@pytest.mark.parametrize(
    ("variable", "nearest"),
    [
        ("SAYSO_ENDPONT__SILENCE_S", "SAYSO_ENDPOINT__SILENCE_S"),
        ("SAYSO_ROBOT__LIMITS__LINEAR_SPED", "SAYSO_ROBOT__LIMITS__LINEAR_SPEED"),
        ("SAYSO_ENDPOINT_SILENCE_S", "SAYSO_ENDPOINT__SILENCE_S"),
        ("SAYSO_PLACES__A__NAM", "SAYSO_PLACES__A__NAME"),
    ],
)
def test_a_misspelt_variable_is_told_with_the_nearest(variable: str, nearest: str) -> None:
    [problem] = check(environ={variable: "1"}, user_folder=NOWHERE)
    assert (problem.where.name, problem.nearest) == (variable, nearest)


@pytest.mark.parametrize("flag", ["endpoint", "endpoint.=1", "=1", ""])
def test_a_flag_that_sets_nothing_is_told(flag: str) -> None:
    [problem] = check(overrides=[flag], environ={}, user_folder=NOWHERE)
    assert "section.key=value" in problem.message


def test_the_error_holds_all_problems_and_the_usage_exit_code() -> None:
    with pytest.raises(ConfigError) as caught:
        load(overrides=["asr.modl=x", "robot.speed=x"], environ={}, user_folder=NOWHERE)
    assert caught.value.exit_code == 2
    assert len(caught.value.problems) == 2
    assert "--set asr.modl" in str(caught.value)
    assert "sayso config" in caught.value.hint


# Large models

WITH_THE_LOCAL_MODEL = {"SAYSO_PLANNER__PROFILE": "local"}
CLOUD = "platforms:\n  cloud:\n    kind: openai\n"
SIGHTED = CLOUD + "    base_url: http://127.0.0.1:11434/v1\n    model: m\n    api_key: ${CLOUD_KEY}\n"


@pytest.mark.parametrize("profile", ["local", "international", "china"])
def test_every_packaged_profile_can_be_used_as_it_is(profile: str) -> None:
    loaded = load(overrides=[f"planner.profile={profile}"], environ={}, user_folder=NOWHERE)
    assert loaded.profile.execution[-1] == "local"
    assert profile == "local" or loaded.profile.decision[0] != loaded.profile.execution[0]


def test_no_packaged_platform_holds_a_key_and_each_names_where_it_comes_from() -> None:
    raw = {setting.key: str(setting.value) for setting in explain(environ={}, user_folder=NOWHERE)}
    platforms = load(environ={}, user_folder=NOWHERE).platforms
    assert all(platform.api_key is None for platform in platforms.values())
    assert {raw[f"platforms.{name}.base_url"].partition(":")[0] for name in platforms} == {"https", "http", "None"}
    variables = {name: f"key of {name}" for name in ("OPENAI_API_KEY", "DIFY_DECISION_KEY", "DIFY_EXECUTION_KEY")}
    keys = {
        name: platform.api_key.get_secret_value()
        for name, platform in load(environ=variables, user_folder=NOWHERE).platforms.items()
        if platform.api_key is not None
    }
    assert keys == {
        "openai": "key of OPENAI_API_KEY",
        "openai_speech": "key of OPENAI_API_KEY",
        "openai_hearing": "key of OPENAI_API_KEY",
        "dify_decision": "key of DIFY_DECISION_KEY",
        "dify_execution": "key of DIFY_EXECUTION_KEY",
    }


def test_a_profile_changes_only_what_it_says(tmp_path: Path) -> None:
    (tmp_path / "profiles.yaml").write_text(
        "profiles:\n  china: {vision: null}\n  mine: {execution: [ollama, local]}\n"
    )
    profiles = load(environ={}, user_folder=tmp_path).profiles
    assert profiles["china"].vision is None
    assert profiles["china"].execution == ("dashscope_vision", "local")
    assert profiles["mine"].execution == ("ollama", "local")
    assert profiles["mine"].decision == ()


def test_what_one_thinks_with_may_be_several_or_nothing(problems: Callable[..., list[str]]) -> None:
    several = f"profiles: {{local: {{execution: [cloud, ollama, local], decision: [cloud]}}}}\n{SIGHTED}"
    for text in ("profiles: {local: {execution: [], decision: []}}", several):
        assert problems(text, **WITH_THE_LOCAL_MODEL) == []


def test_no_large_model_is_started_unasked() -> None:
    assert load(environ={}, user_folder=NOWHERE).profile.execution == ()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "planner:\n  profile: chinna",
            "config.yaml:2: planner.profile: there is no profile called chinna; there are local, international, "
            "china, phrases; did you mean 'china'?",
        ),
        (
            f"profiles:\n  local:\n    execution: [local, clowd]\n{SIGHTED}",
            "config.yaml:3: profiles.local.execution.1: there is no platform called clowd; those for this: local,",
        ),
        (
            f"profiles:\n  local:\n    decision:\n    - clowd\n{SIGHTED}",
            "config.yaml:4: profiles.local.decision.0: there is no platform called clowd",
        ),
        (
            f"profiles:\n  local:\n    vision: clowd\n{SIGHTED}",
            "config.yaml:3: profiles.local.vision: there is no platform called clowd; those for this: openai,",
        ),
        (
            "profiles:\n  local:\n    vision: local",
            "config.yaml:3: profiles.local.vision: local is a platform of the kind local, which cannot look at",
        ),
        (
            f"{CLOUD}profiles: {{local: {{execution: [cloud]}}}}",
            "config.yaml:2: platforms.cloud: base_url and model must be set here, "
            "because profiles.local.execution names this platform",
        ),
        (
            "platforms:\n  app: {kind: dify}\nprofiles: {local: {vision: app}}",
            "config.yaml:2: platforms.app: base_url must be set here, because profiles.local.vision names",
        ),
        (
            f"{CLOUD}    model: m\n    base_url: models.invalid/v1\n",
            "config.yaml:5: platforms.cloud.base_url: this is no address of a service; "
            "write https://host/path, as its makers say",
        ),
        (
            "profiles:\n  local:\n    vision: [cloud]",
            "config.yaml:3: profiles.local.vision: a list is not allowed here; allowed: text or null",
        ),
        (
            "profiles:\n  local:\n    execution: cloud",
            "config.yaml:3: profiles.local.execution: 'cloud' is not allowed here; allowed: a list of text",
        ),
    ],
)
def test_models_that_cannot_think_are_told_with_their_remedy(
    problems: Callable[..., list[str]], text: str, told: str
) -> None:
    [problem] = problems(text, **({} if "chinna" in text else WITH_THE_LOCAL_MODEL))
    assert problem.startswith(told)


def test_a_platform_that_was_meant_is_named(problems: Callable[..., list[str]]) -> None:
    [problem] = problems(f"profiles: {{local: {{execution: [clowd]}}}}\n{SIGHTED}", **WITH_THE_LOCAL_MODEL)
    assert problem.endswith("did you mean 'cloud'?")


def test_models_that_do_not_think_now_need_not_be_complete(problems: Callable[..., list[str]]) -> None:
    assert problems(f"{CLOUD}profiles: {{mine: {{execution: [cloud, nobody]}}}}") == []


@pytest.mark.parametrize(
    "url", ["ftp://models.invalid", "https://", "https://[::1", "https://models.invalid:port/v1", ""]
)
def test_what_is_no_address_is_told_without_repeating_it(problems: Callable[..., list[str]], url: str) -> None:
    [told] = problems(f'platforms: {{cloud: {{kind: openai, base_url: "{url}"}}}}')
    assert told.startswith("config.yaml:1: platforms.cloud.base_url: this is no address")


def test_a_platform_that_looks_at_pictures_is_taken_and_its_key_shown_to_nobody(
    tmp_path: Path, problems: Callable[..., list[str]]
) -> None:
    environ = {"CLOUD_KEY": "s3cret", **WITH_THE_LOCAL_MODEL}
    assert problems(f"profiles: {{local: {{vision: cloud}}}}\n{SIGHTED}", **environ) == []
    assert load(environ=environ, user_folder=tmp_path).profile.vision == "cloud"
    shown = {setting.key: setting.value for setting in explain(environ=environ, user_folder=tmp_path)}
    assert (shown["profiles.local.vision"], shown["platforms.cloud.api_key"]) == ("cloud", "********")
    assert "s3cret" not in repr(load(environ=environ, user_folder=tmp_path)) + str(shown)


# Variables and secrets


def test_a_variable_is_filled_in(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text('asr: {model: "${FOLDER}/base"}\nconsole: {theme: "$${plain}"}')
    loaded = load(environ={"FOLDER": "models"}, user_folder=tmp_path)
    assert loaded.asr.model == "models/base"
    assert loaded.console.theme == "${plain}"


def test_a_variable_that_is_not_set_is_told_where_it_is_needed(problems: Callable[..., list[str]]) -> None:
    assert problems("asr:\n  model: ${FOLDER}") == [
        "config.yaml:2: asr.model: the environment variable FOLDER is not set"
    ]


def test_a_variable_in_a_value_that_is_overridden_is_not_needed(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("asr:\n  model: ${FOLDER}")
    assert load(overrides=["asr.model=x"], environ={}, user_folder=tmp_path).asr.model == "x"


def test_a_broken_variable_is_told(problems: Callable[..., list[str]]) -> None:
    [told] = problems("asr:\n  model: ${FOLD ER}")
    assert "${FOLD ER} is no variable" in told


def test_a_key_that_is_not_set_does_not_keep_other_platforms_from_working(tmp_path: Path) -> None:
    (tmp_path / "platforms.yaml").write_text("platforms:\n  cloud:\n    kind: openai\n    api_key: ${CLOUD_KEY}")
    assert load(environ={}, user_folder=tmp_path).platforms["cloud"].api_key is None
    key = load(environ={"CLOUD_KEY": "s3cret"}, user_folder=tmp_path).platforms["cloud"].api_key
    assert key is not None
    assert key.get_secret_value() == "s3cret"


def test_secrets_are_never_shown(tmp_path: Path) -> None:
    file = tmp_path / "platforms.yaml"
    file.write_text(
        "platforms:\n  cloud:\n    kind: openai\n    api_key: ${CLOUD_KEY}\n"
        '    model: "m-${CLOUD_KEY}"\n    base_url: https://user:s3cret@models.invalid/v1\n'
    )
    file.chmod(0o600)
    environ = {"CLOUD_KEY": "s3cret"}
    shown = {setting.key: setting.value for setting in explain(environ=environ, user_folder=tmp_path)}
    assert "s3cret" not in str(shown)
    assert shown["platforms.cloud.api_key"] == "********"
    assert shown["platforms.cloud.model"] == "m-${CLOUD_KEY}"
    assert show(load(environ=environ, user_folder=tmp_path))["platforms"]["cloud"]["api_key"] == "********"


@pytest.mark.parametrize("mistake", ["api_key: [s3cret]", "api_key: 12345", 'timeout_s: "${CLOUD_KEY}"'])
def test_secrets_are_not_in_messages(problems: Callable[..., list[str]], mistake: str) -> None:
    [told] = problems(f"platforms: {{cloud: {{kind: openai, {mistake}}}}}", CLOUD_KEY="s3cret")
    assert "s3cret" not in told
    assert "12345" not in told


@pytest.mark.parametrize(
    "wrong",
    ["s3cret", "{cloud: s3cret}", "{cloud: [s3cret]}", "{cloud: {kind: s3cret}}", '{cloud: {model: "${s3cret-}"}}'],
)
def test_a_key_in_a_wrong_place_is_not_in_messages(problems: Callable[..., list[str]], wrong: str) -> None:
    told = problems(f"platforms: {wrong}")
    assert told
    assert "s3cret" not in str(told)
    assert "s3cret" not in str(check(overrides=["platforms.openai=s3cret"], environ={}, user_folder=NOWHERE))


def test_a_folder_that_is_in_no_folder_has_no_files(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert check(environ={}, user_folder=tmp_path / "file" / "sayso") == ()
    [told] = check([tmp_path / "file" / "mine.yaml"], environ={}, user_folder=NOWHERE)
    assert told.message == "does not exist"


@pytest.mark.parametrize("mode", [0o644, 0o640, 0o604])
def test_a_key_in_a_file_that_others_may_read_is_told(tmp_path: Path, mode: int) -> None:
    file = tmp_path / "platforms.yaml"
    file.write_text("platforms:\n  cloud:\n    kind: openai\n    api_key: s3cret")
    file.chmod(mode)
    [problem] = check(environ={}, user_folder=tmp_path)
    assert (problem.where.line, problem.key) == (4, "platforms.cloud.api_key")
    assert "chmod 600" in str(problem)
    assert "s3cret" not in str(problem)
    file.chmod(0o600)
    key = load(environ={}, user_folder=tmp_path).platforms["cloud"].api_key
    assert key is not None
    assert key.get_secret_value() == "s3cret"


@pytest.mark.parametrize(
    ("url", "refused"),
    [
        ("https://me:s3cret@example.org/v1", True),
        ("https://s3cret@example.org/v1", True),
        ("https://me:s3cret@${HOST}/v1", True),
        ("https://example.org/v1?key=s3cret", True),
        ("https://example.org/v1?a=b&ACCESS%5fToken=s3cret", True),
        ("https://example.org/v1?a=b;sig=s3cret", True),
        ("https://example.org/v1#api-key=s3cret", True),
        ("https://${USER}:${PASS}@example.org/v1?key=${KEY}", False),
        ("https://me:${PASS}@example.org/v1", False),
        ("https://example.org/v1?api-version=2026-01", False),
    ],
)
def test_credentials_in_an_address_are_told_where_others_may_read_the_file(
    tmp_path: Path, url: str, refused: bool
) -> None:
    file = tmp_path / "platforms.yaml"
    file.write_text(f"platforms:\n  cloud:\n    kind: openai\n    base_url: {url}\n")
    environ = {"HOST": "example.org", "USER": "me", "PASS": "s3cret", "KEY": "s3cret"}
    file.chmod(0o644)
    told = check(environ=environ, user_folder=tmp_path)
    assert [(problem.where.line, problem.key) for problem in told] == [(4, "platforms.cloud.base_url")] * refused
    assert "s3cret" not in str(told)
    file.chmod(0o600)
    settings = load(environ=environ, user_folder=tmp_path)
    assert "s3cret" not in str(show(settings))
    assert "s3cret" not in str(explain(environ=environ, user_folder=tmp_path))


def test_a_key_beside_a_variable_is_still_a_key(tmp_path: Path) -> None:
    file = tmp_path / "platforms.yaml"
    file.write_text("platforms:\n  cloud:\n    kind: openai\n    api_key: s3cret${NOTHING}")
    file.chmod(0o644)
    [problem] = check(environ={"NOTHING": ""}, user_folder=tmp_path)
    assert (problem.where.line, problem.key) == (4, "platforms.cloud.api_key")


# Where settings come from


def test_every_setting_knows_where_it_was_written(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("endpoint:\n  silence_s: 0.8\n")
    environ = {"SAYSO_ASR__MODEL": "x"}
    origins = {
        setting.key: setting.origin
        for setting in explain(overrides=["vad.threshold=0.4"], environ=environ, user_folder=tmp_path)
    }
    assert origins["endpoint.silence_s"] == f"{tmp_path}/config.yaml:2"
    assert origins["asr.model"] == "SAYSO_ASR__MODEL"
    assert origins["vad.threshold"] == "--set vad.threshold"
    assert origins["endpoint.start_s"].startswith("packaged engine.yaml:")
    assert origins["places.A.position.z"] == "default"


def test_what_show_prints_can_be_given_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SAYSO_CONFIG_DIR", str(tmp_path))
    (tmp_path / "map.yaml").write_text(
        'places: {"no": {name: "true", aliases: ["a: b", "#1", 阁楼], position: {x: 1, y: 2}}}'
    )
    assert config_show() == 0
    copy = tmp_path / "copy.yaml"
    copy.write_text(capsys.readouterr().out)
    assert load([copy], environ={}, user_folder=NOWHERE) == load(environ={}, user_folder=tmp_path)


def test_check_prints_one_problem_a_line_and_path_works_nevertheless(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SAYSO_CONFIG_DIR", str(tmp_path))
    assert config_check() == 0
    (tmp_path / "config.yaml").write_text("asr: {modle: x}\nvad: {threshold: 2}")
    capsys.readouterr()
    assert config_check() == 2
    assert len(capsys.readouterr().out.splitlines()) == 2
    assert config_check(json=True) == 2
    first = json.loads(capsys.readouterr().out.splitlines()[0])
    assert (first["line"], first["key"], first["nearest"]) == (1, "asr.modle", "model")
    assert config_path(json=True) == 0
    assert json.loads(capsys.readouterr().out)["files"][0] == {"path": str(tmp_path / "config.yaml"), "exists": True}


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("robot.scene", "nothere", "There is no scene called 'nothere'. There are: family"),
        ("robot.scene", "/nowhere/a.yaml", "There is no scene file /nowhere/a.yaml."),
        ("asr.model", "whisper-bose", "There is no model 'whisper-bose'. Did you mean whisper-base?"),
        ("asr.model", "/nowhere", "There is no folder /nowhere."),
        ("asr.model", "assets", "There is no model 'assets'."),
        ("console.theme", "sayso-drak", "There is no theme called 'sayso-drak'. Did you mean sayso-dark?"),
        ("skills.beep", "{does: Beeps., external: [beep]}", "there is a built-in skill of this name"),
    ],
)
def test_check_looks_up_what_settings_are_names_of(
    key: str, value: str, told: str, nowhere: None, capsys: pytest.CaptureFixture[str]
) -> None:
    assert config_check(flags=[f"{key}={value}"]) == 2
    assert capsys.readouterr().out.startswith(f"--set {key}: {told}")


@pytest.mark.parametrize(
    "flag", ["console.theme=nord", "asr.model=whisper-base", "robot.scene=clutter-3", "asr.model=/", "robot.scene=flat"]
)
def test_check_finds_what_there_is(flag: str, nowhere: None) -> None:
    assert config_check(flags=[flag]) == 0


def test_path_names_the_folder_of_models_that_is_configured(nowhere: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert config_path(flags=["models.folder=/data/models"]) == 0
    assert "models  /data/models\n" in capsys.readouterr().out


@pytest.fixture
def nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody has configured anything."""
    monkeypatch.setenv("SAYSO_CONFIG_DIR", str(NOWHERE))


# Anything at all

_TEXT = yaml.safe_dump(show(load(environ={}, user_folder=NOWHERE)), allow_unicode=True)
_SNIPPETS = st.sampled_from(
    [":", "\n", "  ", "{", "}", "[", "]", "- ", "${", "${X}", "null", "&a ", "*a", "!!t ", "'", "#"]
)


@st.composite
def _mutated(draw: st.DrawFn) -> bytes:
    data = bytearray(_TEXT.encode())
    for _ in range(draw(st.integers(1, 6))):
        at = draw(st.integers(0, len(data)))
        length = draw(st.integers(0, 12))
        data[at : at + length] = draw(st.one_of(_SNIPPETS.map(str.encode), st.binary(max_size=4)))
    return bytes(data)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=_mutated())
def test_a_mutated_file_gives_settings_or_problems_and_nothing_else(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "config.yaml").write_bytes(data)
    for problem in check(environ={}, user_folder=tmp_path):
        assert isinstance(problem, Problem)
        assert str(problem).startswith(problem.where.name)


_KEYS = st.sampled_from(
    ["asr", "places", "A", "name", "aliases", "position", "robot", "limits", "platforms", "x", "zero"]
)
_TREES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_KEYS, inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(tree=st.dictionaries(_KEYS, _TREES, max_size=4), text=st.text(max_size=20))
def test_any_tree_and_any_variable_give_settings_or_problems(
    tmp_path: Path, tree: dict[str, object], text: str
) -> None:
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(tree), encoding="utf-8", errors="replace")
    for problem in check(overrides=[f"places.A={text}"], environ={"SAYSO_AUDIO__DEVICE": text}, user_folder=tmp_path):
        assert isinstance(problem, Problem)


@settings(max_examples=300, deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_give_a_tree_or_a_source_error(data: bytes) -> None:
    with contextlib.suppress(SourceError):
        assert isinstance(parse(data, "x"), Node)
