"""Everything that can be set, with types, units, limits and defaults' meaning.

The defaults themselves live in the YAML files beside this module, where a user reads and copies them; this schema
says what is allowed. Every model forbids unknown keys. Settings are frozen: nothing changes them at run time.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Final, Literal, TypeVar
from urllib.parse import urlsplit

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, SecretStr, field_validator, model_validator

from config.languages import CODES, code_of

Seconds = Annotated[float, Field(ge=0)]
Metres = Annotated[float, Field(ge=0)]
T = TypeVar("T")


class Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


Suppression = Literal["off", "low", "moderate", "high"]


class Audio(Section):
    """Where sound comes from."""

    device: str | int | None = Field(
        description="Microphone by (part of the) name or index, or a satellite, tcp://HOST:PORT; null: system default."
    )
    echo: Literal["auto", "off"] = Field(
        description="auto: what the loudspeaker plays is taken out of what the microphone of this machine hears."
    )
    gain_db: Annotated[float, Field(ge=-40, le=40)] | Literal["auto"] = Field(
        description="Gain before anything else, dB; auto: learnt from what is understood, 0 to 30."
    )
    noise_suppression: Suppression = Field(
        description="Steady noise is taken out of what is heard; only where it is as loud as the voice does that help."
    )

    @field_validator("device")
    @classmethod
    def _named(cls, device: str | int | None) -> str | int | None:
        if isinstance(device, str) and "://" in device and not WYOMING.fullmatch(device):
            raise ValueError(
                "this is no address of a satellite; write tcp://HOST:PORT, for example tcp://kitchen:10700"
            )
        return device


WakeProtocol = Literal["ai_voice", "ai_voice_bilingual", "csk4002", "iflytek"]
"""The wake modules there are; each has a file in engine/wake."""


class SerialWake(Section):
    """A module on a serial line that knows its wake word itself."""

    port: str | None = Field(
        description="A device, VID:PID[:serial number], or auto: every USB serial port; null: there is no module."
    )
    protocol: Literal["auto"] | WakeProtocol = Field(
        description="Which module it is; auto: all but ai_voice_bilingual are understood, and none is spoken to first."
    )
    phrase: int | None = Field(
        ge=0, le=999, description="Number of the phrase by which the module answers a wake; null: none."
    )

    @field_validator("port")
    @classmethod
    def _port(cls, port: str | None) -> str | None:
        if port is None or port == "auto" or "/" in port or USB_DEVICE.fullmatch(port):
            return port
        raise ValueError("this is no serial port; write its device (/dev/ttyUSB0), VID:PID (1a86:7523), or auto")

    @model_validator(mode="after")
    def _plays(self) -> SerialWake:
        last = {"iflytek": -1, "ai_voice": 255, "ai_voice_bilingual": 255}.get(self.protocol, 999)
        if self.phrase is not None and self.phrase > last:
            plays = f"plays phrases up to {last}" if last >= 0 else "plays no phrases"
            raise ValueError(f"the module {self.protocol} {plays}")
        return self


USB_DEVICE = re.compile(r"([0-9a-fA-F]{4}):([0-9a-fA-F]{4})(?::(.+))?")
"""How a USB device is named: what its maker and its kind have for numbers, and its own serial number if need be."""


class Wake(Section):
    """What calls the robot, besides a key and a command."""

    serial: SerialWake
    words: Literal["auto"] | tuple[Annotated[str, Field(min_length=1)], ...] = Field(
        description="Phrases that wake (`sayso wake list`); auto: hey jarvis and hey sayso, as far as installed."
    )
    threshold: float | None = Field(
        gt=0, lt=1, description="How sure it has to be of a word; null: as the word's own trial says."
    )


class Vad(Section):
    """Whether somebody speaks."""

    backend: Literal["auto", "silero", "webrtc"] = Field(
        description="auto: webrtcvad as gate and Silero to confirm, webrtcvad alone where Silero cannot load."
    )
    gate_mode: int = Field(ge=0, le=3, description="webrtcvad aggressiveness.")
    threshold: float = Field(gt=0, lt=1, description="Silero probability that counts as speech.")


class Endpoint(Section):
    """When an utterance starts and ends."""

    pre_roll_s: Seconds = Field(le=2, description="Sound kept from before the confirmed start.")
    start_s: Seconds = Field(gt=0, le=1, description="Speech needed to confirm a start.")
    silence_s: Seconds = Field(gt=0, le=5, description="Silence that ends an utterance.")
    complete_s: Seconds = Field(gt=0, le=5, description="The same once what was said is a complete command.")
    incomplete_s: Seconds = Field(gt=0, le=5, description='The same after "and", "to the", or a number without a unit.')
    max_length_s: Seconds = Field(gt=1, le=25, description="Longest utterance; ends it in steady noise too.")
    no_speech_s: Seconds = Field(gt=0, le=120, description="Give up listening when nobody spoke for this long.")


class Asr(Section):
    """Speech recognition."""

    backend: Literal["whisper", "openai", "wyoming"] = Field(
        description="whisper: on this machine; openai: a service (platform); wyoming: a server (server)."
    )
    model: str = Field(
        description="Of whisper: a name from `sayso models list`, a size (small, large-v3) that `hf download` has"
        " fetched, or a folder with a CTranslate2 model."
    )
    platform: str | None = Field(description="Of openai: whose /audio/transcriptions it is (platforms.yaml).")
    server: str | None = Field(description="Of wyoming: its address, tcp://HOST:PORT or unix:///PATH.")
    language: str = Field(description="ISO 639-1 code, or auto.")
    languages: tuple[str, ...] = Field(min_length=1, description="Among which auto chooses; ISO 639-1 codes.")
    threads: int = Field(ge=0, le=64, description="0: half of the cores, at least one.")
    window_s: Seconds = Field(ge=10, le=30, description="Encoder window; shorter is faster.")
    min_logprob: float = Field(le=0, description="Reject a transcript whose mean token log-probability is lower.")
    max_no_speech: float = Field(ge=0, le=1, description="Reject a transcript with a higher no-speech probability.")

    @field_validator("languages")
    @classmethod
    def _known(cls, languages: tuple[str, ...]) -> tuple[str, ...]:
        for language in languages:
            if language not in CODES:
                meant = code_of(language)
                write = meant if meant in CODES else "ISO 639-1 codes, for example [en, zh]"
                raise ValueError(f"{language!r:.40} is no language of Whisper; write {write}")
        return languages

    @field_validator("server")
    @classmethod
    def _address(cls, server: str | None) -> str | None:
        return _wyoming(server)

    @model_validator(mode="after")
    def _reachable(self) -> Asr:
        if self.backend == "wyoming" and self.server is None:
            raise ValueError("the backend wyoming needs asr.server, for example tcp://127.0.0.1:10300")
        return self


WYOMING = re.compile(r"tcp://[^/:\s]+:\d{1,5}|unix:///\S+")
"""How a Wyoming server is named."""


class Voice(Section):
    """How answers are spoken."""

    when: Literal["spoken", "always", "never"] = Field(
        description="Which answers are spoken: those to spoken requests, those to typed ones as well, or none."
    )
    backend: Literal["auto", "piper", "espeak", "openai", "wyoming"] = Field(
        description="auto: piper for English and espeak-ng for everything else, as far as they are installed."
    )
    model: str = Field(description="Of piper: a name from `sayso models list`, or the .onnx file of another voice.")
    speaker: str | None = Field(
        description="Which voice of espeak (English), of the platform or of the server; null: the usual one."
    )
    platform: str | None = Field(description="Of openai: whose /audio/speech it is (platforms.yaml).")
    server: str | None = Field(description="Of wyoming: its address, tcp://HOST:PORT or unix:///PATH.")
    speed: float = Field(
        ge=0.5, le=2, description="1: as fast as the voice speaks by itself; a Wyoming server knows no other."
    )
    device: str | int | None = Field(
        description="Loudspeaker by (part of the) name or index; null: of the satellite that is heard, else the usual."
    )
    volume: float = Field(ge=0, le=1, description="Of speech and sounds, 0…1.")
    duck_db: float = Field(ge=0, le=40, description="How much quieter it speaks while somebody is listened to, dB.")
    sounds: bool = Field(description="A sound when it wakes and listens, and where a spoken request gets no answer.")

    @field_validator("server")
    @classmethod
    def _address(cls, server: str | None) -> str | None:
        return _wyoming(server)

    @model_validator(mode="after")
    def _reachable(self) -> Voice:
        if self.backend == "wyoming" and self.server is None:
            raise ValueError("the backend wyoming needs voice.server, for example tcp://127.0.0.1:10200")
        return self


class Planner(Section):
    """From words to plans."""

    language: Literal["auto", "en", "zh"] = Field(
        description="Language of phrases, prompts and answers; auto: that of what was said."
    )
    max_actions: int = Field(ge=1, le=50, description="Longest plan.")
    profile: str = Field(
        description="Large models that think too (profiles.yaml): phrases (none), local, international, china or yours."
    )
    reader: bool = Field(description="Whether the learned reader comes first, before large models.")
    rounds: int = Field(ge=1, le=50, description="Plans that one request may lead to, as feedback is thought over.")
    steps: int = Field(ge=1, le=500, description="Actions that one request may lead to in all its rounds.")


class Session(Section):
    """The conversation."""

    busy: Literal["interrupt", "queue", "reject"] = Field(
        description="What a new command does while one is running: interrupt it, wait for it, or be turned away."
    )
    turn_limit_s: Seconds = Field(gt=0, description="Longest turn; ends with exit code 4.")
    record_log: bool = Field(description="Append every event to a JSON-lines file in the state folder.")
    log_files: int = Field(ge=1, le=1000, description="How many session logs are kept.")
    log_mb: float = Field(gt=0, le=1000, description="Size at which a session log goes on in a new file.")


class Console(Section):
    """The terminal interface."""

    theme: str = Field(description="Name of a Textual theme.")
    language: Literal["auto", "en", "zh"] = Field(
        description="Of words on the screen; auto: zh where planner.language is, else by LC_ALL, LC_MESSAGES or LANG."
    )
    fps: float = Field(gt=0, le=30, description="How often moving panes are redrawn.")
    camera: Literal["auto", "on", "off"] = Field(
        description="Whether what the camera sees is shown from the start; auto: on a large terminal, not over SSH."
    )
    camera_graphics: Literal["auto", "blocks", "sixel", "kitty"] = Field(
        description="How what the camera sees is drawn: characters, or pixels in either way; auto: pixels where the"
        " terminal says that it has them, on a good line, not in tmux or screen."
    )
    motion: Literal["full", "reduced"] = Field(
        description="reduced: nothing slides, and what moves by itself (sound, times, the robot) does so once a second."
    )
    notify: Literal["auto", "off"] = Field(
        description="auto: the end of a task of more than 20 s is told by a desktop notification and the bell, unless"
        " the terminal reports that it has the keyboard."
    )
    history: bool = Field(description="What is typed is kept in the state folder and recalled in later sessions.")
    keys: dict[str, str] = Field(description="Other keys, by action (`ctrl+p` in the console and its help name them).")


class Limits(Section):
    """The safety envelope of the base; no skill, plan or remote user can pass it."""

    linear_speed: float = Field(gt=0, le=2, description="m/s, along either axis.")
    angular_speed: float = Field(gt=0, le=6, description="rad/s.")
    linear_acceleration: float = Field(gt=0, le=10, description="m/s².")
    angular_acceleration: float = Field(gt=0, le=30, description="rad/s².")
    command_lifetime_s: Seconds = Field(gt=0, le=1, description="A motion command without a successor dies after this.")
    obstacle_margin: Metres = Field(
        le=1, description="Nearest that the hull may come to an obstacle by its own motion."
    )


class Camera(Section):
    """The robot's camera."""

    device: str | None = Field(
        default=None,
        description="On a real robot: number, name or path of a USB camera (`sayso robot check` lists them).",
    )
    backend: Literal["auto", "opengl", "rays"] = Field(
        description="Simulated: auto: OpenGL (EGL or OSMesa) where it works, rays cast elsewhere."
    )
    width: int = Field(ge=32, le=640, description="Pixels; more makes small tags readable from farther away.")
    height: int = Field(ge=24, le=480, description="Pixels; 48 degrees of view are divided among them.")


