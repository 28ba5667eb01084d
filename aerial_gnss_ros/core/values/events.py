# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sentences for the log: what a user wants to be told once."""

from __future__ import annotations

from collections import Counter

MAX_KEPT = 200


class WarningText(str):
    """A sentence of something that a user should mend: nodes log it as a warning."""

    __slots__ = ()


class ErrorText(WarningText):
    """A sentence of what no position can be given with: nodes log it as an error."""

    __slots__ = ()


class Events:
    """Collects sentences until somebody takes them; the oldest go when nobody does.

    Attributes:
        sentences: that nobody took yet.
        counts: how often what has a name happened since the start, for diagnostics.
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
        """Warn of something about a topic, the first time only."""
        if topic not in self._told:
            self._told.add(topic)
            self.add(WarningText(sentence))

    def error(self, sentence: str) -> None:
        """Say why no position can be given until something is mended."""
        self.add(ErrorText(sentence))

    def drain(self) -> list[str]:
        """Return the sentences and forget them."""
        taken, self.sentences = self.sentences, []
        return taken
