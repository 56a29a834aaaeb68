"""What the planner itself says, in each language."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from engine.planner.request import Language

SAID: Final[Mapping[Language, Mapping[str, str]]] = {
    "en": {
        "unknown_place": "I don't know a place called {name}. I know {known}.",
        "not_understood": "I did not understand{part}. {understood}",
        "which_thing": "Which thing do you mean?",
        "absent": "I see no {thing} there.",
        "present": "The {thing} is there.",
        "uncounted": "I can see whether there is any {thing}, but not how many.",
        "so_many": "It is so.",
        "not_so_many": "It is not so.",
        "no_place_there": "I know no place beside the {name} to stand at. Shall I go to the {room}? It is there.",
        "unknown_thing": "I do not know what a {thing} looks like, so I cannot tell whether it is there.",
        "which_of": "Which one: the {names}?",
        "or": " or the ",
        "unfinished": "That stops in the middle. What shall I do?",
        "all_right": "All right.",
        "forbidden": "I heard “{words}”, so I do nothing. What shall I do?",
        "told": "I heard “{words}”, so I take that for talk about an order, and do nothing. What shall I do?",
        "asked": "I don't know. If you want me to do something, tell me to.",
        "condition": "I did not understand what that depends on, so I do nothing yet. What shall I do?",
        "nearest": "I don't know a place called {name}. Shall I go to the {near}?",
        "no_model": "{answer} ({error})",
    },
    "zh": {
        "unknown_place": "我不知道叫“{name}”的地方。我知道：{known}。",
        "not_understood": "我没有听懂{part}。{understood}",
        "which_thing": "您指的是哪个东西？",
        "absent": "我在那里没有看到{thing}。",
        "present": "{thing}在那里。",
        "uncounted": "我能看到那里有没有{thing}，但数不出有几个。",
        "so_many": "是这样。",
        "not_so_many": "不是这样。",
        "no_place_there": "我不知道“{name}”旁边可以去的位置，它在{room}里。要我去{room}吗？",
        "unknown_thing": "我不认识“{thing}”，所以不知道那里有没有。",
        "which_of": "哪一个：{names}？",
        "or": "还是",
        "unfinished": "话好像没有说完。您要我做什么？",
        "all_right": "好的。",
        "forbidden": "我听到“{words}”，所以什么也不做。您要我做什么？",
        "told": "我听到“{words}”，我想这只是在说某个命令，所以什么也不做。您要我做什么？",
        "asked": "我不知道。要我做什么，请直接告诉我。",
        "condition": "我没有听懂要看什么情况，所以先什么也不做。您要我做什么？",
        "nearest": "我不知道叫“{name}”的地方。要我去{near}吗？",
        "no_model": "{answer}（{error}）",
    },
}
