# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Changes numbers, texts and bytes: to what is known to hurt, and at random."""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Sequence

FLOATS = (
    math.nan, math.inf, -math.inf, 0.0, -0.0, 1.0, -1.0, 0.3, 1e-9, 5e-324, 1e-300, 90.0, -90.0,
    180.0, -180.0, 360.0, 500.0, 1e4, 1e9, -1e9, 1e18, -1e18, 3.4028235e38, 1e154, 1e308, -1e308,
)  # fmt: skip
TEXTS = (
    "", " ", "0", "-1", "a" * 5000, "\x00", "\x07\x1b[31m", "\ud7ff\ue000", "\u202eaqua", "ä_ö",
    "=1+1", "@cmd", "+1", "-1+1", "a,b", 'a"b', "a\nb", "a\r\nb", "<a>&amp;]]>", "../../etc", "/",
    "{x}", "%s%n", "aqua", "AQUA", "aqua_1", "équipe", "机器人", "🤖", "\ufeffaqua", "\ufffe", "__",
    "nan", "null", "true", "1e999", "9" * 400,
)  # fmt: skip
_SIZES = {"int8": 8, "uint8": 8, "byte": 8, "char": 8, "int16": 16, "uint16": 16, "int32": 32,
          "uint32": 32, "int64": 64, "uint64": 64}  # fmt: skip


def number(rng: random.Random, value: float) -> float:
    """Return another number than `value`, or by chance the same."""
    way = rng.randrange(8)
    if way < 3 or not math.isfinite(value):
        return rng.choice(FLOATS)
    if way == 3:
        return -value
    if way == 4:
        return value * math.pow(10.0, rng.uniform(-6.0, 6.0))
    if way == 5:
        return value + rng.gauss(0.0, 1.0) * (abs(value) + 1.0)
    if way == 6:
        bits = struct.unpack("<Q", struct.pack("<d", value))[0] ^ (1 << rng.randrange(64))
        return float(struct.unpack("<d", struct.pack("<Q", bits))[0])
    return value + rng.choice((-1.0, 1.0)) * math.pow(10.0, rng.uniform(-8.0, 8.0))


def whole(rng: random.Random, value: int, kind: str) -> int:
    """Return another whole number that a field of this kind (`int32`) can hold."""
    size = _SIZES[kind]
    signed = kind.startswith("int")
    low, high = (-(1 << (size - 1)), (1 << (size - 1)) - 1) if signed else (0, (1 << size) - 1)
    way = rng.randrange(5)
    if way == 0:
        return rng.choice((low, high, 0, min(1, high), max(-1, low), high // 2))
    if way == 1:
        changed = value + rng.choice((-1, 1)) * int(10 ** rng.randrange(10))
    elif way == 2:
        changed = value ^ (1 << rng.randrange(size - 1))
    elif way == 3:
        changed = rng.randint(low, high)
    else:
        changed = value + rng.randrange(-3, 4)
    return min(max(changed, low), high)


def text(rng: random.Random, value: str) -> str:
    """Return another text."""
    way = rng.randrange(4)
    if way == 0 or not value:
        return rng.choice(TEXTS)
    place = rng.randrange(len(value) + 1)
    if way == 1:
        return value[:place] + rng.choice(TEXTS)[:200] + value[place:]
    if way == 2:
        return value[:place] + value[place + 1 :]
    return (
        value[:place] + chr(rng.choice((rng.randrange(32), rng.randrange(0xD7FF)))) + value[place:]
    )


def octets(rng: random.Random, data: bytes, other: bytes = b"") -> bytes:
    """Return changed bytes; `other` is of the same kind, to splice."""
    changed = bytearray(data)
    for _ in range(1 + int(rng.expovariate(0.7))):
        if not changed:
            break
        place = rng.randrange(len(changed))
        way = rng.randrange(9)
        if way == 0:
            changed[place] ^= 1 << rng.randrange(8)
        elif way == 1:
            changed[place] = rng.randrange(256)
        elif way == 2:
            packed = struct.pack("<d", rng.choice(FLOATS))
            changed[place - place % 8 : place - place % 8 + 8] = packed
        elif way == 3:
            four = rng.choice((0, 1, 0x7F, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF))
            changed[place - place % 4 : place - place % 4 + 4] = struct.pack("<I", four)
        elif way == 4:
            del changed[place:]
        elif way == 5:
            changed += rng.randbytes(rng.randrange(1, 64))
        elif way == 6:
            del changed[place : place + rng.randrange(1, 9)]
        elif way == 7:
            changed[place:place] = rng.randbytes(rng.randrange(1, 9))
        elif other:
            changed[place:] = other[place:]
    return bytes(changed)


def lines(rng: random.Random, whole_text: str, words: Sequence[str]) -> str:
    """Return a changed text of lines, such as YAML or CSV; `words` are put into it."""
    rows = whole_text.split("\n")
    for _ in range(1 + int(rng.expovariate(0.6))):
        place = rng.randrange(len(rows)) if rows else 0
        way = rng.randrange(10)
        if way == 0 and rows:
            del rows[place : place + rng.randrange(1, 4)]
        elif way == 1 and rows:
            rows.insert(rng.randrange(len(rows) + 1), rows[place])
        elif way == 2:
            rows.insert(place, rng.choice(words))
        elif way == 3 and rows:
            rows[place] = " " * rng.randrange(6) + rows[place].lstrip()
        elif way == 4 and rows:
            rows = rows[: place + 1]
            rows[-1] = rows[-1][: rng.randrange(len(rows[-1]) + 1)]
        elif way == 5 and rows:
            rows[place] = text(rng, rows[place])
        elif rows:
            rows[place] = _token(rng, rows[place], words)
    return "\n".join(rows)


def _token(rng: random.Random, row: str, words: Sequence[str]) -> str:
    """Return a row in which one token, between the signs that part tokens, is another."""
    edges = [0, *(i + 1 for i, sign in enumerate(row) if sign in " ,:;\t[](){}/"), len(row) + 1]
    where = rng.randrange(len(edges) - 1)
    start, end = edges[where], max(edges[where], edges[where + 1] - 1)
    token = row[start:end]
    try:
        value = float(token)
    except ValueError:
        return row[:start] + rng.choice(words) + row[end:]
    if rng.random() < 0.3:
        return row[:start] + rng.choice(words) + row[end:]
    return row[:start] + f"{number(rng, value):.12g}" + row[end:]
