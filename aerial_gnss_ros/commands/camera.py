# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss camera`: field of view and ground sample distance; writes a CameraInfo YAML."""

from __future__ import annotations

import argparse
import json
import math
import textwrap
from pathlib import Path
from typing import Any

from aerial_gnss_ros.adapters.camera_files import camera_file_text
from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.commands.camera_arguments import ChosenCamera, add_numbers, chosen_camera
from aerial_gnss_ros.core.camera.catalogue import KNOWN
from aerial_gnss_ros.core.camera.equivalent_focal_length import FULL_FRAME_DIAGONAL_MM
from aerial_gnss_ros.core.georeferencing.footprint import (
    GroundSample,
    field_of_view,
    ground_samples,
)
from aerial_gnss_ros.core.values.errors import InputError

_WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "camera", nargs="?", metavar="YAML|JPEG|NAME",
        help="CameraInfo as camera_calibration writes it or `ros2 topic echo` prints it, a "
        "photo (its EXIF), or the name of a known drone (--list); or give the numbers below",
    )  # fmt: skip
    add_numbers(parser.add_argument_group("numbers", "give all three, or --image-size with a NAME"))
    parser.add_argument("--zoom", type=float, default=1.0, metavar="X", help="with a NAME (1)")
    parser.add_argument(
        "--height", type=float, metavar="M", help="height of the camera above the water, m"
    )
    parser.add_argument(
        "--tilt", type=float, default=90.0, metavar="DEG",
        help="angle of the optical axis below the horizon, deg; 90 is straight down (%(default)g)",
    )  # fmt: skip
    parser.add_argument("--write", type=Path, metavar="YAML", help="write a CameraInfo file")
    parser.add_argument("--list", action="store_true", help="list the known drones")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(args: argparse.Namespace) -> int:
    """Describe a camera."""
    if args.list:
        _print_known(args.json)
        return 0
    chosen = chosen_camera(args, args.camera, zoom=args.zoom)
    if chosen is None:
        raise InputError(
            "no camera given; give a CameraInfo YAML, a photo, the name of a known drone (--list "
            "shows them), or --image-size, --focal-length-mm and --sensor-width-mm."
        )
    samples: tuple[GroundSample, ...] = ()
    if args.height is not None:
        samples = ground_samples(chosen.camera, args.height, math.radians(args.tilt))
    if args.write is not None:
        with partial(args.write) as file:
            file.write_text(camera_file_text(chosen.camera, chosen.name), encoding="utf-8")
    if args.json:
        print(json.dumps(_summary(chosen, samples), indent=2))
    else:
        _print(chosen, samples, args)
    return 0


def _print_known(as_json: bool) -> None:
    if as_json:
        rows = {
            k.name: {"words": k.product, "equivalent_mm": k.equivalent_mm, "photo": list(k.photo),
                     "source": k.source}
            for k in KNOWN.values()
        }  # fmt: skip
        print(json.dumps(rows, indent=2))
        return
    for known in KNOWN.values():
        photo = f"{known.photo[0]}x{known.photo[1]}"
        print(f"{known.name:<18} {known.equivalent_mm:3.0f} mm  {photo:<10} {known.product}")
    print("\nFocal lengths are the makers' equivalents on 35 mm film.")


def _summary(chosen: ChosenCamera, samples: tuple[GroundSample, ...]) -> dict[str, Any]:
    camera, view = chosen.camera, field_of_view(chosen.camera)
    return {
        "source": chosen.source,
        "width_px": camera.width,
        "height_px": camera.height,
        "model": camera.model,
        "fx_px": float(camera.K[0, 0]),
        "fy_px": float(camera.K[1, 1]),
        "cx_px": float(camera.K[0, 2]),
        "cy_px": float(camera.K[1, 2]),
        "distortion": [float(d) for d in camera.D],
        "field_of_view_deg": {
            "horizontal": _degrees(view.horizontal),
            "vertical": _degrees(view.vertical),
            "diagonal": _degrees(view.diagonal),
        },
        "ground": [
            {
                "place": s.place,
                "below_horizon_deg": _degrees(s.below_horizon),
                "distance_m": _number(s.distance),
                "range_m": _number(s.range_m),
                "across_m_per_px": _number(s.across),
                "along_m_per_px": _number(s.along),
            }
            for s in samples
        ],
        "warnings": chosen.warnings,
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _degrees(value: float) -> float | None:
    return _number(math.degrees(value))


def _print(
    chosen: ChosenCamera, samples: tuple[GroundSample, ...], args: argparse.Namespace
) -> None:
    camera, view = chosen.camera, field_of_view(chosen.camera)
    fx, fy = camera.K[0, 0], camera.K[1, 1]
    equivalent = fx * FULL_FRAME_DIAGONAL_MM / math.hypot(camera.width, camera.height)
    angles = " x ".join(
        "?" if math.isnan(a) else f"{math.degrees(a):.1f}" for a in (view.horizontal, view.vertical)
    )
    diagonal = "?" if math.isnan(view.diagonal) else f"{math.degrees(view.diagonal):.1f}"
    print(f"{chosen.name}: {chosen.source}")
    print(f"  image           {camera.width} x {camera.height} px, {camera.model}")
    print(f"  focal length    {fx:.1f} x {fy:.1f} px, {equivalent:.1f} mm on 35 mm film")
    print(f"  field of view   {angles} deg (horizontal x vertical), {diagonal} deg diagonal")
    if samples:
        print(f"\n  {args.height:g} m above the water, {args.tilt:g} deg below the horizon:")
        print("  image     below horizon   from the drone   per pixel across x along")
        for sample in samples:
            print("  " + _ground_row(sample))
    for warning in chosen.warnings:
        print()
        print(textwrap.fill(warning, _WIDTH, initial_indent="  ! ", subsequent_indent="    "))
    if args.write is not None:
        print(f"\n  written to {args.write}")


def _ground_row(sample: GroundSample) -> str:
    angle = f"{math.degrees(sample.below_horizon):10.1f} deg"
    if math.isnan(sample.distance):
        return f"{sample.place:<8}{angle}     above the horizon: no water"
    size = f"{_length(sample.across)} x {_length(sample.along)}"
    return f"{sample.place:<8}{angle}   {sample.distance:12.1f} m   {size}"


def _length(metres: float) -> str:
    return f"{metres * 100.0:.2f} cm" if metres < 1.0 else f"{metres:.2f} m"