EMULATED: Final = "emulated"
"""The port of no board, and the description of the robot behind it."""


class Robot(Section):
    """Which robot, and how fast it may be."""

    kind: Literal["sim", "rosmaster", "ros2"] = Field(
        description="sim: the MuJoCo robot; rosmaster: one with Yahboom's Rosmaster motor board; ros2: one of ROS 2."
    )
    model: str | None = Field(
        description="How it is made: a name from `sayso robot list`, or a file; null: sim, x3plus on a board, and ros2."
    )
    port: str | None = Field(
        description="Serial port of the motor board; /dev/serial/by-id/… names stay the same. `emulated`: one in here,"
        " which drives the simulated robot."
    )
    door: str | None = Field(
        description="The way to a robot of ROS 2: ws://HOST:PORT, zenoh://HOST:PORT[/DOMAIN] or rclpy."
    )
    lidar: str | None = Field(description="On a real robot: serial port of its lidar; null: it drives without one.")
    scene: str = Field(
        description="The house: name of a scene in assets/scenes, or the path of a scene file. On a real robot it is "
        "the map alone."
    )
    map: str | None = Field(
        description="On a real robot: the YAML file of a map that Nav2 saved, in place of the scene."
    )
    speed: Literal["real", "max"] = Field(
        description="Simulated time: real, or as fast as the machine can. A real robot has the real one."
    )
    heartbeat_s: Seconds = Field(gt=0, le=2, description="The robot stops when the engine is silent for this long.")
    realtime_priority: bool = Field(description="SCHED_FIFO for the robot process where the system allows it.")
    odometry_noise: float = Field(ge=0, le=0.5, description="Relative error of odometry; 0 for none.")
    seed: int = Field(description="Seed of everything random in the simulation.")
    limits: Limits
    camera: Camera

    @model_validator(mode="after")
    def _board_has_a_port(self) -> Robot:
        if self.kind == "rosmaster" and not self.port:
            raise ValueError("a rosmaster needs robot.port; `sayso robot check` lists the ports there are")
        devices = [os.path.realpath(path) for path in (self.lidar, self.port) if path]
        if len(set(devices)) < len(devices):
            raise ValueError("robot.lidar and robot.port are one and the same port")
        if self.kind == "ros2" and not is_door(self.door or ""):
            raise ValueError(
                "a robot of ros2 needs robot.door, such as ws://127.0.0.1:9090, zenoh://127.0.0.1:7447 or rclpy"
            )
        if self.kind == "sim" and self.map is not None:
            raise ValueError("robot.map is for real robots; a simulated one lives in robot.scene")
        return self

    @property
    def emulated(self) -> bool:
        """Whether the motor board is one that is emulated in the robot's own process."""
        return self.kind == "rosmaster" and self.port == EMULATED

    @property
    def made_as(self) -> str:
        """The description: the one that is named, else the usual one of its kind."""
        if self.model is not None:
            return self.model
        if self.kind == "rosmaster":
            return EMULATED if self.emulated else "x3plus"
        return self.kind


