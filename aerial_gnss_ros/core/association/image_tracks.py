# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Follows robots in the picture while images have no pose, so that they keep their names.

An image without a pose gives no position, but its boxes still show which robot went where. They are
followed from image to image (`image_links`), from the last image whose boxes measured robots to the
first ones with a pose again. Each point of the picture has label probabilities: of which robot it
is. Each link mixes them by the probabilities of its assignments, so that the chance of a mix-up
multiplies up, and what cannot be told apart in one image stays so. It is evidence for
re-identification, together with places; positions are never taken from it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ImageTracksTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    steady_s: float = 0.3
    """Time constant over which these rates are averaged, s. Judged."""
    history_s: float = 1.0
    """Images with a pose that are kept, s; and a point that is missed for so long is given up, s.
    Judged."""
    missed_images: int = 3
    """A point that is missed is kept for so many images at least. Judged."""
    link_s: float = 2.0
    """Images farther apart than this are not linked, s. Judged."""
    again_s: float = 1.0
    """For so long after the last image without a pose new tracks get labels, s. Judged."""
    most_points: int = 32
    """Points or detections beyond which nothing is followed: the picture is full of false boxes.
    Judged."""
    least_label_probability: float = 1e-3
    """Probability below which a label is forgotten. Judged."""
    unmodelled_probability: float = 0.01
    """Probability that links have failed in a way that their model does not know. Judged."""
    clearly: float = 0.95
    """Probability from which a detection is one robot, and not another one. Judged."""
    real_probability: float = 0.5
    """Probability that a detection where none was expected is of something that will be seen again.
    Judged."""
    prior_new_boxes: float = 0.1
    """Detections of no known robot in an image, before any image has shown how many. Judged."""
    prior_hits: float = 9.0
    """Detections of known robots that are counted before the first image: nine of ten. Judged."""
    prior_misses: float = 1.0
    """Misses of known robots that are counted before the first image: one of ten. Judged."""


TUNING = ImageTracksTuning()


class Labels(NamedTuple):
    """What the picture says about which robot a detection is: factors of likelihood.

    Attributes:
        names: by name of a robot that was followed.
        others: of any other robot.
    """

    names: dict[str, float]
    others: float

    def factor(self, name: str) -> float:
        """Return the likelihood that it is a robot, but for a common factor."""
        return max(self.names.get(name, self.others), TUNING.unmodelled_probability)

    def contradicts(self, name: str) -> bool:
        """Return whether, of the robots that were followed, it is clearly another one."""
        return (
            self.names.get(name, 1.0) < 1.0 - TUNING.clearly
            and max(self.names.values()) > TUNING.clearly
        )


UNTOLD = Labels({}, 1.0)
"""Nothing is known."""


class Seen(NamedTuple):
    """An image whose boxes measured robots.

    Attributes:
        stamp_ns: of the image.
        centers: (m, 2) of its boxes, px.
        class_ids: of these.
        named: by box, the robot that it measured.
        camera: lens and image size.
        height: of the camera above the water, m.
    """

    stamp_ns: int
    centers: Array
    class_ids: tuple[str, ...]
    named: dict[int, str]
    camera: CameraModel
    height: float


class Point(NamedTuple):
    """A point of the picture that is followed.

    Attributes:
        place: (x, y) where it was in the last image, 1 before the camera.
        class_id: of its box.
        names: probability of each robot to be it.
        seen_ns: of the last image that showed it.
        spread: variance of its place beyond that of a box and its own motion.
        there: probability that there is anything; `names` are less or equal together.
    """

    place: tuple[float, float]
    class_id: str
    names: dict[str, float]
    seen_ns: int
    spread: float = 0.0
    there: float = 1.0


