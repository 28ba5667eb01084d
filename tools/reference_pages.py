# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes the reference pages that follow from the code: parameters, commands, topics, files.

    python tools/reference_pages.py FOLDER

`make docs` does this before it builds the site, so that these pages cannot be out of date. All but
the commands, whose text depends on the version of Python, are in the repository, where pages that
link to them are read, too. A topic or column without a description here is an error.
"""

from __future__ import annotations

import argparse
import importlib
import os
import re
import sys
import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.feed import Feed, Inputs
from aerial_gnss_ros.adapters.fleet_messages import PARAMETERS, REQUEST
from aerial_gnss_ros.adapters.fleet_overview import DRONES
from aerial_gnss_ros.adapters.kinds import ATTITUDE, FIX, GIMBAL, HEIGHT
from aerial_gnss_ros.adapters.overview import OVERVIEW
from aerial_gnss_ros.adapters.parameter_documents import scalar
from aerial_gnss_ros.adapters.results import covariance_parts, position_update, result_messages
from aerial_gnss_ros.adapters.sighting_messages import SIGHTINGS
from aerial_gnss_ros.adapters.transforms import TF, TF_STATIC, TF_TYPE
from aerial_gnss_ros.bags.drone_tables import DRONE_COLUMNS, NAME_COLUMNS
from aerial_gnss_ros.bags.results import PLATFORM_COLUMNS, REJECTED_COLUMNS
from aerial_gnss_ros.bags.tables import POSITION_COLUMNS
from aerial_gnss_ros.cli import COMMANDS
from aerial_gnss_ros.core.config.estimator import DepthConfig, EstimatorConfig, HeightConfig
from aerial_gnss_ros.core.config.noise import SETS, Noise
from aerial_gnss_ros.core.config.references import REFERENCE_KEYS
from aerial_gnss_ros.core.config.robot_classes import RobotClass
from aerial_gnss_ros.core.config.schema import Leaf, leaves, type_hints
from aerial_gnss_ros.core.values.estimates import (
    Current,
    FrameResult,
    MapDatum,
    RobotEstimate,
    State,
)
from aerial_gnss_ros.core.values.rejection import Cause, Reason
from aerial_gnss_ros.nodes.schemas import SCHEMAS

INPUTS = {
    "detections": "The boxes of one image, in pixels of the source image.",
    "camera_info": "Intrinsics: `plumb_bob`, `rational_polynomial`, `equidistant`. The newest one "
    "that is not later than the image applies.",
    "fix": "The drone's GNSS position; a status of −1 is refused.",
    "attitude": "Body FLU in ENU. Needed unless `gimbal.reference` is `earth`, and where "
    "`camera.offset_m` is not zero or `height.along` is `body`.",
    "gimbal": "Camera FLU in ENU; straight down is a pitch of +90°.",
    "height": "The drone above the water (`height.reference: water`) or above its take-off point "
    "(`home`), m.",
    "home": "Altitude of the take-off point, subtracted from `height`. Only where "
    "`height.home_topic` names a topic.",
    "water_level": "How far the water stands above the reference of `height` (tide), m. Optional; "
    "held until replaced.",
    "depth": "Depth of the robots below the surface, m. Only where `depth.topics` names topics.",
}
KINDS = {"fix": FIX, "attitude": ATTITUDE, "gimbal": GIMBAL, "height": HEIGHT}
OUTPUTS = {
    "robots/<id>/geo_pose": "Position on the water; orientation from the course once it is known. "
    "Covariance in m² and rad², in the order **North, East, Up** that this message demands.",
    "robots/<id>/fix": "The same position. Covariance **East, North, Up**; status `FIX` when "
    "measured in this image, `NO_FIX` while predicted.",
    "robots/<id>/odom": "The same position in the map frame (`map.frame`, ENU), z = 0 on the "
    "water, with the velocity in `child_frame_id` `<namespace>/<id>/course`.",
    "robots/<id>/position_update": "A position each `updates.interval_s` at most, for other "
    "filters: errors of two of them may be taken as independent. Not latched.",
    "robots/<id>/covariance_shared": "Each measured position with the part of its covariance "
    "that lasts minutes; while `updates.covariance_parts` is true. Not latched.",
    "robots/<id>/covariance_white": "The same position with the rest of its covariance, which "
    "boxes of some seconds average out. Not latched.",
    "robots/markers": "Error ellipses and names for RViz and Foxglove; made while somebody "
    "subscribes.",
    "overview": "All of these with the camera's footprint, depths, references and the state of "
    "the inputs, as JSON for `aerial-gnss view`; made while somebody subscribes.",
    "sightings": "For a [fleet](../howto/drones.md): boxes and camera pose of each image as JSON, "
    "with `sightings.drone`; made while somebody subscribes.",
    "sightings/parameters": "The parameters and the origin of `map`, as JSON; latched.",
    "current": "Velocity of what drifts with the water and the wind, East and North, while at "
    "least two robots do, with a probability of 95 %.",
    "map_datum": "Origin of the map frame, on the water; altitude NaN where it is unknown.",
    "/tf": "The map frame to each robot's `<namespace>/<id>/course` (`map.publish_tf`).",
    "/tf_static": "`earth` to the map frame (`map.publish_earth_tf`).",
}
POSITION_MEANINGS = {
    "stamp_ns": "stamp of the image, ns",
    "robot_id": "`<class>_<n>`, or the name that `robots:` binds",
    "class_id": "class name of the detector; `'` precedes a name that begins with `=`, `+`, `-` "
    "or `@`",
    "latitude_deg": "WGS 84, deg",
    "longitude_deg": "WGS 84, deg",
    "altitude_m": "of the water above the ellipsoid, m; `nan` without `fix.altitude_datum`",
    "var_east_m2": "variance East, m²",
    "cov_east_north_m2": "covariance of East and North, m²",
    "var_north_m2": "variance North, m²",
    "velocity_east_mps": "m/s",
    "velocity_north_mps": "m/s",
    "state": "`confirmed`: measured in this image; `coasting`: predicted",
}
REJECTED_MEANINGS = {
    "stamp_ns": "stamp of the image, ns",
    "reason": "one of the reasons below",
    "u_px": "column of the box centre, px",
    "v_px": "row of the box centre, px",
}
PLATFORM_MEANINGS = {
    "stamp_ns": "stamp of the image, ns; a row each half second",
    "error": "`gnss_east`, `gnss_north`, `height`, `roll`, `pitch`, `heading`, `latency`",
    "value": "estimated correction (true = measured + correction); m, rad, s",
    "sigma": "its standard deviation",
}
DRONE_MEANINGS = {
    "stamp_ns": "stamp of the image, ns; a row each half second for each drone",
    "drone": "its name",
    "agreement": "mean normalised squared residual of its boxes of robots that another drone has "
    "measured in the last second, over 100 images; 1 is right, `nan` without any",
    "shared_robots": "robots that it and another drone have measured",
    "offset_east_m": "correction of its receiver less the mean of the other drones'",
    "offset_north_m": "likewise",
    "sigma_east_m": "standard deviation of `offset_east_m`",
    "sigma_north_m": "likewise",
    "disagrees": "1 while it [contradicts the others](../explanation/fleet.md), else 0",
    "fault": (
        "sensor that has turned out to be wrong: `compass`, `gimbal`, `receiver` or `height`; "
        "empty if none has"
    ),
    "latitude_deg": "of its camera by its telemetry, WGS84",
    "longitude_deg": "likewise",
    "sees": "names in `positions.csv` of the robots that boxes of this image show, with a space "
    "between",
    "clock_ahead_s": "by how much its clock is ahead of the others', s",
    "clock_sigma_s": "standard deviation of `clock_ahead_s`",
}
NAME_MEANINGS = {
    "robot_id": "the robot's name in `positions.csv`",
    "drone": "name of a drone",
    "drone_robot_id": "by which that drone knew the robot",
    "first_stamp_ns": "stamp of its first image with that name, ns",
    "last_stamp_ns": "of the last one, ns",
    "images": "number of them",
}
PARAMETER_HEADS = ("parameter", "default", "allowed", "meaning")
CLASSES = """\
Parameters of the robots of one class, by the class's name: `classes: {buoy: {max_speed: 0.3}}`."""
ROBOTS = """\
### estimator: robots

Labels bound to robots, so that each knows its own topic. The robot of that class that is first
confirmed near `start` (latitude and longitude in degrees, within `start_radius_m`) gets the label.

```yaml
robots:
  leader: {class: aqua, start: [13.19394, -59.64151]}
  follower: {class: aqua, start: [13.19401, -59.64160]}
```"""
REFERENCES = """\
### estimator: references

Things in view whose position is known; [how to use them](../howto/references.md).

```yaml
references:
  pier: {class: beacon, position: [13.194012, -59.641385], sigma_m: 0.05, height_m: 1.5}
  mark: {class: buoy, position: [13.19405, -59.6414], sigma_m: 0.5, radius_m: 4.0}
  boat: {class: boat, topic: boat/fix}
```"""
RESULT_FILES = {
    "positions.geojson": "a line and the last position of each robot (RFC 7946)",
    "positions.kml": "Google Earth",
    "positions.gpx": "chart plotters (GPX 1.1)",
    "report.html": "a page for a person: map, errors, refusals",
    "bag/": "the result topics as rosbag2 (mcap)",
}


