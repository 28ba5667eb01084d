# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Drives the fleet's estimator with one recording for each drone.

Each recording is replayed by its drone's own estimator first; what that sees is then given to the
fleet in the order of the scenes' times. The recordings' stamps must be of one clock.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial

from aerial_gnss_ros.bags.drone_tables import DroneTables
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.bags.replay import Replay, Summary
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.fleet.fleet import Fleet, refuse_unable
from aerial_gnss_ros.core.fleet.publication import FleetUpdate
from aerial_gnss_ros.core.fleet.sighting import Sighting, SightingTap
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.tracker.protocol import Tracking
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.text.sentences import counted


@dataclass(frozen=True)
class _Image:
    """One image of one drone: what its own estimator gave, and what it tells the fleet."""

    scene_ns: int
    drone: str
    result: FrameResult
    sighting: Sighting | None


class DronesReplay:
    """One pass over a recording of each of several drones.

    Args:
        bags: open, by the drone's name.
        configs: of the drones' estimators.
        detector_config: names the image topic; `load` loads the model only if needed.
        load: creates the detector.
        namespaces: that relative topics of each drone were recorded in; empty of others.
        detect: run the detector even if a bag has detections.
        share: prior share of the receivers' variance that is common.

    Attributes:
        method: filter.
        summary: counts; complete when `results` is exhausted.
        tables: of the drones, likewise.

    Raises:
        ConfigError: a configuration asks for what a fleet cannot do.
        InputError: a topic is missing or has another type.
        ModelError: the model is unusable.
    """

    method = "filter"

    def __init__(
        self,
        bags: Mapping[str, BagReader],
        configs: Mapping[str, EstimatorConfig],
        detector_config: DetectorConfig,
        load: Callable[[DetectorConfig], Detector],
        *,
        namespaces: Mapping[str, str] | None = None,
        detect: bool = False,
        share: float = 0.5,
    ) -> None:
        self.summary = Summary()
        self.tables = DroneTables()
        self._share = share
        self._configs = dict(configs)
        self._taps: dict[str, SightingTap] = {}
        self._replays: dict[str, Replay] = {}
        for name, bag in bags.items():
            config = configs[name]
            refuse_unable(name, config)
            # The fleet has no use for which robots a drone holds to stay.
            tracks = replace(config.tracks, find_moored=False)
            estimator = Estimator(replace(config, state_file="", tracks=tracks))
            estimator.wrap_tracking(partial(self._tapped, name))
            with _named(name):
                self._replays[name] = Replay(
                    bag, config, detector_config, load,
                    namespace=(namespaces or {}).get(name, ""), detect=detect, estimator=estimator,
                )  # fmt: skip
        sources = {one.summary.detections_from for one in self._replays.values()}
        self.summary.detections_from = " and ".join(sorted(sources))

    def _tapped(self, name: str, tracker: Tracking) -> SightingTap:
        assert isinstance(tracker, Tracker)  # noqa: S101 - the default one
        tap = self._taps.setdefault(name, SightingTap(tracker))
        tap.follow(tracker)
        return tap

    @property
    def message_count(self) -> int:
        """Number of messages to read."""
        return sum(one.message_count for one in self._replays.values())

    def results(
        self, on_message: Callable[[int], None] = lambda _done: None
    ) -> Iterator[FrameResult]:
        """Yield one result for each time of an image, in order.

        Args:
            on_message: called with the number of messages read so far.

        Raises:
            InputError: a bag is damaged, no image of any drone has a pose, two recordings are of
                one drone, or the drones have not flown at one place and time.
        """
        images: list[_Image] = []
        datum, done = None, 0
        for name, replay in self._replays.items():
            found = list(replay.results(partial(_counted, on_message, done)))
            done += replay.message_count
            datum = datum or next((one.datum for one in found if one.datum is not None), None)
            images += self._images(name, found)
            self._note(name, replay.summary)
        if datum is None:
            raise InputError("no image of any drone has a camera pose: there is nothing to join.")
        local = LocalMap(datum)
        limits = {name: one.limits.origin_distance_m for name, one in self._configs.items()}
        refuse_one_flight(images)
        refuse_apart(images, local, limits)
        fleet = Fleet(self._configs, local, self._share)
        images.sort(key=lambda one: (one.scene_ns, one.drone))
        same: list[_Image] = []
        for image in images:
            if same and image.result.stamp_ns != same[0].result.stamp_ns:
                yield self._joined(fleet, same, datum)
                same = []
            same.append(image)
        if same:
            yield self._joined(fleet, same, datum)
        self._conclude()

    def _images(self, name: str, results: list[FrameResult]) -> list[_Image]:
        """Return a drone's images with their sightings."""
        sightings = {one.stamp_ns: one for one in self._taps[name].drain()}
        latency_ns = round(self._configs[name].camera.latency_s * 1e9)
        found = []
        for result in results:
            seen = sightings.get(result.stamp_ns)
            scene_ns = result.stamp_ns - latency_ns if seen is None else seen.pose.stamp_ns
            found.append(_Image(scene_ns, name, result, seen))
        return found

    def _joined(self, fleet: Fleet, images: list[_Image], datum: MapDatum) -> FrameResult:
        """Return the result of all images with one stamp."""
        update: FleetUpdate | None = None
        pose = None
        for image in images:
            if image.sighting is not None:
                update = fleet.update(image.drone, image.sighting)
                self.tables.add(update, image.sighting)
                self.summary.notes += update.notes
                first = image.drone == next(iter(self._replays))
                pose = image.sighting.pose if first else pose  # the path that maps show
        own = [image.result for image in images]
        result = FrameResult(
            own[0].stamp_ns,
            own[0].frame_id,
            update.estimates if update is not None else (),
            tuple(one for result in own for one in result.rejections),
            datum,
            pose,
            platform=update.platform if update is not None else (),
            boxes=sum(result.boxes for result in own),
            used=sum(result.used for result in own),
            late=tuple(one for result in own for one in result.late),
        )
        self.summary.add(result)
        return result

    def _note(self, name: str, own: Summary) -> None:
        """Take over what a drone's own replay says."""
        self.summary.images_refused += own.images_refused
        self.summary.images_dropped.update(own.images_dropped)
        self.summary.interval_s = max(self.summary.interval_s, own.interval_s)
        self.summary.notes += [f"Drone {name}: {note}" for note in own.notes]

    def _conclude(self) -> None:
        """Say where drones disagree, or share nothing."""
        reports = self.tables.reports
        last = {report.drone: report for report in reports}
        faults = Counter((one.drone, one.fault) for one in reports if one.fault)
        self.summary.notes += [
            f"Drone {name}: the {fault} is wrong by far more than it states, in "
            f"{counted(images, 'image')}; the filter allows for it."
            for (name, fault), images in sorted(faults.items())
        ]
        disagreed = Counter(one.drone for one in reports if one.disagrees and not one.fault)
        self.summary.notes += [
            f"Drone {name} contradicts the others in {counted(images, 'image')}: a compass, a "
            "gimbal, a receiver or the clock of one of them may be wrong."
            for name, images in sorted(disagreed.items())
        ]
        self.summary.notes += [
            f"Drone {name}: {report.clock.words}, by robots that move; the filter allows for it. "
            "Set clocks by GNSS or NTP."
            for name, report in sorted(last.items())
            if report.clock.said
        ]
        alone = sorted(last.keys() - self._together())
        if len(last) > 1 and alone:
            self.summary.notes.append(
                f"No robot of {counted(len(alone), 'drone')} ({', '.join(alone)}) was found to be "
                "another drone's: each is as if flown alone. If they saw the same robots, their "
                "clocks differ by more than some tenths of a second, or a sensor is far off."
            )

    def _together(self) -> set[str]:
        """Return the drones that have had a robot in common with another one."""
        drones: dict[str, set[str]] = {}
        for name, drone, _ in self.tables.names:
            drones.setdefault(name, set()).add(drone)
        return {drone for known in drones.values() if len(known) > 1 for drone in known}


