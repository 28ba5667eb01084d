# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes the bags of the golden record: boxes and telemetry of simulated flights, no images.

python test/golden/make_bags.py [NAME ...]

`recorded` flies the path, attitude and gimbal of a DJI flight record; its robots, boxes and sensor
errors are simulated too. The log is looked for in ../shared/data, see README.md. The bags are part
of the repository: they are made again only to add one, and a flight that has changed with the
simulation is a new input, whose results have to be recorded anew.

Values are rounded to what fits the sensor (1/16 px, 0.1 mm, 1e-6 of a quaternion), in powers of two
so that they compress well.
"""

from __future__ import annotations

import argparse
import math
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters import telemetry_fields as fields
from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.writer import RELIABLE, SENSOR, BagWriter
from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
)
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import Flight, FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.recorded import RecordedFlight
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan

HERE = Path(__file__).resolve().parent
BAGS = HERE / "bags"
LOG = HERE.parents[2] / "shared" / "data" / "dji_tracking.csv"

DETECTIONS_TYPE = "vision_msgs/msg/Detection2DArray"
INFO_EVERY = 5
"""Images for each CameraInfo."""

Message = tuple[int, str, str, dict[str, Any]]
"""Log time in ns, topic, type, fields."""


@dataclass(frozen=True)
class Story:
    """A flight, and what goes wrong with its messages.

    Attributes:
        about: what it shows.
        flight: the drone's true motion.
        swim: how robots move.
        robots: how many, where `places` is empty.
        places: East, North of robots at the start, m.
        detector: how boxes fail.
        noise: errors of the sensors by name, beyond the set's.
        image_hz: images a second.
        latency_s: true one of the images.
        attitude: whether the body's attitude is recorded, the gimbal relative to the body, and the
            height with a stamp.
        change: what goes wrong, message by message; None: the message is lost.
        seed: of all chance.
    """

    about: str
    flight: Callable[[int], Flight]
    swim: SwimPlan
    robots: int = 3
    places: tuple[tuple[float, float], ...] = ()
    detector: DetectorPlan = field(default_factory=lambda: DetectorPlan(2.0, 0.05, 0.05))
    noise: dict[str, float] = field(default_factory=dict)
    image_hz: float = 5.0
    latency_s: float = 0.0
    attitude: bool = False
    change: Callable[[float, Any], Any] = lambda _t, value: value
    seed: int = 1


def generated(kind: str, seconds: float, height: float, **more: Any) -> Callable[[int], Flight]:
    """Return what makes a flight of a kind, so long (s), so high (m)."""
    return lambda seed: GeneratedFlight(FlightPlan(kind, seconds, height, **more), seed)


def recorded(start: float, seconds: float) -> Callable[[int], Flight]:
    """Return what cuts a piece out of the recorded log, s."""
    return lambda _seed: RecordedFlight(read_dji_log(LOG), start, seconds)


def turned(value: Orientation, yaw_deg: float, pitch_deg: float = 0.0) -> Orientation:
    """Return an orientation turned about the vertical and about its own left axis."""
    matrix = matrix_from_quaternion(value.quaternion)
    about = matrix_from_rpy(0.0, 0.0, math.radians(yaw_deg))
    nod = matrix_from_rpy(0.0, math.radians(pitch_deg), 0.0)
    return replace(value, quaternion=quaternion_from_matrix(about @ matrix @ nod))


def glitches(t: float, value: Any) -> Any:
    """Turn the gimbal's telemetry by 30 deg of yaw for 1 s, and by 5 deg of pitch for 3 s."""
    if isinstance(value, Orientation) and 15.0 <= t < 16.0:
        return turned(value, 30.0)
    if isinstance(value, Orientation) and 30.0 <= t < 33.0:
        return turned(value, 0.0, 5.0)
    return value


def jump(t: float, value: Any) -> Any:
    """Let the receiver's position jump by 6 m to the east at 20 s, and stay there."""
    if isinstance(value, Fix) and t >= 20.0:
        east = 6.0 / (6_378_137.0 * math.cos(value.latitude))
        return replace(value, longitude=value.longitude + east)
    return value


def runaway(t: float, value: Any) -> Any:
    """Turn the gimbal's telemetry by 2 deg/s about the vertical from 15 s to 25 s."""
    if isinstance(value, Orientation):
        return turned(value, 2.0 * min(max(t - 15.0, 0.0), 10.0))
    return value


