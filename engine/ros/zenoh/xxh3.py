"""XXH3, 128 bits wide, of texts longer than 128 bytes: rmw_zenoh makes from it the id of a publisher or a client.

(Source: the specification of xxHash, doc/xxhash_spec.md of Cyan4973/xxHash, with seed 0 and its default secret.)
"""

from __future__ import annotations

from struct import unpack_from
from typing import Final

SHORTEST: Final = 129
"""Shorter texts are hashed in other ways, which nobody needs here."""

_LONG: Final = 240  # longer texts are taken in stripes
_STRIPE: Final = 64  # bytes
_MASK: Final = 2**64 - 1
_32_1, _32_2, _32_3 = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
_64_1, _64_2, _64_3 = 0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9
_64_4, _64_5 = 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5
_AVALANCHE: Final = 0x165667919E3779F9
_SECRET: Final = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671f"
    "cb79e64eccc0e578825ad07dccff7221b8084674f743248ee03590e6813a264c"
    "3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364"
    "eac5ac8334d3ebc3c581a0fffa1363eb170ddd51b7f0da49d316552629d4689e"
    "2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e"
)
_LEAST_SECRET: Final = 136  # bytes of it that hashes of texts up to 240 bytes use


def xxh3_128(text: bytes) -> tuple[int, int]:
    """The lower and the upper 64 bits of the hash of a text of ``SHORTEST`` bytes or more."""
    if len(text) < SHORTEST:
        raise ValueError(f"only texts of at least {SHORTEST} bytes are hashed here, not of {len(text)}")
    return _middle(text) if len(text) <= _LONG else _long(text)


def _middle(text: bytes) -> tuple[int, int]:
    size = len(text)
    low, high = size * _64_1 & _MASK, 0

    def mix(first: int, second: int, secret: int) -> None:
        nonlocal low, high
        low = (low + _mixed(text, first, secret)) & _MASK
        low ^= (_u64(text, second) + _u64(text, second + 8)) & _MASK
        high = (high + _mixed(text, second, secret + 16)) & _MASK
        high ^= (_u64(text, first) + _u64(text, first + 8)) & _MASK

    for at in range(0, 128, 32):
        mix(at, at + 16, at)
    low, high = _avalanched(low), _avalanched(high)
    for at in range(128, size - 31, 32):
        mix(at, at + 16, at - 128 + 3)
    mix(size - 16, size - 32, _LEAST_SECRET - 17 - 16)
    mingled = (low * _64_1 + high * _64_4 + size * _64_2) & _MASK
    return _avalanched((low + high) & _MASK), -_avalanched(mingled) & _MASK


def _long(text: bytes) -> tuple[int, int]:
    size = len(text)
    sums = [_32_3, _64_1, _64_2, _64_3, _64_4, _32_2, _64_5, _32_1]
    stripes = (len(_SECRET) - _STRIPE) // 8  # in a block
    for stripe in range((size - 1) // _STRIPE):
        within = stripe % stripes
        _accumulate(sums, text, stripe * _STRIPE, within * 8)
        if within == stripes - 1:
            for i, key in enumerate(unpack_from("<8Q", _SECRET, len(_SECRET) - _STRIPE)):
                sums[i] = ((sums[i] ^ sums[i] >> 47 ^ key) * _32_1) & _MASK
    _accumulate(sums, text, size - _STRIPE, len(_SECRET) - _STRIPE - 7)
    low = _merged(sums, 11, size * _64_1)
    high = _merged(sums, len(_SECRET) - _STRIPE - 11, ~(size * _64_2))
    return low, high


def _accumulate(sums: list[int], text: bytes, at: int, secret: int) -> None:
    values, keys = unpack_from("<8Q", text, at), unpack_from("<8Q", _SECRET, secret)
    for i, (value, key) in enumerate(zip(values, keys, strict=True)):
        mixed = value ^ key
        sums[i ^ 1] = (sums[i ^ 1] + value) & _MASK
        sums[i] = (sums[i] + (mixed & 0xFFFFFFFF) * (mixed >> 32)) & _MASK


def _merged(sums: list[int], secret: int, start: int) -> int:
    keys = unpack_from("<8Q", _SECRET, secret)
    folded = (_folded((sums[i] ^ keys[i]) * (sums[i + 1] ^ keys[i + 1])) for i in range(0, 8, 2))
    return _avalanched((start + sum(folded)) & _MASK)


def _mixed(text: bytes, at: int, secret: int) -> int:
    return _folded((_u64(text, at) ^ _u64(_SECRET, secret)) * (_u64(text, at + 8) ^ _u64(_SECRET, secret + 8)))


def _folded(product: int) -> int:
    return (product & _MASK) ^ product >> 64


def _avalanched(value: int) -> int:
    value = ((value ^ value >> 37) * _AVALANCHE) & _MASK
    return value ^ value >> 32


def _u64(text: bytes, at: int) -> int:
    value: int = unpack_from("<Q", text, at)[0]
    return value
