# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tracks robots in the image plane, to keep their labels.

An image without a pose gives no position, but its boxes still show which robot went where. They are
linked from image to image (`image_links`), from the last image that updated robots to the first
ones with a pose again. Each point has label probabilities, which each link mixes by the
probabilities of its assignments, so that ambiguity accumulates. The result is evidence for
re-identification, beside positions, and for the assignment of boxes while poses are so uncertain
that it is in doubt; positions are never derived from it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.image_history import Seen, detection_rates
from aerial_gnss_ros.core.association.image_labels import (
    LabelEvidence,
    Point,
    label_probabilities,
    labels_of,
    once_each,
    scaled,
)
from aerial_gnss_ros.core.association.image_links import Links, links
from aerial_gnss_ros.core.association.image_motion import (
    CHANGE,
    Motion,
    by_motion,
    fitted,
    in_picture,
    moved,
    on_plane,
)
from aerial_gnss_ros.core.association.image_motion import TUNING as IMAGE_MOTION
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.models.evidence import TUNING as EVIDENCE
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ImageTracksTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    steady_s: float = 0.3
    """Time constant over which the rates of the image's motion are averaged, s. Judged."""
    history_s: float = 1.0
    """Time for which images with a pose are kept, and after which an undetected point is dropped,
    s. Judged."""
    missed_images: int = 3
    """Least number of images for which an undetected point is kept. Judged."""
    link_s: float = 2.0
    """Greatest time between images that are linked, s. Judged."""
    again_s: float = 1.0
    """Time after the last image without a pose during which new tracks get evidence, s. Judged."""
    most_points: int = 32
    """Points or detections beyond which nothing is tracked, because of clutter. Judged."""
    real_probability: float = 0.5
    """Probability that an unexpected detection is an object that will be detected again. Judged."""


TUNING = ImageTracksTuning()


