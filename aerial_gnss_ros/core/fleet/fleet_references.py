# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""References of a fleet: what one drone sees of known position corrects the robots of all.

The decisions and the correction are those of a single drone (`core.references`), by the joint
Gaussian of all drones' errors and all robots.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.filter.moored_law import MooredLaw
from aerial_gnss_ros.core.filter.state import JointState
from aerial_gnss_ros.core.filter.state_arrays import Indices
from aerial_gnss_ros.core.fleet.common_share import CommonShare
from aerial_gnss_ros.core.fleet.drone import Drone
from aerial_gnss_ros.core.fleet.robots import FleetRobot
from aerial_gnss_ros.core.fleet.shared_state import SharedState
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.label_format import class_token
from aerial_gnss_ros.core.models.platform_model import GNSS
from aerial_gnss_ros.core.references.candidates import Expected, below_camera
from aerial_gnss_ros.core.references.position_law import PositionLaw
from aerial_gnss_ros.core.references.references import References
from aerial_gnss_ros.core.telemetry.reference_places import ReferencePlaces
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.reference_place import ReferencePlace

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FleetReferencesTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    waits_s: float = 2.5
    """Time for which a reference that moves stays bound to its robot between images of the drones
    that hear its fixes, s: as long as fixes are interpolated. Judged."""
    shown_s: float = 1.0
    """Time for which a drone's last image counts as showing a reference, s. Judged."""


TUNING = FleetReferencesTuning()


class FleetSource:
    """What a fleet estimates without references (see `Source`).

    Args:
        drones: of the fleet.
        state: the filter.
        share: of the receivers' variance that is common.
    """

    def __init__(self, drones: list[Drone], state: SharedState, share: CommonShare) -> None:
        self._drones, self.state, self._share = drones, state, share

    @property
    def laws(self) -> list[PositionLaw]:
        """All robots."""
        rows: Indices = self.state.joint.rows
        return [PositionLaw(rows, *self.state.ordered())]

    @property
    def stationary(self) -> Array:
        """(9 N, 9 N) covariance of all errors when nothing is known."""
        return self.state.prior([one.stationary for one in self._drones])

    @property
    def believed(self) -> Array:
        """(2 N,) sums of the accepted jumps, m."""
        nothing = np.zeros(GNSS.stop - GNSS.start)
        return np.concatenate(
            [nothing if one.last is None else one.last.believed for one in self._drones]
        )

    def decay(self, seconds: float) -> Array:
        """Return the factors (9 N,) by which the errors decay over a time."""
        return np.concatenate([one.model.decay(seconds) for one in self._drones])

    def final(self, law: PositionLaw) -> PositionLaw:
        """Return a law by all shares that receivers may have in common."""
        return self._share.weighed(law, [one.stationary for one in self._drones])


class FleetReferences:
    """Objects of known position that any drone sees.

    What stays is known by the drones' configurations, what moves by their sightings.

    Args:
        drones: of the fleet.
        staying: references that stay, by drone, see `staying_references`.
        state: the filter at the beginning.
        share: of the receivers' variance that is common.

    Attributes:
        log: what becomes of each reference, until it is drained.
    """

    def __init__(
        self, drones: list[Drone], staying: tuple[ReferencePlace, ...], state: SharedState,
        share: CommonShare,
    ) -> None:  # fmt: skip
        self._drones, self._staying = drones, staying
        self._source = FleetSource(drones, state, share)
        self.log = Events()
        self._references = References(self._source, self.log)
        self._shifts: dict[str, dict[int, Expected]] = {}
        self._heard: dict[str, int] = {}
        self._corrects = False

    def reset(self) -> None:
        """Forget everything but what was said: the filter has begun anew."""
        self._references.reset()

    def update(
        self, robots: list[FleetRobot], drone: int, seen: Sighting, state: SharedState,
        local: LocalMap,
    ) -> None:  # fmt: skip
        """Decide again which robots are references, after the filter's update by an image.

        Args:
            robots: of the fleet.
            drone: number of the image's drone.
            seen: its sighting.
            state: the filter.
            local: the frame `map`.
        """
        self._source.state = state
        now_ns = seen.pose.stamp_ns
        for one in seen.references:
            self._heard[one.name] = now_ns
        if not self._staying and not self._heard:
            return
        moving, staying = (
            below_camera(places, seen.pose, self.log) for places in (seen.references, self._staying)
        )
        expected = [self._expected(one, drone, seen, local) for one in staying]
        expected += [Expected.of(one, seen.pose, local) for one in moving]
        waiting = {
            name for name, heard_ns in self._heard.items()
            if now_ns - heard_ns <= TUNING.waits_s * 1e9
        } - {one.name for one in seen.references}  # fmt: skip
        self._references.update(robots, expected, now_ns, waiting)

    def apply(
        self, robots: list[FleetRobot], mean: Array, blocks: Array, state: SharedState,
        now_ns: int,
    ) -> tuple[Array, Array]:  # fmt: skip
        """Correct robots' states; return all drones' errors and their covariance.

        Args:
            robots: of the fleet.
            mean: (n, 4) of all robots, changed in place, m, m/s.
            blocks: (n, 4, 4) their covariances, likewise.
            state: the filter.
            now_ns: time of the last scene, ns.
        """
        self._source.state = state
        if not robots:
            return state.platforms()
        told = self._references.apply(robots, mean, blocks, now_ns)
        self._corrects = told is not None
        if told is None:
            law = self._source.final(self._source.laws[0])
            mean[law.rows], blocks[law.rows] = law.states()
            told = law.mean[: law.errors], law.covariance[: law.errors, : law.errors]
        return told

    def published(self, law: MooredLaw, base: JointState) -> tuple[Array, Array]:
        """Return states (n, 4) and covariances of the robots of a law in which some stay.

        After `apply`, corrected as that does.

        Args:
            law: in which some robots stay.
            base: the filter's, in which all swim.
        """
        if self._corrects:
            return self._references.published(law, base)
        return self._source.final(PositionLaw(law.rows, *law.jointly_published())).states()

    def _expected(
        self, place: ReferencePlace, drone: int, seen: Sighting, local: LocalMap
    ) -> Expected:
        """Return where the drones show a reference that stays.

        What stands out of the water appears at another place to each of them: the robot lies
        somewhere between these places.
        """
        now_ns, shown = seen.pose.stamp_ns, self._shifts.setdefault(place.name, {})
        here = Expected.of(place, seen.pose, local)
        token = class_token(place.class_id)
        if token in map(class_token, seen.class_ids):
            shown[drone] = here
        last = {k: self._drones[k].last for k in shown}
        fresh = [
            one for k, one in shown.items()
            if (before := last[k]) is not None
            and now_ns - before.pose.stamp_ns <= TUNING.shown_s * 1e9
        ]  # fmt: skip
        every = fresh or [*shown.values()] or [here]
        places = np.array([one.position for one in every])
        apart = places - places.mean(axis=0)
        spread = place.covariance + apart.T @ apart / len(every)
        return replace(here, position=places.mean(axis=0), spread=spread)


def staying_references(drones: Iterable[Drone]) -> tuple[ReferencePlace, ...]:
    """Return the references that stay, of all drones.

    Where two drones state one name differently, each is a reference of its own: that which the data
    contradict is then left out.
    """
    found: dict[str, ReferencePlace] = {}
    for one in drones:
        for place in ReferencePlaces(one.references).at(0):
            if not place.moves:
                other = found.setdefault(place.name, place)
                if repr(other) != repr(place):
                    name = f"{place.name} of {one.name}"
                    found[name] = replace(place, name=name)
    return tuple(found.values())