class Quaternion(Section):
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0

    @model_validator(mode="after")
    def _unit_length(self) -> Quaternion:
        norm = math.sqrt(self.x**2 + self.y**2 + self.z**2 + self.w**2)
        if abs(norm - 1) > 0.01:
            raise ValueError(f"an orientation is a quaternion of length 1, this one has length {norm:.3f}")
        return self

    @property
    def yaw(self) -> float:
        """Rotation about the vertical axis, rad."""
        return math.atan2(2 * (self.w * self.z + self.x * self.y), 1 - 2 * (self.y**2 + self.z**2))


class Position(Section):
    x: float = Field(description="m, map frame.")
    y: float = Field(description="m, map frame.")
    z: float = Field(default=0.0, description="m, map frame.")


class Place(Section):
    """A place on the map that the robot can be sent to."""

    name: str = Field(min_length=1, description="What people call it.")
    aliases: tuple[str, ...] = ()
    position: Position
    orientation: Quaternion = Quaternion()


PersonColour = Literal["red", "orange", "yellow", "green", "blue", "purple", "white", "grey", "black"]


class KnownPerson(Section):
    """Somebody whom the robot knows; their name is the key."""

    aliases: tuple[str, ...] = Field(default=(), description="Other names, in any language.")
    shirt: PersonColour | None = Field(default=None, description="What they wear, by which they are told apart.")
    trousers: PersonColour | None = None
    tag: int | None = Field(default=None, ge=0, le=586, description="AprilTag 36h11 that they wear.")
    gender: Literal["female", "male"] | None = Field(default=None, description="How they are spoken of.")
    language: Literal["en", "zh"] | None = Field(default=None, description="To speak to them in; null: the request's.")
    place: str | None = Field(default=None, description="The room in which they mostly are; it is looked in first.")