def table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a Markdown table."""
    heads = list(heads)
    lines = [heads, ["---"] * len(heads), *map(list, rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def parameters() -> str:
    """Return the page of all parameters of all nodes."""
    parts = [
        "# Parameters",
        (
            "Made from the dataclasses that the program itself reads. The same keys serve the "
            "nodes (`--params FILE`), the launch file and `aerial-gnss replay`; "
            "`config/detector.yaml` and `config/estimator.yaml` are complete files to copy from. "
            "`.nan` means *not given*."
        ),
    ]
    for node, schema in SCHEMAS.items():
        parts += [f"## {node.capitalize()}", *_groups(node, schema, "")]
    by_class = table(PARAMETER_HEADS, map(_parameter, leaves(RobotClass, "classes.<name>.")))
    parts += [f"### estimator: classes\n\n{CLASSES}", by_class, ROBOTS]
    keys = [replace(leaf, name=f"references.<name>.{key}") for key, leaf in REFERENCE_KEYS.items()]
    parts += [REFERENCES, table(PARAMETER_HEADS, map(_parameter, keys))]
    return "\n\n".join(parts) + "\n"


def _groups(node: str, schema: type[Any], prefix: str) -> Iterator[str]:
    hints = type_hints(schema)
    own = [leaf for leaf in leaves(schema, prefix) if "." not in leaf.name[len(prefix) :]]
    if prefix:
        first = (schema.__doc__ or "").split("\n\n", maxsplit=1)[0]
        yield f"### {node}: {prefix.rstrip('.')}\n\n{' '.join(first.split())}"
    if own:
        yield table(PARAMETER_HEADS, map(_parameter, own))
    if schema is Noise:
        yield noise_sets()
    for item in fields(schema):
        kind = hints[item.name]
        if is_dataclass(kind) and isinstance(kind, type):
            yield from _groups(node, kind, f"{prefix}{item.name}.")


def _parameter(leaf: Leaf) -> list[str]:
    key = leaf.key
    if key.choices:
        allowed = ", ".join(f"`{choice}`" for choice in key.choices)
    elif key.low is not None or key.high is not None:
        low = "−∞" if key.low is None else f"{key.low:g}"
        allowed = f"{low} to {'∞' if key.high is None else f'{key.high:g}'} {key.unit}".rstrip()
    else:
        allowed = key.unit
    meaning = escaped(key.doc) + (" *Can be changed in flight.*" if key.dynamic else "")
    return [f"`{leaf.name}`", f"`{scalar(leaf.default)}`", allowed, meaning]


def escaped(text: str) -> str:
    """Return text that Markdown shows as it is, but for code between backticks."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([*_<|\[])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def noise_sets() -> str:
    """Return the standard deviations of the named noise sets."""
    names = list(next(iter(SETS.values())))
    units = {leaf.name: leaf.key.unit for leaf in leaves(Noise)}
    rows = (
        [f"`noise.{name}`", units[name], *(f"{one[name]:g}" for one in SETS.values())]
        for name in names
    )
    return table(("one sigma", "unit", *(f"`{name}`" for name in SETS)), rows)


