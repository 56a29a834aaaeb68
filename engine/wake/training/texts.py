"""What is said: the phrase, what is nearly the phrase, what one says to a robot, and everything else."""

from __future__ import annotations

import random
import re
from collections.abc import Sequence
from typing import Final

from engine.han import is_chinese
from engine.wake.training import chinese
from engine.wake.training.voices import Language

ONSETS: Final = ("b", "d", "m", "r", "t", "w", "")
VOWELS: Final = ("a", "i", "oo", "ee")
OTHER_NAMES: Final = (
    "there",
    "you",
    "robot",
    "Google",
    "Siri",
    "Jarvis",
    "Rosie",
    "Sam",
    "everyone",
    "listen",
    "Alexa",
)

KNOWN_NEAR: Final = {
    "hey sayso": (
        "say so", "hey say", "they say so", "I say so", "you said so", "hey Sarah", "hey Seiko", "if you say so",
        "hey so so", "hey Sasha", "hey, so", "stay so", "hey Sato", "essay so", "hey Lassie", "they also", "hey Cisco",
        "just because I say so", "a sales pitch", "the same sofa", "hey, save some", "did he say no", "hey Satan",
    ),
    "stop": (
        "stock", "step", "top", "shop", "start", "stuff", "stamp", "drop", "steep", "stoop", "star", "stomp", "chop",
        "store", "spot", "storm", "stack", "stick", "cop", "stork", "stalk", "pop", "swap", "stone", "stand", "still",
        "a lot", "some more", "test", "past", "slop", "strong", "most of", "post", "it's hot", "the top", "laptop",
        "start now", "step back", "in stock", "rooftop", "tip top", "hop", "flop", "sort", "short", "sob", "staff",
    ),
}  # fmt: skip
"""For the phrases that ship: what people say that sounds like them."""

COMMANDS: Final = (
    "Go to the kitchen.", "Turn left ninety degrees.", "Move forward half a metre.", "What do you see?",
    "Bring me the red box.", "Pick up the blue cup and put it on the table.", "Come back.", "Raise your arm.",
    "Follow me.", "Follow the blue line.", "Remember this place.", "Where is the ball?", "Clean the room.",
    "Put it in the bin.", "Open the gripper.", "Go to the study and wait there.", "Turn the light green.", "Nod twice.",
    "End the current task.", "Patrol the bedroom and the living room.", "Drive slower, please.", "What can you do?",
    "How far is the wall?", "Go back twenty centimetres.", "Turn around and look for the cat.",
)  # fmt: skip

SENTENCES: Final = (
    "I think we should leave before it starts to rain.", "Have you seen my keys anywhere?", "The train was late again.",
    "She told me about her trip to Scotland last summer.", "Could you pass the salt, please?", "It is half past seven.",
    "We still need milk, bread, and a dozen eggs.", "My brother's house is at the top of the hill.", "Yes, of course.",
    "That was the best film that I have seen this year.", "No, I don't think so.", "Let's talk about it tomorrow.",
    "He says it also works with the old software.", "The shop closes at six on Saturdays.", "How was your day?",
    "Nobody knows what happened to the second package.", "Hey, what are you doing there?", "Okay, thank you very much.",
    "Please take a seat, the doctor will see you soon.", "The weather tomorrow: sunny, with some clouds later.",
    "It costs about fifteen dollars, including shipping.", "Mum, where did you put the scissors?", "Oh, I see.",
    "One, two, three, four, five, six, seven, eight, nine, ten.", "The stars are bright tonight, aren't they?",
    "A quick brown fox jumps over the lazy dog.", "You have reached the voice mail of Doctor Anderson.",
    "They stayed at a small hotel close to the station.", "I'd say that's a pretty good start.", "Good morning!",
    "Her essay was about the history of the steam engine.", "Turn the music down, I can't hear you.", "Maybe later.",
    "The recipe says to add the sugar slowly and stir.", "We also sell shoes, socks and sweaters.", "Never mind.",
    "Is there anything else that I can help you with?", "Someone is at the door.", "What a lovely surprise!",
    "The meeting was moved from Thursday to next Monday.", "He dropped his phone on the steps.", "I'm so sorry.",
    "Can you read me the first paragraph again?", "It takes twenty minutes by bus, or an hour on foot.", "Perfect.",
)  # fmt: skip

