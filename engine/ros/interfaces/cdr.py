"""Messages as plain mappings from and to CDR, the bytes that ROS 2 sends.

rosbags does the bytes, from and to objects of its own; here they become mappings and are made from them. A field that
a mapping leaves out has its default. What a mapping of ours holds must fit its type; bytes of a peer may be anything.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

from engine.ros.door import Message, octets
from engine.ros.interfaces.definitions import Definitions

LONG: Final = 64
"""Arrays of more numbers than these are numpy arrays, which are not to be written to; shorter ones are lists."""

_ARRAY, _SEQUENCE, _NAME = 3, 4, 2  # kinds of nodes, as rosbags numbers them
_DTYPES: Final = {"bool": "?", "byte": "uint8", "char": "uint8", "octet": "uint8"}
_Convert = Callable[[Any], Any]


class BadMessage(ValueError):
    """Bytes or a mapping that are no message of the type that they should be."""


class Codec:
    """Writes and reads messages of all types that are defined. Thread-safe. Raises UnknownType for all others."""

    def __init__(self, definitions: Definitions) -> None:
        self._definitions = definitions
        self._lock = threading.RLock()
        self._makers: dict[str, _Convert] = {}
        self._readers: dict[str, _Convert] = {}

    def encode(self, type: str, message: Message) -> bytes:
        """Raises BadMessage where a field is unknown or does not fit."""
        maker = self._makers.get(type) or self._maker(type)
        try:
            return bytes(self._definitions.store.serialize_cdr(maker(message), type))
        except BadMessage:
            raise
        except (ValueError, TypeError, AttributeError, OverflowError, struct.error) as error:
            raise BadMessage(f"it does not fit {type} ({error})") from error

    def decode(self, type: str, data: bytes) -> dict[str, Any]:
        """Bytes behind the message are ignored, as ROS 2 does: some of its programs leave them there. Raises
        BadMessage."""
        reader = self._readers.get(type) or self._reader(type)
        if len(data) < 4 or data[0] != 0 or data[1] > 1:
            raise BadMessage("these bytes are not plain CDR")
        store = self._definitions.store
        definition = store.get_msgdef(type)
        read = definition.deserialize_cdr_le if data[1] else definition.deserialize_cdr_be
        try:
            made, _ = read(memoryview(data)[4:], 0, definition.cls, store)
            return reader(made)  # type: ignore[no-any-return]
        except Exception as error:  # rosbags promises one kind of error and raises many
            raise BadMessage(f"these bytes are no {type} ({error or error.__class__.__name__})") from error

    def _maker(self, type: str) -> _Convert:
        with self._lock:
            if type not in self._makers:
                self._definitions.need(type)
                self._makers[type] = self._made_maker(type)
            return self._makers[type]

    def _reader(self, type: str) -> _Convert:
        with self._lock:
            if type not in self._readers:
                self._definitions.need(type)
                self._readers[type] = self._made_reader(type)
            return self._readers[type]

    def _made_maker(self, type: str) -> _Convert:
        from rosbags.typesys.base import normalize_fieldname

        cls = self._definitions.store.types[type]
        makers: dict[str, tuple[str, _Convert, Any]] = {}
        for name, description in self._definitions.store.fielddefs[type][1]:
            if (default := self._definitions.default(type, name)) is None:
                default = _zero(description)
            makers[name] = (normalize_fieldname(name), self._field_maker(type, name, description), default)

        def make(message: Any) -> Any:
            if not isinstance(message, Mapping):
                raise BadMessage(f"{type} is made from a mapping, not from {message!r:.40}")
            if unknown := message.keys() - makers.keys():
                raise BadMessage(f"{type} has no field {min(map(str, unknown))!r}")
            made = {}
            for name, (attribute, maker, default) in makers.items():
                made[attribute] = maker(message.get(name, default))
            return cls(**made)

        return make

    def _field_maker(self, type: str, name: str, description: Any) -> _Convert:
        kind, rest = description
        where = f"{name} of {type}"
        if kind == _NAME:
            return self._maker(rest)
        if kind not in (_ARRAY, _SEQUENCE):
            return _scalar(where, rest[0])
        (inner, of), most = rest
        if inner != _NAME and of[0] != "string":
            return _numbers(where, _DTYPES.get(of[0], of[0]), kind == _ARRAY, most)
        single = self._maker(of) if inner == _NAME else _scalar(where, "string")

        def make(values: Any) -> list[Any]:
            if isinstance(values, (str, bytes, Mapping)):
                raise BadMessage(f"{where} is a list, not {values!r:.40}")
            made = [single(value) for value in values]
            if kind == _ARRAY and not made:
                made = [single("" if inner != _NAME else {}) for _ in range(most)]
            _check_length(where, len(made), kind == _ARRAY, most)
            return made

        return make

    def _made_reader(self, type: str) -> _Convert:
        from rosbags.typesys.base import normalize_fieldname

        readers = []
        for name, description in self._definitions.store.fielddefs[type][1]:
            if name != "structure_needs_at_least_one_member":
                readers.append((name, normalize_fieldname(name), self._field_reader(description)))

        def read(made: Any) -> dict[str, Any]:
            fields = made.__dict__
            return {
                name: fields[attribute] if reader is None else reader(fields[attribute])
                for name, attribute, reader in readers
            }

        return read

    def _field_reader(self, description: Any) -> _Convert | None:
        kind, rest = description
        if kind == _NAME:
            return self._reader(rest)
        if kind not in (_ARRAY, _SEQUENCE):
            return None
        inner, of = rest[0]
        if inner == _NAME:
            single = self._reader(of)
            return lambda values: [single(value) for value in values]
        return None if of[0] == "string" else _plain


def _plain(values: Any) -> Any:
    return values if len(values) > LONG else values.tolist()


def _zero(description: Any) -> Any:
    kind, rest = description
    if kind == _NAME:
        return {}
    if kind in (_ARRAY, _SEQUENCE):
        return ()
    return "" if rest[0] == "string" else 0


def _scalar(where: str, base: str) -> _Convert:
    if base == "string":
        return _text(where)
    if base == "bool":
        return bool
    if base.startswith("float"):
        return float

    def whole(value: Any) -> int:
        if int(value) != value:
            raise BadMessage(f"{where} is a whole number, not {value!r:.40}")
        return int(value)

    return whole


def _text(where: str) -> _Convert:
    def text(value: Any) -> str:
        if not isinstance(value, str):
            raise BadMessage(f"{where} is a text, not {value!r:.40}")
        return value

    return text


def _numbers(where: str, dtype: str, fixed: bool, most: int) -> _Convert:
    def numbers(values: Any) -> Any:
        if dtype == "uint8" and isinstance(values, (bytes, bytearray, memoryview, str)):
            if (given := octets(values)) is None:
                raise BadMessage(f"{where} is neither octets nor base64")
            array = np.frombuffer(given, np.uint8) if given else np.zeros(0, np.uint8)
        else:
            array = np.ascontiguousarray(values, dtype)
        if array.ndim != 1:
            raise BadMessage(f"{where} has one dimension, not {array.ndim}")
        if fixed and not len(array):
            array = np.zeros(most, dtype)
        _check_length(where, len(array), fixed, most)
        return array

    return numbers


def _check_length(where: str, length: int, fixed: bool, most: int) -> None:
    if most and (length > most or (fixed and length != most)):
        raise BadMessage(f"{where} has {'' if fixed else 'at most '}{most} elements, not {length}")
