# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss calibrate`: the platform's constant errors from a recording of still robots."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.calibration.advice import Excitation, advice, excitation
from aerial_gnss_ros.calibration.fit import Fit, unknown
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.solve import calibrate
from aerial_gnss_ros.commands.configuration import add_arguments as add_configuration
from aerial_gnss_ros.commands.configuration import configuration
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.config import EstimatorConfig
from aerial_gnss_ros.core.errors import ConfigError
from aerial_gnss_ros.core.words import counted
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector

OUTLIERS = 0.08
KEYS = {
    "heading": "heading_deg",
    "gimbal_pitch": "gimbal_pitch_deg",
    "gimbal_roll": "gimbal_roll_deg",
    "height": "height_m",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Robots should stay where they are; the best flight is an orbit round one, once at a near "
        "and once at a far distance. A correction is what is added to the measured value, "
        "East-North-Up and counter-clockwise. The GNSS offset cannot be told from such a flight."
    )
    parser.add_argument("bags", type=Path, nargs="+", metavar="BAG", help="as for replay")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="YAML", help="parameter file to write for --params"
    )
    parser.add_argument("--focal", action="store_true", help="estimate the focal length, too")
    parser.add_argument(
        "--robot-speed", type=float, default=0.0, metavar="MPS",
        help="how fast robots may drift or swim (default 0: they stay)",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="the result for machines")
    add_configuration(parser)


def run(args: argparse.Namespace) -> int:
    """Calibrate."""
    if args.output is not None:
        refuse_existing(args.output)
    if not 0.0 <= args.robot_speed <= 2.0:
        raise ConfigError(f"--robot-speed must lie within 0 to 2 m/s, not {args.robot_speed:g}.")
    given = configuration(args)
    with ended_cleanly():
        found = _calibrate(args, given.estimator, given.detector)
        if args.output is not None:
            with partial(args.output) as path:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(as_yaml(found, args.bags), encoding="utf-8")
    if args.json:
        print(json.dumps(_as_dict(found), indent=2))
    else:
        print("\n".join(_as_text(found, args.robot_speed)))
        if args.output is not None:
            print(f"wrote {args.output}: give it to the nodes and to replay with --params")
    return 0


@dataclass(frozen=True)
class Calibration:
    """What was found, against which parameters.

    Attributes:
        fit: corrections to the values used at last.
        base: the parameters used at last.
        given: the parameters of the first pass.
        flown: how the flight varied.
    """

    fit: Fit
    base: EstimatorConfig
    given: EstimatorConfig
    flown: Excitation

    def parameters(self) -> dict[str, float]:
        """Return the parameters that were determined, by dotted name."""
        corrected = corrected_config(self.base, self.fit)
        names = {"latency": "camera.latency_s", "focal": "calibration.focal_scale"}
        names |= {name: f"calibration.{key}" for name, key in KEYS.items()}
        values = {}
        for name in self.fit.names:
            if self.fit.determined(name):
                group, key = names[name].split(".")
                values[names[name]] = round(float(getattr(getattr(corrected, group), key)), 4)
        return values

    def correction(self, name: str) -> tuple[float, float]:
        """Return the correction to the given parameters, and its one sigma, in the unit."""
        value, sigma = self.fit.value(name)
        if name == "latency":
            return value + self.base.camera.latency_s - self.given.camera.latency_s, sigma
        if name == "focal":
            ratio = self.base.calibration.focal_scale / self.given.calibration.focal_scale
            return value + 100.0 * math.log(ratio), sigma
        key = KEYS[name]
        before = getattr(self.given.calibration, key)
        return value + float(getattr(self.base.calibration, key)) - before, sigma


def corrected_config(config: EstimatorConfig, fit: Fit) -> EstimatorConfig:
    """Return parameters with what was determined added to them."""
    camera, calibration = config.camera, config.calibration
    for name in fit.names:
        if not fit.determined(name):
            continue
        value, _ = fit.value(name)
        if name == "latency":
            camera = replace(camera, latency_s=max(-3.0, min(3.0, camera.latency_s + value)))
        elif name == "focal":
            scale = calibration.focal_scale * math.exp(value / 100.0)
            calibration = replace(calibration, focal_scale=scale)
        else:
            key = KEYS[name]
            sum_ = getattr(calibration, key) + value
            calibration = replace(calibration, **{key: sum_})
    return replace(config, camera=camera, calibration=calibration)


