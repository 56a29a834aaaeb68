"""Messages of rclpy as plain mappings, and back.

How each type is read and filled is found out once for each type. Long arrays are copied as a whole, never number by
number in Python: a picture or a scan costs what copying its memory costs.
"""

from __future__ import annotations

import array
import importlib
import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import cache
from typing import Any, Final

import numpy as np

LIST_MOST: Final = 64
"""Numbers in an array that becomes a list; a longer one becomes a numpy array."""

_BYTES: Final = ("uint8", "char")
"""Numbers whose arrays are ``bytes`` here."""
_CODES: Final = {
    "float": "f",
    "double": "d",
    "int8": "b",
    "uint8": "B",
    "char": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}
"""What numpy and ``array`` call the numbers of an interface."""

Read = Callable[[Any], Any]
Make = Callable[[Any], Any]


class BadTypeError(Exception):
    """A type is not there, or a message or a name does not go with it; says so in words for people."""


def made_by(create: Callable[[], Any]) -> Any:
    """What this makes of rclpy. Raises BadTypeError: one node cannot use a name with two types, nor any name."""
    from rclpy.exceptions import NameValidationException  # type: ignore[import-not-found]

    try:
        return create()
    except (RuntimeError, ValueError, NameValidationException) as error:
        raise BadTypeError(" ".join(str(error).split())) from error


@cache
def find_type(name: str, kind: str) -> Any:
    """The class of ``package/kind/Name``. Raises BadTypeError."""
    from rclpy.type_support import check_for_type_support  # type: ignore[import-not-found]
    from rosidl_generator_py.import_type_support_impl import (  # type: ignore[import-not-found]
        UnsupportedTypeSupport,
    )

    package, _, rest = name.partition("/")
    its_kind, _, own = rest.partition("/")
    if its_kind != kind or not own.isidentifier() or not package.isidentifier():
        raise BadTypeError(f"{name} is not the name of a type as package/{kind}/Name")
    try:
        found = getattr(importlib.import_module(f"{package}.{kind}"), own)
        check_for_type_support(found)
    except ModuleNotFoundError:
        raise BadTypeError(f"the type {name} is not installed here: there is no package {package}") from None
    except (AttributeError, ImportError, UnsupportedTypeSupport) as error:
        raise BadTypeError(f"the type {name} is not installed here: {error}") from error
    return found


def to_mapping(message: Any) -> dict[str, Any]:
    """What a message says."""
    return {name: read(getattr(message, name)) for name, read in _readers(_class(message))}


def to_message(type: Any, fields: Mapping[str, Any]) -> Any:
    """A message of this class; fields that are not given have their defaults. Raises BadTypeError."""
    message, makers = type(), _makers(type)
    for name, value in fields.items():
        make = makers.get(name)
        if make is None:
            raise BadTypeError(f"{_name_of(type)} has no field {name}")
        try:
            setattr(message, name, make(value))
        except (TypeError, ValueError, OverflowError, AssertionError) as error:
            raise BadTypeError(f"{_name_of(type)}.{name} cannot be {str(value)[:60]!r} ({error})") from error
    return message


def _class(message: Any) -> Any:
    return type(message)


def _name_of(type: Any) -> str:
    return f"{type.__module__.partition('.')[0]}/{type.__name__}"


def _slots(type: Any) -> list[tuple[str, Any]]:
    return list(zip(type.get_fields_and_field_types(), type.SLOT_TYPES, strict=True))


# Reading


@cache
def _readers(type: Hashable) -> list[tuple[str, Read]]:
    return [(name, _reader(slot)) for name, slot in _slots(type)]


