# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sentences for the log, each reported once."""

from __future__ import annotations

from collections import Counter

MAX_KEPT = 200


class WarningText(str):
    """A sentence about something that a user should fix: nodes log it as a warning."""

    __slots__ = ()


class ErrorText(WarningText):
    """A sentence about something that prevents all positions: nodes log it as an error."""

    __slots__ = ()


class Events:
    """Collects sentences until they are drained; if they are not, the oldest are dropped.

    Attributes:
        sentences: not drained yet.
        counts: number of named events since the start, for diagnostics.
    """

    def __init__(self) -> None:
        self.sentences: list[str] = []
        self.counts: Counter[str] = Counter()
        self._told: set[str] = set()

    def add(self, sentence: str) -> None:
        """Say something."""
        self.sentences.append(sentence)
        del self.sentences[:-MAX_KEPT]

    def warn_once(self, topic: str, sentence: str) -> None:
        """Warn about a topic, the first time only."""
        if topic not in self._told:
            self._told.add(topic)
            self.add(WarningText(sentence))

    def warned(self, topic: str) -> bool:
        """Return whether a topic was warned about."""
        return topic in self._told

    def error(self, sentence: str) -> None:
        """Report why no positions are possible until something is fixed."""
        self.add(ErrorText(sentence))

    def drain(self) -> list[str]:
        """Return the sentences and clear them."""
        taken = self.sentences.copy()
        self.sentences.clear()  # in place: another one may share them
        return taken

    def join(self, other: Events) -> None:
        """Forget everything, and say in another's name from now on."""
        self.sentences, self.counts, self._told = other.sentences, other.counts, other._told