def commands() -> str:
    """Return the page of all commands with their options."""
    os.environ["COLUMNS"] = "100"
    parts = [
        "# Commands",
        (
            "What `aerial-gnss COMMAND --help` prints. Each command ends with status 0 when its "
            "work is done, 2 and one sentence when its input was wrong, and 130 when it was "
            "interrupted. Where a machine may read the result, `--json` prints JSON."
        ),
    ]
    for name, (module, summary) in COMMANDS.items():
        command = importlib.import_module(f"aerial_gnss_ros.commands.{module}")
        parser = argparse.ArgumentParser(prog=f"aerial-gnss {name}")
        command.add_arguments(parser)
        text = f"{summary[0].upper()}{summary[1:]}."
        parts.append(f"## {name}\n\n{text}\n\n```text\n{parser.format_help().rstrip()}\n```")
    return "\n\n".join(parts) + "\n"


def topics() -> str:
    """Return the page of all topics of all nodes."""
    detector = SCHEMAS["detector"]()
    compressed = replace(detector.image, transport="compressed")
    found = [
        ["in", detector.image.full_topic, "sensor_msgs/msg/Image", ("bgr8, rgb8, mono8, bgra8, "
         "rgba8, nv12, yuv422, yuv422_yuy2")],
        ["in", compressed.full_topic, "sensor_msgs/msg/CompressedImage",
         "JPEG or PNG, instead, with `image.transport: compressed`"],
        ["in", detector.camera_info.topic, "sensor_msgs/msg/CameraInfo",
         "Images of another size than it states are refused."],
        ["out", detector.detections.topic, "vision_msgs/msg/Detection2DArray",
         ("One array for each image that was processed, also an empty one; header of the image; "
         "class *name* in `class_id`.")],
        ["out", detector.annotated.full_topic, "sensor_msgs/msg/CompressedImage",
         ("The image with its boxes as JPEG, at most `annotated.rate_hz`; made while somebody "
         "subscribes.")],
    ]  # fmt: skip
    heads = ("", "topic", "type", "meaning")
    shown = [[way, f"`{topic}`", _type(kind), text] for way, topic, kind, text in found]
    parts = ["## Detector", table(heads, shown), "## Estimator", table(heads, _estimator_topics())]
    parts += ["## Fleet", table(heads, _fleet_topics())]
    kinds = [
        [f"`{name}.type`", f"`{kind}`", _type(found.msgtype)]
        for name, choices in KINDS.items()
        for kind, found in choices.items()
    ]
    return "\n\n".join(
        [
            "# Topics",
            (
                "All names are relative, so that a namespace moves them (`--namespace drone1`), "
                "and can be remapped or replaced by a parameter. Frames follow REP 103 and REP "
                "105."
            ),
            *parts,
            (
                "All nodes publish `/diagnostics` (`diagnostic_msgs/DiagnosticArray`): rate and "
                "age of each input, refusals by reason, milliseconds of each stage."
            ),
            "## Quality of service",
            table(
                ("topics", "reliability", "durability", "depth"),
                [
                    ["sensor inputs", "best effort", "volatile", "1 for images, 50 for telemetry"],
                    ["`detections`, both ends", "reliable", "volatile", "10"],
                    ["results", "reliable", "transient local", "1 for each robot"],
                    ["`sightings`", "reliable", "volatile", "100"],
                    ["`annotated/compressed`", "reliable", "volatile", "1"],
                    ["`/tf`", "reliable", "volatile", "100"],
                    ["`/tf_static`", "reliable", "transient local", "1"],
                ],
            ),
            (
                "A subscriber that asks for reliable *and* transient local receives the last "
                "position at once, even of a robot that surfaced for a second an hour ago: **look "
                "at the stamp and the status**."
            ),
            "## Types that an input may have",
            table(("parameter", "value", "type"), kinds),
        ]
    )


