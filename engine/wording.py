"""Our own sentences, as the robot says them: in English, or in the language of whoever asked.

Skills, events and logs are English, so that programs, recordings and models can rely on them; only the mouth speaks
Chinese. A catalogue (``assets/wording/zh.yaml``, and what the records in ``assets/skills`` call skills) has a template
for every sentence, with named slots. A text is read
from the outside in: one sentence after the other, then what stands in the slots of each (reasons, places, things,
lists, amounts), which are put into Chinese by the same catalogue and by the names of the house. What is not in the
catalogue stays as it is: nothing that was to be said is lost.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from importlib.resources import files
from typing import Any, Final

import yaml

from config.schema import Settings
from engine.errors import SceneError
from engine.han import is_chinese
from engine.planner.request import Language
from engine.planner.sentences import SAID
from engine.planner.text.language import load
from engine.planner.worlds.house import build_vocabulary
from engine.skills.record import records

Called = Callable[[str], Sequence[str]]
"""Every name, in any language, of what has this one in the house; that name itself where there is none."""

_FILE: Final = files("assets") / "wording" / "zh.yaml"
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml is ten times as fast, where it is built in

_SLOT: Final = r"(?!(?:There|Nothing) )(?:(?![.!?]\s|[。！？（）\n]).)+?"
"""What stands in a slot: a part of one sentence; what is nowhere is no part."""
_KINDS: Final = {"": _SLOT, "n": r"[-+]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?", "s": r"(?s:.*?)"}
"""Slots by their format: words, ``n`` a number, ``s`` somebody else's words, which stay as they are. Any other format
lists what may stand there: ``{way:ahead|behind}``."""
_SLOTS: Final = re.compile(r"\{(\w+)(?::([^}]*))?\}")
_OPTIONAL: Final = re.compile(r"\[([^\[\]]*)\]")
"""A part of how an action is told that is left out where an argument was not given."""
_SAID: Final = re.compile(r"([“\"])\{(\w+)\}([”\"])")
_UNTOLD: Final = re.compile(r"\{(name|part)\}")
"""Slots of what the planner says in which stands a name that nobody knows, or what it was told."""
_OWN_SENTENCE: Final = re.compile(r"(?<=[.。]) ?\{\w+\}$")
_ENDS: Final = r"""(?=\s|[)）\]”"』」]|$)"""
_NEXT: Final = re.compile(r"“[^”]*”|[.!?:]\s+|\n+|[。！？：（(]\s*")
"""Behind this a sentence may begin; what somebody said is no sentence of ours."""
_WORDS: Final = re.compile(r"[A-Za-z°%]")
_ARTICLE: Final = re.compile(r"^(?:the|my|your)\s+(?=\S)")
_COMMA: Final = re.compile(r",\s+(?:(and|or|then:)\s+)?(?![^()]*\))|\s+(and|or)\s+")
_CALL: Final = re.compile(r"([a-z]\w*)\((.*)\)")
_QUOTED: Final = re.compile(r"(['\"“])(.*)(?:\1|”)", re.DOTALL)
_LAST: Final[Mapping[str | None, str]] = {"and": "和", "or": "或", "then:": "，然后", None: "、"}
_LONGEST: Final = 150  # characters of a part of a sentence of ours
_SHORT: Final = 3  # words of a name that nobody has put into Chinese