class ImageTracks:
    """Tracks boxes in the image plane.

    Args:
        pixel_sigma: one sigma of a box's centre, px.
        speed_sigma: of an unknown velocity of a robot, each axis, m/s.

    Attributes:
        blind_ns: stamp of the last image without a pose, ns; None while there are poses.
    """

    def __init__(self, pixel_sigma: float, speed_sigma: float) -> None:
        self._pixel_sigma = pixel_sigma
        self._speed_sigma = speed_sigma
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self._history: deque[Seen] = deque()
        self._points: list[Point] = []
        self._rates = np.zeros(6)
        self._stamp_ns = 0
        self.blind_ns: int | None = None
        self._known: tuple[str, ...] = ()

    def measured(
        self, frame: DetectionFrame, camera: CameraModel, height: float, named: dict[int, str]
    ) -> dict[int, LabelEvidence]:
        """Record an image whose boxes updated robots.

        Args:
            frame: its boxes.
            camera: lens and image size.
            height: of the camera above the water, m.
            named: by box, the label of the robot that it updated.

        Returns:
            Evidence for the other boxes, by box, if recent images had no pose.
        """
        stamp_ns, labels = frame.stamp_ns, {}
        if self.blind_ns is not None:
            labels = self.followed(frame, blind=False)
            if stamp_ns - self.blind_ns > TUNING.again_s * 1e9:
                self.blind_ns, self._points = None, []
            else:
                self._name(named)
        history = self._history
        history.append(Seen(stamp_ns, frame.centers, frame.class_ids, named, camera, height))
        while stamp_ns - history[0].stamp_ns > TUNING.history_s * 1e9:
            history.popleft()
        return {i: one for i, one in labels.items() if i not in named} if labels else labels

    def keep_labels(self, names: set[str]) -> None:
        """Drop all labels except these: points with a dropped label may be any robot."""
        if self.blind_ns is None or names.issuperset(self._known):
            return
        self._known = tuple(name for name in self._known if name in names)
        self._points = [
            one._replace(names={name: p for name, p in one.names.items() if name in names})
            for one in self._points
        ]

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        self._known = tuple(names.get(name, name) for name in self._known)
        self._points = [
            one._replace(names={names.get(name, name): p for name, p in one.names.items()})
            for one in self._points
        ]
        self._history = deque(
            one._replace(named={i: names.get(name, name) for i, name in one.named.items()})
            for one in self._history
        )

    def expected(self, frame: DetectionFrame) -> dict[int, LabelEvidence]:
        """Return the evidence of the images before for an image's boxes.

        Args:
            frame: its boxes; `measured` or `followed` come next.
        """
        if self.blind_ns is None and len(frame) > TUNING.most_points:
            return {}
        return self.followed(frame, blind=False)

    def followed(self, frame: DetectionFrame, blind: bool = True) -> dict[int, LabelEvidence]:
        """Process an image whose boxes updated no robot; return the evidence for its boxes.

        Args:
            frame: its boxes.
            blind: whether it updated no robot.
        """
        if not self._history or (self.blind_ns is None and not len(frame)):
            return {}
        if self.blind_ns is None:
            self._begin()
        if blind and len(frame):
            self.blind_ns = frame.stamp_ns
        if frame.stamp_ns != self._stamp_ns:
            self._follow(frame)
        return labels_of(self._points[: len(frame)], self._known)

    def _begin(self) -> None:
        """Start from the last image that updated robots."""
        last = self._history[-1]
        places = {name: (seen, i) for seen in self._history for i, name in seen.named.items()}
        self._rates = self._first_rates()
        self._stamp_ns = last.stamp_ns
        self._known = tuple(places)
        own = [i for i in range(len(last.centers)) if i not in last.named]
        found: list[tuple[Seen, int, dict[str, float]]] = [(last, i, {}) for i in own]
        found += [(seen, i, {name: 1.0}) for name, (seen, i) in places.items()]
        self._points = []
        for seen, i, names in found:
            (place,) = on_plane(seen.centers[i : i + 1], seen.camera)
            passed = (last.stamp_ns - seen.stamp_ns) * 1e-9
            (place,) = moved(place[None], Motion(passed * self._rates, np.zeros((6, 6))))
            one = Point((place[0], place[1]), seen.class_ids[i], names, seen.stamp_ns)
            self._points.append(one)

    def _first_rates(self) -> Array:
        """Return the motion's rates (6,) over the last images with a pose, 1/s."""
        last = self._history[-1]
        at = {name: i for i, name in last.named.items()}
        for seen in self._history:
            passed = (last.stamp_ns - seen.stamp_ns) * 1e-9
            both = [(i, at[name]) for i, name in seen.named.items() if name in at]
            if not both or passed <= 0.0:
                continue
            before = on_plane(seen.centers[[i for i, _ in both]], seen.camera)
            after = on_plane(last.centers[[i for _, i in both]], last.camera)
            expected = Motion(np.zeros(6), passed**2 * CHANGE)
            return fitted(before, after, self._variances(before, passed), expected).mean / passed
        return np.zeros(6)

    def _variances(self, places: Array, passed: Array | float) -> Array:
        """Return the variance (n,) of the own motion of points (n, 2), each axis.

        Noise of both boxes, motion of the robots, and the deviation of the image's motion from an
        affine one, which grows with the squared distance from the axis.
        """
        last = self._history[-1]
        box = self._pixel_sigma / float(last.camera.K[0, 0])
        own = self._speed_sigma * np.asarray(passed) / max(last.height, 1.0)
        bent = IMAGE_MOTION.rate_change_sigma * np.asarray(passed) * (places**2).sum(axis=1)
        variances: Array = 2.0 * box**2 + own**2 + bent**2
        return variances

    def _follow(self, frame: DetectionFrame) -> None:
        """Link the points to an image's boxes."""
        passed = (frame.stamp_ns - self._stamp_ns) * 1e-9
        self._stamp_ns = frame.stamp_ns
        if (
            passed <= 0.0
            or passed > TUNING.link_s
            or max(len(self._points), len(frame)) > TUNING.most_points
        ):
            self._points = []
            if len(frame) > TUNING.most_points:
                return
        camera = self._history[-1].camera
        found = on_plane(frame.centers, camera)
        places = np.array([one.place for one in self._points]).reshape(-1, 2)
        unseen = np.array([(frame.stamp_ns - one.seen_ns) * 1e-9 for one in self._points])
        spread = np.array([one.spread for one in self._points])
        detected, density = detection_rates(self._history)
        linked = links(
            places,
            found,
            self._variances(places, unseen) + spread,
            Motion(passed * self._rates, passed**2 * CHANGE),
            np.array([[one.class_id == name for name in frame.class_ids] for one in self._points],
                     dtype=bool).reshape(len(self._points), len(frame)),
            detected * np.array([one.there for one in self._points]),
            density,
        )  # fmt: skip
        if self._points:
            gain = 1.0 - np.exp(-passed / TUNING.steady_s)
            self._rates = self._rates + gain * (linked.motion.mean / passed - self._rates)
        hits = label_probabilities(self._points, linked.chances)
        missed = self._missed(linked, places, detected, passed)
        scale = once_each(self._points, self._known, [*hits, *(one.names for one in missed)])
        claimed = linked.chances.sum(axis=0)
        self._points = [
            Point((x, y), frame.class_ids[j], scaled(hits[j], scale), frame.stamp_ns,
                  there=float(claimed[j] + (1.0 - claimed[j]) * TUNING.real_probability))
            for j, (x, y) in enumerate(found.tolist())
        ]  # fmt: skip
        self._points += [one._replace(names=scaled(one.names, scale)) for one in missed]

    def _missed(self, linked: Links, places: Array, detected: float, passed: float) -> list[Point]:
        """Return points that the image may have missed, at their predicted positions.

        The probability that a point exists decreases with each missed detection.
        """
        camera = self._history[-1].camera
        patience_ns = max(TUNING.history_s, TUNING.missed_images * passed) * 1e9
        after, by = moved(places, linked.motion), by_motion(places)
        found = []
        for i, one in enumerate(self._points):
            left = max(0.0, 1.0 - float(linked.chances[i].sum()))
            left *= (1.0 - detected) / (1.0 - detected * one.there)
            x, y = after[i].tolist()
            gone = self._stamp_ns - one.seen_ns > patience_ns or not in_picture(x, y, camera)
            if gone or left * one.there < EVIDENCE.forgotten:
                continue
            unsure = 0.5 * float(np.trace(by[i] @ linked.motion.covariance @ by[i].T))
            found.append(one._replace(
                place=(x, y), names=scaled(one.names, dict.fromkeys(one.names, left)),
                spread=one.spread + unsure, there=left * one.there,
            ))  # fmt: skip
        return found

    def _name(self, named: dict[int, str]) -> None:
        """Set the labels of boxes that updated robots."""
        sure = set(named.values())
        self._known = tuple(dict.fromkeys((*self._known, *sure)))
        for index, one in enumerate(self._points):
            names = {name: p for name, p in one.names.items() if name not in sure}
            if index in named:
                names = {named[index]: 1.0}
            self._points[index] = one._replace(names=names)