def _type(msgtype: str) -> str:
    package, _, name = msgtype.split("/")
    return f"`{package}/{name}`"


def _estimator_topics() -> Iterator[list[str]]:
    config = replace(
        EstimatorConfig(),
        height=replace(HeightConfig(), home_topic="home"),
        depth=replace(DepthConfig(), topics=("depth",)),
    )
    listening: Any = Inputs  # only described, never fed
    for wanted in Feed(config, listening).subscriptions:
        meaning = INPUTS[wanted.name]
        yield ["in", f"`{wanted.topic}`", _type(wanted.msgtype), meaning]
    example = _example()
    update = position_update(example.estimates[0], example.datum)
    parts = covariance_parts(example.estimates[0], example.datum)
    for message in (*result_messages(example), update, *parts):
        topic = message.topic.replace("aqua_1", "<id>")
        yield ["out", f"`{topic}`", _type(message.msgtype), OUTPUTS[topic]]
    yield ["out", f"`{OVERVIEW[0]}`", _type(OVERVIEW[1]), OUTPUTS[OVERVIEW[0]]]
    for topic, kind in (SIGHTINGS, PARAMETERS):
        yield ["out", f"`{topic}`", _type(kind), OUTPUTS[topic]]
    meaning = "Sequence numbers of sightings that the fleet wants again: of the last 64 s, as JSON."
    yield ["in", f"`{REQUEST[0]}`", _type(REQUEST[1]), meaning]
    for topic in (TF, TF_STATIC):
        yield ["out", f"`{topic}`", _type(TF_TYPE), OUTPUTS[topic]]