class Platform(Section):
    """A large-model service."""

    kind: Literal["local", "openai", "dify"]
    base_url: str | None = None
    model: str | None = Field(default=None, description="Of a local one: a name from `sayso models list`, or a file.")
    threads: int = Field(default=0, ge=0, le=64, description="Of a local model; 0: one for each core, four at most.")
    api_key: SecretStr | None = Field(default=None, description="Write ${VARIABLE}: keys come from the environment.")
    timeout_s: float = Field(default=30, gt=0, le=600, description="Longest wait for an answer.")
    sees: bool = Field(default=False, description="It is sent what the camera shows when it plans after a look.")
    grammar: bool = Field(default=False, description="It is a llama.cpp server, which can be held to a grammar.")

    @field_validator("base_url")
    @classmethod
    def _address(cls, url: str | None) -> str | None:
        if url is not None and not _is_address(url):
            raise ValueError("this is no address of a service; write https://host/path, as its makers say")
        return url


class Profile(Section):
    """Which large models think, by their names in platforms.yaml. In a list, the next one is asked where one fails;
    when none is left, only what the learned reader understands is done."""

    decision: tuple[str, ...] = Field(
        default=(), description="Break a new request into steps; empty: execution does it in the same breath."
    )
    execution: tuple[str, ...] = Field(
        default=(), description="Turn steps into actions; empty: the learned reader alone."
    )
    vision: str | None = Field(default=None, description="Is sent pictures, to say what they show; null: none is.")


