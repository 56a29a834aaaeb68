"""The action library: one file per family of skills. ``LIBRARY`` lists all of them; to add a skill, write a
function with ``@skill`` in the file of its family and add it here."""

from engine.skills.library.conversation import finish_dialogue, finishtask, list_skills, say
from engine.skills.library.gestures import arm_applaud, arm_down, arm_nod, arm_shake, arm_up, dance, drift
from engine.skills.library.motion import move_forward, move_left, move_right, move_sideways, set_cmdvel, stop, wait
from engine.skills.library.navigation import get_current_pose, navigation, report_pose
from engine.skills.library.signals import beep, light
from engine.skills.registry import Skill

LIBRARY: tuple[Skill, ...] = (
    set_cmdvel,
    move_forward,
    move_sideways,
    move_left,
    move_right,
    stop,
    navigation,
    get_current_pose,
    report_pose,
    arm_up,
    arm_down,
    arm_nod,
    arm_shake,
    arm_applaud,
    dance,
    drift,
    wait,
    beep,
    light,
    say,
    list_skills,
    finishtask,
    finish_dialogue,
)
