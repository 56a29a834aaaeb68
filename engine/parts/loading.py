"""What the settings stand for: the parts they name, built but not started."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import yaml

from config import paths
from config.schema import WYOMING, Settings
from config.schema import Voice as VoiceSettings
from engine.asr.recogniser import Recogniser
from engine.asr.whole import WholeRecogniser
from engine.audio.microphone import Microphone
from engine.audio.player import Player
from engine.audio.satellite import Satellite
from engine.audio.satellite_microphone import SatelliteMicrophone
from engine.audio.simulated import SimulatedMicrophone
from engine.audio.source import Source
from engine.errors import ModelError
from engine.han import is_chinese
from engine.llm.chain import Chain
from engine.llm.chat import Chat
from engine.llm.local import LocalChat
from engine.models import ModelStore
from engine.parts import remembered
from engine.planner.stages.models import Models
from engine.planner.worlds.house import build_vocabulary
from engine.robot.home import home
from engine.tts.choice import ByLanguage
from engine.tts.synthesis import Synthesiser

if TYPE_CHECKING:
    from engine.perception.asking import Onlooker


@dataclass(frozen=True, slots=True)
class Sound:
    """Where sound comes from.

    mic: the microphone; auto: the microphone, or sound that is sent as commands where there is none; none: sound that
    is sent as commands; demo: a simulated microphone; source: ``source``.
    """

    kind: Literal["auto", "mic", "demo", "none", "source"]
    source: Source | None = None


def at_home(settings: Settings) -> Settings:
    """The settings with the places and the people of the robot's house: places of the map where it names some, else
    those of the configuration, unless the map is from elsewhere; and what was remembered there. Raises ``SceneError``
    or ``StorageError``."""
    house = home(settings.robot)
    places = house.places or ({} if settings.robot.map is not None else settings.places)
    places = remembered.joined(places, remembered.PLACES.read(places_file(settings)))
    people = {**house.people, **settings.people, **remembered.PEOPLE.read(people_file(settings))}
    return settings.model_copy(update={"places": places, "people": people})


def people_file(settings: Settings) -> Path:
    """Where the people are kept who told the robot their names in its house."""
    return remembered.file_for(paths().people, home(settings.robot).key)


def places_file(settings: Settings) -> Path:
    """Where the places that are remembered in the robot's house are kept."""
    return remembered.file_for(paths().places, home(settings.robot).key)


def make_vision(settings: Settings) -> Onlooker | None:
    """The model that is asked about pictures, where one is configured; nothing is sent before a question is."""
    name = settings.profile.vision
    if name is None:
        return None
    from engine.perception.asking import Onlooker

    return Onlooker(make_chat(settings, name))


def make_models(settings: Settings, tell: Callable[[str], None]) -> Models | None:
    """The large models that think, none of them loaded or asked yet; None where there are none. ``tell``
    gets a sentence when another one is asked than before."""
    profile = settings.profile
    if not profile.execution:
        return None
    made: dict[str, Chat] = {}
    for name in (*profile.execution, *profile.decision):
        made[name] = made.get(name) or make_chat(settings, name)
    local = next((chat for chat in made.values() if isinstance(chat, LocalChat)), None)
    decision = Chain([made[name] for name in profile.decision], tell) if profile.decision else None
    return Models(Chain([made[name] for name in profile.execution], tell), decision, local)


def make_chat(settings: Settings, name: str) -> Chat:
    """The model of one platform, not loaded or asked yet."""
    platform = settings.platforms[name]
    match platform.kind:
        case "local":
            return LocalChat(name, platform, gguf_of(settings, name), paths().cache / "prompts")
        case "openai":
            from engine.llm.openai import OpenAIChat

            return OpenAIChat(name, platform)
        case "dify":
            from engine.llm.dify import DifyChat

            return DifyChat(name, platform)


def gguf_of(settings: Settings, name: str) -> Path:
    """The file of a local model, which need not be there."""
    model = settings.platforms[name].model
    assert model is not None, "the configuration sees to that"
    path = Path(model).expanduser()
    return path if path.is_absolute() or path.suffix == ".gguf" else model_store(settings).file(model)


def is_to_be_heard(settings: VoiceSettings, sound: Sound) -> bool:
    """Whether there is anything to play: answers, or sounds. Where sound comes as commands, nobody is in the room,
    unless somebody names a loudspeaker or wants to hear every answer."""
    return sound.kind != "none" or settings.device is not None or settings.when == "always"


def make_satellite(settings: Settings, sound: Sound) -> Satellite | None:
    """The satellite whose microphone is to be heard, not connected yet."""
    device = settings.audio.device
    if sound.kind not in ("mic", "auto") or not isinstance(device, str) or not WYOMING.fullmatch(device):
        return None
    return Satellite(device)