class Models(Section):
    """Where model files are kept."""

    folder: Path | None = Field(description="null: the user's cache folder.")
    fetch: bool = Field(description="Fetch the profile's large model, and piper's voice, in the background.")


class Misnamed(ValueError):
    """A word that names two entries, or one that none may have. ``symbols`` are the entries concerned."""

    def __init__(self, message: str, *symbols: str) -> None:
        super().__init__(message)
        self.symbols = symbols


class Unfit(ValueError):
    """A setting that is right by itself and does not fit another one. ``path`` are the keys of the one to mend,
    ``choices`` what it might have meant."""

    def __init__(self, message: str, *path: str, choices: Collection[str] = ()) -> None:
        super().__init__(message)
        self.path = path
        self.choices = choices


class ExternalParameter(Section):
    """One parameter of an external skill: a number with a unit and limits, or words of a kind."""

    unit: Literal["m", "deg", "s", "m/s", "rad/s", ""] | None = Field(
        default=None, description="Of a number; empty for a bare number."
    )
    min: float | None = Field(default=None, description="Smallest number allowed.")
    max: float | None = Field(default=None, description="Largest number allowed.")
    kind: (
        Literal["place", "places", "object", "surface", "room", "person", "colour", "thing_colour", "sentence"] | None
    ) = Field(
        default=None,
        description="Of words: places are separated by commas or and; colour is that of the light.",
    )
    default: float | str | None = Field(default=None, description="null: an argument is required.")

    @model_validator(mode="after")
    def _number_or_words(self) -> ExternalParameter:
        if (self.unit is None) == (self.kind is None):
            raise ValueError("a parameter is a number (unit, min, max) or words (kind)")
        if self.kind is not None:
            if self.min is not None or self.max is not None:
                raise ValueError("min and max are limits of a number, not of words")
            if isinstance(self.default, float):
                raise ValueError("the default of words is text")
            return self
        if self.min is None or self.max is None or self.min > self.max:
            raise ValueError("a number needs limits: min, and max that is not below it")
        if isinstance(self.default, str) or (self.default is not None and not self.min <= self.default <= self.max):
            raise ValueError(f"the default is a number from {self.min:g} to {self.max:g}")
        return self


