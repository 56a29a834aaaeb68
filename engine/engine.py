"""The engine: builds the parts from settings and runs the session in a thread of its own.

:class:`Engine` is what a screen or a command holds (``engine.handle.EngineHandle``). Its loop runs the session, the
robot's heartbeat and the publisher of the robot's state; the robot starts and models load in the background, so that
the engine takes commands from the first moment. Whatever ends the loop, the robot is stopped and closed first.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import os
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Mapping, Sequence
from typing import Any, TypeVar

from config import paths
from config.schema import KnownPerson, Place, Settings
from engine import __version__, events
from engine.bus import Bus, Subscriber
from engine.chimes import Chimes
from engine.clock import Clock, SystemClock
from engine.commands import Command, EStop, Heard, Release, Wake
from engine.epoch import Epoch
from engine.errors import RobotError, SaysoError, StorageError
from engine.event_log import EventLog
from engine.events import Body, Event
from engine.handle import PartName, PartStatus
from engine.hearing.hearing import Hearing
from engine.hearing.readings import Afterthought
from engine.llm.chat import Message
from engine.llm.local import LocalChat
from engine.offer import Offer, offered
from engine.parts import remembered
from engine.parts.camera import CameraPart
from engine.parts.charging import Charging
from engine.parts.demo import Demo
from engine.parts.ears import Ears
from engine.parts.estop import EmergencyStop
from engine.parts.fetching import Fetching, Pull
from engine.parts.health import Health
from engine.parts.keeper import Keeper
from engine.parts.loading import (
    Sound,
    at_home,
    is_to_be_heard,
    make_models,
    make_player,
    make_satellite,
    make_vision,
    model_store,
    people_file,
    places_file,
)
from engine.parts.model import Instructions, ModelPart
from engine.parts.part import Part
from engine.parts.viewfinder import Viewfinder
from engine.parts.voice import VoicePart
from engine.parts.words import WordsPart
from engine.perception.eyes import Eyes
from engine.perception.memory import World, WorldMemory
from engine.perception.sighting import Sight
from engine.plan import Action, InWords, as_written
from engine.planner.build import build_planner, build_registry
from engine.planner.phrases.stopping import is_stop
from engine.planner.planner import Planner
from engine.planner.worlds.house import build_vocabulary
from engine.robot.bodies import description_of, make_robot
from engine.robot.floor_map import FloorMap
from engine.robot.robot import Robot, RobotState, Scan
from engine.scheduling import collect_in_small_steps, prefer, workers
from engine.session.around import Around
from engine.session.dispatch import Dispatcher
from engine.session.hesitation import Hesitation
from engine.session.holds import Holds
from engine.session.recall import Recall
from engine.session.session import Session
from engine.session.turn import Needs
from engine.skills.people import People, looks_of
from engine.skills.places import Places
from engine.skills.registry import SkillRegistry
from engine.speaking import SpokenVoice
from engine.tts.voice import SilentVoice
from engine.understanding.base import MODEL
from engine.wording import build_wording

T = TypeVar("T")

PULSE_S = 0.05
"""Between two signs of life of the engine's loop, s."""
SWITCH_S = 0.0005
"""How long a thread that stops the robot may have to wait for one that computes in Python, s (Python: 5 ms)."""
AROUND_S = 0.05
"""Between two looks at what those around the robot do."""
PATIENCE_S = 20.0
"""How long the answer to a single request waits for a voice that still loads, s."""
PAUSE_S = 1.0
"""From this long without one, the loop itself says that it was away, once it is back."""