def make_microphone(settings: Settings) -> Microphone | SatelliteMicrophone:
    """The configured microphone, for whoever needs no loudspeaker; not opened yet."""
    if (satellite := make_satellite(settings, Sound("mic"))) is not None:
        return SatelliteMicrophone(satellite)
    return Microphone(settings.audio.device)


def make_player(settings: VoiceSettings, sound: Sound, satellite: Satellite | None = None) -> Player:
    """What answers are played through, not opened yet: the loudspeaker that has a name, else that of the satellite
    which is heard, else the system's; where nothing is to be heard, nothing is."""
    if not is_to_be_heard(settings, sound):
        from engine.audio.clocked import ClockedOutput

        return Player(ClockedOutput(), volume=settings.volume, duck_db=settings.duck_db)
    if satellite is not None and settings.device is None:
        from engine.audio.satellite_loudspeaker import SatelliteLoudspeaker

        output = SatelliteLoudspeaker(satellite)
        player = Player(output, volume=settings.volume, duck_db=settings.duck_db)
        output.busy = lambda: player.busy
        return player
    from engine.audio.loudspeaker import Loudspeaker

    return Player(Loudspeaker(settings.device), volume=settings.volume, duck_db=settings.duck_db)


def make_synthesiser(settings: Settings, tell: Callable[[str], None] = lambda words: None) -> Synthesiser:
    """The configured voice, not loaded yet; ``tell`` gets a sentence when it cannot say something. Raises
    ``ModelError`` that says what to install or to fetch."""
    from engine.tts import espeak, piper

    voice = settings.voice
    match voice.backend:
        case "openai":
            return _service_voice(settings)
        case "espeak":
            return _espeak(voice)
        case "piper":
            return _piper(settings)
        case "wyoming":
            return _wyoming_voice(voice)
    try:
        own = _piper(settings)
    except ModelError as error:
        if espeak.is_installed():
            return _espeak(voice)
        if not piper.is_installed():
            hint = "Install piper (pip install 'sayso[voice]') or espeak-ng to hear them."
            raise ModelError("There is no voice on this machine.", hint=hint) from error
        raise
    other = _espeak(voice) if espeak.is_installed() else None
    return ByLanguage(own, other, tell, chinese=_language_of_piper(voice) == "zh")


def languages_said(settings: Settings) -> tuple[str, ...]:
    """The languages (ISO 639-1) of the configured voice, of those that sayso speaks itself."""
    from engine.tts import espeak, piper

    backend = settings.voice.backend
    if backend == "piper" or (backend == "auto" and piper.is_installed() and not espeak.is_installed()):
        return (_language_of_piper(settings.voice),)
    return ("en", "zh")


def voice_to_fetch(settings: Settings) -> str | None:
    """The model that the configured voice needs and that can be fetched by its name."""
    from engine.tts import piper

    voice = settings.voice
    if voice.when == "never" or voice.backend not in ("auto", "piper") or not piper.is_installed():
        return None
    return voice.model if voice.model in model_store(settings).manifest.models else None


def _piper(settings: Settings) -> Synthesiser:
    from engine.tts import piper
    from engine.tts.isolated import IsolatedVoice

    if not piper.is_installed():
        raise ModelError("piper is not installed.", hint=piper.INSTALL)
    file = Path(settings.voice.model).expanduser()
    if file.suffix != ".onnx":
        store = model_store(settings)
        store.find(settings.voice.model)
        file = store.file(settings.voice.model)
    return IsolatedVoice(f"piper ({file.stem})", "piper", voice=str(file), speed=settings.voice.speed)


def _language_of_piper(settings: VoiceSettings) -> str:
    """The language (ISO 639-1) of the voice; that of a file is in its name: ``zh_CN-huayan-medium.onnx``."""
    return Path(settings.model).stem[:2].casefold() if settings.model.endswith(".onnx") else "en"


def _espeak(settings: VoiceSettings) -> Synthesiser:
    from engine.tts import espeak
    from engine.tts.isolated import IsolatedVoice

    if not espeak.is_installed():
        raise ModelError("espeak-ng is not installed.", hint=espeak.INSTALL)
    return IsolatedVoice("espeak-ng", "espeak", voice=settings.speaker or "", speed=settings.speed)


def _service_voice(settings: Settings) -> Synthesiser:
    from engine.llm.bytes import ByteService
    from engine.tts.openai import USUAL_SPEAKER, ServiceVoice

    voice = settings.voice
    assert voice.platform is not None, "the configuration sees to that"
    platform = settings.platforms[voice.platform]
    assert platform.model is not None
    remedy = f"Check platforms.{voice.platform}.model and voice.speaker: does it know both, and can it send pcm?"
    service = ByteService(voice.platform, platform, "a service for speech that is compatible with OpenAI's", remedy)
    return ServiceVoice(service, platform.model, voice.speaker or USUAL_SPEAKER, voice.speed)