def _variable(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name):
        raise ValueError(f"{name!r} is no name of a variable of the environment")
    return name


Variable = Annotated[str, AfterValidator(_variable)]


class Telling(Section):
    """How one action of a skill is told. A slot {name} stands for the argument of that name; what is in [brackets] is
    left out where an argument in it was not given."""

    when: dict[str, str] = Field(
        default={}, description="Arguments that it holds for: a word, or negative or positive of a number."
    )
    step: str = Field(min_length=1, description="A sentence: Drive {distance} back[ at {speed}].")
    doing: str | None = Field(
        default=None, description="What it is doing then: driving back; null: as the step; empty: it speaks for itself."
    )


class SkillWords(Section):
    """The words of a skill in one language."""

    called: str = Field(default="", description="Its name in lists and forms; empty: the name that programs use.")
    arguments: dict[str, str] = Field(default={}, description="What its parameters are called there.")
    told: tuple[Telling, ...] = Field(default=(), description="How it is told; the first that fits is taken.")
    asked: tuple[str, ...] = Field(
        default=(),
        description="How it is asked for: water the {plant} [for {time}]; (a|b) is a choice, [a] may be left out.",
    )


class SkillRecord(Section):
    """The words of a skill in every language that is spoken (assets/skills has those of the built-in ones)."""

    en: SkillWords = SkillWords()
    zh: SkillWords = SkillWords()


class ExternalSkill(Section):
    """A skill that is a program of its own (the protocol is in engine/skills/external/protocol.py)."""

    does: str = Field(min_length=1, description="One sentence about what it does; planners read it.")
    external: tuple[Annotated[str, Field(min_length=1)], ...] = Field(
        min_length=1, description="The program and its arguments; python stands for the one that runs sayso."
    )
    occupies: tuple[Literal["base", "arm", "camera", "voice"], ...] = Field(
        default=(), description="What it may use, and nobody else meanwhile."
    )
    environment: tuple[Variable, ...] = Field(
        default=(), description="Variables that it sees beside PATH, HOME, LANG and the like, by their names."
    )
    parameters: dict[str, ExternalParameter] = {}
    words: SkillRecord = Field(
        default=SkillRecord(), description="How it is asked for and told, in each language; without it, models only."
    )
    silence_s: float | None = Field(
        default=5, gt=0, le=3600, description="The action fails when the program says nothing for so long; null: never."
    )
    depth: bool = Field(default=True, description="Whether it needs a camera that measures depth, if it needs one.")
    endless: bool = Field(
        default=False, description="It goes on until told otherwise: session.turn_limit_s does not end it."
    )

    @model_validator(mode="after")
    def _slots(self) -> ExternalSkill:
        for language in (self.words.en, self.words.zh):
            sentences = [*language.asked, *(text for told in language.told for text in (told.step, told.doing or ""))]
            named = {*language.arguments, *(name for told in language.told for name in told.when)}
            named |= {slot for sentence in sentences for slot in re.findall(r"\{([^{}]*)\}", sentence)}
            for name in sorted(named - self.parameters.keys()):
                known = ", ".join(sorted(self.parameters)) or "none"
                raise ValueError(f"words: there is no parameter {name!r}; there is: {known}")
        return self

    @field_validator("parameters")
    @classmethod
    def _names(cls, parameters: dict[str, ExternalParameter]) -> dict[str, ExternalParameter]:
        return _named(parameters, "parameter")


