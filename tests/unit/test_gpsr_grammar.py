"""The grammar's notation is read as it is written, and a drawn command keeps how it came about."""

from __future__ import annotations

import os
import random
from collections import Counter
from pathlib import Path

import pytest

from tests.eval.gpsr.commands import KINDS, UnknownKind, commands, kind_of
from tests.eval.gpsr.draw import Generator, generator
from tests.eval.gpsr.grammar import Choice, Grammar, GrammarError, Rule, Slot, Text, missing, production, read_grammar
from tests.eval.gpsr.lexicon import Lexicon, Location, Ware

LEXICON = Lexicon(
    (
        Location("entrance", "corridor", True, False),
        Location("desk", "bedroom", True, True),
        Location("couch", "living room", True, False),
        Location("sink", "kitchen", True, True),
        Location("counter", "kitchen", False, True),
    ),
    (
        Ware("coke", "drinks", True, False, "counter"),
        Ware("sprite", "drinks", True, False, "counter"),
        Ware("apple", "fruits", False, False, "desk"),
        Ware("tray", "containers", False, True, "desk"),
    ),
    ("waving",),
    (("Linda", "female"), ("John", "male")),
)
OWN = r"""
; a comment
# another one
$polite = Please | Could you please
$main   = $man
$main   = $guide
$man    = $deliver
$deliver = $vbbring me the {aobject} from the {placement}
$deliver = $take and $vbplace it on the {placement 2}
$guide  = $gdcmd {void meta: must deviate before the {beacon 2}}
$gdcmd  = meet {name 1} at the {beacon 1} and $guideto
$guideto = (lead | take) {pron} to the {beacon 2}
$take   = get the $object
$object = {object} | tray
$vbbring = bring
$vbplace = put#
"""


def grammar(text: str, folder: Path) -> Grammar:
    file = folder / "own.txt"
    file.write_text("\ufeff" + text, "utf-8")
    return read_grammar([file])


def own(folder: Path) -> Generator:
    return Generator(grammar(OWN, folder), LEXICON)


def test_a_production_has_words_rules_choices_and_placeholders() -> None:
    found = production("$a = go (to | into) the {room 1 meta: put {object?} there}, $b | stop")
    assert found is not None
    name, (first, second) = found
    assert name == "a"
    go, choice, the, slot, comma, rule = first.parts
    assert (go, the, comma, rule) == (Text("go"), Text("the"), Text(","), Rule("b"))
    assert isinstance(choice, Choice)
    assert [str(option) for option in choice.options] == ["to", "into"]
    assert isinstance(slot, Slot)
    assert (slot.kind, slot.number) == ("room", 1)
    assert slot.meta is not None
    assert Slot("object", vague=True) in slot.meta.parts
    assert str(second) == "stop"


def test_a_production_is_told_without_its_metas() -> None:
    found = production("$a = find {name 1 meta: is at the {beacon 1}} and {pron pos} {aobject?}")
    assert found is not None
    assert str(found[1][0]) == "find {name 1} and {pron pos} {aobject?}"


@pytest.mark.parametrize("line", ["; $a = b", "# $a = b", "", "   "])
def test_comments_are_no_productions(line: str) -> None:
    assert production(line) is None


@pytest.mark.parametrize(
    "line", ["$a = (b", "$a = {room", "$a = b)", "$a = b}", "$a = {Room!}", "a = b", "no production"]
)
def test_a_line_that_is_not_of_the_notation_is_told(line: str) -> None:
    with pytest.raises(GrammarError):
        production(line)


def test_an_error_names_file_and_line(tmp_path: Path) -> None:
    with pytest.raises(GrammarError, match=r"own\.txt:2: a \) is missing"):
        grammar("$a = b\n$c = (d", tmp_path)


def test_lines_of_one_rule_are_alternatives_and_what_follows_a_hash_is_no_word(tmp_path: Path) -> None:
    rules = grammar(OWN, tmp_path)
    assert [str(option) for option in rules["main"]] == ["$man", "$guide"]
    assert [str(option) for option in rules["vbplace"]] == ["put"]


def test_rules_that_are_nowhere_are_named(tmp_path: Path) -> None:
    rules = grammar("$main = $a ($b | c)\n$a = d", tmp_path)
    assert missing(rules) == {"b"}
    with pytest.raises(GrammarError, match="b"):
        Generator(rules, LEXICON)


def test_the_same_number_means_the_same_and_another_one_something_else(tmp_path: Path) -> None:
    for seed in range(50):
        drawn = own(tmp_path).draw("guide", random.Random(seed))
        hidden = {filled.slot.kind: filled.value for filled in drawn.hidden}
        assert drawn.fill("beacon", 2) == hidden["beacon"]
        assert drawn.fill("beacon", 1) != drawn.fill("beacon", 2)


def test_a_pronoun_is_of_whom_was_named_last(tmp_path: Path) -> None:
    for seed in range(20):
        drawn = own(tmp_path).draw("guide", random.Random(seed))
        assert drawn.fill("pron") == {"Linda": "her", "John": "him"}[drawn.fill("name")]


def test_a_command_keeps_its_derivation(tmp_path: Path) -> None:
    drawn = own(tmp_path).draw("man", random.Random(3))
    assert drawn.path[:3] == ("main", "man", "deliver") or drawn.path[1:4] == ("polite", "man", "deliver")
    kind_of(drawn)


def test_a_thing_that_is_told_vaguely_is_told_by_its_category(tmp_path: Path) -> None:
    text = "$main = $man\n$man = bring me the {object?}"
    drawn = Generator(grammar(text, tmp_path), LEXICON).draw("man", random.Random(1))
    filled = drawn.filled("object")
    assert filled.said == LEXICON.category_of(filled.value)
    assert drawn.text == f"bring me the {filled.said}"
    with pytest.raises(UnknownKind, match="bring me the"):
        kind_of(drawn)


def test_the_same_seed_draws_the_same_commands_and_each_category_as_often(tmp_path: Path) -> None:
    made = own(tmp_path)
    found = commands(made, 20, 7)
    assert found == commands(made, 20, 7)
    assert [one.text for one in found] != [one.text for one in commands(made, 20, 8)]
    assert Counter(one.category for one in found) == {"man": 10, "guide": 10}


def test_a_chinese_command_wants_the_same(tmp_path: Path) -> None:
    made = own(tmp_path)
    pairs = zip(commands(made, 40, 2), commands(made, 40, 2, language="zh"), strict=True)
    for english, chinese in pairs:
        assert english.kind == chinese.kind
        assert [want.what for want in english.goal.wants] == [want.what for want in chinese.goal.wants]
        assert [guest.called for guest in english.needs.guests] == [guest.called for guest in chinese.needs.guests]
        assert any("一" <= sign <= "鿿" for sign in chinese.text)


@pytest.mark.skipif("SAYSO_GPSR" not in os.environ, reason="SAYSO_GPSR names the folder with the published grammar")
def test_every_command_of_the_published_grammar_has_a_meaning() -> None:
    made = generator(Path(os.environ["SAYSO_GPSR"]))
    found = commands(made, 2000, 1)
    assert {one.kind for one in found} == {f"${rule} = {text}" for rule, text in KINDS}