class Engine:
    """A running engine. ``start`` it once; it ends by a ``Quit`` command, and ``join`` waits for that.

    ``mode`` is for the record (``console``, ``ask``…). ``sound`` says where sound comes from. ``release_key`` is told
    to whoever asks in words to release the emergency stop; empty: a command is.
    """

    def __init__(
        self, settings: Settings, *, mode: str, sound: Sound, clock: Clock | None = None, release_key: str = ""
    ) -> None:
        self._release_key = release_key
        self._settings = settings = at_home(settings)
        self._mode = mode
        self._sound = sound
        self._clock = clock or SystemClock()
        self._bus = Bus(self._clock)
        self._robot: Robot = make_robot(settings.robot, lambda news: self._camera.follow(news))
        self._stays = mode in ("console", "engine")  # else it ends with what it was asked to do
        self._satellite = make_satellite(settings, sound)
        self._player = make_player(settings.voice, sound, self._satellite)
        self._epoch = Epoch(self._stop)
        self._estop = EmergencyStop(
            paths().estop,
            self._robot.press,
            lambda pressed: self.send(EStop() if pressed else Release()),
            lambda words: self._tell_log("robot", words),
        )
        self._parts: dict[PartName, Part[Any]] = {}
        self._memory = WorldMemory()
        self._session: Session | None = None
        self._viewfinder: Viewfinder | None = None
        self._registry: SkillRegistry | None = None
        self._ready = threading.Event()
        self._ended = threading.Event()
        self._failure: BaseException | None = None
        self._beaten = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="engine", daemon=True)

    # What holders call, from any thread

    def start(self) -> None:
        """Start the engine thread; returns when it takes commands. Raises what kept it from starting."""
        sys.setswitchinterval(SWITCH_S)
        collect_in_small_steps()
        self._thread.start()
        self._ready.wait()
        if self._failure is not None:
            raise self._failure

    def join(self, timeout: float | None = 10.0) -> bool:
        """Wait for the engine to end; False if it has not by then."""
        return self._ended.wait(timeout)  # not Thread.join, which a signal handler that raises leaves broken

    def send(self, command: Command) -> None:
        """Give a command; see ``Session.request``."""
        assert self._session is not None, "start() comes first"
        self._session.request(command)

    def subscribe(self, subscriber: Subscriber) -> Callable[[], None]:
        """Get every event from now on, in the publishing thread."""
        return self._bus.subscribe(subscriber)

    def reject(self, message: str, do: str = "", id: str | None = None) -> None:
        """Acknowledge a command that cannot be carried out, with as much of it as could be read."""
        self._bus.publish(events.Ack(do, False, message, id), epoch=self._epoch.current)

    def status(self) -> tuple[PartStatus, ...]:
        return tuple(part.status for part in self._parts.values())

    @property
    def failure(self) -> BaseException | None:
        """The fault that the engine ended by, if it was one."""
        return self._failure

    def pulse(self) -> float:
        return 0.0 if self._ended.is_set() else time.monotonic() - self._beaten

    def robot_state(self) -> RobotState | None:
        return self._when_robot_is_up(self._robot.state)

    def scan(self) -> Scan | None:
        return self._when_robot_is_up(self._robot.scan)

    def look(self, deliver: Callable[[Sight | SaysoError], object]) -> None:
        """Take one picture for people who look on; see ``Viewfinder``."""
        assert self._viewfinder is not None, "start() comes first"
        self._viewfinder.look(deliver)

    def floor_map(self) -> FloorMap | None:
        return self._robot.floor_map

    def places(self) -> Mapping[str, Place]:
        return self._settings.places

    def offer(self) -> Offer:
        if self._registry is None:
            return Offer()
        names = tuple(place.name for place in self._settings.places.values())
        return offered(self._registry, build_vocabulary(self._settings), names)

    def world(self) -> World:
        return self._memory.snapshot()

    def _stop(self, epoch: int) -> None:
        """Whatever moves, then whatever sounds, in the thread of whoever stops it."""
        self._robot.stop(epoch)
        self._player.stop(epoch)

    def _when_robot_is_up(self, read: Callable[[], T]) -> T | None:
        if "robot" not in self._parts or self._parts["robot"].value is None:
            return None
        try:
            return read()
        except RobotError:
            return None

    # The engine thread

    def _run(self) -> None:
        if self._settings.robot.realtime_priority:
            prefer()
        try:
            asyncio.run(self._main())
        except BaseException as error:  # noqa: BLE001 - handed to whoever waits in start(), or published
            self._robot.stop(self._epoch.advance())
            self._failure = error
            message = f"The engine ended by a fault: {error!r}."
            self._bus.publish(events.ErrorRaised("engine_died", message, "Please report it.", fatal=True))
        finally:
            self._ready.set()
            self._ended.set()

    async def _main(self) -> None:
        prompt = self._settings.robot.realtime_priority
        asyncio.get_running_loop().set_default_executor(workers("aside", prompt=prompt))
        log = self._open_log()
        self._emit(events.SessionStarted(__version__, self._mode, self._robot.name, os.getpid()))
        places = Places(self._settings.places)
        people = People(self._settings.people)
        around = Around(self._robot, self._emit)
        self._memory.people.know(looks_of(people))
        dock = description_of(self._settings.robot).dock
        place_names = {symbol: place.name for symbol, place in self._settings.places.items()}
        self._registry = registry = build_registry(self._settings, places, people)
        robot: Part[Robot] = self._part("robot")
        planner: Part[Planner] = self._part("planner")
        hearing: Part[Hearing] = self._part("recogniser")
        microphone: Part[str] = self._part("microphone")
        self._viewfinder = Viewfinder(robot, asyncio.get_running_loop(), prompt=prompt)
        has_camera = "camera" in self._robot.capabilities
        self._camera = CameraPart(self._part("camera") if has_camera else Part("camera", lambda s: None), self._emit)

        holds, eyes = Holds(), Eyes(self._robot, self._memory)
        vision = make_vision(self._settings)
        models = make_models(self._settings, lambda words: self._tell_log("model", words))

        def abilities() -> str:
            return planner.value.abilities if planner.value else ""

        def in_words(action: Action) -> InWords:
            return planner.value.in_words(action) if planner.value else as_written(action)

        voice = SpokenVoice(self._player, patience_s=0.0 if self._stays else PATIENCE_S)
        needs = Needs(
            robot=robot,
            planner=planner,
            dispatcher=lambda up: Dispatcher(
                registry, up, places, self._epoch, holds, abilities, eyes, vision, dock, people
            ),
            around=lambda: around,
            hearing=hearing,
            voice=voice,
            voice_for_typed=voice if self._settings.voice.when == "always" else SilentVoice(),
            place_names=place_names,
            recall=lambda up: Recall(up, self._memory),
            ask=self.send,
            press=self._estop.press,
            set_volume=self._player.set_volume,
            wording=build_wording(self._settings),
            rounds=self._settings.planner.rounds,
            steps=self._settings.planner.steps,
            told=in_words,
            release_key=self._release_key,
        )
        hesitation = Hesitation(
            self._robot,
            self._epoch,
            self._bus,
            self._clock,
            state=lambda: self._session.state if self._session is not None else "IDLE",
            ears=lambda: hearing.value,
            duck=self._player.duck,
        )

        def hears_itself() -> bool:
            return hearing.value is not None and hearing.value.hears_itself

        def notice(first: str, whole: str) -> Afterthought | None:
            tells_apart = hearing.value is not None and hearing.value.without_own_voice
            if planner.value is None or (not tells_apart and voice.repeats(whole[len(first) :])):
                return None
            return planner.value.afterthought(first, whole)

        words = None
        if self._hears_people():
            words = WordsPart(
                self._settings,
                lambda wake: None if hears_itself() else self.send(wake),
                lambda spotted: None if hears_itself() else hesitation.suspect(spotted.phrase, sure=spotted.sure),
                lambda spotted, sound, answer: (
                    hearing.value.ask(spotted.phrase, sound, answer, likely=spotted.likely)
                    if hearing.value
                    else answer(None)
                ),
                self._emit,
                wakes=self._listens_for_words(),
            )
        ears = Ears(
            self._settings,
            self._sound,
            microphone,
            hearing,
            on_words=lambda words: self._overhear(words, voice, hearing.value),
            judge=lambda text: planner.value.completeness(text) if planner.value is not None else "unknown",
            notice=notice,
            listener=words,
            played=self._player.sounded,
            on_going_on=self._go_on if self._hears_people() else None,
            satellite=self._satellite,
            door=paths().door if self._stays else None,
            warn=lambda words: self._tell_log("microphone", words),
            on_fault=self._tell,
        )
        self._session = Session(
            self._settings.session, self._bus, self._epoch, needs, hear_audio=ears.push, mark_wake=ears.mark
        )

        async def instructions() -> Sequence[Sequence[Message]]:
            assert models is not None
            assert models.local is not None
            return (await planner.get()).beginnings(models.local)

        def build() -> Planner:
            return build_planner(self._settings, registry, models=models, places=places)

        def added(symbol: str, place: Place) -> None:
            """Another place is known from now on: whoever plans has to know it, too."""
            place_names[symbol] = place.name
            self._settings = self._settings.model_copy(update={"places": {**self._settings.places, symbol: place}})
            self._keep_place(place)
            background.append(self._keep(self._rebuild(planner, build)))

        def met(name: str, person: KnownPerson) -> None:
            """Somebody else is known from now on."""
            self._settings = self._settings.model_copy(update={"people": {**self._settings.people, name: person}})
            self._keep_person(name, person)
            self._memory.people.know(looks_of(people))
            background.append(self._keep(self._rebuild(planner, build)))

        places.on_added, people.on_added = added, met
        charging = Charging(robot, places, dock, self._session.is_free, self._session.request, self._emit)
        background = [
            self._keep(self._beat()),
            self._keep(self._keep_robot(robot, places), "robot"),
            self._keep(self._estop.keep()),
            self._keep(self._listen_around(around)),
            self._keep(Health(robot, paths().state, self._emit, on_battery=charging.look).keep()),
            self._keep(self._keep_planner(planner, build), "planner"),
            self._keep(ears.keep(), "microphone", "recogniser"),
            self._keep(self._keep_voice(voice), "voice"),
        ]
        if models is not None and models.local and self._stays:  # else it is loaded when it is needed
            background.append(self._keep(self._keep_model(models.local, instructions), "model"))
        if self._settings.wake.serial.port and self._stays:
            background.append(self._keep(self._keep_wake(self._part("wake")), "wake"))
        if words is not None:
            background.append(self._keep(words.keep(lambda: self._part("wake words")), "wake words"))
        if self._settings.ros.door is not None and self._stays:
            background.append(self._keep(self._keep_graph(ears, planner, registry, needs), "ros"))
        if self._sound.kind == "demo":
            background.append(self._keep(self._play_demo(ears, hearing)))
        is_stop("")  # its words are read once, which nobody who interrupts may have to wait for
        self._ready.set()
        reason = "a fault"
        try:
            await self._session.run()
            reason = "asked to"
        finally:
            for task in background:
                task.cancel()
            await asyncio.gather(*background, return_exceptions=True)
            await self._viewfinder.close()
            for thinking in (models, vision):
                if thinking is not None:
                    await thinking.close()
            gc.unfreeze()  # what was loaded goes with the engine
            self._emit(events.SessionEnded(reason))
            if log is not None:
                log.close()

    def _keep(self, work: Coroutine[Any, Any, None], *parts: PartName) -> asyncio.Task[None]:
        """Do in the background what goes on until the engine ends. Nobody waits for it: a fault in it is told here, and
        the parts that it kept have failed."""

        def over(task: asyncio.Task[None]) -> None:
            if task.cancelled() or (error := task.exception()) is None:
                return
            name = parts[0] if parts else "engine"
            fault = SaysoError(f"The {name} has a fault: {error!r}.", hint="Please report it.")
            for part in (self._parts[name] for name in parts if name in self._parts):
                part.fail(fault)
            self._emit(events.ErrorRaised("internal", fault.message, fault.hint))

        task = asyncio.create_task(work)
        task.add_done_callback(over)
        return task

    async def _beat(self) -> None:
        """Show that the loop lives; when it did not (paused, or held up), say for how long."""
        self._beaten = time.monotonic()
        while True:
            away, self._beaten = time.monotonic() - self._beaten, time.monotonic()
            if away > PAUSE_S:
                message = f"The engine did not respond for {away:.1f} s. A robot that was moving has stopped by itself."
                self._emit(events.Log("warning", "engine", message))
                self._emit(events.Timing("paused", round(away, 3)))
            await asyncio.sleep(PULSE_S)

    async def _keep_robot(self, part: Part[Robot], places: Places) -> None:
        """Keep the robot until this is cancelled, and close it."""
        assert self._session is not None, "made before"
        keeper = Keeper(self._robot, part, self._epoch, self._emit, self._session.request)
        await keeper.keep(lambda robot: places.begin(robot.state().pose))

    async def _keep_model(self, chat: LocalChat, instructions: Instructions) -> None:
        """Get the local model ready, fetching it first if it is missing."""
        name, fetching = self._settings.platforms[chat.name].model or "", None
        if self._settings.models.fetch:
            store = model_store(self._settings)
            fetching = Fetching(store, name) if name in store.manifest.models else None
        await ModelPart(self._part("model"), chat, instructions, fetching).keep()

    def _keep_place(self, place: Place) -> None:
        """Keep a place that was remembered for later sessions."""
        file = places_file(self._settings)
        try:
            remembered.PLACES.write(file, {**remembered.PLACES.read(file), place.name: place})
        except StorageError as error:
            self._tell(error)

    async def _listen_around(self, around: Around) -> None:
        """Tell what those around the robot do, also while nothing runs."""
        while True:
            around.poll()
            await asyncio.sleep(AROUND_S)

    def _keep_person(self, name: str, person: KnownPerson) -> None:
        """Keep somebody who told their name for later sessions."""
        file = people_file(self._settings)
        try:
            remembered.PEOPLE.write(file, {**remembered.PEOPLE.read(file), name: person})
        except StorageError as error:
            self._tell(error)

    async def _rebuild(self, part: Part[Planner], build: Callable[[], Planner]) -> None:
        """Have another planner, which knows what has changed."""
        try:
            part.succeed(await asyncio.to_thread(build))
        except SaysoError as error:
            self._tell(error)

    async def _keep_planner(self, part: Part[Planner], build: Callable[[], Planner]) -> None:
        """Build it, and have it ready for the first command where somebody waits for that."""
        await part.load(lambda: asyncio.to_thread(build))
        if self._stays and part.value is not None:
            await asyncio.to_thread(part.value.warm_up)
            if self._settings.models.fetch and self._settings.planner.reader:
                await self._fetch_reader(part.value)

    async def _fetch_reader(self, planner: Planner) -> None:
        """Fetch what the learned reader stands on, unless it is here: until then it understands only what stops it."""
        store = model_store(self._settings)
        with contextlib.suppress(SaysoError):
            await asyncio.to_thread(store.find, MODEL)
            return
        size = store.manifest[MODEL].size / 1e6
        self._emit(events.Log("info", "planner", f"fetching {MODEL} for the learned reader ({size:.0f} MB)"))
        try:
            await Pull(store, MODEL, lambda detail: None).done()
            await asyncio.to_thread(planner.warm_up)
        except SaysoError as error:
            self._emit(events.Log("warning", "planner", str(error)))

    async def _keep_wake(self, part: Part[str]) -> None:
        """Listen to the wake module."""
        from engine.parts.wake import WakePart

        prompt = self._settings.robot.realtime_priority
        await WakePart(part, self._settings.wake.serial, self.send, self._emit, prompt=prompt).keep()

    async def _keep_graph(self, ears: Ears, planner: Part[Planner], registry: SkillRegistry, needs: Needs) -> None:
        """Take part in a ROS graph."""
        from engine.parts.graph import GraphPart, Uses

        assert self._session is not None, "made before"
        session = self._session
        uses = Uses(
            ask=session.request,
            state=lambda: session.state,
            subscribe=self._bus.subscribe,
            emit=self._emit,
            hear=ears.push,
            planner=planner,
            registry=registry,
            wording=needs.wording,
            place_names=needs.place_names,
        )
        await GraphPart(self._settings, uses).keep(self._part("ros"))

    def _overhear(self, words: str, voice: SpokenVoice, hearing: Hearing | None) -> None:
        """A stop without a wake. Not the robot's own "Stopped.", which would be answered by another one, where the ears
        cannot tell it from somebody else's: but while it acts, it stops for whatever may have been one. In the
        recogniser's thread."""
        assert self._session is not None, "made before its ears are open"
        tells_apart = hearing is not None and hearing.without_own_voice
        if self._session.state == "ACTING" or tells_apart or is_stop(voice.not_own(words)):
            self.send(Heard(words))

    def _go_on(self, ago_s: float) -> None:
        """Somebody goes on whose turn was ended in the middle of a sentence. What has been begun because of it is given
        up, unless the robot acts: then only a wake, or a stop, interrupts."""
        assert self._session is not None, "made before its ears are open"
        if self._session.state not in ("LISTENING", "ACTING", "FEEDBACK"):
            self.send(Wake("speech", ago_s=ago_s))

    def _hears_people(self) -> bool:
        """Whether somebody may be heard at any time, and not only one recording, or nobody at all."""
        return self._stays or (self._sound.source is not None and self._sound.source.live)

    def _listens_for_words(self) -> bool:
        """Whoever only hears one recording is not woken, and a demo wakes by itself."""
        return self._stays and self._sound.kind not in ("demo", "source") and self._settings.wake.words != ()

    async def _keep_voice(self, voice: SpokenVoice) -> None:
        """Speak, and sound, where that is wanted. Whoever only asks for one thing reads the answer."""
        wanted = self._settings.voice
        speaks = wanted.when == "always" or (self._stays and (wanted.when == "spoken" or wanted.sounds))
        if not (speaks and is_to_be_heard(wanted, self._sound)):
            voice.settle(None)
            return
        self._bus.subscribe(voice.see)
        if wanted.sounds and self._stays:
            chimes = Chimes(self._player, module_answers=self._settings.wake.serial.phrase is not None)
            self._bus.subscribe(chimes.see)
        await VoicePart(self._settings, self._player, voice, lambda: self._part("voice"), self._emit).keep()

    async def _play_demo(self, ears: Ears, hearing: Part[Hearing]) -> None:
        """Let the demo speak once the robot can hear."""
        await hearing.get()

        def speak() -> None:
            assert ears.simulated is not None, "it is what can be heard"
            ears.simulated.speak()

        demo = Demo(speak, self.send)
        unsubscribe = self._bus.subscribe(demo.see)
        try:
            await asyncio.Event().wait()
        finally:
            unsubscribe()
            demo.close()

    def _part(self, name: PartName) -> Part[Any]:
        part: Part[Any] = Part(name, self._report)
        self._parts = {**self._parts, name: part}  # replaced, not changed: others look through it
        return part

    def _report(self, status: PartStatus) -> None:
        """Say how a part is doing; how the robot is lost is its keeper's to say."""
        if status.state == "ready":
            self._emit(events.Log("info", status.name, f"ready: {status.detail}" if status.detail else "ready"))
        elif status.name != "robot":
            self._emit(events.Log("warning", status.name, status.detail))
        if not any(part.status.state == "loading" for part in self._parts.values()):
            # All that was loaded stays. Looking through it for garbage again and again would hold up everybody, also
            # those who stop the robot, for a tenth of a second each time.
            gc.freeze()

    def _emit(self, body: Body, /) -> Event:
        """Publish what belongs to no turn."""
        return self._bus.publish(body, epoch=self._epoch.current)

    def _open_log(self) -> EventLog | None:
        settings = self._settings.session
        if not settings.record_log:
            return None
        log = EventLog(paths().logs, self._bus.session, max_bytes=int(settings.log_mb * 1e6), keep=settings.log_files)
        try:
            log.open()
        except StorageError as error:
            self._tell(error)
            return None
        log.on_error = self._tell
        self._bus.subscribe(log.write)
        return log

    def _tell_log(self, source: str, message: str) -> None:
        self._emit(events.Log("warning", source, message))

    def _tell(self, error: SaysoError) -> None:
        self._emit(events.ErrorRaised(error.code, error.message, error.hint))
