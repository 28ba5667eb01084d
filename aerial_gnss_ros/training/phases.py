# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The curriculum: first images with one robot, then images with several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.training.inspection import Example

# Number of robots in the images of a phase. Images without robots are in every phase, as negatives.
SHOWS: dict[str, str] = {
    "single": "one robot or none",
    "several": "several robots or none",
    "all": "any number of robots",
}
MOST_HOURS = 10_000


@dataclass(frozen=True)
class Phase:
    """A part of a training.

    Attributes:
        shows: key of SHOWS.
        epochs: passes over its images; 0: as many as fit into `hours`.
        hours: time for it, if not 0.
    """

    shows: str
    epochs: int
    hours: float = 0.0

    @property
    def words(self) -> str:
        """Content of its images, in words."""
        return SHOWS[self.shows]

    def holds(self, example: Example) -> bool:
        """Return whether an image belongs to the phase."""
        robots = len(example.boxes)
        if self.shows == "single":
            return robots <= 1
        return robots != 1 if self.shows == "several" else True


def plan_phases(epochs: Sequence[int], one_phase: bool) -> tuple[Phase, ...]:
    """Return the paper's two phases, or one over all images.

    Args:
        epochs: of both phases; with `one_phase` they add up.
        one_phase: no curriculum.

    Raises:
        ConfigError: wrong numbers of epochs.
    """
    for count in epochs:
        if not 1 <= count <= 100_000:
            raise ConfigError(f"each of --epochs must lie within 1 to 100000, not {count}.")
    if one_phase:
        return (Phase("all", sum(epochs)),)
    if len(epochs) != 2:
        raise ConfigError(
            f"the curriculum has two phases, but --epochs gives {len(epochs)} number; give two, "
            "such as 100,100, or --one-phase."
        )
    return (Phase("single", epochs[0]), Phase("several", epochs[1]))


def timed_phase(hours: float) -> tuple[Phase, ...]:
    """Return one phase over all images, for a given time.

    Raises:
        ConfigError: an invalid time.
    """
    if not 0.0 < hours <= MOST_HOURS:
        raise ConfigError(f"--time must be above 0 and at most {MOST_HOURS} hours, not {hours:g}.")
    return (Phase("all", 0, hours),)


def members(phase: Phase, examples: Sequence[Example]) -> list[Example]:
    """Return the images of a phase.

    Raises:
        ConfigError: none of them shows a robot.
    """
    chosen = [example for example in examples if phase.holds(example)]
    if not any(len(example.boxes) for example in chosen):
        robots = {"single": "exactly one robot", "several": "several robots", "all": "any robot"}
        raise ConfigError(
            f"none of the {len(examples)} training images shows {robots[phase.shows]}; add such "
            "images, or train without the curriculum (train --one-phase)."
        )
    return chosen
