# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Targets that read files: parameters, cameras, flight records, names, models, tables, images."""

from __future__ import annotations

import functools
import io
import json
import random
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
from PIL import Image

from aerial_gnss_ros.adapters.camera_files import camera_file_text, read_camera_file
from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.adapters.parameter_files import read, ros_parameters
from aerial_gnss_ros.adapters.photo_files import read_photo
from aerial_gnss_ros.bags.drone_tables import read_drones
from aerial_gnss_ros.bags.import_dji import messages
from aerial_gnss_ros.bags.tables import read_positions, read_rejections
from aerial_gnss_ros.bags.typestore import make
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.estimator import Estimator
from aerial_gnss_ros.core.estimation.state_file import load
from aerial_gnss_ros.core.identity.saved_labels import from_text, to_text
from aerial_gnss_ros.core.values.errors import AerialGnssError
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.images import decode
from aerial_gnss_ros.detection.onnx_model import agreed_names, class_names, input_size
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.nodes.schemas import DETECTOR, ESTIMATOR, SCHEMAS
from fuzz import mutate, samples
from fuzz.checks import check_sentence
from fuzz.engine import NOT_FINITE, OUTPUT, Broken

Report = Callable[[str], None]


def allowed(use: Callable[[], object]) -> None:
    """Do something that may refuse what it is given, in a sentence."""
    try:
        use()
    except AerialGnssError as error:
        check_sentence(str(error))


class Parser:
    """Reads damaged texts or bytes from a file.

    Args:
        name: of the target.
        weight: share of the cases.
        suffix: of the file.
        damage: makes its contents.
        use: reads it and uses what it says; may raise AerialGnssError and nothing else.
    """

    block = 100

    def __init__(
        self,
        name: str,
        weight: int,
        suffix: str,
        damage: Callable[[random.Random], bytes],
        use: Callable[[Path], None],
    ) -> None:
        self.name, self.weight = name, weight
        self._suffix, self._damage, self._use = suffix, damage, use

    def begin(self, _block: int, _rng: random.Random) -> None:
        """Nothing is kept from case to case."""

    def case(self, rng: random.Random, report: Report) -> None:
        """Read one damaged file."""
        data = self._damage(rng)
        path = _folder() / f"case{self._suffix}"
        path.write_bytes(data)
        report(repr(data[:400]))
        allowed(lambda: self._use(path))


@functools.cache
def _folder() -> Path:
    _folder.kept = tempfile.TemporaryDirectory(prefix="fuzz_")  # type: ignore[attr-defined]
    return Path(_folder.kept.name)  # type: ignore[attr-defined]


def texts(
    good: Callable[[], Sequence[str]], words: Sequence[str]
) -> Callable[[random.Random], bytes]:
    """Return what damages one of some texts, line by line; now and then its bytes."""

    def damage(rng: random.Random) -> bytes:
        text = mutate.lines(rng, rng.choice(good()), words)
        data = text.encode("utf-8", "replace")
        return mutate.octets(rng, data) if rng.random() < 0.1 else data

    return damage


def _parameters(path: Path) -> None:
    values = read([path], SCHEMAS)
    ros_parameters([path], ESTIMATOR, "/drone1")
    estimator_config(values[ESTIMATOR])
    detector_config(values[DETECTOR])


def _camera(path: Path) -> None:
    camera = read_camera_file(path).camera
    corners = np.array([[0.0, 0.0], [camera.width - 1.0, camera.height - 1.0]])
    rays, known = camera.rays(corners)
    if not np.isfinite(rays[known]).all():
        raise Broken(NOT_FINITE, f"rays not finite: {rays.tolist()}")
    path.write_text(camera_file_text(camera, "again"), encoding="utf-8")
    read_camera_file(path)


def _flight_record(path: Path) -> None:
    log = read_dji_log(path)
    heights = np.array([height.value for height in log.heights()])  # rows may have none
    columns = (log.latitude, log.longitude, heights, log.attitude, log.gimbal, log.seconds)
    if not all(np.isfinite(column).all() for column in columns):
        raise Broken(NOT_FINITE, f"flight record: {log}")
    if (np.diff(log.stamps_ns) <= 0).any() or (abs(log.latitude) > 0.5 * np.pi).any():
        raise Broken(NOT_FINITE, f"flight record out of range: {log}")
    check_sentence(" ".join((*log.statements, *log.guesses)))
    _ = log.gaps_s
    for _stamp_ns, _topic, msgtype, fields in messages(log, None, log.clock_ns or 0):
        make(msgtype, fields)