def _calibrate(
    args: argparse.Namespace, config: EstimatorConfig, detector: DetectorConfig
) -> Calibration:
    """Fit twice: with the first result boxes are told apart better than without it."""
    fit, detected = _pass(args, config, detector)
    base = config
    if not detected:
        # The latency alone: what else the first pass says may rest on boxes that it mixed up.
        late = corrected_config(config, fit).camera.latency_s
        base = replace(config, camera=replace(config.camera, latency_s=late))
        fit, _ = _pass(args, base, detector)
    assert args.recording is not None  # noqa: S101 - a pass was made
    return Calibration(fit, base, config, excitation(args.recording))


def _pass(
    args: argparse.Namespace, config: EstimatorConfig, detector: DetectorConfig
) -> tuple[Fit, bool]:
    """Return the fit, and whether images were looked at, which takes too long for a second time."""
    recording = Recording(config)
    with open_bag(args.bags) as bag:
        replay = Replay(
            bag, config, detector, load_detector, namespace=args.namespace,
            detect=args.model is not None, estimator=recording,
        )  # fmt: skip
        with progress("reading", replay.message_count, "messages") as report:
            for _ in replay.results(report):
                pass
        detected = replay.plan.image_topic is not None
    with progress("searching the latency", 13, "steps") as report:
        fit = calibrate(
            recording, config, focal=args.focal, robot_speed=args.robot_speed, progress=report
        )
    args.recording = recording
    return fit, detected


def as_yaml(found: Calibration, bags: list[Path]) -> str:
    """Return the parameter file; what was not determined is in it as a comment only."""
    lines = [
        f"# Written by `aerial-gnss calibrate` from {', '.join(path.name for path in bags)}.",
        "# What is added to the measured value to have the true one; ENU, counter-clockwise.",
        *(f"# {line}" for line in _table(found)),
        *(f"# {line}" for line in found.flown.words()),
        "/**/estimator:",
        "  ros__parameters:",
    ]
    values = found.parameters()
    groups: dict[str, list[str]] = {}
    for dotted, value in values.items():
        group, key = dotted.split(".")
        groups.setdefault(group, []).append(f"      {key}: {value!r}")
    for group, keys in groups.items():
        lines += [f"    {group}:", *keys]
    if not values:
        lines[-1] += " {}"
    lines += [f"# To do: {sentence}" for sentence in advice(found.fit)]
    return "\n".join(lines) + "\n"


def _table(found: Calibration) -> list[str]:
    lines = []
    for name in found.fit.names:
        value, sigma = found.correction(name)
        other, correlation = found.fit.correlation(name)
        verdict = "determined" if found.fit.determined(name) else "NOT determined, not written"
        lines.append(
            f"{name.replace('_', ' '):<13} {value:+8.3f} {unknown(name).unit:<3} +- {sigma:6.3f}  "
            f"{verdict}; correlation with {other.replace('_', ' ')} {correlation:+.2f}"
        )
    return lines


def _as_text(found: Calibration, robot_speed: float) -> list[str]:
    fit = found.fit
    lines = [
        (
            f"{counted(fit.boxes, 'box')} in {counted(fit.images, 'image')}, robots: "
            f"{', '.join(fit.robots)}; residual {fit.residual_px:.1f} px, "
            f"{counted(fit.outliers, 'outlier')}"
        ),
        *found.flown.words(),
        "",
        "correction (true = measured + correction), one sigma:",
        *(f"  {line}" for line in _table(found)),
        "GNSS offset: cannot be told from the flight; it moves drone and robots alike.",
    ]
    if not robot_speed:
        lines.append(
            "Robots were taken to stay where they are. If they drifted or swam, these values are "
            "wrong by more than they say: give --robot-speed."
        )
    if fit.outliers > OUTLIERS * fit.boxes:
        lines.append(
            f"CAUTION: {fit.outliers / fit.boxes:.0%} of the boxes do not fit: robots moved (see "
            "--robot-speed), or boxes were taken for another robot's."
        )
    todo = advice(fit)
    if todo:
        lines += ["", "What to fly next:", *(f"  {sentence}" for sentence in todo)]
    return lines


def _as_dict(found: Calibration) -> dict[str, Any]:
    fit = found.fit
    return {
        "corrections": {
            name: {
                "value": found.correction(name)[0],
                "sigma": found.correction(name)[1],
                "unit": unknown(name).unit,
                "determined": fit.determined(name),
                "correlated_with": dict([fit.correlation(name)]),
            }
            for name in fit.names
        },
        "parameters": found.parameters(),
        "covariance_si": fit.covariance.tolist(),
        "boxes": fit.boxes,
        "outliers": fit.outliers,
        "images": fit.images,
        "robots": list(fit.robots),
        "residual_px": fit.residual_px,
        "excitation": asdict(found.flown),
        "advice": advice(fit),
    }
