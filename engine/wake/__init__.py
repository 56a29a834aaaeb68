"""What wakes the robot: modules on a serial line that know their wake word themselves, and wake words in what
the microphone hears.

Whatever wakes is given a function that takes an ``engine.commands.Wake``, and calls it in its own thread in the moment
in which it knows: the wake has stopped the robot and marked where in the sound the request begins when that call
returns. Everything else that it has to say is news for people and may wait.
"""