WORDS: Final = tuple(
    "about after again all also always and another any apple are as at away baby back bad bag ball bank be because bed "  # noqa: SIM905
    "before begin behind best better big bird black blue boat body book both box boy bread bring broken brother build "
    "busy but buy by call came can car carry cat chair change cheese child church city clean clear close cloud coat "
    "coffee cold colour come cook cosy could country crazy daisy dark daughter day decide deep desk dinner do doctor "
    "dog door down draw drink drive early earth easy egg else end enough evening ever every eye face fall family far "
    "farm fast father feel few field finger finish fire first fish five floor flower fly follow food foot for forest "
    "four free friend from full funny garden gave girl give glad glass go gold good grass great green grey group grow "
    "hair half hand happy hard has hat have he head hear heavy help her here high him his hold holiday home hope horse "
    "hospital hot hour house how hundred I ice idea if in into is it job join joy juice July jump just keep key kind "
    "king kitchen knee knife know lady lake language large last late laugh lazy learn leave left leg lemon less let "
    "letter light like line listen little live long look lose love low lucky made mail main make man many may me meat "
    "meet message middle milk minute money moon more morning most mother mountain mouth move much music must my name "
    "near need never new next nice night no noise nose not nothing now number o'clock of off often oil old on once one "
    "only open or orange order other our out over own page paper part party pay people person phone picture piece "
    "place play please pocket police pretty pull push put quarter queen question quick quiet rain raise ready really "
    "red rest rice right ring river road room rose round run sad said salt same sand say school sea season seat "
    "second see sell send seven shall she ship shoe short show shower side silver sing sister six sleep slow small "
    "snow so soap soft some song soon soup south speak spoon spring star station stay stone story street strong "
    "such sugar summer sun sure sweet swim table take talk tall tea teach tell ten than thank that the their them then "
    "there these they thing think this those three through ticket time to today toe together tomorrow too top towel "
    "town toy train tree trousers true try turn twelve two ugly uncle under until up us use usual valley van very "
    "village visit voice wait walk wall want warm was wash watch water way we wear weather week well went were west "
    "wet what wheel when where which white who why wide wife wild will wind window winter with woman wonder wood word "
    "work world would write wrong yard year yellow yes yesterday you young your zero zoo".split()
)
"""What everybody says every day, with every sound of English in it."""
NAMES: Final = tuple(
    "Josie Rosa Posy Rory Rosalie Roger Rob Rachel Daisy Maisie Lizzie Lucy Susie Cassie Jessie Bessie Mary Molly "  # noqa: SIM905
    "Sally Polly Holly Harry Barry Larry Terry Jerry Kelly Kevin Peter Paul John Joe Joey Josh Jack Mike Bob Tom Tim "
    "Anna Emma Ella Mia Zoe Chloe Sophie Olivia David Daniel Martin Michael Maria Laura Nora Cora Dora Victor Oscar "
    "Otto Leo Theo Hugo Marco Carlo".split()
)
_HALVES: Final = 20
_FEWEST: Final = 10
"""Texts that are like a phrase. Where there are not so many, everyday words that are short as well take their place."""
_SHORT: Final = 4  # letters
_SENTENCE: Final = (5, 9)  # words

_WORD: Final = re.compile(r"([^aeiouy]*)([aeiouy]+)(.*)")


def language_of(phrase: str) -> Language:
    """In which language a phrase is."""
    return "zh" if is_chinese(phrase) else "en"


def talk(language: Language) -> Sequence[str]:
    """What many say."""
    return COMMANDS + SENTENCES if language == "en" else chinese.COMMANDS + chinese.SENTENCES


def ways_to_say(phrase: str) -> tuple[str, ...]:
    """The phrase as one calls it, asks it, and says it in passing."""
    if is_chinese(phrase):
        return chinese.WAYS.get(phrase, (f"{phrase}。", f"{phrase}！", f"{phrase}？", f"{phrase}，"))
    return (f"{phrase}.", f"{phrase}!", f"{phrase}?", f"{phrase},")