def airframe(t: float, value: Any) -> Any:
    """Lose telemetry, step back in time, and find boxes of other classes and low scores."""
    if isinstance(value, Fix) and 8.0 <= t < 12.0:
        return None
    if isinstance(value, Fix) and 14.0 <= t < 14.4:
        return replace(value, latitude=math.nan)
    if isinstance(value, DetectionFrame) and len(value.class_ids):
        names = ("buoy", *value.class_ids[1:]) if round(5 * t) % 4 == 0 else value.class_ids
        scores = value.scores.copy()
        scores[-1] = 0.125 if round(5 * t) % 5 == 0 else scores[-1]
        value = replace(value, class_ids=names, scores=scores)
    # The drone's computer is set back by 30 s.
    return shifted(value, -30_000_000_000) if t >= 22.0 else value


def shifted(value: Any, by_ns: int) -> Any:
    """Return a value with another stamp."""
    return replace(value, stamp_ns=value.stamp_ns + by_ns)


STORIES = {
    "dives": Story(
        "three robots that dive for 8 to 20 s each, under an orbit",
        generated("orbit", 100.0, 20.0, speed_mps=3.0),
        SwimPlan(0.1, 0.4, roam_m=5.0, apart_m=1.5, dives=True, dive_s=20.0, dive_every_s=45.0,
                 shortest_dive_s=8.0),
        image_hz=10.0,
    ),
    "crossing": Story(
        "four robots that swim across one another's ways, under a hover; missed and false boxes",
        generated("hover", 60.0, 15.0),
        SwimPlan(0.3, 0.7, roam_m=4.0, apart_m=0.8),
        places=((-2.0, 0.0), (2.0, 0.5), (0.0, 2.5), (0.5, -2.5)),
        detector=DetectorPlan(2.0, 0.15, 0.1),
    ),
    "glitch": Story(
        "gimbal telemetry that is wrong by 30 deg for 1 s, and by 5 deg for 3 s",
        generated("orbit", 50.0, 30.0, speed_mps=4.0), SwimPlan(0.15, 0.6),
        noise={"gnss_offset_m": 0.02}, change=glitches,
    ),
    "jump": Story(
        "a receiver whose position jumps by 6 m, over two robots",
        generated("hover", 40.0, 20.0), SwimPlan(0.1, 0.4), robots=2, change=jump,
    ),
    "runaway": Story(
        "gimbal telemetry that turns by itself for 10 s, over robots that stay",
        generated("hover", 40.0, 30.0), SwimPlan(0.0, 0.0), noise={"gnss_offset_m": 0.02},
        change=runaway,
    ),
    "many": Story(
        "36 robots that dive, more than one block of the filter holds",
        generated("orbit", 30.0, 60.0, speed_mps=6.0),
        SwimPlan(0.1, 0.4, roam_m=4.0, apart_m=2.0, dives=True, dive_s=12.0, dive_every_s=25.0,
                 shortest_dive_s=6.0),
        robots=36, detector=DetectorPlan(1.0, 0.02, 0.1),
    ),
    "airframe": Story(
        "a gimbal relative to the body, a camera beside the antenna, late images, lost and wrong "
        "telemetry, a clock that is set back",
        generated("transit", 40.0, 25.0, speed_mps=4.0, camera_offset_m=(0.3, -0.1, -0.2)),
        SwimPlan(0.15, 0.5), attitude=True, latency_s=0.2, change=airframe,
    ),
    "recorded": Story(
        "the recorded motion of a DJI drone over three robots; missed and false boxes",
        recorded(480.0, 80.0), SwimPlan(0.15, 0.6), detector=DetectorPlan(2.0, 0.2, 0.15),
    ),
}  # fmt: skip


def make(name: str) -> Path:
    """Write the bag of a story; equal stories give equal bytes."""
    story = STORIES[name]
    made = Experiment(
        story.flight(story.seed),
        default_camera(1280, 720),
        replace(
            sensor_plan("consumer", **story.noise),
            fix_hz=5.0, attitude_hz=20.0, gimbal_hz=20.0 if story.attitude else 10.0, height_hz=5.0,
        ),
        CameraClock(story.image_hz, story.latency_s),
        robots=story.robots,
        places=np.array(story.places) if story.places else None,
        swim=story.swim,
        detector=story.detector,
        seed=story.seed,
    )  # fmt: skip
    messages = sorted(_messages(story, made), key=lambda message: message[0])
    target = BAGS / f"{name}.mcap"
    BAGS.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        with BagWriter(Path(folder) / name, compress=True) as bag:
            for log_ns, topic, msgtype, values in messages:
                qos = RELIABLE if topic == "detections" else SENSOR
                bag.write(topic, msgtype, log_ns, values, qos)
        shutil.copyfile(Path(folder) / name / f"{name}.mcap", target)
    return target


