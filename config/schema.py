"""Everything that can be set, with types, units, limits and defaults' meaning.

The defaults themselves live in the YAML files beside this module, where a user reads and copies them; this schema
says what is allowed. Every model forbids unknown keys. Settings are frozen: nothing changes them at run time.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Literal, TypeVar
from urllib.parse import urlsplit

from pydantic import BaseModel, ConfigDict, Field, SecretStr, field_validator, model_validator

Seconds = Annotated[float, Field(ge=0)]
Metres = Annotated[float, Field(ge=0)]
T = TypeVar("T")


class Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Audio(Section):
    """Where sound comes from."""

    device: str | int | None = Field(description="Microphone by (part of the) name or index; null: system default.")
    gain_db: float = Field(ge=-40, le=40, description="Fixed gain before anything else, dB.")


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
    max_length_s: Seconds = Field(gt=1, le=25, description="Longest utterance; ends it in steady noise too.")
    no_speech_s: Seconds = Field(gt=0, le=120, description="Give up listening when nobody spoke for this long.")


class Asr(Section):
    """Speech recognition."""

    model: str = Field(description="A name from `sayso models list`, or a folder with a CTranslate2 Whisper model.")
    language: str = Field(description="ISO 639-1 code, or auto.")
    threads: int = Field(ge=0, le=64, description="0: half of the cores, at least one.")
    window_s: Seconds = Field(ge=10, le=30, description="Encoder window; shorter is faster.")
    min_logprob: float = Field(le=0, description="Reject a transcript whose mean token log-probability is lower.")
    max_no_speech: float = Field(ge=0, le=1, description="Reject a transcript with a higher no-speech probability.")


class Planner(Section):
    """From words to plans."""

    language: Literal["en"] = Field(description="Language of phrases and answers.")
    max_actions: int = Field(ge=1, le=50, description="Longest plan.")
    vision: str | None = Field(description="A platform that is asked what a picture shows; null: none is.")


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
    fps: float = Field(gt=0, le=30, description="How often moving panes are redrawn.")


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
    """The camera of the simulated robot."""

    backend: Literal["auto", "opengl", "rays"] = Field(
        description="auto: OpenGL (EGL or OSMesa) where it works, rays cast in the simulation elsewhere."
    )
    width: int = Field(ge=32, le=640, description="Pixels; more makes small tags readable from farther away.")
    height: int = Field(ge=24, le=480, description="Pixels; 48 degrees of view are divided among them.")


class Robot(Section):
    """Which robot, and how fast it may be."""

    kind: Literal["sim"] = Field(description="sim: the MuJoCo robot.")
    scene: str = Field(description="Name of a scene in assets/scenes, or the path of a scene file.")
    speed: Literal["real", "max"] = Field(description="Simulated time: real, or as fast as the machine can.")
    heartbeat_s: Seconds = Field(gt=0, le=2, description="The robot stops when the engine is silent for this long.")
    realtime_priority: bool = Field(description="SCHED_FIFO for the robot process where the system allows it.")
    odometry_noise: float = Field(ge=0, le=0.5, description="Relative error of odometry; 0 for none.")
    seed: int = Field(description="Seed of everything random in the simulation.")
    limits: Limits
    camera: Camera


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


class Platform(Section):
    """A large-model service."""

    kind: Literal["local", "openai", "dify"]
    base_url: str | None = None
    model: str | None = None
    api_key: SecretStr | None = Field(default=None, description="Write ${VARIABLE}: keys come from the environment.")
    timeout_s: float = Field(default=30, gt=0, le=600, description="Longest wait for an answer.")

    @field_validator("base_url")
    @classmethod
    def _address(cls, url: str | None) -> str | None:
        if url is not None and not _is_address(url):
            raise ValueError("this is no address of a service; write https://host/path, as its makers say")
        return url


class Models(Section):
    """Where model files are kept."""

    folder: Path | None = Field(description="null: the user's cache folder.")


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
    kind: Literal["place", "places", "colour", "sentence"] | None = Field(
        default=None, description="Of words; places are separated by commas or and."
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


class ExternalSkill(Section):
    """A skill that is a program of its own (the protocol is in engine/skills/external/protocol.py)."""

    does: str = Field(min_length=1, description="One sentence about what it does; planners read it.")
    external: tuple[Annotated[str, Field(min_length=1)], ...] = Field(
        min_length=1, description="The program and its arguments; python stands for the one that runs sayso."
    )
    occupies: tuple[Literal["base", "arm", "camera", "voice"], ...] = Field(
        default=(), description="What it may use, and nobody else meanwhile."
    )
    parameters: dict[str, ExternalParameter] = {}
    silence_s: float | None = Field(
        default=5, gt=0, le=3600, description="The action fails when the program says nothing for so long; null: never."
    )
    endless: bool = Field(
        default=False, description="It goes on until told otherwise: session.turn_limit_s does not end it."
    )

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


class Settings(Section):
    """The whole configuration."""

    audio: Audio
    vad: Vad
    endpoint: Endpoint
    asr: Asr
    planner: Planner
    session: Session
    console: Console
    models: Models
    robot: Robot
    places: dict[str, Place]
    skills: dict[str, ExternalSkill]
    platforms: dict[str, Platform]

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

    @model_validator(mode="after")
    def _a_platform_that_sees(self) -> Settings:
        name = self.planner.vision
        if name is None:
            return self
        sighted = [name for name, platform in self.platforms.items() if platform.kind == "openai"]
        known = f"those that can look at pictures: {', '.join(sighted) or 'none yet; add one to platforms.yaml'}"
        platform = self.platforms.get(name)
        if platform is None:
            raise Unfit(f"there is no platform called {name}; {known}", "planner", "vision", choices=sighted)
        if platform.kind != "openai":
            message = f"{name} is a platform of the kind {platform.kind}, which cannot look at pictures; {known}"
            raise Unfit(message, "planner", "vision")
        if missing := [key for key in ("base_url", "model") if not getattr(platform, key)]:
            message = f"{' and '.join(missing)} must be set here, because planner.vision names this platform"
            raise Unfit(message, "platforms", name)
        return self


def _is_address(url: str) -> bool:
    try:
        parts = urlsplit(url)
        return parts.scheme in ("http", "https") and bool(parts.hostname) and parts.port != 0
    except ValueError:  # a port or an IPv6 address that is none
        return False
