"""The hash of a type: RIHS01, which two ROS 2 peers compare to know that they mean the same type by one name.

It is the SHA-256 of the type's description in JSON, with all types that it refers to. Names and types of fields count,
constants, default values and comments do not. Services and actions are described as structures, too, whose fields are
their messages (sources: REP-2016 and the package rosidl_generator_type_description).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, Final

PREFIX: Final = "RIHS01_"

NESTED: Final = 1
"""The id of a field that is a structure of its own."""
TYPE_IDS: Final[Mapping[str, int]] = {
    "int8": 2,
    "uint8": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "char": 3,  # the same as uint8, in ROS 2
    "bool": 15,
    "byte": 16,
    "octet": 16,
    "string": 17,
}
"""Ids of simple types (type_description_interfaces/msg/FieldType)."""
BOUNDED_STRING: Final = 21
ARRAY, BOUNDED_SEQUENCE, SEQUENCE = 48, 96, 144
"""What is added to the id of a type for an array, a sequence of a largest length, and any other sequence of it."""


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a structure, as its description has it."""

    name: str
    type_id: int
    capacity: int = 0
    """Length of an array, or largest length of a sequence."""
    string_capacity: int = 0
    nested: str = ""
    """The type of a structure, such as ``std_msgs/msg/Header``."""


def type_hash(type: str, fields_of: Callable[[str], Sequence[Field]]) -> str:
    """The hash of a type, such as ``RIHS01_df66…``. ``fields_of`` gives the fields of any type by its name, and what
    it raises for a type that it does not know passes through."""
    structures: dict[str, dict[str, Any]] = {}

    def describe(name: str) -> None:
        if name in structures:
            return
        fields = fields_of(name)
        structures[name] = {"type_name": name, "fields": [_described(field) for field in fields]}
        for field in fields:
            if field.nested:
                describe(field.nested)

    describe(type)
    description = {
        "type_description": structures.pop(type),
        "referenced_type_descriptions": [structures[name] for name in sorted(structures)],
    }
    return PREFIX + sha256(json.dumps(description).encode()).hexdigest()


def _described(field: Field) -> dict[str, Any]:
    type = {
        "type_id": field.type_id,
        "capacity": field.capacity,
        "string_capacity": field.string_capacity,
        "nested_type_name": field.nested,
    }
    return {"name": field.name, "type": type}
