# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""CameraInfo YAML files: as camera_calibration writes them, or as `ros2 topic echo` prints them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.yaml_files import read_yaml
from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import CameraError, InputError
from aerial_gnss_ros.text.sentences import shown

_EXPECTED = (
    "image_width, image_height, camera_matrix, distortion_model and distortion_coefficients (as "
    "camera_calibration writes them), or width, height, k and d (as in sensor_msgs/CameraInfo)"
)


@dataclass(frozen=True)
class CameraFile:
    """A camera described by a file.

    Attributes:
        path: the file.
        name: `camera_name`; empty if the file has none.
        camera: the model of images that are not rectified.
    """

    path: Path
    name: str
    camera: CameraModel


def read_camera_file(path: str | Path) -> CameraFile:
    """Read a CameraInfo YAML.

    Raises:
        InputError: the file is missing, is not YAML, or has no camera.
        CameraError: the description is unusable (zeros, unknown distortion model, …).
    """
    path = Path(path)
    fields = _mapping(path)
    names = {"width": "image_width", "height": "image_height", "k": "camera_matrix",
             "d": "distortion_coefficients"}  # fmt: skip
    found = {
        short: fields[key]
        for short, long in names.items()
        for key in (long, short, short.upper())
        if key in fields
    }
    missing = [names[short] for short in ("width", "height", "k") if short not in found]
    if missing:
        raise InputError(
            f"{path} has no {', '.join(missing)}; found: {', '.join(map(str, fields)) or 'nothing'}"
            f"; expected: {_EXPECTED}."
        )
    try:
        camera = CameraModel.from_camera_info(
            _whole(found["width"]),
            _whole(found["height"]),
            str(fields.get("distortion_model") or ""),
            _numbers(found.get("d", [])),
            _numbers(found["k"]),
        )
    except CameraError as error:
        raise CameraError(f"{path}: {error}") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{path} has a value that is not a number ({error}).") from error
    return CameraFile(path, str(fields.get("camera_name") or ""), camera)


def camera_file_text(camera: CameraModel, name: str) -> str:
    """Return a camera as camera_calibration's YAML, which camera drivers accept."""
    projection = np.zeros((3, 4))
    projection[:, :3] = camera.K
    parts = {
        "camera_matrix": camera.K,
        "distortion_coefficients": camera.D.reshape(1, -1) if camera.D.size else np.zeros((1, 5)),
        "rectification_matrix": np.eye(3),
        "projection_matrix": projection,
    }
    lines = [
        f"image_width: {camera.width}",
        f"image_height: {camera.height}",
        f"camera_name: {name}",
        f"distortion_model: {camera.model}",
    ]
    for key, matrix in parts.items():
        data = ", ".join(f"{value:.10g}" for value in matrix.ravel())
        rows, columns = matrix.shape
        lines += [f"{key}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{data}]"]
    return "\n".join(lines) + "\n"


def _mapping(path: Path) -> Mapping[str, Any]:
    first = read_yaml(path, first=True)  # `ros2 topic echo --once` ends with ---
    if not isinstance(first, Mapping):
        raise InputError(f"{path} holds no CameraInfo; expected: {_EXPECTED}.")
    return first


def _numbers(value: Any) -> list[float]:
    data = value.get("data", []) if isinstance(value, Mapping) else value
    if not isinstance(data, Sequence) or isinstance(data, str):
        raise TypeError(f"{shown(data)} is not a list of numbers")
    return [float(number) for number in data]


def _whole(value: Any) -> int:
    number = int(value)
    if number != float(value):
        raise ValueError(f"{shown(value)} is not a whole number")
    return number
