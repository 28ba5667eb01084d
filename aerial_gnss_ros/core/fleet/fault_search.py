# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Finds out which drone is wrong: by the filter's own state, or where drones contradict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.fault import TUNING as FAULT
from aerial_gnss_ros.core.fleet.fault import (
    Fault,
    Suspicion,
    culprit,
    log_ratio,
    suspects,
    suspicions,
)
from aerial_gnss_ros.core.fleet.fault_trial import Trial, trials
from aerial_gnss_ros.core.fleet.robots import FleetRobot
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.fleet.snapshot import Snapshot
from aerial_gnss_ros.core.models.platform_model import COUNT

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FaultSearchTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    every_s: float = 0.5
    """How often faults are sought, s: the errors that tell them change more slowly. Judged."""
    sure_s: float = 1.0
    """Time for which a fault must be sure, s. Judged."""
    rest: float = 1.5
    """Factor by which the time between two trials grows while none convinces: each costs up to some
    tenths of a second. Judged."""
    longest_s: float = 10.0
    """Longest time between two trials, s. Judged."""
    contradicted_s: float = 0.5
    """Time for which drones must contradict each other before a trial, s. Judged."""
    least_pairs: int = 2
    """Least number of robots on which drones must agree under a fault: a single one agrees under
    many."""
    fresh_s: float = 0.5
    """Greatest age of an image in a trial, s: robots move. Judged."""
    over: float = 0.5
    """Probability below which a fault is taken back. Judged."""


TUNING = FaultSearchTuning()


@dataclass(frozen=True)
class Found:
    """A drone that is wrong.

    Attributes:
        drone: its number.
        fault: what is wrong.
        trial: under which the drones agree; None if the filter's own state shows the fault, and so
            has followed it.
    """

    drone: int
    fault: Fault
    trial: Trial | None = None


class FaultSearch:
    """Weighs faults of drones.

    Args:
        drones: of the fleet, by number.
        speed: one sigma of a robot's velocity, each axis, m/s.
    """

    def __init__(self, drones: list[Drone], speed: float) -> None:
        self._drones, self._speed = drones, speed
        self._weighed_ns: int | None = None
        self._since: dict[tuple[int, bool], int] = {}
        self._suspected_ns: dict[int, int] = {}
        self._tried_ns, self._pause_s = 0, TUNING.every_s

    def update(self, state: SharedState, robots: list[FleetRobot], now_ns: int) -> Found | None:
        """Return a drone that has turned out to be wrong.

        Args:
            state: the filter.
            robots: of the fleet.
            now_ns: time of the last scene, ns.
        """
        due = self._weighed_ns is None or now_ns - self._weighed_ns >= TUNING.every_s * 1e9
        if len(self._drones) < 2 or not due:
            return None
        self._weighed_ns = now_ns
        stationary = [one.stationary for one in self._drones]
        self._take_back(state, stationary)
        if any(one.fault is not None for one in self._drones):
            self._suspect([], now_ns)
            return None  # what the others show then has one cause
        suspected = suspicions(state, stationary)
        self._suspect(suspected, now_ns)
        found = culprit(suspected)
        if found is not None and self._lasts(found.drone, False, now_ns):
            return Found(found.drone, found.fault)
        if self._contradicted(robots, now_ns):
            return self._by_trial(stationary, now_ns)
        self._pause_s = TUNING.every_s
        return None

    def _suspect(self, suspected: list[Suspicion], now_ns: int) -> None:
        """Note which drones have been suspected for some time: one of them probably is wrong."""
        wrong = suspects(suspected, FAULT.probably)
        self._suspected_ns = {one: self._suspected_ns.get(one, now_ns) for one in sorted(wrong)}
        for number, one in enumerate(self._drones):
            since_ns = self._suspected_ns.get(number, now_ns)
            one.suspected = now_ns - since_ns >= TUNING.sure_s * 1e9

    def _by_trial(self, stationary: list[Array], now_ns: int) -> Found | None:
        """Return the drone whose fault makes the last images agree."""
        if now_ns - self._tried_ns < self._pause_s * 1e9:
            return None
        snapshots = self._snapshots(now_ns)
        if len(snapshots) < 2:
            return None
        self._tried_ns = now_ns
        trial = self._try(snapshots, stationary)
        if trial is None:
            self._pause_s = min(TUNING.rest * self._pause_s, TUNING.longest_s)
            return None
        self._pause_s = TUNING.every_s
        if self._lasts(trial.suspicion.drone, True, now_ns):
            return Found(trial.suspicion.drone, trial.suspicion.fault, trial)
        return None

    def _lasts(self, drone: int, tried: bool, now_ns: int) -> bool:
        """Return whether a drone has been found to be wrong in the same way for some time."""
        since_ns = self._since.get((drone, tried), now_ns)
        self._since = {(drone, tried): since_ns}
        if now_ns - since_ns > 2e9 * max(TUNING.sure_s, self._pause_s):
            self._since, since_ns = {(drone, tried): now_ns}, now_ns
        return now_ns - since_ns >= TUNING.sure_s * 1e9

    def _take_back(self, state: SharedState, stationary: list[Array]) -> None:
        """Take back a fault that the data no longer show."""
        for number, one in enumerate(self._drones):
            if one.fault is None:
                continue
            mean, covariance = state.platforms()
            columns = [COUNT * number + k for k in one.fault.columns]
            less = -(one.fault.sigma**2)
            ratio = log_ratio(mean, covariance, state.prior(stationary), columns, less)
            if 1.0 / (1.0 + np.exp(min(ratio, 50.0))) < TUNING.over:
                one.fault = None

    def _contradicted(self, robots: list[FleetRobot], now_ns: int) -> bool:
        """Return whether drones contradict each other."""
        patience_ns = TUNING.contradicted_s * 1e9
        rivals = any(
            robot.rival is not None and now_ns - robot.rival_ns >= patience_ns for robot in robots
        )
        return rivals or any(one.agreement.disagrees for one in self._drones)

    def _snapshots(self, now_ns: int) -> dict[int, Snapshot]:
        """Return the last images of all drones that see robots, by number."""
        snapshots = {}
        for number, one in enumerate(self._drones):
            if one.last is None or not one.recent(now_ns, TUNING.fresh_s):
                continue
            labels = [label for label in one.last.labels if label]
            if labels:
                snapshots[number] = Snapshot(one, labels)
        return snapshots

    def _try(self, snapshots: dict[int, Snapshot], stationary: list[Array]) -> Trial | None:
        """Return the fault under which the drones' last images agree, if one surely is."""
        tried = trials(snapshots, stationary, self._speed)
        found = culprit([one.suspicion for one in tried])
        if found is None:
            return None
        trial = next(one for one in tried if one.suspicion is found)
        agreed = {label for label, _, _ in trial.matched}
        return trial if len(agreed) >= TUNING.least_pairs else None
