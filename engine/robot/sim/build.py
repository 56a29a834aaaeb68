"""From a scene to a MuJoCo model: floors, walls, furniture, signs, loose objects, people, lights and the robot.

Everything is addressed by name afterwards: a loose object is a body with the name it has in the scene file, a piece
of furniture too. Geom groups (see ``body``) tell the lidar what it can meet. Who only moves things leaves out the
pictures on them, which take longer to make than all the rest.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from engine.errors import SceneError
from engine.robot.floor_map import Wall
from engine.robot.sim.body import FIXED, LOOSE, UNSEEN, Node, add_robot
from engine.robot.sim.colours import rgba
from engine.robot.sim.dimensions import LIDAR_HEIGHT
from engine.robot.sim.floor import door_leaf, wall_pieces
from engine.robot.sim.furniture import FLAT, Solid, solids
from engine.robot.sim.person import add_person, first_pose, in_hand
from engine.robot.sim.scene import Scene
from engine.robot.sim.scene_parts import FloorLine, FurniturePiece, LooseObject, RoomArea, Sign
from engine.robot.sim.textures import TAG_CELLS, cube, planks, qr_cells, tag_cells, tiles

TIMESTEP = 0.002
"""s of simulated time per physics step."""

_G = mujoco.mjtGeom
_SHAPES = {"box": _G.mjGEOM_BOX, "cylinder": _G.mjGEOM_CYLINDER, "ellipsoid": _G.mjGEOM_ELLIPSOID}
_SHEET = 0.002  # m, half of the thickness of a sign
_PATTERN_SIZE = 1.6  # m that one picture of a floor pattern covers


def build(scene: Scene, *, pictures: bool = True) -> Any:
    """Compile the scene with the robot in it; returns an ``mujoco.MjModel``. Raises :class:`SceneError`."""
    try:
        return specify(scene, pictures=pictures).compile()
    except ValueError as error:  # what MuJoCo's compiler raises
        raise SceneError(f"Scene {scene.name} cannot be built: {error}.") from error


def specify(scene: Scene, *, pictures: bool = True) -> Node:
    """The scene as an ``MjSpec``, for tests and tools that want to add to it. Without ``pictures`` nothing is painted
    on surfaces (tags, codes, floors), and all else is the same: the geoms, their order, and how everything moves."""
    spec = mujoco.MjSpec()
    spec.modelname = scene.name
    spec.compiler.degree = False  # MjSpec reads degrees otherwise
    option = spec.option
    option.timestep = TIMESTEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10  # grasping by friction slips without
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP  # what lies still costs nothing: 20 µs a step, not 75
    _light(spec, scene)
    _floors(spec, scene, pictures=pictures)
    for index, wall in enumerate(wall_pieces(scene)):
        _wall(spec, scene, f"wall {index}", wall)
    for door in scene.doors:
        if door.closed:
            _door(spec, scene, f"door {door.between[0]} {door.between[1]}", door_leaf(scene, door))
    for name, piece in scene.furniture.items():
        _furniture(spec, name, piece)
    for name, line in scene.lines.items():
        _line(spec, name, line)
    held = {
        person.holds: in_hand(person, first_pose(person))
        for person in scene.people.values()
        if person.holds is not None
    }
    for name, loose in scene.objects.items():
        above = 0.002 if loose.stands_on is not None else 0.001
        x, y, z = held.get(name, (*loose.at, scene.standing_height(loose) + above + loose.tall / 2))
        solid = _object(spec, name, loose, (x, y, z - loose.tall / 2))
        if pictures and loose.tag is not None:
            _paste(spec, solid, tag_cells(loose.tag))
    for mark in scene.landmarks:
        sheet = _sign(spec, f"landmark {mark.id}", mark, mark.size * TAG_CELLS / (TAG_CELLS - 2))
        if pictures:
            _paste(spec, sheet, tag_cells(mark.id))
    for index, poster in enumerate(scene.posters):
        sheet = _sign(spec, f"poster {index}", poster, poster.size)
        if pictures:
            _paste(spec, sheet, qr_cells(poster.text))
    for name, person in scene.people.items():
        add_person(spec, name, person)
    add_robot(spec)
    return spec


def _light(spec: Node, scene: Scene) -> None:
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.28, 0.28, 0.28]
    spec.visual.headlight.specular = [0.0, 0.0, 0.0]
    spec.visual.quality.shadowsize = 4096
    spec.visual.map.znear = 0.002
    spec.visual.map.shadowscale = 0.9
    sky = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX)
    sky.builtin = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2, sky.width, sky.height = [0.93, 0.94, 0.96], [0.72, 0.76, 0.82], 64, 384
    middle = (sum(scene.bounds.x) / 2, sum(scene.bounds.y) / 2)
    sun = spec.worldbody.add_light(name="sun", pos=[middle[0] - 3, middle[1] - 4, 9], dir=[0.3, 0.4, -0.9])
    sun.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    sun.diffuse, sun.specular = [0.42, 0.41, 0.38], [0.05, 0.05, 0.05]


def _fixed(geom: Node) -> None:
    geom.group, geom.contype, geom.conaffinity = FIXED, 1, 3


def _for_the_eye(geom: Node) -> None:
    geom.group, geom.contype, geom.conaffinity, geom.mass = UNSEEN, 0, 0, 0.0


def _floors(spec: Node, scene: Scene, *, pictures: bool) -> None:
    ground = spec.worldbody.add_geom(name="floor", type=_G.mjGEOM_PLANE, size=[12, 12, 0.1])
    ground.rgba, ground.friction = rgba("grey", shade=1.25), [0.9, 0.005, 0.0001]
    _fixed(ground)
    for index, (name, room) in enumerate(scene.rooms.items()):
        # A plane, because only planes carry a two-dimensional texture; lifted by a hair above the ground.
        half = [(high - low) / 2 for low, high in (room.x, room.y)]
        centre = [sum(room.x) / 2, sum(room.y) / 2, 0.0005]
        geom = spec.worldbody.add_geom(name=f"{name} floor", type=_G.mjGEOM_PLANE, pos=centre, size=[*half, 0.1])
        _for_the_eye(geom)
        geom.rgba = rgba(room.colour)
        picture = _floor_picture(room, index) if pictures else None
        if picture is not None:
            material = _material(spec, f"{name} floor", picture, mujoco.mjtTexture.mjTEXTURE_2D)
            material.texuniform, material.texrepeat = True, [2 / _PATTERN_SIZE, 2 / _PATTERN_SIZE]
            geom.material, geom.rgba = material.name, [1, 1, 1, 1]


def _floor_picture(room: RoomArea, seed: int) -> NDArray[np.uint8] | None:
    if room.floor == "planks":
        return planks(room.colour, seed)
    return tiles(room.colour) if room.floor == "tiles" else None


def _material(spec: Node, name: str, picture: NDArray[np.uint8], kind: Node) -> Node:
    height, width, channels = picture.shape
    texture = spec.add_texture(name=name, type=kind, width=width, height=height, nchannel=channels)
    texture.data = picture.tobytes()
    material = spec.add_material(name=name, specular=0.05, shininess=0.1)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
    return material


def _paste(spec: Node, geom: Node, cells: NDArray[np.bool_]) -> None:
    """Put a picture in black and white on all sides of a box."""
    geom.material = _material(spec, geom.name, cube(cells), mujoco.mjtTexture.mjTEXTURE_CUBE).name


def _wall(spec: Node, scene: Scene, name: str, area: Wall) -> None:
    x0, y0, x1, y1 = area.x_min, area.y_min, area.x_max, area.y_max
    height = scene.walls.height
    body = spec.worldbody.add_body(name=name, pos=[(x0 + x1) / 2, (y0 + y1) / 2, 0])
    half = ((x1 - x0) / 2, (y1 - y0) / 2)
    wall = body.add_geom(type=_G.mjGEOM_BOX, pos=[0, 0, height / 2], size=[*half, height / 2])
    wall.rgba = rgba(scene.walls.colour)
    _fixed(wall)
    for z, tall, grow, shade in ((0.03, 0.03, 0.006, 0.78), (height, 0.004, 0.001, 0.62)):
        trim = body.add_geom(type=_G.mjGEOM_BOX, pos=[0, 0, z], size=[half[0] + grow, half[1] + grow, tall])
        _for_the_eye(trim)
        trim.rgba = rgba(scene.walls.colour, shade=shade)


def _door(spec: Node, scene: Scene, name: str, area: Wall) -> None:
    """A closed leaf, with a handle on either side."""
    x0, y0, x1, y1 = area.x_min, area.y_min, area.x_max, area.y_max
    height, along_x = 0.96 * scene.walls.height, x1 - x0 > y1 - y0
    body = spec.worldbody.add_body(name=name, pos=[(x0 + x1) / 2, (y0 + y1) / 2, 0])
    leaf = body.add_geom(
        type=_G.mjGEOM_BOX, pos=[0, 0, height / 2], size=[(x1 - x0) / 2, (y1 - y0) / 2, height / 2], rgba=rgba("birch")
    )
    _fixed(leaf)
    aside, out = 0.4 * max(x1 - x0, y1 - y0), min(x1 - x0, y1 - y0) / 2 + 0.015
    at, size = (
        ([aside, 0, 0.55 * height], [0.04, out, 0.01]) if along_x else ([0, aside, 0.55 * height], [out, 0.04, 0.01])
    )
    handle = body.add_geom(type=_G.mjGEOM_BOX, pos=at, size=size, rgba=rgba("steel", shade=0.7))
    _for_the_eye(handle)


def _sign(spec: Node, name: str, sign: Sign, size: float) -> Node:
    """A thin sheet; a box, because those carry their picture for either renderer."""
    out = (math.cos(sign.yaw), math.sin(sign.yaw))
    sheet = spec.worldbody.add_geom(
        name=name,
        type=_G.mjGEOM_BOX,
        pos=[sign.at[0] - _SHEET * out[0], sign.at[1] - _SHEET * out[1], sign.z],
        size=[_SHEET, size / 2, size / 2],
        quat=[math.cos(sign.yaw / 2), 0, 0, math.sin(sign.yaw / 2)],
    )
    _for_the_eye(sheet)
    return sheet


def _furniture(spec: Node, name: str, piece: FurniturePiece) -> None:
    turn = math.radians(piece.turn)
    body = spec.worldbody.add_body(
        name=name, pos=[*piece.stands, 0.001], quat=[math.cos(turn / 2), 0, 0, math.sin(turn / 2)]
    )
    for part in solids(piece):
        geom = _primitive(body, part)
        if piece.kind in FLAT:
            _for_the_eye(geom)
            continue
        _fixed(geom)
        if not part.centre[2] - part.half[2] <= LIDAR_HEIGHT <= part.centre[2] + part.half[2]:
            geom.group = UNSEEN


def _primitive(body: Node, part: Solid) -> Node:
    size = part.half if part.shape != "cylinder" else (part.half[0], part.half[2], 0)
    return body.add_geom(type=_SHAPES[part.shape], pos=part.centre, size=size, rgba=rgba(part.colour, shade=part.shade))


def _line(spec: Node, name: str, line: FloorLine) -> None:
    """Tape on the floor: a thin box per stretch, a disc at each joint."""
    half = line.width / 2
    for index, (start, end) in enumerate(zip(line.points, line.points[1:], strict=False)):
        dx, dy = end[0] - start[0], end[1] - start[1]
        angle = math.atan2(dy, dx)
        tape = spec.worldbody.add_geom(
            name=f"{name} {index}",
            type=_G.mjGEOM_BOX,
            pos=[(start[0] + end[0]) / 2, (start[1] + end[1]) / 2, 0.001],
            size=[math.hypot(dx, dy) / 2, half, 0.001],
            quat=[math.cos(angle / 2), 0, 0, math.sin(angle / 2)],
            rgba=rgba(line.colour),
        )
        _for_the_eye(tape)
    for point in line.points:
        disc = spec.worldbody.add_geom(
            type=_G.mjGEOM_CYLINDER, pos=[*point, 0.001], size=[half, 0.001, 0], rgba=rgba(line.colour)
        )
        _for_the_eye(disc)


def _object(spec: Node, name: str, loose: LooseObject, at: tuple[float, float, float]) -> Node:
    """A free body; its frame is at the middle of its bottom, which is ``at`` this place. Returns its main geom."""
    turn = math.radians(loose.turn)
    body = spec.worldbody.add_body(name=name, pos=at, quat=[math.cos(turn / 2), 0, 0, math.sin(turn / 2)])
    body.add_freejoint(name=name)
    size, colour = loose.size, rgba(loose.colour)
    seen: list[Node] = []  # what is for the eye only
    if loose.kind in ("box", "tag_block"):
        solid = body.add_geom(type=_G.mjGEOM_BOX, pos=[0, 0, loose.tall / 2], size=[size / 2, size / 2, loose.tall / 2])
        if loose.tag is not None:
            colour = (1.0, 1.0, 1.0, 1.0)
    elif loose.kind == "ball":
        solid = body.add_geom(type=_G.mjGEOM_SPHERE, pos=[0, 0, size / 2], size=[size / 2, 0, 0])
    else:
        radius = 0.375 * size if loose.kind == "cup" else 0.2 * size
        tall = size if loose.kind == "cup" else 0.68 * size
        solid = body.add_geom(type=_G.mjGEOM_CYLINDER, pos=[0, 0, tall / 2], size=[radius, tall / 2, 0])
        if loose.kind == "cup":
            inside = body.add_geom(type=_G.mjGEOM_CYLINDER, pos=[0, 0, tall], size=[0.85 * radius, 0.0007, 0])
            inside.rgba = rgba(loose.colour, shade=0.45)
            seen.append(inside)
        else:
            neck = body.add_geom(type=_G.mjGEOM_CYLINDER, pos=[0, 0, 0.82 * size], size=[0.45 * radius, 0.14 * size, 0])
            neck.rgba = colour
            cap = body.add_geom(type=_G.mjGEOM_CYLINDER, pos=[0, 0, 0.97 * size], size=[0.5 * radius, 0.03 * size, 0])
            cap.rgba = rgba("white")
            label = body.add_geom(type=_G.mjGEOM_CYLINDER, pos=[0, 0, 0.5 * tall], size=[1.02 * radius, 0.25 * tall, 0])
            label.rgba = rgba("linen")
            seen += [neck, cap, label]
    for geom in seen:
        _for_the_eye(geom)
        geom.group = LOOSE
    solid.name, solid.group, solid.mass, solid.rgba = name, LOOSE, loose.mass, colour
    solid.contype, solid.conaffinity = 1, 3
    solid.condim, solid.friction = 4, [0.9, 0.01, 0.0001]
    if loose.kind == "ball":
        solid.condim, solid.friction = 6, [0.8, 0.01, 0.002]  # rolling friction, or it never comes to rest
    return solid