def _wyoming_voice(settings: VoiceSettings) -> Synthesiser:
    from engine import wyoming
    from engine.tts.wyoming import WyomingVoice

    assert settings.server is not None, "the configuration sees to that"
    wyoming.require()
    return WyomingVoice(settings.server, settings.speaker)


def model_store(settings: Settings) -> ModelStore:
    """Where this user's models are."""
    return ModelStore(settings.models.folder or paths().models)


def make_recogniser(settings: Settings) -> WholeRecogniser:
    """The configured recogniser, in this process and not loaded yet. Raises ``ModelError`` with the command that
    fetches what it lacks."""
    if settings.asr.backend != "whisper":
        return _recogniser_elsewhere(settings)
    from engine.asr.whisper import WhisperRecogniser

    return WhisperRecogniser(_speech_model(settings), settings.asr)


def make_isolated_recogniser(settings: Settings) -> Recogniser:
    """The same for whoever must not be held up while it decodes: what decodes on this machine has a process of its
    own."""
    if settings.asr.backend != "whisper":
        return _recogniser_elsewhere(settings)
    from engine.asr.isolated import IsolatedRecogniser

    return IsolatedRecogniser(_speech_model(settings), settings.asr)


def _recogniser_elsewhere(settings: Settings) -> WholeRecogniser:
    from engine.asr.remote import RemoteRecogniser

    if settings.asr.backend == "wyoming":
        from engine import wyoming
        from engine.asr.wyoming import WyomingTranscription

        assert settings.asr.server is not None, "the configuration sees to that"
        wyoming.require()
        return RemoteRecogniser(WyomingTranscription(settings.asr.server), settings.asr)
    from engine.asr.openai import OpenAITranscription
    from engine.llm.recordings import RecordingService

    name = settings.asr.platform
    assert name is not None, "the configuration sees to that"
    platform = settings.platforms[name]
    assert platform.model is not None
    remedy = f"Check platforms.{name}.model: is it one that transcribes?"
    service = RecordingService(name, platform, "a service for speech that is compatible with OpenAI's", remedy)
    return RemoteRecogniser(OpenAITranscription(service, platform.model), settings.asr)


def speech_folder(settings: Settings) -> Path | None:
    """The folder that ``asr.model`` names; None where it is the name of a model. A folder that is called like one is
    meant only where its name has a separator in it. Raises ``ModelError`` where there is no such folder."""
    from engine.asr.sizes import is_size, listed

    name = settings.asr.model
    folder = Path(name).expanduser()
    is_model = is_size(name) or listed(name, model_store(settings).manifest.models) is not None
    if is_model or (os.sep not in name and not (folder / "model.bin").is_file()):
        return None
    if not folder.is_dir():
        hint = "Set asr.model to a folder with a CTranslate2 model, or to a name from `sayso models list`."
        raise ModelError(f"There is no folder {folder}.", hint=hint)
    return folder


def _speech_model(settings: Settings) -> Path:
    """Where the model is that ``asr.model`` stands for. Raises ``ModelError``."""
    from engine.asr.sizes import in_hub, is_size, listed

    if (folder := speech_folder(settings)) is not None:
        return folder
    name, store = settings.asr.model, model_store(settings)
    ours = listed(name, store.manifest.models)
    return in_hub(name) if ours is None and is_size(name) else store.find(ours or name)


def make_demo() -> SimulatedMicrophone:
    """A simulated microphone at which somebody says the next demo command when told to."""
    folder = Path(str(files("assets") / "speech"))
    index = yaml.safe_load((folder / "index.yaml").read_text(encoding="utf-8"))
    return SimulatedMicrophone([folder / entry["file"] for entry in index], every_s=None)


SKILL_NOUNS = ("arm", "gripper", "light", "line", "task", "degrees", "metres", "centimetres")
SKILL_NOUNS_ZH = ("手臂", "夹爪", "灯", "线", "任务", "度", "米", "厘米")
"""What skills are about; verbs would make a recogniser hear commands in silence."""
MOST_NOUNS = 60
"""Of one language: a recogniser that is told more is slower, and hears lists of them in noise."""


def vocabulary(settings: Settings) -> tuple[str, ...]:
    """Nouns that the recogniser should expect in its language (in every one, where it finds that out itself), the more
    useful first: what skills are about, names of places, things and their colours, other names of the places."""
    places = settings.places.values()
    names = (place.name for place in places)
    aliases = (alias for place in places for alias in place.aliases)
    nouns = dict.fromkeys((*SKILL_NOUNS, *SKILL_NOUNS_ZH, *names, *build_vocabulary(settings).thing_words(), *aliases))
    english = [noun for noun in nouns if not is_chinese(noun)][:MOST_NOUNS]
    chinese = [noun for noun in nouns if is_chinese(noun)][:MOST_NOUNS]
    return tuple({"zh": chinese, "auto": [*english, *chinese]}.get(settings.asr.language, english))