def refuse_one_flight(images: Sequence[_Image]) -> None:
    """Refuse a recording that is given twice: errors of one drone would count as those of two.

    Args:
        images: of all drones.

    Raises:
        InputError: two drones were at exactly one place at exactly one time.
    """
    drones: dict[tuple[int, float, float], str] = {}
    for image in images:
        if image.sighting is None:
            continue
        pose = image.sighting.pose
        other = drones.setdefault((pose.stamp_ns, pose.latitude, pose.longitude), image.drone)
        if other != image.drone:
            raise InputError(
                f"the recordings of {other} and {image.drone} are of one drone: it was in the same "
                "place at the same time. Give one of each drone."
            )


def refuse_apart(images: Sequence[_Image], local: LocalMap, limits: Mapping[str, float]) -> None:
    """Refuse drones that have not flown at one place and time.

    Args:
        images: of all drones.
        local: the frame `map`.
        limits: greatest distance from its origin by drone, m.

    Raises:
        InputError: says which drone, and how far off.
    """
    spans: dict[str, tuple[int, int]] = {}
    for image in images:
        if image.sighting is None:
            continue
        pose, stamp_ns = image.sighting.pose, image.scene_ns
        began_ns, ended_ns = spans.get(image.drone, (stamp_ns, stamp_ns))
        spans[image.drone] = min(began_ns, stamp_ns), max(ended_ns, stamp_ns)
        place = local.positions([pose.latitude], [pose.longitude])[0]
        far = math.hypot(*place.tolist())
        most = limits[image.drone]
        if far > most:
            raise InputError(
                f"drone {image.drone} is {far / 1000.0:.0f} km from the origin of map "
                f"(limits.origin_distance_m: {most / 1000.0:g} km): drones of one site are joined."
            )
    for name, (began_ns, ended_ns) in spans.items():
        others = [span for other, span in spans.items() if other != name]
        if others and not any(began_ns <= end and start <= ended_ns for start, end in others):
            gap = min(max(start - ended_ns, began_ns - end) for start, end in others)
            raise InputError(
                f"the recording of drone {name} is {gap * 1e-9:.0f} s apart from those of the "
                "others: all stamps must be of one clock."
            )


@contextmanager
def _named(drone: str) -> Iterator[None]:
    """Say of which drone something is wrong, and which option is that of one drone."""
    try:
        yield
    except InputError as error:
        words = str(error).replace(" --namespace ", f" --drone-namespace {drone}=")
        raise InputError(f"drone {drone}: {words}") from error


def _counted(on_message: Callable[[int], None], before: int, read: int) -> None:
    """Report messages of one bag as those of all."""
    on_message(before + read)
