# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Factories for the nodes of a process, ordered for a fast start."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from aerial_gnss_ros.nodes.schemas import DETECTOR, FLEET
from aerial_gnss_ros.nodes.supervised import Given


def both(given: Given) -> list[Callable[[], Any]]:
    """Return the node factories in order: the network loads while the rest is imported."""
    return [lambda: _detector(given), lambda: _estimator(given)]


def only(name: str, given: Given) -> Callable[[], Any]:
    """Return the factory of one node.

    Args:
        name: detector, estimator or fleet.
        given: parameter files, namespace and session.
    """
    made = {DETECTOR: _detector, FLEET: _fleet}.get(name, _estimator)
    return lambda: made(given)


def _detector(given: Given) -> Any:
    from aerial_gnss_ros.nodes.detector_node import DetectorNode

    return DetectorNode(given, meanwhile=True)


def _estimator(given: Given) -> Any:
    from aerial_gnss_ros.nodes.estimator_node import EstimatorNode

    return EstimatorNode(given)


def _fleet(given: Given) -> Any:
    from aerial_gnss_ros.nodes.fleet_node import FleetNode

    return FleetNode(given)
