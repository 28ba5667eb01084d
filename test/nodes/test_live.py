# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A flight played through real DDS into the real nodes gives what replay gives."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest

from aerial_gnss_ros.adapters.feed import Feed
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.geometry.geodesy import geodesic_inverse

ESTIMATOR = "aerial_gnss_ros.nodes.estimator"
START_NS, STEP_NS = 1_700_000_000_000_000_000, 200_000_000  # of the flight's images
WAITING = ("--wait-for", "/detections", "/gimbal", "--after", "1")
SIM_TIME = ("--ros-args", "-p", "use_sim_time:=true")


def replayed(bag_path):
    """Return (stamp_ns, robot_id) -> (latitude, longitude) in rad by the same core."""
    config = estimator_config({})
    estimator = Estimator(config)
    routes = {"/" + s.topic: s for s in Feed(config, estimator).subscriptions}
    results = []
    with open_bag(bag_path) as bag:
        for recorded in bag.messages(set(routes)):
            routes[recorded.topic].handle(recorded.message(), recorded.log_ns)
            results += estimator.advance(recorded.log_ns)
    results += estimator.flush()
    return {
        (result.stamp_ns, estimate.robot_id): (estimate.latitude, estimate.longitude)
        for result in results
        for estimate in result.estimates
    }


def collect(ros, robot_ids):
    """Subscribe to the robots' fixes; return the dict that fills with them."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from sensor_msgs.msg import NavSatFix

    found = {}
    node = ros.node()
    profile = QoSProfile(depth=50, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    for name in robot_ids:

        def take(msg, name=name):
            place = (math.radians(msg.latitude), math.radians(msg.longitude))
            found[nanoseconds(msg.header.stamp), name] = place

        node.create_subscription(NavSatFix, f"/robots/{name}/fix", take, profile)
    return found


def answered(expected, found):
    """Return the number of the next image, counted from 0, whose positions are to be waited for."""
    names = {stamp: {name for at, name in expected if at == stamp} for stamp, _ in expected}
    done = [stamp for stamp in names if all((stamp, name) in found for name in names[stamp])]
    ahead = [stamp for stamp in names if stamp > max(done, default=0)]
    return (min(ahead, default=2**62) - START_NS) // STEP_NS


def say(sentence):
    """Write a figure that `pytest -s` shows."""
    sys.stdout.write(f"\n{sentence}\n")


def distances_m(a, b):
    """Return the distances of common keys."""
    common = sorted(set(a) & set(b))
    lat0, lon0, lat1, lon1 = np.array([(*a[key], *b[key]) for key in common]).T
    return geodesic_inverse(lat0, lon0, lat1, lon1)[0]


@pytest.mark.slow
def test_recorded_detections_through_dds_agree_with_replay(ros, start, in_step, flight):
    bag = flight("boxes")
    expected = replayed(bag)
    assert {name for _, name in expected} == {"aqua_1", "aqua_2"}
    found = collect(ros, ["aqua_1", "aqua_2"])
    node = start(ESTIMATOR, *SIM_TIME)
    node.wait_for(r"method filter; detections /detections, .* -> /robots/<id>/geo_pose")
    player = in_step("/detections", bag, *WAITING)
    player.play(ros, lambda: answered(expected, found))
    off = distances_m(expected, found)
    share = len(off) / len(expected)
    say(f"{len(off)} of {len(expected)} positions in common, largest difference {max(off):.5f} m")
    assert share > 0.9
    assert max(off) < 0.01
    assert set(found) <= set(expected)


@pytest.mark.slow
def test_images_through_both_nodes_give_the_robots_places(ros, start, in_step, flight):
    bag = flight("images")
    truth = replayed(flight("boxes"))
    found = collect(ros, ["aqua_1", "aqua_2"])
    detector = ros.add(red_square_detector())
    node = start(ESTIMATOR, *SIM_TIME)
    node.wait_for("method filter")
    topic = "/camera/image_raw"
    player = in_step(topic, bag, "--wait-for", topic, *WAITING[1:])
    player.play(ros, lambda: answered(truth, found))
    off = distances_m(truth, found)
    say(f"{len(off)} of {len(truth)} positions in common, largest difference {max(off):.3f} m")
    assert detector._images.lost == 0  # 691 kB an image: more than the default segment holds
    assert len(off) > 0.8 * len(truth)
    assert max(off) < 0.15  # whole pixels instead of true ones: a pixel is 0.04 m


def red_square_detector():
    import cv2

    from aerial_gnss_ros.detection.base import Detections
    from aerial_gnss_ros.nodes.detector_node import DetectorNode

    class RedSquares:
        name = "red squares on OpenCV"
        class_names = ("aqua",)

        def detect(self, image):
            mask = (image[..., 2] > 200).astype(np.uint8)
            _, _, stats, centers = cv2.connectedComponentsWithStats(mask)
            xywh = np.hstack([centers, stats[:, 2:4]])[:0:-1]  # nearest first, background not
            count = len(xywh)
            return Detections(
                xywh, np.full(count, 0.9), np.zeros(count, np.int64), ("aqua",), {"infer": 1.0}
            )

    return DetectorNode(load=lambda _config: RedSquares())
