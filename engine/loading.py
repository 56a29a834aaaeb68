"""What the settings stand for: the parts they name, built but not started."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import yaml

from config import paths
from config.schema import Robot as RobotSettings
from config.schema import Settings
from engine.asr.recogniser import Recogniser
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import Source
from engine.models import ModelStore
from engine.planner.house import build_vocabulary
from engine.robot.camera_news import TellOfCamera
from engine.robot.robot import Robot

if TYPE_CHECKING:
    from engine.skills.context import AskAbout


@dataclass(frozen=True, slots=True)
class Sound:
    """Where sound comes from.

    mic: the microphone; auto: the microphone, or sound that is sent as commands where there is none; none: sound that
    is sent as commands; demo: a simulated microphone; source: ``source``.
    """

    kind: Literal["auto", "mic", "demo", "none", "source"]
    source: Source | None = None


def make_robot(settings: RobotSettings, on_camera: TellOfCamera | None = None) -> Robot:
    """The configured robot; ``on_camera`` is told how its camera is doing. Raises ``SceneError``."""
    from engine.robot.sim.robot import SimRobot

    return SimRobot(settings, on_camera)


def at_home(settings: Settings) -> Settings:
    """The settings with the places of the robot's house: those of the scene where it names some, else those of the
    configuration. Raises ``SceneError``."""
    from engine.robot.sim.scene import load_scene, scene_path

    places = load_scene(scene_path(settings.robot.scene)).known_places()
    return settings.model_copy(update={"places": places}) if places else settings


def make_vision(settings: Settings) -> AskAbout | None:
    """The model that is asked about pictures, where one is configured; nothing is sent before a question is."""
    name = settings.planner.vision
    if name is None:
        return None
    from engine.llm.openai import OpenAIChat
    from engine.perception.asking import Onlooker

    return Onlooker(OpenAIChat(name, settings.platforms[name]))


def model_store(settings: Settings) -> ModelStore:
    """Where this user's models are."""
    return ModelStore(settings.models.folder or paths().models)


def make_recogniser(settings: Settings) -> Recogniser:
    """The configured recogniser, in this process and not loaded yet. Raises ``ModelError`` with the command that
    fetches its model."""
    from engine.asr.whisper import WhisperRecogniser

    return WhisperRecogniser(_speech_model(settings), settings.asr)


def make_isolated_recogniser(settings: Settings) -> Recogniser:
    """The same in a process of its own, for whoever must not be held up while it decodes."""
    from engine.asr.isolated import IsolatedRecogniser

    return IsolatedRecogniser(_speech_model(settings), settings.asr)


def _speech_model(settings: Settings) -> Path:
    """The folder that ``asr.model`` stands for. Raises ``ModelError``."""
    name = settings.asr.model
    folder = Path(name).expanduser()
    if folder.is_absolute() or folder.is_dir():
        return folder
    return model_store(settings).find(name)


def make_demo() -> SimulatedMicrophone:
    """A simulated microphone at which somebody says the next demo command when told to."""
    folder = Path(str(files("assets") / "speech"))
    index = yaml.safe_load((folder / "index.yaml").read_text(encoding="utf-8"))
    return SimulatedMicrophone([folder / entry["file"] for entry in index], every_s=None)


def vocabulary(settings: Settings) -> tuple[str, ...]:
    """Nouns that the recogniser should expect, the more useful first: names of places, things and their colours, other
    names of the places."""
    places = settings.places.values()
    names = (place.name for place in places)
    aliases = (alias for place in places for alias in place.aliases)
    return tuple(dict.fromkeys((*names, *build_vocabulary(settings).thing_words(), *aliases)))
