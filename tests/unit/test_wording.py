"""What the robot says is in the language of whoever asked, and nothing that was to be said is lost.

Whether the catalogue is complete is read from the source: every sentence that skills, plans, models and turns can end
with is put into Chinese as it stands there, with something in its slots.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from string import Formatter
from typing import Final

import pytest
import yaml
from hypothesis import assume, given
from hypothesis import strategies as st

import engine
from config import load as load_settings
from engine.errors import DeviceError, ModelError, PlanError, RobotError
from engine.han import is_chinese
from engine.llm.chat import ChatError
from engine.parts.loading import at_home
from engine.planner.build import build_registry
from engine.planner.sentences import SAID
from engine.planner.text.language import load as load_phrases
from engine.planner.worlds.house import build_vocabulary
from engine.wording import Template, Wording, build_wording, catalogue
from tests.spoken import Written, written
from tui.words import strings

SETTINGS = load_settings(environ={})
WORDING = build_wording(SETTINGS)

ALL_TEXT: Final = (
    "skills", "perception/describe.py", "perception/naming.py", "robot/host/envelope.py", "robot/occupancy.py",
    "states.py", "robot/host/hosted.py", "robot/rosmaster/body.py", "robot/ros2/body.py", "ros/rosbridge/door.py",
    "robot/sim/camera.py", "robot/sim/camera_process.py", "robot/host/process.py",
    "parts/keeper.py", "parts/camera.py", "asr/isolated.py", "llm/service.py", "llm/openai.py", "llm/dify.py",
    "llm/llama.py", "llm/local.py", "session/turn.py", "session/session.py", "hearing/hearing.py",
    "hearing/intake.py", "session/dispatch.py", "session/way_back.py",
)  # fmt: skip
"""Where every text may be said."""
ENDS_ONLY: Final = (
    "plan.py", "planner", "asr/gates.py", "asr/whisper.py", "audio/recorder.py", "audio/microphone.py",
    "wyoming.py", "asr/wyoming.py", "tts/wyoming.py", "audio/satellite.py", "audio/satellite_microphone.py",
    "audio/satellite_loudspeaker.py", "robot/host/memory.py",
)  # fmt: skip
"""Where only what errors and answers are made of is said."""
SAYS: Final = frozenset({"NoPlan", "Rejected", "NothingHeard", "Trouble", "fault"})
"""What is called with a sentence that is said, besides the errors."""
SHOWN: Final = (
    "../tui/doctor/diagnosis.py", "../tui/doctor/examiner.py", "../tui/doctor/robots.py",
    "engine.py", "graph", "parts", "session",
    "hearing/hearing.py", "hearing/intake.py", "llm/chain.py", "planner/stages/two_stage.py",
    "planner/worlds/world_file.py", "robot/sim/camera.py", "tts", "wake/choice.py", "wake/embedding.py",
    "wake/head.py", "wake/micro.py", "wake/ports.py", "serial_port.py",
    "wake/reader.py", "audio/loudspeaker.py", "audio/sounder.py",
    "audio/vad.py",
)  # fmt: skip
"""Where something is written that a console shows: what the doctor finds, how parts are doing, lines of the log."""
SHOWS: Final = frozenset(
    {"Finding", "Log", "_tell_log", "_tell", "_warn", "warn", "Remark", "Opened", "SaysoError", "ErrorRaised"}
    | {"_complain", "UsageError", "_ack"}
)
"""What is called with it."""

KNOWN: Final = yaml.safe_load(Path(__file__).with_name("wording.yaml").read_text("utf-8"))

_PROBE: Final = re.compile(r"[\w.]*Ж\d+[\w.]*")
_LATIN: Final = re.compile(r"[A-Za-z][A-Za-z.'’]*")


def zh(text: str) -> str:
    return WORDING.worded(text, "zh")


# What there is to be said


@cache
def error_names() -> frozenset[str]:
    """The names of all errors that are told to users, by the source: which modules are imported by now says nothing."""
    files = Path(engine.__file__).parent.rglob("*.py")
    nodes = (node for file in files for node in ast.walk(ast.parse(file.read_text("utf-8"))))
    classes = [node for node in nodes if isinstance(node, ast.ClassDef)]
    names = {error.__name__ for error in (PlanError, ChatError, RobotError, DeviceError, ModelError)}
    while more := {one.name for one in classes if names & {ast.unparse(base) for base in one.bases}} - names:
        names |= more
    return frozenset(names)


def all_written() -> Iterator[Written]:
    for place in ALL_TEXT:
        yield from written(place)
    for place in ENDS_ONLY:
        yield from written(place, SAYS | error_names())


def all_shown() -> Iterator[Written]:
    for place in SHOWN:
        yield from written(place, SHOWS | SAYS | error_names())


def english_in(told: str) -> set[str]:
    """Latin words in a Chinese text that are in no Chinese template either."""
    templates = (*catalogue().sentences, *catalogue().parts)
    meant = {word for words in (*(one.told for one in templates), *catalogue().words.values()) for word in latin(words)}
    return latin(told) - meant


def latin(text: str) -> set[str]:
    return {word.rstrip(".") for word in _LATIN.findall(_PROBE.sub("", text))}


def test_every_sentence_that_may_be_said_is_in_the_catalogue() -> None:
    english = []
    for one in all_written():
        text = KNOWN["put_together"].get(one.text, one.text)
        told = zh(text), zh(f"I had to stop: {text}.")  # by itself, or in another sentence
        if one.text not in KNOWN["not_said"] and not is_chinese(one.text) and all(map(english_in, told)):
            english.append(f"{one.where}: {one.text}   ->   {told[0]}")
    assert not english, "add these to assets/wording/zh.yaml:\n" + "\n".join(english)


def test_whatever_a_console_shows_of_the_engine_and_the_doctor_is_in_the_catalogue() -> None:
    english = []
    for one in all_shown():
        text = KNOWN["put_together"].get(one.text, one.text)
        if one.text in KNOWN["not_shown"] or one.text in strings.CHECKS:  # by its name, which stands there
            continue
        if english_in(told := WORDING.told(text)):
            english.append(f"{one.where}: {one.text}   ->   {told}")
    assert not english, "add these to assets/wording/zh.yaml:\n" + "\n".join(english)


def test_a_template_tells_all_that_stands_in_its_slots() -> None:
    for template in (*catalogue().sentences, *catalogue().parts):
        told = {name for _, name, _, _ in Formatter().parse(template.told) if name is not None}
        open_slots = {name for name, spec in template.slots.items() if spec in ("", "n", "s")}
        assert open_slots <= told <= template.slots.keys(), template.written  # the words around a closed one tell it


def test_every_template_is_of_a_sentence_that_may_be_said() -> None:
    skills = [skill.summary.replace("`", "") for skill in build_registry(SETTINGS)]
    texts = (one.text for one in (*all_written(), *all_shown()))
    said = [*texts, *skills, *said_by_the_planner(), *KNOWN["put_together"].values(), *KNOWN["examples"]]
    stale = [
        template.written
        for template in catalogue().sentences
        if not any(template.stands(text, at) for text in said for at in beginnings(text))
    ]
    assert not stale, "nobody says this any more, or an example is missing:\n" + "\n".join(stale)


def said_by_the_planner() -> list[str]:
    """What it says in English, with something in its slots."""
    answers = load_phrases("en")["answers"]
    texts = [answers["understood"], answers["understood_anywhere"], *answers["talk"].values()]
    texts += [*answers["questions"].values(), *SAID["en"].values()]
    return [re.sub(r"\{(\w+)\}", lambda slot: SLOTS.get(slot[1], "kitchen"), text) for text in texts]


SLOTS: Final = {
    "name": "Ж1", "words": "Ж2", "part": ": “Ж3”", "thing": "red box", "names": "red box, the blue cup or the mug",
    "known": "kitchen, study", "understood": "I am at the kitchen.", "answer": "I am at the kitchen.", "error": "Ж4",
    "steps": "Go to the kitchen, then: Go to the study",
}  # fmt: skip
"""What stands in the slots of what the planner says."""


def test_everything_that_the_planner_says_in_english_stands_in_chinese_on_a_chinese_console() -> None:
    joints = {SAID["en"]["or"], SAID["en"]["then"]}
    texts = [text for text in said_by_the_planner() if text not in joints]
    english = [f"{text}   ->   {told}" for text in texts if english_in(told := WORDING.told(text))]
    assert not english, "\n".join(english)


def test_a_question_of_the_planner_is_told_as_a_whole() -> None:
    nearest = SAID["en"]["nearest"].format(name="bedrom", near="bedroom")
    assert WORDING.told(nearest) == "我不知道叫“bedrom”的地方。要我去卧室吗？"
    assert "红色盒子" in WORDING.told(SAID["en"]["unable_full"].format(words="the red box"))
    assert "“the red thing”" in WORDING.told(SAID["en"]["unable_amount"].format(words="the red thing"))


def beginnings(text: str) -> list[int]:
    """Where a sentence may begin in a text."""
    return [0, *(found.end() for found in re.finditer(r"[.?!:] ", text))]


# How it is told


@pytest.mark.parametrize(("english", "chinese"), KNOWN["examples"].items())
def test_a_sentence_of_ours_in_chinese(english: str, chinese: str) -> None:
    assert zh(english) == chinese
    assert WORDING.worded(english, "en") == english


@pytest.mark.parametrize(
    "text", ["去厨房，然后左转90度。", "I would rather not!", "Wait. What?", "It depends.", "x", "", "…", "OK 去厨房"]
)
def test_what_is_not_in_the_catalogue_or_chinese_already_stays_as_it_is(text: str) -> None:
    assert zh(text) == text


def test_what_is_not_in_the_catalogue_stays_among_what_is() -> None:
    assert (
        zh("Strange things happened. I am at the lab. Go figure.") == "Strange things happened. 我到lab了。 Go figure."
    )


def test_words_that_somebody_asked_to_say_are_not_translated() -> None:
    told = zh("Said: “Hi there. I am at the kitchen.”. I am at the kitchen.")
    assert told == "我说了：“Hi there. I am at the kitchen.”。我到厨房了。"
    assert zh(told) == told


def test_a_configured_language_is_the_one_of_all_requests() -> None:
    assert Wording(language="zh").worded("Nodded.", "en") == "我点过头了。"
    assert Wording(language="en").worded("Nodded.", "zh") == "Nodded."


def test_the_catalogue_is_not_read_where_nobody_speaks_chinese() -> None:
    catalogue.cache_clear()
    assert Wording().worded("I am at the kitchen.", "en") == "I am at the kitchen."
    assert Wording().worded("我到厨房了。", "zh") == "我到厨房了。"
    assert catalogue.cache_info().currsize == 0


# Names


@pytest.mark.parametrize("scene", ["flat", "workshop", "clutter-7"])
def test_whatever_the_house_calls_something_has_a_chinese_name(scene: str) -> None:
    configured = at_home(load_settings(overrides=(f"robot.scene={scene}",), environ={}))
    wording, house = build_wording(configured), build_vocabulary(configured)
    names = (place.name for place in configured.places.values())
    for name in (*names, *house.furniture(), *house.inventory(), *house.rooms()):
        assert english_in(wording.worded(f"I am at the {name}.", "zh")) == set(), name


def test_a_name_that_nobody_has_put_into_chinese_stays_and_loses_its_article() -> None:
    assert zh("I am at the blacksmith.") == "我到blacksmith了。"
    assert zh("I am at the 实验室.") == "我到实验室了。"


def test_every_skill_and_every_parameter_has_a_chinese_word() -> None:
    for skill in build_registry(SETTINGS):
        for name in (skill.name, *(parameter.name for parameter in skill.parameters)):
            assert is_chinese(catalogue().words.get(name, "")), name


def test_every_skill_has_a_chinese_sentence() -> None:
    for skill in build_registry(SETTINGS):
        about = WORDING.told(skill.summary.replace("`", ""))
        assert is_chinese(about), skill.name
        assert not english_in(about), skill.name


# Nothing is lost

WORDS = st.text("ЖЯßçñ漢字", min_size=1, max_size=8)
SLOTTED = st.sampled_from([one for one in catalogue().sentences if one.slots])


@given(st.data())
def test_whatever_stands_in_a_sentence_is_told(data: st.DataObject) -> None:
    template = data.draw(SLOTTED)
    number = st.integers(-99, 99).map(str)
    kinds = {"": WORDS | number, "n": number, "s": WORDS}
    put = {
        name: data.draw(kinds[spec] if spec in kinds else st.sampled_from(spec.split("|")))
        for name, spec in template.slots.items()
    }
    told = zh(filled(template, put))
    for name, words in put.items():
        if template.slots[name] in kinds:
            assert words in told, name


@given(st.lists(st.tuples(SLOTTED, WORDS), min_size=1, max_size=3))
def test_nothing_between_sentences_is_lost(parts: list[tuple[Template, str]]) -> None:
    text = ""
    for template, words in parts:
        put = {name: "7" if spec in ("", "n", "s") else spec.split("|")[0] for name, spec in template.slots.items()}
        text += f"{filled(template, put)} {words}! "
    told = zh(text)
    assert all(words in told for _, words in parts)


def filled(template: Template, put: Mapping[str, str]) -> str:
    """The sentence with something in its slots."""
    return re.sub(r"\{(\w+)(?::[^}]*)?\}", lambda slot: put[slot[1]], template.written)


@pytest.mark.parametrize("text", ["the ", "on a in b on ", "a: b of c is not allowed: d to ", "x, a y and "])
def test_no_text_takes_long(text: str) -> None:
    assert zh(text * 300)  # or the test runs into its time limit


@given(st.text(max_size=60))
def test_any_text_can_be_worded(text: str) -> None:
    told = zh(text)
    assume(not any(one.stands(text, at) for at in range(len(text)) for one in catalogue().sentences))
    assert "".join(told.split()) == "".join(text.split())


def test_what_is_nowhere_is_not_told_as_somebody() -> None:
    for line in ("There is no plan yet that could be done again.", "There is nothing that could be undone."):
        assert zh(line) == line, "the console's own words in the other language stay as they are"