def _reader(slot: Any) -> Read:
    from rosidl_parser.definition import (  # type: ignore[import-not-found]
        AbstractNestedType,
        BasicType,
        NamespacedType,
    )

    if isinstance(slot, NamespacedType):
        return to_mapping
    if not isinstance(slot, AbstractNestedType):
        return _same
    if isinstance(slot.value_type, NamespacedType):
        return lambda values: [to_mapping(value) for value in values]
    if not isinstance(slot.value_type, BasicType) or slot.value_type.typename == "boolean":
        return list
    if slot.value_type.typename == "octet":
        return b"".join
    return bytes if slot.value_type.typename in _BYTES else _numbers


def _same(value: Any) -> Any:
    return value


def _numbers(values: array.array[Any] | np.ndarray[Any, Any]) -> Any:
    return values.tolist() if len(values) <= LIST_MOST else np.asarray(values)


# Filling


@cache
def _makers(type: Hashable) -> dict[str, Make]:
    return {name: _maker(slot) for name, slot in _slots(type)}


def _maker(slot: Any) -> Make:
    from rosidl_parser.definition import (
        AbstractNestedType,
        Array,
        BasicType,
        NamespacedType,
    )

    if not isinstance(slot, AbstractNestedType):
        return _single(slot)
    inner, exact = slot.value_type, slot.size if isinstance(slot, Array) else None
    most = exact if exact is not None else getattr(slot, "maximum_size", None)
    if isinstance(inner, BasicType) and inner.typename not in ("boolean", "octet"):
        make = _array_of(inner.typename, fixed=exact is not None)
    elif isinstance(inner, BasicType) and inner.typename == "octet":
        make = _octets
    else:
        single = _maker(inner) if isinstance(inner, NamespacedType) else _single(inner)
        make = lambda values: [single(value) for value in _sequence(values)]  # noqa: E731

    def limited(values: Any) -> Any:
        made = make(values)
        if (exact is not None and len(made) != exact) or (most is not None and len(made) > most):
            raise ValueError(f"{len(made)} values where there are {most}")
        return made

    return limited


def _single(slot: Any) -> Make:
    from rosidl_parser.definition import BasicType, NamespacedType

    if isinstance(slot, NamespacedType):
        module = importlib.import_module(".".join(slot.namespaces))
        inner = getattr(module, slot.name)
        return lambda value: to_message(inner, _fields(value))
    if not isinstance(slot, BasicType):
        return _text
    match slot.typename:
        case "float" | "double":
            return lambda value: math.nan if value is None else float(value)
        case "boolean":
            return bool
        case "octet":
            return lambda value: bytes([value]) if isinstance(value, int) else bytes(value)
        case name:
            return _integer(name)


def _integer(name: str) -> Make:
    known = np.iinfo(np.dtype(_CODES[name]))
    low, high = int(known.min), int(known.max)

    def make(value: Any) -> int:
        number = int(value)
        if number != value or not low <= number <= high:
            raise ValueError(f"no {name}")
        return number

    return make


def _array_of(name: str, *, fixed: bool) -> Make:
    code = _CODES[name]
    dtype = np.dtype(code)

    def make(values: Any) -> Any:
        if isinstance(values, bytes | bytearray | memoryview):
            whole = np.frombuffer(values, np.uint8).astype(dtype, copy=False)
        else:
            if isinstance(values, list) and None in values:
                values = [math.nan if value is None else value for value in values]
            found = np.asarray(values)
            whole = np.ascontiguousarray(found, dtype)
            if dtype.kind != "f" and not np.array_equal(whole, found):
                raise ValueError(f"not all of it is {name}")
        if whole.ndim != 1:
            raise ValueError("an array of one dimension")
        if fixed:
            return whole
        made = array.array(code)
        made.frombytes(whole.tobytes())
        return made

    return make


def _octets(values: Any) -> list[bytes]:
    return [bytes([value]) if isinstance(value, int) else bytes(value) for value in values]


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("no text")
    return value


def _fields(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise TypeError("no fields")
    return value


def _sequence(values: Any) -> Sequence[Any]:
    if isinstance(values, str | bytes | Mapping):
        raise TypeError("no sequence")
    return list(values)
