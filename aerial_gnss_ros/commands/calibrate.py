# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss calibrate`: delays and the platform's constant errors from a recording of robots."""

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
from aerial_gnss_ros.calibration.advice import advice
from aerial_gnss_ros.calibration.excitation import Excitation
from aerial_gnss_ros.calibration.fit import Fit, unknown
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.search import GRID
from aerial_gnss_ros.calibration.solve import calibrate
from aerial_gnss_ros.commands.configuration import add_arguments as add_configuration
from aerial_gnss_ros.commands.configuration import configuration
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.text.sentences import counted

NOT_FOUND = 1
KEYS = {
    "heading": "heading_deg",
    "gimbal_pitch": "gimbal_pitch_deg",
    "gimbal_roll": "gimbal_roll_deg",
    "height": "height_m",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Swimming robots suffice for the latency; angles and height need at least one that stays "
        "in place. The best flight is an orbit around it, once close and once far. A correction "
        "is added to the measured value, East-North-Up and counter-clockwise. The GNSS offset "
        "cannot be determined from such a flight. If the boxes do not fit, nothing is written "
        "and the exit status is 1."
    )
    parser.add_argument(
        "bags", type=Path, nargs="+", metavar="BAG", help="recorded bags, as for replay"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="YAML", help="parameter file to write for --params"
    )
    parser.add_argument("--focal", action="store_true", help="also estimate the focal length")
    parser.add_argument(
        "--robot-speed", type=float, default=0.0, metavar="MPS",
        help="has no effect: whether a robot swims is estimated",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
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
        refused = bool(found.fit.misfit)
        if args.output is not None and not refused:
            with partial(args.output) as path:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(as_yaml(found, args.bags), encoding="utf-8")
    if args.json:
        print(json.dumps(_as_dict(found), indent=2))
    else:
        print("\n".join(_as_text(found)))
        if args.output is not None and not refused:
            print(f"wrote {args.output}: give it to the nodes and to replay with --params")
    return NOT_FOUND if refused else 0


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration.

    Attributes:
        fit: corrections to the given parameters.
        given: parameters before calibration.
        flown: variation of angles, distance and speed during the flight.
    """

    fit: Fit
    given: EstimatorConfig
    flown: Excitation

    def parameters(self) -> dict[str, float]:
        """Return the determined parameters by their dotted names."""
        corrected = corrected_config(self.given, self.fit)
        keys: dict[str, tuple[str, ...]] = {"latency": ("camera.latency_s",)}
        keys["focal"] = ("calibration.focal_scale",)
        keys["fix_latency"] = ("fix.latency_s", "height.latency_s")
        keys |= {name: (f"calibration.{key}",) for name, key in KEYS.items()}
        values = {}
        for name in self.fit.names:
            for dotted in keys[name] if self.fit.determined(name) else ():
                group, key = dotted.split(".")
                values[dotted] = round(float(getattr(getattr(corrected, group), key)), 4)
        return values


def corrected_config(config: EstimatorConfig, fit: Fit) -> EstimatorConfig:
    """Return parameters with the determined corrections added."""
    camera, calibration = config.camera, config.calibration
    fix, height = config.fix, config.height
    for name in fit.names:
        if not fit.determined(name):
            continue
        value, _ = fit.value(name)
        if name == "latency":
            camera = replace(camera, latency_s=_within(camera.latency_s + value))
        elif name == "fix_latency":
            fix = replace(fix, latency_s=_within(fix.latency_s + value))
            height = replace(height, latency_s=_within(height.latency_s + value))
        elif name == "focal":
            scale = calibration.focal_scale * math.exp(value / 100.0)
            calibration = replace(calibration, focal_scale=scale)
        else:
            key = KEYS[name]
            sum_ = getattr(calibration, key) + value
            calibration = replace(calibration, **{key: sum_})
    return replace(config, camera=camera, calibration=calibration, fix=fix, height=height)


def _within(latency_s: float) -> float:
    return max(-3.0, min(3.0, latency_s))


def _calibrate(
    args: argparse.Namespace, config: EstimatorConfig, detector: DetectorConfig
) -> Calibration:
    recording = Recording(config)
    with open_bag(args.bags) as bag:
        replay = Replay(
            bag, config, detector, load_detector, namespace=args.namespace,
            detect=args.model is not None, estimator=recording,
        )  # fmt: skip
        with progress("reading", replay.message_count, "messages") as report:
            for _ in replay.results(report):
                pass
    with progress("searching for the latency", GRID, "steps") as report:
        fit = calibrate(recording, config, focal=args.focal, progress=report)
    return Calibration(fit, config, fit.flown)


def as_yaml(found: Calibration, bags: list[Path]) -> str:
    """Return the parameter file, with undetermined values as comments."""
    lines = [
        f"# Written by `aerial-gnss calibrate` from {', '.join(path.name for path in bags)}.",
        "# True value = measured value + correction; ENU, counter-clockwise.",
        *(f"# {line}" for line in _table(found)),
        *(f"# {line}" for line in found.flown.lines()),
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
        value, sigma = found.fit.value(name)
        other, correlation = found.fit.correlation(name)
        verdict = "determined"
        if not found.fit.determined(name):
            doubt = found.fit.ambiguities.get(name)
            verdict = "NOT determined, not written" + (f" ({doubt})" if doubt else "")
        lines.append(
            f"{name.replace('_', ' '):<19} {value:+8.3f} {unknown(name).unit:<3} +- {sigma:6.3f}  "
            f"{verdict}; correlation with {other.replace('_', ' ')} {correlation:+.2f}"
        )
    return lines


def _as_text(found: Calibration) -> list[str]:
    fit = found.fit
    lines = [
        (
            f"{counted(fit.boxes, 'box')} in {counted(fit.images, 'image')}; residual "
            f"{fit.residual_px:.1f} px, {counted(fit.outliers, 'outlier')}"
        ),
        f"robots: {fit.moved()}",
        *found.flown.lines(),
        "",
    ]
    if fit.misfit:
        return [
            *lines,
            "No delay and no platform errors explain the boxes; nothing is written:",
            *(f"  {sentence}" for sentence in fit.misfit),
            (
                "The boxes may show things that move faster than robots, the focal length or the "
                "gimbal's reference may be wrong (see `aerial-gnss check`), or the telemetry may "
                "be that of another flight."
            ),
        ]
    lines += [
        "correction (true = measured + correction), one sigma:",
        *(f"  {line}" for line in _table(found)),
        "GNSS offset: not determined by the flight; it displaces drone and robots equally.",
    ]
    todo = advice(fit)
    if todo:
        lines += ["", "What to fly next:", *(f"  {sentence}" for sentence in todo)]
    return lines


def _as_dict(found: Calibration) -> dict[str, Any]:
    fit = found.fit
    return {
        "corrections": {
            name: {
                "value": fit.value(name)[0],
                "sigma": fit.value(name)[1],
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
        "speeds_mps": list(fit.speeds_mps),
        "residual_px": fit.residual_px,
        "excitation": asdict(found.flown),
        "doubts": fit.ambiguities,
        "trouble": list(fit.misfit),
        "advice": advice(fit),
    }