def _messages(story: Story, made: Experiment) -> Iterator[Message]:
    plan, sensors = made.sensors_plan, made.sensors
    gimbals = sensors.gimbals()
    if story.attitude:
        gimbals = _by_body(made)
        for log_ns, one in _changed(story, sensors.attitudes(), plan.attitude_latency_s):
            yield log_ns, "attitude", fields.IMU_TYPE, fields.imu_fields(_rounded(one))
    for log_ns, one in _changed(story, gimbals, plan.gimbal_latency_s):
        values = fields.quaternion_fields(_rounded(one), "enu")
        yield log_ns, "gimbal", fields.QUATERNION_TYPE, values
    for log_ns, one in _changed(story, sensors.fixes(), plan.fix_latency_s):
        yield log_ns, "fix", fields.FIX_TYPE, _fix_fields(one)
    for log_ns, one in _changed(story, sensors.heights(), plan.height_latency_s):
        if story.attitude:  # with a stamp of its own
            yield log_ns, "height", "geometry_msgs/msg/PoseStamped", _height_pose(one)
            continue
        value = replace(one, value=_grid(one.value, 10))
        yield log_ns, "height", fields.FLOAT_TYPE, fields.float_fields(value)
    boxes = [found for _, _, found in made.detections()]
    delay = made.clock.delay_s
    for i, (log_ns, frame) in enumerate(_changed(story, boxes, delay)):
        if i % INFO_EVERY == 0:
            info = fields.camera_info_fields(made.camera, frame.stamp_ns, frame.frame_id)
            yield log_ns, "camera/camera_info", fields.CAMERA_INFO_TYPE, info
        yield log_ns, "detections", DETECTIONS_TYPE, _array(frame)


def _changed(story: Story, values: Iterable[Any], late_s: float) -> Iterator[tuple[int, Any]]:
    """Yield when each value arrives, and what is left of it."""
    for value in values:
        one = story.change((value.stamp_ns - START_NS) * 1e-9, value)
        if one is not None:
            yield value.stamp_ns + round(late_s * 1e9), one


def _by_body(made: Experiment) -> Iterator[Orientation]:
    """Yield the camera relative to the body, as exact as an encoder is."""
    rng = np.random.default_rng(made.seed)
    both = zip(made.sensors.attitudes(true=True), made.sensors.gimbals(true=True), strict=True)
    for body, camera in both:
        flu = matrix_from_quaternion(body.quaternion).T @ matrix_from_quaternion(camera.quaternion)
        white = matrix_from_rpy(*np.radians(0.03 * rng.standard_normal(3)))
        yield Orientation(camera.stamp_ns, quaternion_from_matrix(flu @ white))


def _grid(value: Any, bits: int) -> Any:
    """Return a number or array in whole multiples of 2 to the power of -bits."""
    rounded = np.round(np.asarray(value, dtype=np.float64) * 2.0**bits) / 2.0**bits
    return float(rounded) if rounded.ndim == 0 else rounded


def _rounded(one: Orientation) -> Orientation:
    return replace(one, quaternion=_grid(one.quaternion, 20))


def _fix_fields(fix: Fix) -> dict[str, Any]:
    values = fields.fix_fields(fix)
    for name, bits in (("latitude", 30), ("longitude", 30), ("altitude", 7)):
        values[name] = _grid(values[name], bits)
    return values


def _height_pose(height: Scalar) -> dict[str, Any]:
    position = {"x": 0.0, "y": 0.0, "z": _grid(height.value, 10)}
    upright = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    pose = {"position": position, "orientation": upright}
    return {"header": header_fields(height.stamp_ns, "water"), "pose": pose}


def _array(found: DetectionFrame) -> dict[str, Any]:
    names = tuple(sorted(set(found.class_ids)))
    index = np.array([names.index(name) for name in found.class_ids], dtype=np.int64)
    boxes = np.hstack([_grid(found.centers, 4), _grid(found.sizes, 1)])
    header = header_fields(found.stamp_ns, found.frame_id)
    return detection_array(Detections(boxes, _grid(found.scores, 6), index, names), header)


def main() -> None:
    """Make the bags that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[[], *STORIES], help="default: all")
    for name in parser.parse_args().names or STORIES:
        path = make(name)
        print(f"{name:<10} {path.stat().st_size / 1024:7.0f} KiB  {STORIES[name].about}")


if __name__ == "__main__":
    main()