class Wording:
    """Puts sentences of ours into the language of a request, names by ``called``."""

    def __init__(self, called: Called = lambda name: (name,), *, language: Language | None = None) -> None:
        """``language`` is the one of all requests; None: that of each."""
        self._called = called
        self._language = language
        self._known = lru_cache(maxsize=1000)(self._known_anew)

    def worded(self, text: str, language: Language) -> str:
        """``text`` in the language of a request, as far as the catalogue has it."""
        if (self._language or language) == "en" or not _WORDS.search(text):
            return text
        return self._sentences(text)

    def told(self, text: str) -> str:
        """What stands on a Chinese screen, as far as the catalogue has it: sentences, or a part of one by itself, such
        as a name, a reason, or a call of a skill."""
        if not _WORDS.search(text):
            return text
        return told if (told := self._sentences(text)) != text else self._known(text, True) or text

    def _sentences(self, text: str) -> str:
        said, at, known = "", 0, True
        while at < len(text):
            if (found := self._sentence(text, at)) is not None:
                words, end = found
                said, known = said + words, True
                at = end + len(text[end:]) - len(text[end:].lstrip())
            else:
                end = after.end() if (after := _NEXT.search(text, at)) else len(text)
                gap = " " if known and said and said[-1] != "：" and text[at].isascii() and text[at].isalnum() else ""
                said, at, known = f"{said}{gap}{text[at:end]}", end, False
        return said

    def _sentence(self, text: str, at: int) -> tuple[str, int] | None:
        """The sentence that stands at a place, in Chinese, and where it ends; rather one that is known as a whole."""
        found = [(one, slots) for one in catalogue().sentences if (slots := one.stands(text, at)) is not None]
        for strict in (True, False):
            for template, slots in found:
                if told := self._filled(template, slots, strict=strict):
                    return told, slots.end()
        return None

    def _filled(self, template: Template, slots: re.Match[str], *, strict: bool) -> str:
        """What is written in the slots, told; with ``strict`` empty where something in them is not known."""
        told = {}
        for name, words in slots.groupdict().items():
            told[name] = words if template.slots[name] == "s" else self._told(words, strict=strict)
            if words and not told[name]:
                return ""
        return template.told.format_map(told)

    def _told(self, words: str, *, strict: bool) -> str:
        """What stands in a slot, in Chinese: all of it (``strict``), else empty; or as much as is known."""
        known = self._known(words, True)
        return known if known or strict else self._known(words, False) or _nameless(words)

    def _known_anew(self, words: str, strict: bool) -> str:
        if (quoted := _QUOTED.fullmatch(words)) is not None:
            return f"“{quoted[2]}”"
        if not _WORDS.search(words):
            return words
        if told := self._name(words) or self._list(words, strict=True):
            return told
        for template in catalogue().parts if len(words) <= _LONGEST else ():
            if (slots := template.matches(words)) is not None and (
                told := self._filled(template, slots, strict=strict)
            ):
                return told
        if (call := _CALL.fullmatch(words)) is not None and (does := catalogue().words.get(call[1])):
            given = "、".join(map(self._given, call[2].split(", ")))
            return f"{does}（{given}）" if given else does
        return self._composed(words) or ("" if strict else self._list(words, strict=False))

    def _given(self, argument: str) -> str:
        """An argument of a call, with its name where that is written."""
        name, is_named, value = argument.rpartition("=")
        told = self._told(value, strict=False)
        return f"{catalogue().words.get(name, name)}={told}" if is_named else told

    def _name(self, words: str) -> str:
        """What has a word of its own, here or in the house."""
        bare = _ARTICLE.sub("", words)
        for name in (words, bare):
            if (word := catalogue().words.get(name.casefold())) is not None:
                return word
        called = (name for name in self._called(bare) if is_chinese(name))
        return next((name for name in called if name != bare or not _COMMA.search(name)), "")

    def _composed(self, words: str) -> str:
        """A thing by its colour and its kind."""
        parts = [catalogue().words.get(word.casefold(), "") for word in _ARTICLE.sub("", words).split()]
        return "".join(parts) if all(parts) else ""

    def _list(self, words: str, *, strict: bool) -> str:
        """What is enumerated; empty where that is not so, or where all is unknown (``strict``: where anything is)."""
        joints = list(_COMMA.finditer(words))
        if not joints:
            return ""
        cuts = [0, *(cut for joint in joints for cut in joint.span()), len(words)]
        items = [words[begin:end] for begin, end in zip(cuts[::2], cuts[1::2], strict=True)]
        told = [self._told(item, strict=True) for item in items]
        if not (all if strict else any)(told):
            return ""
        *most, end = [known or _nameless(item) for known, item in zip(told, items, strict=True)]
        return f"{'、'.join(most)}{_LAST[joints[-1][1] or joints[-1][2]]}{end}"


@dataclass(frozen=True)
class Template:
    """A sentence, or a part of one, and how it is told."""

    written: str
    told: str

    @property
    def is_sentence(self) -> bool:
        """It may stand by itself; else it is a part of one."""
        return self.written.endswith((".", "?", "!", ":"))

    @cached_property
    def slots(self) -> Mapping[str, str]:
        """The format of each slot by its name."""
        return dict(zip(self._pieces[1::3], self._pieces[2::3], strict=True))

    @cached_property
    def exactness(self) -> int:
        """Letters that must be there."""
        closed = (kind.split("|") for kind in self.slots.values() if kind not in _KINDS)
        return sum(map(len, self._pieces[::3])) + sum(min(map(len, words)) for words in closed)

    @cached_property
    def _pieces(self) -> Sequence[str]:
        """The text before each slot, its name and its format, and the text at the end."""
        return [piece or "" for piece in _SLOTS.split(self.written)]

    def _pattern(self, end: str) -> re.Pattern[str]:
        """Words reach to where what follows them is found first, and nothing else is tried, so that no text is read for
        long."""
        head, *texts = self._pieces[::3]
        pattern, group = re.escape(head), ""
        for (name, kind), text in zip(self.slots.items(), texts, strict=True):
            what = _KINDS.get(kind) or "|".join(map(re.escape, kind.split("|")))
            if kind in ("", "s"):
                pattern, group = f"{pattern}{group}(?>", ")"
            pattern += f"(?P<{name}>{what}){re.escape(text)}"
        return re.compile(f"{pattern}{end}{group}")

    @cached_property
    def _sentence(self) -> re.Pattern[str]:
        return self._pattern(_ENDS)

    @cached_property
    def _part(self) -> re.Pattern[str]:
        return self._pattern(r"\Z")

    def matches(self, words: str) -> re.Match[str] | None:
        """Whether ``words`` are this."""
        return self._part.match(words) if words.startswith(self._pieces[0]) else None

    def stands(self, text: str, at: int) -> re.Match[str] | None:
        """Whether this sentence stands in ``text`` at a place."""
        return self._sentence.match(text, at) if text.startswith(self._pieces[0], at) else None


