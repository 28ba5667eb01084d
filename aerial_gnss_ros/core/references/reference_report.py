# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is said of references: which track each is, and which are not used and why."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from aerial_gnss_ros.core.models.evidence import CLEAR_NATS, UNCLEAR
from aerial_gnss_ros.core.references.candidates import Candidate, NamedTrack
from aerial_gnss_ros.core.references.hypotheses import TUNING as HYPOTHESES
from aerial_gnss_ros.core.references.hypotheses import Hypothesis
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.values.events import Events, WarningText


@dataclass(frozen=True)
class ReferenceReportTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    said_after_s: float = 2.0
    """Time after which a reference that has not been used is reported, s. Judged."""


TUNING = ReferenceReportTuning()


class ReferenceReport:
    """Says of each reference what becomes of it, once until that changes.

    That one is set aside which was used is said at once: positions change by metres.

    Args:
        log: receives the sentences.
    """

    def __init__(self, log: Events) -> None:
        self._log = log
        self._since_ns: dict[str, int] = {}
        self._said: dict[str, str] = {}

    def forget(self, name: str) -> None:
        """Forget what was reported of a reference."""
        self._since_ns.pop(name, None)
        self._said.pop(name, None)

    def update(
        self,
        stamp_ns: int,
        candidates: list[Candidate],
        found: list[Hypothesis],
        links: Mapping[str, str],
        law: PositionLaw,
        tracks: Sequence[NamedTrack],
    ) -> None:
        """Take in what was decided.

        Args:
            stamp_ns: of the image, ns.
            candidates: references, each with the tracks that it may be.
            found: all hypotheses.
            links: label of the track that each used reference is.
            law: of the tracks, without references.
            tracks: by row.
        """
        patience_ns = round(TUNING.said_after_s * 1e9)
        for one in candidates:
            label = links.get(one.name, "")
            if label:
                self._since_ns[one.name] = stamp_ns - patience_ns
                self._say(one.name, f"Reference {one.name} is {label}: positions refer to it.")
                continue
            since_ns = self._since_ns.setdefault(one.name, stamp_ns)
            if stamp_ns - since_ns >= patience_ns:
                self._say(one.name, self._refusal(one, found, links, law, tracks))

    def _say(self, name: str, sentence: str) -> None:
        kind = sentence.partition(":")[0]
        if self._said.get(name) != kind:
            self._said[name] = kind
            self._log.add(sentence if " is not used" not in sentence else WarningText(sentence))

    def _refusal(
        self,
        one: Candidate,
        found: list[Hypothesis],
        links: Mapping[str, str],
        law: PositionLaw,
        tracks: Sequence[NamedTrack],
    ) -> str:
        """Return why a reference in view is not used."""
        begin = f"Reference {one.name} is not used"
        if not one.rows:
            return f"{begin}: its track is estimated apart from those of other references."
        by_row: dict[int, float] = {}
        for other in found:
            if one.name in other.rows:
                at = other.rows[one.name]
                by_row[at] = by_row.get(at, 0.0) + other.probability
        likely, likeliest = sum(by_row.values()), max(by_row.values(), default=0.0)
        distances = [
            (math.dist(law.mean[law.places([row])].tolist(), one.position.tolist()), row)
            for row in one.rows
        ]
        metres, row = min(distances)
        label = tracks[row].robot_id
        if likely > 1.0 - UNCLEAR > likeliest:
            return f"{begin}: it may be one of several of its class; give it a class of its own."
        motion = one.motion(row)
        if motion.metres and motion.adrift - motion.nats + math.log(HYPOTHESES.adrift) > CLEAR_NATS:
            return (
                f"{begin}: {label} has moved by {motion.metres:.1f} m, which what has a position "
                "cannot; give it a topic, or a radius_m."
            )
        own = law.places([row])
        sigma = math.sqrt(float(np.trace(law.covariance[np.ix_(own, own)] + one.spread)) / 2.0)
        seen = (
            f"{begin}: {label} is seen {metres:,.1f} m from where it should be (one sigma without "
            f"references {sigma:.1f} m)"
        )
        if likely > 1.0 - UNCLEAR:
            return f"{seen}; it is used once that is more certain."
        others = ", ".join(sorted(links)) or "the receiver"
        if likely > UNCLEAR:
            others = "the receiver or another reference"
        return (
            f"{seen}, which contradicts {others}; check the position, and which "
            f"{tracks[row].class_id} it is."
        )