class ImageTracks:
    """Follows the boxes of images.

    Args:
        pixel_sigma: one sigma of a box's centre, px.
        speed_sigma: of a robot whose velocity is unknown, each axis, m/s.

    Attributes:
        blind_ns: stamp of the last image without a pose, ns; None where poses go on.
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
    ) -> dict[int, Labels]:
        """Take in an image whose boxes measured robots.

        Args:
            frame: its boxes.
            camera: lens and image size.
            height: of the camera above the water, m.
            named: by box, the robot that it measured.

        Returns:
            By box, what the picture says of the others, where images before had no pose.
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

    def expected(self, frame: DetectionFrame) -> dict[int, Labels]:
        """Return what the picture says of an image's boxes; nothing where poses go on.

        Args:
            frame: its boxes; `measured` or `followed` come next.
        """
        return {} if self.blind_ns is None else self.followed(frame, blind=False)

    def followed(self, frame: DetectionFrame, blind: bool = True) -> dict[int, Labels]:
        """Take in an image whose boxes measured no robots; return what the picture says of them.

        Args:
            frame: its boxes.
            blind: whether it measured none.
        """
        if not self._history or (self.blind_ns is None and not len(frame)):
            return {}
        if self.blind_ns is None:
            self._begin()
        if blind and len(frame):
            self.blind_ns = frame.stamp_ns
        if frame.stamp_ns != self._stamp_ns:
            self._follow(frame)
        return self._labels(len(frame))

    def _begin(self) -> None:
        """Go on from the last image that measured robots."""
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
        """Return the rates (6,) of the camera's motion over the last images with a pose, 1/s."""
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
        """Return by how much points (n, 2) move by themselves, each axis, (n,).

        Both boxes' noise; swimming; and by how much the camera's motion is not affine, which goes
        with the square of the distance from the axis.
        """
        last = self._history[-1]
        box = self._pixel_sigma / float(last.camera.K[0, 0])
        swum = self._speed_sigma * np.asarray(passed) / max(last.height, 1.0)
        bent = IMAGE_MOTION.rate_change_sigma * np.asarray(passed) * (places**2).sum(axis=1)
        variances: Array = 2.0 * box**2 + swum**2 + bent**2
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
        detected, density = self._detected(camera)
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
        hits = self._hits(linked.chances)
        missed = self._missed(linked, places, detected, passed)
        scale = self._shares([*hits, *(one.names for one in missed)])
        claimed = linked.chances.sum(axis=0)
        self._points = [
            Point((x, y), frame.class_ids[j], _scaled(hits[j], scale), frame.stamp_ns,
                  there=float(claimed[j] + (1.0 - claimed[j]) * TUNING.real_probability))
            for j, (x, y) in enumerate(found.tolist())
        ]  # fmt: skip
        self._points += [one._replace(names=_scaled(one.names, scale)) for one in missed]

    def _hits(self, chances: Array) -> list[dict[str, float]]:
        """Return, for each detection, the probabilities of robots, each by itself."""
        found: list[dict[str, float]] = []
        for of_points in chances.T.tolist():
            names: dict[str, float] = {}
            for one, chance in zip(self._points, of_points, strict=True):
                for name, p in one.names.items():
                    names[name] = names.get(name, 0.0) + p / one.there * chance
            found.append(names)
        return found

    def _missed(self, linked: Links, places: Array, detected: float, passed: float) -> list[Point]:
        """Return the points that the image may have missed, where they should be by now.

        One that may not be there at all is the less likely to be, for not being detected.
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
            if gone or left * one.there < TUNING.least_label_probability:
                continue
            unsure = 0.5 * float(np.trace(by[i] @ linked.motion.covariance @ by[i].T))
            found.append(one._replace(
                place=(x, y), names=_scaled(one.names, dict.fromkeys(one.names, left)),
                spread=one.spread + unsure, there=left * one.there,
            ))  # fmt: skip
        return found

    def _shares(self, found: list[dict[str, float]]) -> dict[str, float]:
        """Return factors by which each robot, which is at one point or lost, is there once."""
        factors = {}
        for name in self._known:
            lost = max(0.0, 1.0 - sum(one.names.get(name, 0.0) for one in self._points))
            factors[name] = 1.0 / max(
                lost + sum(one.get(name, 0.0) for one in found), TUNING.least_label_probability
            )
        return factors

    def _detected(self, camera: CameraModel) -> tuple[float, float]:
        """Return how often robots are detected, and the density of detections of no robot."""
        names = {name for seen in self._history for name in seen.named.values()}
        hits = sum(len(seen.named) for seen in self._history)
        others = sum(len(seen.centers) - len(seen.named) for seen in self._history)
        share = (hits + TUNING.prior_hits) / (
            len(names) * len(self._history) + TUNING.prior_hits + TUNING.prior_misses
        )
        area = float(camera.width * camera.height / (camera.K[0, 0] * camera.K[1, 1]))
        return min(share, 0.99), (TUNING.prior_new_boxes + others / len(self._history)) / area

    def _name(self, named: dict[int, str]) -> None:
        """Let boxes that measured robots be these for certain."""
        sure = set(named.values())
        self._known = tuple(dict.fromkeys((*self._known, *sure)))
        for index, one in enumerate(self._points):
            names = {name: p for name, p in one.names.items() if name not in sure}
            if index in named:
                names = {named[index]: 1.0}
            self._points[index] = one._replace(names=names)

    def _labels(self, boxes: int) -> dict[int, Labels]:
        """Return what the picture says of an image's boxes, which are the first points.

        A box that no robot's way leads to may be any robot whose way got lost.
        """
        points = self._points[:boxes]
        lost = {
            name: max(0.0, 1.0 - sum(one.names.get(name, 0.0) for one in points))
            for name in self._known
        }
        found = {}
        for index, one in enumerate(points):
            unknown = max(0.0, 1.0 - sum(one.names.values()))
            names = {name: one.names.get(name, 0.0) + unknown * lost[name] for name in self._known}
            found[index] = Labels(names, unknown)
        return found


def _scaled(names: dict[str, float], factors: dict[str, float]) -> dict[str, float]:
    """Return probabilities times a factor for each name, without those too small to matter."""
    scaled = {name: p * factors[name] for name, p in names.items()}
    return {name: p for name, p in scaled.items() if p > TUNING.least_label_probability}