@dataclass(frozen=True)
class Catalogue:
    """What is known of a language: words by themselves, sentences, and parts of sentences."""

    words: Mapping[str, str]
    sentences: Sequence[Template]
    parts: Sequence[Template]


@cache
def catalogue() -> Catalogue:
    """Chinese, read when it is spoken."""
    read = yaml.load(_FILE.read_text("utf-8"), Loader=_Loader)  # noqa: S506 - a safe one
    words, templates = {**_of_skills(), **read["words"]}, []
    for section in read["said"].values():
        for written, told in section.items():
            templates.append(Template(written, told))
    templates += [Template(written, told) for written, told in (*_of_actions().items(), *_of_the_planner())]
    templates.sort(key=lambda template: -template.exactness)
    return Catalogue(
        words | {one.written.casefold(): one.told for one in templates if not one.slots and not one.is_sentence},
        [one for one in templates if one.is_sentence],
        [one for one in templates if one.slots and not one.is_sentence],
    )


def _of_skills() -> dict[str, str]:
    """What skills and their arguments are called."""
    chinese = {name: record.zh for name, record in records().items()}
    called = {name: words.called for name, words in chinese.items() if words.called}
    return {name: said for words in chinese.values() for name, said in words.arguments.items()} | called


def _of_actions() -> dict[str, str]:
    """How actions are told, as steps and as what goes on, from the records of the skills. Two that English tells alike
    (navigation, navigate_to_object) are told by the one that may have any name in its slot."""
    pairs: dict[str, tuple[str, str]] = {}
    for _, record in sorted(records().items()):
        chinese = {tuple(one.when.items()): one for one in record.zh.told}
        for english in record.en.told:
            if (twin := chinese.get(tuple(english.when.items()))) is None:
                continue
            step = twin.step.removesuffix("。")
            for written, told in ((english.step.removesuffix("."), step), (english.doing, twin.doing or step)):
                for short, short_told in _with_and_without(written or "", told):
                    for begun in {short, f"{short[:1].upper()}{short[1:]}"} - {""}:
                        pairs[_SLOTS.sub("{}", begun)] = begun, short_told
    return dict(pairs.values())


def _of_the_planner() -> Iterator[tuple[str, str]]:
    """What the planner says, which it has in both languages itself. What somebody said stays as it is, and a slot at
    the end holds a sentence of its own."""
    english, chinese = (load(language)["answers"] for language in ("en", "zh"))
    pairs = [(english[key], chinese[key]) for key in ("understood", "understood_anywhere")]
    pairs += [(english[part][key], chinese[part][key]) for part in ("talk", "questions") for key in english[part]]
    for written, told in (*pairs, *((SAID["en"][key], SAID["zh"][key]) for key in SAID["en"])):
        template = Template(_OWN_SENTENCE.sub("", written), _OWN_SENTENCE.sub("", told))
        if template.is_sentence:
            yield _UNTOLD.sub(r"{\1:s}", _SAID.sub(r"\1{\2:s}\3", template.written)), template.told


def _with_and_without(english: str, chinese: str) -> Iterator[tuple[str, str]]:
    """A telling with its optional parts, and without any of them, as pairs of a template; the words that somebody said
    stay as they are."""
    given = _OPTIONAL.findall(english)
    for count in range(1 << len(given)):
        kept = {slot for number, part in enumerate(given) if count >> number & 1 for slot in _SLOTS.findall(part)}

        def optional(found: re.Match[str], kept: set[tuple[str, str]] = kept) -> str:
            return found[1] if set(_SLOTS.findall(found[1])) <= kept else ""

        written, told = _OPTIONAL.sub(optional, english), _OPTIONAL.sub(optional, chinese)
        if {name for name, _ in _SLOTS.findall(told)} == {name for name, _ in _SLOTS.findall(written)}:
            yield _SAID.sub(r"\1{\2:s}\3", written), told


def build_wording(settings: Settings) -> Wording:
    """The wording of a robot that knows this house; its names are read when they are needed."""

    @lru_cache(maxsize=1000)
    def called(name: str) -> Sequence[str]:
        if (declared := settings.skills.get(name)) is not None and declared.words.zh.called:
            return (name, declared.words.zh.called)
        place = settings.places.get(name)  # actions name places by their symbols
        try:
            return build_vocabulary(settings).words_for(name if place is None else place.name)
        except SceneError:  # that has been said, and this may be how
            return (name,)

    return Wording(called, language=None if settings.planner.language == "auto" else settings.planner.language)


def _nameless(words: str) -> str:
    """A name that nobody has put into Chinese, without its article; all other words as they are."""
    return _ARTICLE.sub("", words) if len(words.split()) <= _SHORT + 1 else words
