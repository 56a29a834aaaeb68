"""The action library: one file per family of skills. ``LIBRARY`` lists all of them; to add a skill, write a
function with ``@skill`` in the file of its family and add it here."""

from engine.skills.library.accompanying import guide, person_follow
from engine.skills.library.conversation import finish_dialogue, finishtask, list_skills, say
from engine.skills.library.following import (
    color_follow,
    follow_line,
    follow_line_clear,
    get_dist,
    qr_follow,
    track,
)
from engine.skills.library.gestures import arm_applaud, arm_down, arm_nod, arm_shake, arm_up, dance, drift
from engine.skills.library.handing import hand_over, serve, take_from
from engine.skills.library.household import ask_user, carry, clean_room, clear_rubbish, tidy
from engine.skills.library.manipulation import (
    close_gripper,
    grasp_obj,
    open_gripper,
    pick_object,
    place_in_bin,
    place_object,
    putdown,
    servo1_move,
)
from engine.skills.library.motion import move_forward, move_left, move_right, move_sideways, set_cmdvel, stop, wait
from engine.skills.library.navigation import get_current_pose, navigation, remember_place, report_pose, return_to
from engine.skills.library.people import count_people, describe_person, find_person, learn_name, meet
from engine.skills.library.searching import list_things, locate, navigate_to_object, scan_room, seewhat
from engine.skills.library.signals import beep, light
from engine.skills.library.sorting import apriltag_remove_higher, apriltag_sort, color_remove_higher
from engine.skills.library.talking import answer_question, ask_person, report_answer, tell, tell_everyone
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
    remember_place,
    return_to,
    report_pose,
    arm_up,
    arm_down,
    arm_nod,
    arm_shake,
    arm_applaud,
    dance,
    drift,
    servo1_move,
    open_gripper,
    close_gripper,
    seewhat,
    scan_room,
    list_things,
    locate,
    navigate_to_object,
    grasp_obj,
    pick_object,
    putdown,
    place_object,
    place_in_bin,
    carry,
    clean_room,
    clear_rubbish,
    tidy,
    color_follow,
    person_follow,
    qr_follow,
    track,
    follow_line,
    follow_line_clear,
    get_dist,
    apriltag_sort,
    apriltag_remove_higher,
    color_remove_higher,
    wait,
    beep,
    light,
    say,
    find_person,
    meet,
    guide,
    tell,
    tell_everyone,
    ask_person,
    report_answer,
    answer_question,
    hand_over,
    take_from,
    serve,
    count_people,
    describe_person,
    learn_name,
    ask_user,
    list_skills,
    finishtask,
    finish_dialogue,
)
