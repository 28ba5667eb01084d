# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes config/detector.yaml and config/estimator.yaml from the program's own defaults."""

from __future__ import annotations

import sys
import textwrap
from pathlib import Path

from aerial_gnss_ros.adapters.parameter_documents import document, meaning
from aerial_gnss_ros.core.config.references import REFERENCE_KEYS
from aerial_gnss_ros.core.config.robot_classes import RobotClass
from aerial_gnss_ros.core.config.schema import leaves
from aerial_gnss_ros.nodes.schemas import ESTIMATOR, SCHEMAS

COMMAND = "`python3 -m aerial_gnss_ros.nodes.config_files config`"
_CLASSES = """\
Parameters of the robots of one class, by the class's name; what is absent is the global one.
classes:
  aqua: {max_speed: 1.5, coast_s: 120.0, length_m: [0.4, 0.9]}
  buoy: {max_speed: 0.3, acceleration: 0.01}"""
_ROBOTS = """\
Names bound to robots, so that each knows its own topic: the robot of that class that is first
confirmed near `start` (latitude and longitude in degrees; within start_radius_m) is called so.
robots:
  leader: {class: aqua, start: [13.19394, -59.64151]}
  follower: {class: aqua, start: [13.19401, -59.64160]}
"""
_REFERENCES = """\
Things in view whose position is known: they make the receiver's offset observable.
references:
  pier: {class: beacon, position: [13.194012, -59.641385], sigma_m: 0.05, height_m: 1.5}
  mark: {class: buoy, position: [13.19405, -59.6414], sigma_m: 0.5, radius_m: 4.0}
  boat: {class: boat, topic: boat/fix}"""


def _classes() -> str:
    """Return an example of parameters by class, and their meanings."""
    meanings = [
        textwrap.fill(f"{leaf.name}: {meaning(leaf)}", 94, subsequent_indent="  ")
        for leaf in leaves(RobotClass)
    ]
    return "\n".join([_CLASSES, *meanings, ""])


def _references() -> str:
    """Return an example of references, and what their keys mean."""
    meanings = [
        textwrap.fill(f"{key}: {meaning(leaf)}", 94, subsequent_indent="  ")
        for key, leaf in REFERENCE_KEYS.items()
    ]
    return "\n".join([_REFERENCES, *meanings])


def texts() -> dict[str, str]:
    """Return file names with their contents."""
    return {
        f"{node}.yaml": document(
            node,
            schema,
            COMMAND,
            _classes() + _ROBOTS + _references() if node == ESTIMATOR else "",
        )
        for node, schema in SCHEMAS.items()
    }


def main() -> int:
    """Write the files to the given folder."""
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_dir():
        sys.stderr.write("usage: python3 -m aerial_gnss_ros.nodes.config_files FOLDER\n")
        return 2
    for name, text in texts().items():
        (Path(sys.argv[1]) / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
