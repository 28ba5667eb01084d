# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The table of `faults.py`, and which of its rows are off target."""

from __future__ import annotations

import textwrap
from typing import Any

from tables import columns

Record = dict[str, Any]

MOST_WRONG = 0.001
RIGHT_S = 3.0

HEADS = [
    "fault", "flights", "died", "positions during", "after", "wrong", "largest, sigmas",
    "largest wrong, m", "names", "right after, s", "sigma",
]  # fmt: skip


def troubles(one: Record) -> list[str]:
    """Return in which respects a flight is off target."""
    unused, ends = one["case"].startswith("attitude:"), one.get("ends", True)
    found = {
        "died": bool(one["died"]),
        "wrong": one["wrong"] > MOST_WRONG * one["rows"],
        "names": ends and one["kept"] < one["names"],
        "late": ends and (one["right_s"] is None or one["right_s"] > RIGHT_S),
        "changed": unused and not one["same"],
    }
    return [name for name, is_so in found.items() if is_so]


def line(one: Record) -> str:
    """Return a flight in a line."""
    right = "never" if one["right_s"] is None else f"{one['right_s']:.1f} s"
    bad = ", ".join(troubles(one))
    return (
        f"{one['case']} | {one['flight']} {one['seed']} | during {one['during']}/"
        f"{one['clean_during']} after {one['after']}/{one['clean_after']} | wrong {one['wrong']} "
        f"({one['most_m']:.3g} m, {_number(one['most_sigmas'])} sigmas) | names {one['kept']}/"
        f"{one['names']} | right {right} | sigma {_number(one['sigma'])} | {one['died'][:90]} "
        f"{'=' if one['same'] else ''} {('!! ' + bad) if bad else ''}"
    )


def markdown(flights: list[Record], failing: bool = False) -> str:
    """Return the table, a row a case."""
    by_case: dict[str, list[Record]] = {}
    for one in flights:
        by_case.setdefault(one["case"], []).append(one)
    rows = [
        _row(case, those)
        for case, those in by_case.items()
        if not failing or any(troubles(one) for one in those)
    ]
    return columns(HEADS, rows)


def _row(case: str, flights: list[Record]) -> list[str]:
    def total(name: str) -> int:
        return sum(one[name] for one in flights)

    rights = [one["right_s"] for one in flights]
    ends = all(one.get("ends", True) for one in flights)
    sigmas = [one["sigma"] for one in flights if one["sigma"] is not None]
    largest = [one["most_sigmas"] for one in flights]
    return [
        case,
        str(len(flights)),
        str(sum(bool(one["died"]) for one in flights)),
        _share(total("during"), total("clean_during")),
        _share(total("after"), total("clean_after")),
        f"{100.0 * total('wrong') / max(1, total('rows')):.2g} %",
        "–" if None in largest else f"{max(largest):.1f}",
        f"{max(one['most_m'] for one in flights):.3g}" if total("wrong") else "–",
        f"{total('kept')}/{total('names')}" if ends else "–",
        ("never" if None in rights else f"{max(rights):.1f}") if ends else "–",
        f"{max(sigmas):.2f}" if sigmas else "–",
    ]


def counts(flights: list[Record]) -> str:
    """Return in a sentence how many flights are on target."""
    off = [troubles(one) for one in flights]
    kept, names = (
        sum(one[name] for one in flights if one.get("ends", True)) for name in ("kept", "names")
    )
    wrong, rows = (sum(one[name] for one in flights) for name in ("wrong", "rows"))
    late = sum("late" in one for one in off)
    sentence = (
        f"{len(flights)} flights: {sum('died' in one for one in off)} died; "
        f"{sum('wrong' in one for one in off)} with confident wrong positions beyond 0.1 %, "
        f"{wrong} of all {rows} positions; {kept} of {names} names kept; "
        f"{late} right again later than after {RIGHT_S:g} s; "
        f"{sum('changed' in one for one in off)} changed by an input that is not used."
    )
    return textwrap.fill(sentence, 120) + "\n"


def _share(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.0f} %" if whole else "–"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"