def _state(path: Path) -> None:
    saved = load(path)
    if from_text(to_text(saved), "again") != from_text(to_text(from_text(to_text(saved), "")), ""):
        raise Broken(OUTPUT, f"names change when saved: {saved}")
    engine = Estimator(estimator_config({"state_file": str(path)}))
    engine.flush()
    load(path)


def _rejections(path: Path) -> None:
    read_rejections(path)


def _drones(path: Path) -> None:
    for drone in read_drones(path).values():
        places = np.array([drone.path.latitude, drone.path.longitude])
        if not np.isfinite(places).all() or not len(drone.path):
            raise Broken(NOT_FINITE, f"a drone's path: {places.tolist()}")


def _positions(path: Path) -> None:
    read_positions(path)


def _image(path: Path) -> None:
    data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    decode(SimpleNamespace(format="jpeg", data=data))


def _photo(path: Path) -> None:
    read_photo(path)


@functools.cache
def _pictures() -> tuple[bytes, ...]:
    rng = np.random.default_rng(1)
    picture = rng.integers(0, 255, (24, 32, 3), dtype=np.uint8)
    encoded = [cv2.imencode(kind, picture)[1].tobytes() for kind in (".jpg", ".png")]
    stream = io.BytesIO()
    exif = Image.Exif()
    exif[0x0110] = "camera"
    exif.get_ifd(0x8769)[0xA405] = 24
    Image.fromarray(picture).save(stream, "JPEG", exif=exif)
    return (*encoded, stream.getvalue())


def _octets(good: Callable[[], Sequence[bytes]]) -> Callable[[random.Random], bytes]:
    def damage(rng: random.Random) -> bytes:
        data = mutate.octets(rng, rng.choice(good()), rng.choice(good()))
        if rng.random() < 0.1 and len(data) > 24:  # a size that the pixels do not fill
            data = data[:16] + rng.randbytes(8) + data[24:]
        return data

    return damage


class Models:
    """What a detection model says of itself."""

    name, weight, block = "onnx", 4, 100

    def begin(self, _block: int, _rng: random.Random) -> None:
        """Nothing is kept from case to case."""

    def case(self, rng: random.Random, report: Report) -> None:
        """Read damaged metadata and shapes."""
        names = mutate.lines(rng, rng.choice(samples.NAMES), samples.YAML_WORDS)
        metadata = {"names": names, "task": "detect"}
        if rng.random() < 0.1:
            metadata["task"] = mutate.text(rng, "detect")
        look = mutate.lines(rng, json.dumps({"side": 64, "near": 2.0}), samples.JSON_WORDS)
        shape = [rng.choice((1, 3, 640, -1, 0, None, "n", 2**63)) for _ in range(rng.randrange(7))]
        given = ("aqua",) if rng.random() < 0.3 else ()
        report(f"{metadata}, {look[:100]!r}, {shape}")
        allowed(lambda: class_names(metadata, given, "model"))
        allowed(lambda: agreed_names(("a", "b"), given, "model"))
        allowed(lambda: input_size(shape, "model"))
        allowed(lambda: Terms.read({"second_look": look}, "model"))


def targets() -> list[Parser | Models]:
    """Return the targets that read files."""
    return [
        Parser("yaml", 8, ".yaml", texts(samples.parameters, samples.YAML_WORDS), _parameters),
        Parser("camera", 4, ".yaml", texts(lambda: samples.CAMERA, samples.YAML_WORDS), _camera),
        Parser("csv", 6, ".csv", texts(lambda: samples.CSV, samples.CSV_WORDS), _flight_record),
        Parser("srt", 6, ".srt", texts(lambda: samples.SRT, samples.SRT_WORDS), _flight_record),
        Parser("state", 4, ".json", texts(lambda: (samples.STATE,), samples.JSON_WORDS), _state),
        Parser(
            "positions", 2, ".csv", texts(lambda: (samples.POSITIONS,), samples.CSV_WORDS),
            _positions,
        ),
        Parser(
            "drones", 1, ".csv", texts(lambda: (samples.DRONES,), samples.CSV_WORDS), _drones
        ),
        Parser(
            "rejected", 1, ".csv", texts(lambda: (samples.REJECTED,), samples.CSV_WORDS),
            _rejections,
        ),
        Parser("images", 4, ".jpg", _octets(_pictures), _image),
        Parser("photo", 2, ".jpg", _octets(lambda: _pictures()[2:]), _photo),
        Models(),
    ]  # fmt: skip