def _named(entries: dict[str, T], what: str) -> dict[str, T]:
    for name in entries:
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            message = f"{name!r} is no name for a {what}: small letters, digits and _, beginning with a letter"
            raise Misnamed(message, name)
    return entries


def _ros_name(name: str) -> str:
    if not re.fullmatch(r"/?[A-Za-z_]\w*(?:/[A-Za-z_]\w*)*", name, re.ASCII):
        raise ValueError("this is no name of a ROS graph; write words of letters, digits and _, with / between them")
    return name


RosName = Annotated[str, AfterValidator(_ros_name)]
_DOOR = re.compile(
    r"wss?://(?:\[[0-9a-fA-F:]+\]|[^/:@?\s]+)(?::\d{1,5})?(?:/[^?\s]*)?|zenoh://[^/@?\s]+(?:/\d+)?|rclpy"
)
"""How a way to a ROS graph is written: without secrets, for it is shown."""


def is_door(text: str) -> bool:
    """Whether it is a way to a ROS graph."""
    try:
        return _DOOR.fullmatch(text) is not None and urlsplit(text).port != 0
    except ValueError:  # no such port
        return False


class RosNames(Section):
    """What things are called in a ROS graph; null: not there. One that begins with / is outside of the namespace."""

    audio: RosName | None = Field(description="Topic of sound to be heard.")
    command: RosName | None = Field(description="Topic of sentences to be carried out, and of what was heard here.")
    intent: RosName | None = Field(description="Topic of intents, as JSON.")
    voice_feedback: RosName | None = Field(description="Topic of what the robot says.")
    plan: RosName | None = Field(description="Topic of plans, as JSON.")
    outcome: RosName | None = Field(description="Topic of what became of actions and requests, as JSON.")
    stop: RosName | None = Field(description="Topic of std_msgs/msg/Empty: each stops the robot.")
    get_plan: RosName | None = Field(description="Service that plans, and does nothing.")
    execute_plan: RosName | None = Field(description="Action that carries a plan out.")


class Ros(Section):
    """sayso as a part of a ROS 2 graph, whatever its robot is."""

    door: str | None = Field(
        description="The way to the graph: ws://HOST:PORT, zenoh://HOST:PORT[/DOMAIN] or rclpy; null: no part of any."
    )
    namespace: RosName | None = Field(description="Before all names; null: none.")
    sound: Literal["int16", "uint8"] = Field(
        description="Type of sound: int16 (Int16MultiArray) or uint8 (UInt8MultiArray, two bytes a sample)."
    )
    listens: Literal["speech", "wake"] = Field(
        description="speech: sound from the graph is listened to as soon as somebody speaks in it; wake: after a wake."
    )
    names: RosNames

    @field_validator("door")
    @classmethod
    def _way(cls, door: str | None) -> str | None:
        if door is not None and not is_door(door):
            raise ValueError(
                "this is no way to a ROS graph; write ws://127.0.0.1:9090, zenoh://127.0.0.1:7447 or rclpy"
            )
        return door

    @model_validator(mode="after")
    def _distinct(self) -> Ros:
        taken: dict[str, str] = {}
        for key, name in self.names:
            if name is not None and (first := taken.setdefault(name, key)) != key:
                raise ValueError(f"names.{first} and names.{key} are one and the same name")
        return self