def _fleet_topics() -> Iterator[list[str]]:
    for topic, kind in (SIGHTINGS, PARAMETERS):
        yield ["in", f"`<drone>/{topic}`", _type(kind), "Of each estimator, see above."]
    yield ["out", f"`<drone>/{REQUEST[0]}`", _type(REQUEST[1]), "To each estimator."]
    yield ["out", "`robots/...`, `map_datum`, `/tf`, `/tf_static`", "", "As an estimator."]
    meaning = (
        "[Each drone](../howto/drones.md): agreement, offset, delay, names; JSON, each second."
    )
    yield ["out", f"`{DRONES[0]}`", _type(DRONES[1]), meaning]
    meaning = "For [view](../howto/view.md): as an estimator's, with all `drones`."
    yield ["out", f"`{OVERVIEW[0]}`", _type(OVERVIEW[1]), meaning]


def _example() -> FrameResult:
    robot = RobotEstimate(
        0, "aqua_1", "aqua", State.CONFIRMED, 0.0, 0.0, 0.0,
        np.zeros(2), np.zeros(2), np.eye(4), 0, np.eye(2),
    )  # fmt: skip
    drift = Current(np.zeros(2), np.eye(2))
    return FrameResult(0, "camera", (robot,), (), MapDatum(0.0, 0.0, 0.0), current=drift)


def files() -> str:
    """Return the page of the files that a replay writes, with the reasons of refusals."""
    columns = ("column", "meaning")
    return "\n\n".join(
        [
            "# Files of a replay",
            (
                "`aerial-gnss replay BAG -o DIR` writes these into `DIR`; the same input gives the "
                "same bytes."
            ),
            "## positions.csv",
            table(columns, _columns(POSITION_COLUMNS, POSITION_MEANINGS)),
            "## rejected.csv",
            "Every box measures a robot or has one row here.",
            table(columns, _columns(REJECTED_COLUMNS, REJECTED_MEANINGS)),
            "## platform.csv",
            table(columns, _columns(PLATFORM_COLUMNS, PLATFORM_MEANINGS)),
            "## drones.csv and names.csv",
            "Only of [several drones](../howto/drones.md).",
            table(columns, _columns(DRONE_COLUMNS, DRONE_MEANINGS)),
            table(columns, _columns(NAME_COLUMNS, NAME_MEANINGS)),
            "## Others",
            table(("file", "for"), ([f"`{name}`", text] for name, text in RESULT_FILES.items())),
            "## Reasons of refusal",
            "The same words stand in `rejected.csv`, the report and `/diagnostics`.",
            table(("reason", "meaning"), ([f"`{r}`", escaped(r.meaning)] for r in Reason)),
            (
                "Boxes refused as `unconfirmed` also have a likely cause, which summary, report "
                "and `/diagnostics` state:"
            ),
            table(("cause", "meaning"), ([f"`{c}`", escaped(c.meaning)] for c in Cause)),
        ]
    )


def _columns(names: Iterable[str], meanings: dict[str, str]) -> Iterator[list[str]]:
    for name in names:
        yield [f"`{name}`", meanings[name]]


PAGES = {
    "parameters.md": parameters,
    "commands.md": commands,
    "topics.md": topics,
    "files.md": files,
}


def wrapped(text: str) -> str:
    """Return a page with lines of at most 120 characters, tables excepted."""
    lines = (
        textwrap.wrap(line, 120, break_long_words=False, break_on_hyphens=False)
        if len(line) > 120 and not line.startswith("|")
        else [line]
        for line in text.rstrip().splitlines()
    )
    return "\n".join(line for each in lines for line in each) + "\n"


def write(folder: Path) -> None:
    """Write all pages into a folder; a page that has not changed keeps its time."""
    for name, make in PAGES.items():
        text = wrapped(make())
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]))
