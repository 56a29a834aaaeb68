"""What the grammar's commands about people mean: who must be in the house, and what is to be judged.

One function a kind, under the productions that it belongs to, as the grammar's file writes them without metas.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

from engine.robot.company import Posture
from tests.eval.gpsr.goal import Fact, Goal, MustBe, Want
from tests.eval.gpsr.lexicon import Gender, said
from tests.eval.gpsr.making import GENDERS, GESTURE_WORDS, Kind, Making, Order, Receiver, Traits, Undrawable

OfTheDay = Literal["", "time", "today", "tomorrow", "weekday", "day"]
POSTURES: Final[Mapping[str, Posture]] = {"sitting": "sitting", "standing": "standing", "lying down": "lying"}
_POSTURE_WORDS: Final[Mapping[Posture, tuple[str, ...]]] = {
    "sitting": ("sitting", "sits", "seated", "坐"),
    "standing": ("standing", "stands", "站"),
    "lying": ("lying", "lies", "躺"),
}
_GENDER_WORDS: Final[Mapping[Gender, tuple[str, ...]]] = {
    "female": ("female", "woman", "girl", "lady", "女"),
    "male": ("male", "man", "boy", "gentleman", "男"),
}
_OTHER: Final[Mapping[Gender, Gender]] = {"female": "male", "male": "female"}
_SPEECH: Final[Mapping[str, tuple[OfTheDay, str]]] = {
    "something about yourself": ("", "介绍一下你自己"),
    "the time": ("time", "告诉他现在几点"),
    "what day is today": ("today", "告诉他今天是几号"),
    "what day is tomorrow": ("tomorrow", "告诉他明天是几号"),
    "your team's name": ("", "告诉他你们队的名字"),
    "your team's country": ("", "告诉他你们队来自哪个国家"),
    "your team's affiliation": ("", "告诉他你们队属于哪个单位"),
    "the day of the week": ("weekday", "告诉他今天星期几"),
    "the day of the month": ("day", "告诉他今天是这个月的几号"),
    "a joke": ("", "讲个笑话"),
}
"""What there is to say: what is judged of it, and in Chinese."""
_QUESTION: Final = {"question": "What day is today?", "问题": "今天星期几？"}
"""What they answer where the robot asks for their question."""
_OUTSIDE: Final = "entrance"
"""The end of the house: outside of it nobody walks in a simulation."""


def _zh(word: str) -> str:
    return said(word, "zh")


# Find people


def talk_to_whom_is_found(m: Making) -> Order:
    """Somebody is described, in a room; a question of theirs is answered, or something is told."""
    more: Traits = {"replies": _QUESTION} if m.drawn.has("answer") else {}
    described = m.drawn.has("whowhere")
    to = m.gesturing(m.drawn.fill("gesture"), m.place("room"), **more) if described else _found(m, more)
    if m.drawn.has("answer"):
        of_the_day, chinese = "weekday", "回答他的一个问题"
        wants: tuple[Want, ...] = (Want(("ask", "tell"), to.who),)
    else:
        of_the_day, chinese = _SPEECH[m.drawn.word("whattosay")]
        wants = (Want(("tell",), to.who),)
    fact = Fact(of_the_day=of_the_day, to=to.key)  # type: ignore[arg-type]
    truth = MustBe("heard", to.key, words=("",))
    return m.order(f"找到{to.chinese}，{chinese}", Goal(wants, (truth,), (fact,)))


def _found(m: Making, more: Traits) -> Receiver:
    room = m.place("room")
    m.clear.add(room)
    if pose := m.drawn.word("pose"):
        more["posture"] = POSTURES[pose]
        key = m.guest(room, **more)
        return Receiver(key, GESTURE_WORDS[pose], room, f"{_zh(room)}里{_zh(pose)}的人")
    if word := m.drawn.word("pgenders"):
        gender, is_child = GENDERS[word]
        more["is_child"] = is_child
        key = m.guest(room, gender=gender, **more)
        return Receiver(key, (word, _zh(word), "person"), room, f"{_zh(room)}里的{_zh(word)}")
    return m.gesturing(m.drawn.fill("gesture"), room, **more)


def tell_of_a_person(m: Making) -> Order:
    trait = m.drawn.word("fndppl|")
    at = m.drawn.fill("beacon" if "{beacon}" in (m.drawn.find("fndppl") or m.drawn.tree).production else "room")
    postures: tuple[Posture, ...] = ("standing", "sitting") if trait == "pose" else ("standing",)
    m.guest(at, posture=m.chance.choice(postures))
    m.clear.add(at)
    guest = m.guests[-1]
    right: tuple[str, ...]
    match trait:
        case "name":
            right, wrong = (guest.called,), tuple(n for n, _ in m.lexicon.names if n != guest.called)
        case "gender":
            right, wrong = _GENDER_WORDS[guest.gender], _GENDER_WORDS[_OTHER[guest.gender]]
        case _:
            right = _POSTURE_WORDS[guest.posture]
            wrong = tuple(w for p, words in _POSTURE_WORDS.items() if p != guest.posture for w in words)
    goal = Goal((Want(("look", "find", "ask"), places=(at,)),), facts=(Fact((right,), wrong),))
    return m.order(f"告诉我{_zh(at)}那里的人的{_zh(trait)}", goal)


def count_people(m: Making) -> Order:
    room, word = m.place("room"), m.drawn.word("fndppl|")
    m.clear.add(room)
    count = m.chance.randint(1, 2)
    if word in POSTURES:
        others = [posture for posture in POSTURES.values() if posture != POSTURES[word]]
        for posture in (*[POSTURES[word]] * count, m.chance.choice(others)):
            m.guest(room, posture=posture)
    else:
        gender, is_child = GENDERS[word]
        for _ in range(count):
            m.guest(room, gender=gender, is_child=is_child)
        m.guest(room, gender=_OTHER[gender], is_child=is_child)
    goal = Goal((Want(("look", "find"), places=(room,)),), facts=(Fact(number=count),))
    return m.order(f"告诉我{_zh(room)}里有几个人是{_zh(word)}", goal)


# Follow


def follow(m: Making) -> Order:
    name, beacon, room = m.drawn.fill("name", 1), m.place("beacon", 1), m.place("room", 2)
    if m.lexicon.room_of(beacon) == room:
        raise Undrawable
    key = m.named(1, beacon, leads_to=room)
    wants = (Want(("follow",), (name,)),)
    said_room = "" if m.drawn.has("fllwhdst") else f"到{_zh(room)}"
    truths = (MustBe("accompanied", key, place=room),)
    if m.drawn.has("gobeacon"):
        return m.order(f"去{_zh(beacon)}找{name}，然后跟着他", Goal(wants, truths))
    return m.order(f"从{_zh(beacon)}跟着{name}{said_room}", Goal(wants, truths))


def follow_whom_one_must_find(m: Making) -> Order:
    name, beacon = m.drawn.fill("name", 1), m.place("beacon", 1)
    room = m.chance.choice([room for room in m.lexicon.rooms if room != m.lexicon.room_of(beacon)])
    key = m.named(1, beacon, leads_to=room, known=True)
    goal = Goal(
        (Want(("follow",), (name,)),), (MustBe("accompanied", key, place=room),), answers={"": _zh_or(m, beacon)}
    )
    return m.order(f"跟着{name}", goal)


def _zh_or(m: Making, place: str) -> str:
    return f"在{_zh(place)}" if m.language == "zh" else f"at the {place}"


def follow_out_and_go(m: Making) -> Order:
    name, beacon, room = m.drawn.fill("name", 1), m.place("beacon", 1), m.place("room", 1)
    key = _leads_out(m, beacon)
    wants = (Want(("follow",), (name,)), Want(("go",), places=(room,)))
    truths = (MustBe("accompanied", key), MustBe("robot in", place=room))
    return m.order(f"去{_zh(beacon)}找{name}，跟着他，然后去{_zh(room)}", Goal(wants, truths))


def follow_out_and_guide(m: Making) -> Order:
    name, beacon = m.drawn.fill("name", 1), m.place("beacon", 1)
    key = _leads_out(m, beacon)
    wants = (Want(("follow",), (name,)), Want(("guide",), (name,)))
    truths = (MustBe("accompanied", key), MustBe("arrived", key, place=beacon))
    return m.order(f"去{_zh(beacon)}找{name}，跟着他，再带他回去", Goal(wants, truths))


def _leads_out(m: Making, beacon: str) -> str:
    if beacon == _OUTSIDE:
        raise Undrawable
    return m.named(1, beacon, leads_to=_OUTSIDE)


# Guide


def guide(m: Making) -> Order:
    """Whoever is guided stops once on the way."""
    name, source, to = m.drawn.fill("name", 1), m.place("beacon", 1), m.place("beacon", 2)
    key = m.named(1, source, strays=True)
    chinese = f"去{_zh(source)}找到{name}，带他去{_zh(to)}"
    return m.order(chinese, _guided(key, name, to))


def _guided(key: str, name: str, to: str, answers: Mapping[str, str] | None = None) -> Goal:
    wants = (Want(("guide",), (name,), places=(to,)),)
    return Goal(wants, (MustBe("arrived", key, place=to),), answers=answers or {})


def guide_whom_one_must_find(m: Making) -> Order:
    name, source, to = m.drawn.fill("name", 1), m.place("beacon", 1), m.place("beacon", 2)
    key = m.named(1, source, strays=m.drawn.has("inguidewho"), known=True)
    if m.drawn.has("inguidewho"):  # where to, the command does not say
        whither = f"去{_zh(to)}" if m.language == "zh" else f"to the {to}"
        led = f"去{_zh(source)}，" if m.drawn.has("gobeacon") else ""
        return m.order(f"{led}找到{name}，给他带路", _guided(key, name, to, {"": whither}))
    return m.order(f"带{name}去{_zh(to)}", _guided(key, name, to, {"": _zh_or(m, source)}))


def guide_to_taxi(m: Making) -> Order:
    name, source = m.drawn.fill("name", 1), m.place("beacon", 1)
    key = m.named(1, source)
    return m.order(f"去{_zh(source)}找到{name}，带他去坐出租车", _guided(key, name, "taxi"))


# Party host


def serve(m: Making) -> Order:
    room, what = m.place("room"), m.drawn.word("partyhost|")
    keys = _guests(m, room)
    place = m.home(m.lexicon.wares_of(what)[0])
    things = tuple(m.item(name, place) for name in m.chance.sample(m.lexicon.wares_of(what), 2))
    wants = (Want(("pick",), things=things), Want(("give", "put")))
    truths = tuple(MustBe("given", key, things) for key in keys)
    return m.order(f"给{_zh(room)}里的{_everyone(m)}送{_zh(what)}", Goal(wants, truths))


def _guests(m: Making, room: str) -> tuple[str, str]:
    """Two people in a room, such as the command speaks of."""
    m.clear.add(room)
    word = m.drawn.word("phpeople").rpartition(" ")[2]
    gender, is_child = GENDERS.get(word, (None, word == "children"))
    first, second = (m.guest(room, gender=gender, is_child=is_child) for _ in range(2))
    return first, second


def _everyone(m: Making) -> str:
    word = m.drawn.word("phpeople")
    return "每个人" if word == "everyone" else f"所有{_zh(word.rpartition(' ')[2])}"


def introduce_to_all(m: Making) -> Order:
    name, room, door = m.drawn.fill("name"), m.place("room"), m.drawn.word("door")
    is_back = door.split()[0] in ("back", "rear")
    m.named(None, "exit" if is_back else "entrance")
    keys = _guests(m, room)
    wants = (Want(("tell",)),)
    truths = tuple(MustBe("heard", key, words=(name,)) for key in keys)
    chinese = f"去{'后门' if is_back else '前门'}接{name}，把他介绍给{_zh(room)}里的{_everyone(m)}"
    return m.order(chinese, Goal(wants, truths))


def introduce_to_one(m: Making) -> Order:
    one, other = m.drawn.fill("name", 1), m.drawn.fill("name", 2)
    here, there = m.place("beacon", 1), m.place("beacon", 2)
    m.named(1, here)
    key = m.named(2, there)
    goal = Goal((Want(("tell",), (other, one)),), (MustBe("heard", key, words=(one,)),))
    return m.order(f"去{_zh(here)}找{one}，把他介绍给{_zh(there)}的{other}", goal)


def ask_to_leave(m: Making) -> Order:
    name, beacon = m.drawn.fill("name"), m.place("beacon")
    key = m.named(None, beacon)
    truth = MustBe("heard", key, words=("leave", "go now", "离开", "走"))
    goal = Goal((Want(("ask", "tell"), (name,)),), (truth,))
    return m.order(f"去{_zh(beacon)}找{name}，请他离开", goal)


KINDS: Final[Mapping[tuple[str, str], Kind]] = {
    ("fndppl", "Tell me the (name | gender | pose) of the person at the {beacon}"): tell_of_a_person,
    ("fndppl", "Tell me the (name | gender | pose) of the person in the {room}"): tell_of_a_person,
    ("fndppl", "tell me how many people in the {room} are ($pgenderp | $pose)"): count_people,
    ("fndppl", "$talk to $whowhere"): talk_to_whom_is_found,
    ("fndppl", "$findp in the {room} and $talk"): talk_to_whom_is_found,
    ("fndppl", "$goroom , $findp , and $talk"): talk_to_whom_is_found,
    ("follow", "$vbfollow {name 1} from the {beacon 1} to the {room 2}"): follow,
    ("follow", "meet {name 1} at the {beacon 1} and $vbfollow {pron} $fllwdest"): follow,
    ("follow", "$gobeacon , meet {name 1} , and $vbfollow {pron} $fllwhdst"): follow,
    ("followout", "$fllwoutdest meet {name 1} at the {beacon 1} , $vbfollow {pron} , and $goroom"): follow_out_and_go,
    (
        "followout",
        "$fllwoutdest meet {name 1} at the {beacon 1} , $vbfollow {pron} , and $vbguide {pron} back",
    ): follow_out_and_guide,
    ("gdcmd", "$vbguide {name 1} from the {beacon 1} to the {beacon 2}"): guide,
    ("gdcmd", "meet {name 1} at the {beacon 1} and $guideto"): guide,
    ("gdcmd", "$gobeacon , meet {name 1} , and $guideto"): guide,
    ("gdcmd", "$vbguide {name 1} to the {beacon 2} , $gdwhere"): guide,
    ("incomplete", "$vbfollow {name 1}"): follow_whom_one_must_find,
    ("incomplete", "$vbguide {name 1} to the {beacon 2}"): guide_whom_one_must_find,
    ("incomplete", "meet $inguidewho and $vbguide {pron}"): guide_whom_one_must_find,
    ("incomplete", "$gobeacon , meet $inguidewho , and $vbguide {pron}"): guide_whom_one_must_find,
    ("partyhost", "$vbserve (drinks | snacks) to $phpeopler"): serve,
    ("partyhost", "$vbmeet {name} at the $door and introduce {pron} to $phpeopler"): introduce_to_all,
    ("partyhost", "$vbmeet {name} at the {beacon} and ask {pron} to leave"): ask_to_leave,
    (
        "partyhost",
        "$vbmeet {name 1} at the {beacon 1} and introduce {pron} to {name 2} at the {beacon 2}",
    ): introduce_to_one,
    ("partyhost", "$vbmeet {name 1} at the {beacon 1} and $vbguide {pron} to {pron pos} $taxi"): guide_to_taxi,
}