class Settings(Section):
    """The whole configuration."""

    audio: Audio
    wake: Wake
    vad: Vad
    endpoint: Endpoint
    asr: Asr
    voice: Voice
    planner: Planner
    session: Session
    console: Console
    models: Models
    robot: Robot
    ros: Ros
    places: dict[str, Place]
    people: dict[str, KnownPerson]
    skills: dict[str, ExternalSkill]
    platforms: dict[str, Platform]
    profiles: dict[str, Profile]

    @field_validator("skills")
    @classmethod
    def _names(cls, skills: dict[str, ExternalSkill]) -> dict[str, ExternalSkill]:
        return _named(skills, "skill")

    @field_validator("places")
    @classmethod
    def _symbols(cls, places: dict[str, Place]) -> dict[str, Place]:
        taken: dict[str, str] = {}
        for symbol, place in places.items():
            if symbol.casefold() == "zero":
                message = "zero is the pose that get_current_pose() remembers and cannot be set here"
                raise Misnamed(message, symbol)
            for word in {symbol.casefold(), place.name.casefold(), *(alias.casefold() for alias in place.aliases)}:
                if taken.setdefault(word, symbol) != symbol:
                    message = f"{word!r} names both {taken[word]} and {symbol}; a place's words are its own"
                    raise Misnamed(message, taken[word], symbol)
        return places

    @field_validator("people")
    @classmethod
    def _each_their_own_name(cls, people: dict[str, KnownPerson]) -> dict[str, KnownPerson]:
        taken: dict[str, str] = {}
        for name, person in people.items():
            for word in (name, *person.aliases):
                if not word.strip() or taken.setdefault(word.casefold(), name) != name:
                    raise Misnamed(f"{word!r} names nobody, or two people; a person's names are their own", name)
        return people

    @model_validator(mode="after")
    def _models_that_think(self) -> Settings:
        if self.planner.profile not in self.profiles:
            known = tuple(self.profiles)
            message = f"there is no profile called {self.planner.profile}; there are {', '.join(known)}"
            raise Unfit(message, "planner", "profile", choices=known)
        profile = self.profile
        for layer, names in (("decision", profile.decision), ("execution", profile.execution)):
            for index, name in enumerate(names):
                self._usable(name, ("local", "openai", "dify"), layer, str(index))
        if profile.vision is not None:
            self._usable(profile.vision, ("openai", "dify"), "vision")
        return self

    @model_validator(mode="after")
    def _services_for_speech(self) -> Settings:
        if self.voice.backend == "openai":
            self._service("voice", self.voice.platform, "the voice is to be that of", "a model of speech")
        if self.asr.backend == "openai":
            self._service("asr", self.asr.platform, "speech is to be recognised by", "a model that transcribes")
        return self

    def _service(self, section: str, name: str | None, purpose: str, model: str) -> None:
        """Whether a platform can do what a section wants. Raises :class:`Unfit`."""
        able = [name for name, it in self.platforms.items() if it.kind == "openai" and it.base_url and it.model]
        if name not in able:
            what = "names none" if name is None else f"{name} is none"
            message = (
                f"{purpose} a platform of the kind openai with a base_url and {model}, "
                f"and {section}.platform {what}; add one to platforms.yaml"
            )
            raise Unfit(message, section, "platform", choices=able)

    def _usable(self, name: str, kinds: tuple[str, ...], *layer: str) -> None:
        """Whether a platform can do the work of a layer. Raises :class:`Unfit`."""
        able = [name for name, platform in self.platforms.items() if platform.kind in kinds]
        known = f"those for this: {', '.join(able) or 'none yet; add one to platforms.yaml'}"
        at = ("profiles", self.planner.profile, *layer)
        platform = self.platforms.get(name)
        if platform is None:
            raise Unfit(f"there is no platform called {name}; {known}", *at, choices=able)
        if platform.kind not in kinds:
            message = f"{name} is a platform of the kind {platform.kind}, which cannot look at pictures; {known}"
            raise Unfit(message, *at)
        needed = {"local": ("model",), "openai": ("base_url", "model"), "dify": ("base_url",)}[platform.kind]
        if missing := [key for key in needed if not getattr(platform, key)]:
            message = f"{' and '.join(missing)} must be set here, because {'.'.join(at[:3])} names this platform"
            raise Unfit(message, "platforms", name)

    @property
    def profile(self) -> Profile:
        """The large models in use."""
        return self.profiles[self.planner.profile]


def _wyoming(server: str | None) -> str | None:
    if server is not None and not WYOMING.fullmatch(server):
        raise ValueError("this is no address of a Wyoming server; write tcp://127.0.0.1:10300")
    return server


def _is_address(url: str) -> bool:
    try:
        parts = urlsplit(url)
        return parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:  # a port or an IPv6 address that is none
        return False
