"""The types of messages, services and actions: what fields they have, and their hashes.

Standard messages come with rosbags, as ROS 2 Jazzy has them. Services, actions and other messages are read from files
``<package>/{msg,srv,action}/<Name>.{msg,srv,action}`` in folders of the user's, which win over everything else, and in
``assets/ros2``. A service is two messages, ``…_Request`` and ``…_Response``; an action is three, and two services and a
message more, which carry them together with the id of a goal (source: https://design.ros2.org/articles/actions.html).
"""

from __future__ import annotations

import contextlib
import re
import threading
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import yaml

from engine.errors import DeviceError, UsageError
from engine.ros.interfaces.hashes import (
    ARRAY,
    BOUNDED_SEQUENCE,
    BOUNDED_STRING,
    NESTED,
    SEQUENCE,
    TYPE_IDS,
    Field,
    type_hash,
)

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

INSTALL: Final = "pip install 'sayso[ros]'"
ID: Final = "unique_identifier_msgs/msg/UUID"
"""What a goal is known by."""

_NO_FIELDS: Final = "structure_needs_at_least_one_member"  # the field of a message that has none
_PARTS: Final = {"srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}
_DEFAULT: Final = re.compile(r"^[ \t]*[\w/\[\]<=]+[ \t]+([a-z]\w*)[ \t]+([^=#\s].*)$", re.MULTILINE)
_STANDARD_DEFAULTS: Final[Mapping[str, Mapping[str, Any]]] = {"geometry_msgs/msg/Quaternion": {"w": 1.0}}
"""The only ones among messages that rosbags knows, which leaves them out."""

_BASE, _NAME, _ARRAY, _SEQUENCE = 1, 2, 3, 4  # kinds of nodes, as rosbags numbers them


class UnknownType(UsageError):
    """A type that nobody has defined."""

    code = "ros_type"

    def __init__(self, type: str) -> None:
        super().__init__(
            f"No definition of {type} is known.",
            hint="Put its .msg, .srv or .action file into a folder <package>/{msg,srv,action}, and name that folder.",
        )


class Definitions:
    """All types that are known. Thread-safe."""

    def __init__(self, folders: Sequence[Path] = ()) -> None:
        """``folders`` are searched with all that is in them. Raises DeviceError where rosbags is not installed."""
        try:
            from rosbags.typesys import Stores, get_typestore
        except ImportError as error:
            raise DeviceError("The messages of ROS 2 need the package rosbags.", hint=INSTALL) from error
        self._lock = threading.RLock()
        self._hashes: dict[str, str] = {}
        self._defaults: dict[str, Mapping[str, Any]] = dict(_STANDARD_DEFAULTS)
        self.store: Typestore = get_typestore(Stores.ROS2_JAZZY)
        """Of rosbags; holds what has been asked for with :meth:`need`."""
        self._files = _found(Path(str(files("assets") / "ros2")))
        for folder in folders:
            theirs = _found(folder)
            self._files.update(theirs)
            for type in theirs:
                self.store.fielddefs.pop(type, None)
                self.store.types.pop(type, None)

    def hash(self, type: str) -> str:
        """The hash of a message, service or action. Raises UnknownType."""
        with self._lock:
            if type not in self._hashes:
                self._hashes[type] = type_hash(type, self.fields)
            return self._hashes[type]

    def fields(self, type: str) -> Sequence[Field]:
        """Of a message, or of a service or an action, whose fields are its messages. Raises UnknownType."""
        with self._lock:
            if (parts := self._implied(type)) is not None:
                return [Field(name, NESTED, nested=nested) for name, nested in parts]
            self.need(type)
            found: Any = self.store.fielddefs[type][1] or [(_NO_FIELDS, (_BASE, ("uint8", 0)))]
            return [_field(name, description) for name, description in found]

    def default(self, type: str, field: str) -> object:
        """What a field of a message has where nothing is said; None for zero."""
        return self._defaults.get(type, {}).get(field)

    def need(self, type: str) -> None:
        """Have a message, and all messages that it holds, in ``store``. Raises UnknownType."""
        with self._lock:
            if type in self.store.fielddefs:
                return
            package, kind, name = _split(type)
            interface = f"{package}/{kind}/{name.partition('_')[0]}"  # which has no underscore in its own name
            if (path := self._files.get(interface)) is None:
                raise UnknownType(type)
            self._read(interface, path)
            if type not in self.store.fielddefs:
                raise UnknownType(type)

    def _implied(self, type: str) -> list[tuple[str, str]] | None:
        """Fields of a service or an action, with their types; None for a message."""
        _, kind, name = _split(type)
        if (kind == "srv" and "_" not in name) or name.endswith(("_SendGoal", "_GetResult")):
            self.need(f"{type}_Request")
            return [(f"{part.lower()}_message", f"{type}_{part}") for part in ("Request", "Response", "Event")]
        if kind == "action" and "_" not in name:
            self.need(f"{type}_Goal")
            parts = [(part.lower(), f"{type}_{part}") for part in _PARTS["action"]]
            services = [("send_goal_service", f"{type}_SendGoal"), ("get_result_service", f"{type}_GetResult")]
            return [*parts, *services, ("feedback_message", f"{type}_FeedbackMessage")]
        return None

    def _read(self, interface: str, path: Path) -> None:
        """Take a file of definitions into the store, and all that it refers to. Raises UsageError."""
        from rosbags.typesys import TypesysError, get_types_from_msg

        package, kind, _ = _split(interface)
        try:
            texts = re.split(r"^---[ \t]*$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
            parts = _PARTS.get(kind)
            names = [f"{interface}_{part}" for part in parts] if parts else [interface]
            made: dict[str, Any] = {}
            for full, text in zip(names, texts, strict=True):
                (definition,) = get_types_from_msg(text, f"{package}/msg/{_split(full)[2]}").values()
                made[full] = definition
                self._defaults[full] = _defaults(text)
            if kind == "srv":
                made[f"{interface}_Event"] = _event(interface)
            elif kind == "action":
                made |= _of_action(interface)
            self.store.register(made)
        except (OSError, ValueError, TypesysError) as error:
            raise UsageError(
                f"{path} is no definition that can be read ({error}).", hint="Compare it with ROS 2's own."
            ) from error
        for full in made:
            for _, description in self.store.fielddefs[full][1]:
                if nested := _nested(description):
                    self.need(nested)


def _split(type: str) -> tuple[str, str, str]:
    package, _, rest = type.partition("/")
    kind, _, name = rest.partition("/")
    if kind not in ("msg", "srv", "action") or not name:
        raise UnknownType(type)
    return package, kind, name


def _found(folder: Path) -> dict[str, Path]:
    """Files of definitions below a folder, by type."""
    found = {}
    for path in sorted(folder.rglob("*")):
        kind = path.suffix.removeprefix(".")
        if kind in ("msg", "srv", "action") and path.parent.name == kind:
            found[f"{path.parent.parent.resolve().name}/{kind}/{path.stem}"] = path
    return found


def _defaults(text: str) -> dict[str, Any]:
    """Default values of fields, which their definition tells in much the syntax of YAML."""
    found = {}
    for name, value in _DEFAULT.findall(text):
        with contextlib.suppress(yaml.YAMLError):
            found[name] = yaml.safe_load(value)
    return found


def _name(type: str) -> tuple[int, str]:
    return (_NAME, type)


def _event(service: str) -> Any:
    """What a service tells those who look on."""
    fields = [("info", _name("service_msgs/msg/ServiceEventInfo"))]
    for part in _PARTS["srv"]:
        fields.append((part.lower(), (_SEQUENCE, (_name(f"{service}_{part}"), 1))))  # type: ignore[arg-type]
    return ([], fields)


def _of_action(action: str) -> dict[str, Any]:
    """The messages that carry those of an action."""
    id = ("goal_id", _name(ID))
    send, get = f"{action}_SendGoal", f"{action}_GetResult"
    return {
        f"{send}_Request": ([], [id, ("goal", _name(f"{action}_Goal"))]),
        f"{send}_Response": ([], [("accepted", (_BASE, ("bool", 0))), ("stamp", _name("builtin_interfaces/msg/Time"))]),
        f"{send}_Event": _event(send),
        f"{get}_Request": ([], [id]),
        f"{get}_Response": ([], [("status", (_BASE, ("int8", 0))), ("result", _name(f"{action}_Result"))]),
        f"{get}_Event": _event(get),
        f"{action}_FeedbackMessage": ([], [id, ("feedback", _name(f"{action}_Feedback"))]),
    }


def _nested(description: Any) -> str | None:
    kind, rest = description
    if kind in (_ARRAY, _SEQUENCE):
        kind, rest = rest[0]
    return str(rest) if kind == _NAME else None


def _field(name: str, description: Any) -> Field:
    kind, rest = description
    increment, capacity = 0, 0
    if kind in (_ARRAY, _SEQUENCE):
        (inner, rest), capacity = rest
        increment = ARRAY if kind == _ARRAY else BOUNDED_SEQUENCE if capacity else SEQUENCE
        kind = inner
    if kind == _NAME:
        return Field(name, increment + NESTED, capacity, nested=str(rest))
    base, limit = rest
    if base == "string" and limit:
        return Field(name, increment + BOUNDED_STRING, capacity, limit)
    return Field(name, increment + TYPE_IDS[base], capacity)