def near(phrase: str, count: int, seed: int = 0) -> list[str]:
    """Up to ``count`` different texts that are like the phrase and are not it."""
    chance = random.Random(f"{seed} {phrase}")
    if is_chinese(phrase):
        return _near_in_chinese("".join(phrase.split()), chance)[:count]
    words = phrase.casefold().split()
    made = [*KNOWN_NEAR.get(" ".join(words), ())]
    if words[0] in ("hey", "hi", "hello", "ok", "okay"):
        made += [f"{words[0]} {name}" for name in (*OTHER_NAMES, *NAMES)]
    if len(words) > 1:
        made += [*words, " ".join(words[1:]), " ".join(words[:-1]), " ".join(reversed(words))]
        for word in chance.sample(WORDS, 2 * _HALVES):  # half of it is not it
            made += [f"{words[0]} {word}", f"{word} {words[-1]}"]
    longest = max(words, key=len)
    for changed in _like(longest):
        made.append(" ".join(changed if word == longest else word for word in words))
    kept = list(dict.fromkeys(text for text in made if _letters(text) != _letters(phrase)))
    chance.shuffle(kept)
    return _enough(kept, phrase, chance)[:count]


def rambling(count: int, chance: random.Random, slips: Sequence[str] = (), language: Language = "en") -> list[str]:
    """Sentences of everyday words in no order: they say nothing, but every sound comes beside every other, as in hours
    of talk. Into each, one of ``slips`` is put."""
    known, between, end = (WORDS + NAMES, " ", ".") if language == "en" else (chinese.WORDS, "", "。")
    sentences = []
    for _ in range(count):
        words = chance.sample(known, chance.randint(*_SENTENCE))
        if slips:
            words.insert(chance.randint(0, len(words)), chance.choice(slips))
        sentences.append(f"{between.join(words)}{end}")
    return sentences


def _near_in_chinese(phrase: str, chance: random.Random) -> list[str]:
    made = [*chinese.KNOWN_NEAR.get(phrase, ())]
    if len(phrase) > 1:
        half = len(phrase) // 2
        made += [*phrase, phrase[:half], phrase[half:], phrase[::-1], phrase[1:], phrase[:-1]]
        for word in chance.sample(chinese.WORDS, 2 * _HALVES):  # half of it is not it
            made += [f"{phrase[:half]}{word}", f"{word}{phrase[half:]}"]
    same = {_signs(way) for way in (phrase, *ways_to_say(phrase))}
    kept = [text for text in dict.fromkeys(made) if _signs(text) not in same]
    chance.shuffle(kept)
    return _enough(kept, phrase, chance)


def _enough(kept: Sequence[str], phrase: str, chance: random.Random) -> list[str]:
    """What is like a phrase, and short words where that is too little: nobody trains with nothing to tell it from."""
    if len(kept) >= _FEWEST:
        return list(kept)
    if is_chinese(phrase):
        words = [*chinese.WORDS, *dict.fromkeys("".join(chinese.WORDS))]
    else:
        words = [word for word in WORDS if len(word) <= _SHORT]
    others = [word for word in words if _signs(phrase.casefold()) not in word and word not in kept]
    return [*kept, *chance.sample(others, 2 * _HALVES)]


def _like(word: str) -> Sequence[str]:
    """Words with another beginning, another vowel, or only half of it."""
    parts = _WORD.fullmatch(word)
    if parts is None:  # "psst": it has no vowel, and what is like it has one
        return tuple(f"{word[:1]}{vowel}{word[1:]}" for vowel in VOWELS)
    onset, vowel, rest = parts.groups()
    return (
        *(f"{other}{vowel}{rest}" for other in ONSETS if other != onset),
        *(f"{onset}{other}{rest}" for other in VOWELS if other != vowel),
        *((word[: len(word) // 2 + 1], word[len(word) // 2 :]) if len(word) > 4 else ()),
    )


def _signs(text: str) -> str:
    return "".join(sign for sign in text if sign.isalpha())


def _letters(text: str) -> str:
    return re.sub(r"[^a-z]", "", text.casefold())
