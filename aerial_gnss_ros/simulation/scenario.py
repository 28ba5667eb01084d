# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Describes a simulated flight, as values for its bag and in words for the user."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import VERTICAL_FACTOR, geodetic

PROBES = 60
"""Greatest number of images sampled for the share in view."""


def scenario(experiment: Experiment, noise: str) -> dict[str, Any]:
    """Return all settings of a simulation, ready for JSON.

    Args:
        experiment: the flight.
        noise: name of the noise set.
    """
    plan, clock, camera = experiment.sensors_plan, experiment.clock, experiment.camera
    return {
        "flight": experiment.flight.words,
        "duration_s": experiment.flight.duration_s,
        "seed": experiment.seed,
        "camera": {
            "width_px": camera.width,
            "height_px": camera.height,
            "focal_length_px": round(float(camera.K[0, 0]), 3),
            "rate_hz": clock.rate_hz,
            "latency_s": clock.latency_s,
            "arrives_after_s": clock.delay_s,
        },
        "robots": _robots(experiment),
        **_references(experiment),
        **_afloat(experiment),
        "noise": {"set": noise, **plan.sigmas},
        "sensors": {
            name: {
                "rate_hz": getattr(plan, f"{name}_hz"),
                "latency_s": getattr(plan, f"{name}_latency_s"),
            }
            for name in ("fix", "attitude", "gimbal", "height")
        },
        "altitude_datum": "ellipsoid",
    }


def words(about: dict[str, Any]) -> list[str]:
    """Return a scenario as lines for the user."""
    camera, noise = about["camera"], about["noise"]
    flight = f"flight: {about['flight']}; {about['duration_s']:g} s, seed {about['seed']}"
    view = (
        f"camera: {camera['width_px']}x{camera['height_px']} at {camera['rate_hz']:g} Hz, focal "
        f"length {camera['focal_length_px']:g} px, images {about.get('images', 'none')}; an image "
        f"stamped t shows the scene at t - {camera['latency_s']:g} s and arrives "
        f"{camera['arrives_after_s']:g} s later"
    )
    lines = [flight, view]
    if "water" in about:
        water = about["water"]
        lines.append(f"water: {water['photograph']}, {water['width_m']:g} m wide")
    lines += [f"robot {name}: {_robot_words(robot)}" for name, robot in about["robots"].items()]
    for name, one in about.get("references", {}).items():
        lines.append(f"reference {name}: {json.dumps(one)}")
    without_room = about.get("distractors_without_room", 0)
    if about["distractors"] or without_room:
        lines.append(f"other things afloat: {about['distractors']}{_left_out(without_room)}")
    lines += [f"noise, one sigma ({noise['set']}): {text}" for text in _noise_words(noise)]
    sensors = ", ".join(
        f"{name} {value['rate_hz']:g} Hz, {1e3 * value['latency_s']:g} ms late"
        for name, value in about["sensors"].items()
    )
    lines.append(f"sensors: {sensors}; fix altitude is above the ellipsoid")
    if "telemetry" in about:
        lines += [f"telemetry: {text}" for text in about["telemetry"]["understood_as"]]
        lines.append(f"telemetry: refused rows: {about['telemetry']['refused_rows']}")
    return lines


def _robots(experiment: Experiment) -> dict[str, dict[str, float]]:
    frames = experiment.frames()
    probes = frames[:: max(1, len(frames) // PROBES)]
    seen = [name for frame in probes for name in experiment.projected(frame).names]
    swarm = experiment.swarm
    start = swarm.positions(np.zeros(1))[:, 0]
    latitude, longitude, _ = geodetic(experiment.flight.origin, start)
    return {
        name: {
            "latitude_deg": round(math.degrees(latitude[i]), 9),
            "longitude_deg": round(math.degrees(longitude[i]), 9),
            "speed_mps": round(float(swarm.speeds[i]), 3),
            "in_view": round(seen.count(name) / max(1, len(probes)), 3),
        }
        for i, name in enumerate(swarm.names)
    }


def _references(experiment: Experiment) -> dict[str, Any]:
    """Return the parameter `references` of the beacon, as `--params` takes it."""
    fix = experiment.reference()
    if fix is None:
        return {}
    position = [round(math.degrees(angle), 9) for angle in (fix.latitude, fix.longitude)]
    class_id = experiment.swarm.class_names[0]
    stated = {"class": class_id, "position": position, "sigma_m": experiment.survey_m}
    return {"references": {class_id: stated}}


def _afloat(experiment: Experiment) -> dict[str, int]:
    placed = len(experiment.props)
    left_out = experiment.distractors - placed
    return {"distractors": placed} | ({"distractors_without_room": left_out} if left_out else {})


def _left_out(count: int) -> str:
    if not count:
        return ""
    return f"; no room for {count} more clear of the robots' paths and of each other"


def _robot_words(robot: dict[str, float]) -> str:
    moves = f"swims at {robot['speed_mps']:g} m/s" if robot["speed_mps"] else "stays"
    return (
        f"starts at {robot['latitude_deg']:.7f}, {robot['longitude_deg']:.7f}, {moves}, in view in "
        f"{100.0 * robot['in_view']:.0f} % of the images"
    )


def _noise_words(noise: dict[str, Any]) -> tuple[str, str]:
    slow = (
        f"slow, correlation time {noise['correlation_time_s']:g} s: GNSS "
        f"{noise['gnss_offset_m']:g} m each horizontal axis ({VERTICAL_FACTOR:g} times that "
        f"vertically), heading {noise['heading_deg']:g} deg, gimbal pitch "
        f"{noise['gimbal_pitch_deg']:g} deg and roll {noise['gimbal_roll_deg']:g} deg, height "
        f"{noise['height_m']:g} m"
    )
    white = (
        f"white: GNSS {noise['gnss_white_m']:g} m, attitude {noise['attitude_white_deg']:g} deg, "
        f"gimbal {noise['gimbal_white_deg']:g} deg, height {noise['height_white_m']:g} m, box "
        f"centre {noise['box_center_px']:g} px (without images)"
    )
    return slow, white
