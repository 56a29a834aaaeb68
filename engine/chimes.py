"""When the robot sounds without speaking: it answers a wake, tells that the recording runs, and how a spoken request
ended that got no spoken answer. Nobody waits for any of it.

What is typed is answered on the screen alone.
"""

from __future__ import annotations

import numpy as np

from engine import events
from engine.audio.player import Playback, Player
from engine.audio.sounds import SoundName, sound
from engine.events import Event, TurnResult


class Chimes:
    """Follows what happens; :meth:`see` is for the bus, in the loop's thread."""

    def __init__(self, player: Player, *, module_answers: bool = False) -> None:
        """``module_answers``: a wake module says something itself when it wakes."""
        self._player = player
        self._module_answers = module_answers
        self._waking: Playback | None = None
        self._heard: str | None = None  # turn that began with speech
        self._spoken_s = 0.0  # what had been said aloud when it began

    def see(self, event: Event) -> None:
        match event.body:
            case events.WakeHeard(source=source):
                if source != "speech" and not (source == "serial" and self._module_answers):
                    self._waking = self._play("wake")
            case events.ListenStarted():
                self._heard, self._spoken_s = event.turn, self._player.spoken_s
                self._play("listen", after=self._waking)
            case events.StateChanged(result=result):
                if result is not None and event.turn is not None and event.turn == self._heard:
                    self._end(result)

    def _end(self, result: TurnResult) -> None:
        self._heard = None
        answered = self._player.spoken_s > self._spoken_s
        if not answered and result.outcome != "interrupted":
            self._play("done" if result.outcome == "done" else "error")

    def _play(self, name: SoundName, *, after: Playback | None = None) -> Playback | None:
        """Play a sound, once ``after`` has ended."""
        if not self._player.usable:
            return None
        made, rate = sound(name, self._player.rate), self._player.rate
        if after is not None and not after.ended:
            left = after.length - after.position
            made = np.concatenate((np.zeros(max(0, round(left * rate)), np.float32), made))
        return self._player.play(made)
