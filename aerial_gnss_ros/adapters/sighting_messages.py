# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The topic `sightings`: what a drone tells the fleet of one image, as JSON in a String.

Every number is written so that the same number is read. A format of one's own in a standard
message, because drones and shore are updated one at a time: another version of a message *type* is
not received, without a word, whereas another version of this text is refused with a sentence. And
it needs no second package, which each vehicle and each shore would have to build.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.schema import type_hints
from aerial_gnss_ros.core.fleet.outbox import SentSighting
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.identity.label_format import class_token
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.errors import CameraError, InputError
from aerial_gnss_ros.core.values.reference_place import ReferencePlace
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.text.sentences import counted, cut, shown

Array = NDArray[np.float64]

SIGHTINGS = ("sightings", "std_msgs/msg/String")
VERSION = 1
MOST_BOXES = 1000
_LONGEST = 1_000_000  # characters of a message, some 1000 boxes
_LARGEST = 2**63
_SHAPES: dict[str, tuple[int, ...]] = {
    "jump": (3,), "believed": (2,), "pixels": (-1, 2), "doubt": (-1, 2, 2),
    "enu_from_camera": (3, 3), "fix_covariance": (2, 2), "interpolation": (6,), "gaps_s": (6,),
    "sizes": (-1, 2), "scores": (-1,), "K": (3, 3), "D": (-1,), "R": (3, 3), "covariance": (2, 2),
}  # fmt: skip
_MAY_BE_NAN = ("altitude",)
_FITS: dict[Any, Callable[[Any], bool]] = {
    int: lambda value: type(value) is int and 0 <= value < _LARGEST,
    float: lambda value: type(value) in (int, float) and -_LARGEST < value < _LARGEST,
    bool: lambda value: type(value) is bool,
    str: lambda value: type(value) is str,
}
_KINDS = {
    int: "a whole number from 0 to 2^63 - 1", float: "a number", bool: "true or false", str: "text",
}  # fmt: skip
_LISTS: dict[Any, type[Any]] = {
    tuple[str, ...]: str, tuple[int, ...]: int, tuple[ReferencePlace, ...]: ReferencePlace,
}  # fmt: skip
_PER_BOX = ("labels", "tracks", "class_ids", "pixels", "doubt", "sizes", "scores")
_MAY_BE_ABSENT: dict[str, Any] = {"sizes": None, "scores": None, "references": []}
"""What earlier releases did not send. References are sent only where there are any: they read it
then, too."""


def sighting_text(sent: SentSighting) -> str:
    """Return a sighting as JSON."""
    document = {
        "version": VERSION,
        "drone": sent.drone,
        "session": sent.session,
        "sequence": sent.sequence,
        "oldest": sent.oldest,
        "sighting": _plain(sent.sighting),
    }
    if not sent.sighting.references:
        del document["sighting"]["references"]
    return json.dumps(document, separators=(",", ":"), allow_nan=False)


def sent_sighting(text: str) -> SentSighting:
    """Return the sighting in a JSON text.

    Raises:
        InputError: it is none, or what it says cannot be; the sentence says what.
    """
    document = message_document(text, "a sighting")
    session, sequence, oldest = (whole(document, n) for n in ("session", "sequence", "oldest"))
    seen = _built(Sighting, document.get("sighting"), "sighting")
    _check(seen)
    return SentSighting(drone_name(document), session, sequence, oldest, seen)


def message_document(text: str, what: str) -> dict[str, Any]:
    """Return the content of a message between drones and fleet.

    Args:
        text: JSON.
        what: it should be, for sentences.

    Raises:
        InputError: it is no object, or of another version.
    """
    if len(text) > _LONGEST:
        raise InputError(f"{what} of {len(text)} characters is refused: at most {_LONGEST}.")
    try:
        document = parse_json(text)
    except ValueError as error:
        raise InputError(f"{what} is not JSON: {cut(str(error))}.") from error
    if not isinstance(document, dict):
        raise InputError(f"{what} is not a JSON object.")
    version = document.get("version")
    if version != VERSION or isinstance(version, bool):
        raise InputError(
            f"{what} is of version {shown(version)}, this program reads {VERSION}: run the "
            "same release on all drones and ashore."
        )
    return document


def drone_name(document: Mapping[str, Any]) -> str:
    """Return the drone's name in a message.

    Raises:
        InputError: it cannot be one.
    """
    name = document.get("drone")
    if not isinstance(name, str) or not is_name(name):
        raise InputError(
            f"a drone's name cannot be {shown(name)}: use a-z, 0-9 and _, a letter first."
        )
    return name


def is_name(text: str) -> bool:
    """Return whether a text can be a robot's or a drone's name, a part of a topic."""
    return len(text) <= 64 and _is_token(text)


@lru_cache(maxsize=4096)
def _is_token(text: str) -> bool:
    return text == class_token(text)


def _what(name: str) -> str:
    return "a sighting" if name == "sighting" else f"the {name} of a sighting"


def _refused(name: str, kind: str, value: Any) -> InputError:
    """Return why a field is refused that should be of another kind."""
    if value is None:
        return InputError(f"{_what(name)} must be {kind}, but has no value.")
    return InputError(f"{_what(name)} must be {kind}, not {shown(value)}.")


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: NaN is null."""
    if is_dataclass(value):
        return {one.name: _plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, float):
        return None if math.isnan(value) else float(value)
    return [_plain(one) for one in value] if isinstance(value, tuple) else value


def _built(kind: type[Any], value: Any, name: str) -> Any:
    """Return a dataclass from its fields as JSON has them.

    Raises:
        InputError: one is absent, unknown or of another kind.
    """
    hints = type_hints(kind)
    if isinstance(value, dict) and kind is Sighting:
        value = _MAY_BE_ABSENT | value
    if not isinstance(value, dict):
        raise _refused(name, "an object", value)
    missing, unknown = hints.keys() - value.keys(), value.keys() - hints.keys()
    if missing:
        raise InputError(f"{_what(name)} has no {cut(', '.join(sorted(missing)))}.")
    if unknown:
        raise InputError(f"{_what(name)} has unknown keys: {cut(', '.join(sorted(unknown)))}.")
    made = {key: _value(hint, value[key], key) for key, hint in hints.items()}
    if kind is CameraModel:
        return _camera(json.dumps(value))
    return kind(**made)


@lru_cache(maxsize=64)
def _camera(text: str) -> CameraModel:
    """Return a camera; each image has the same one, whose checks take time."""
    given = json.loads(text)
    try:
        return CameraModel(
            **{k: _value(h, given[k], k) for k, h in type_hints(CameraModel).items()}
        )
    except CameraError as error:
        raise InputError(f"the camera of a sighting is refused: {error}") from error


def _value(hint: Any, value: Any, name: str) -> Any:
    """Return a field's value.

    Raises:
        InputError: it is of another kind.
    """
    if is_dataclass(hint):
        return _built(hint, value, name)  # type: ignore[arg-type]  # is_dataclass of a class
    if hint in _FITS:
        if value is None and name in _MAY_BE_NAN:
            return math.nan
        if not _FITS[hint](value):
            raise _refused(name, _KINDS[hint], value)
        return hint(value)
    if hint in _LISTS:
        if not isinstance(value, list):
            raise _refused(name, "a list", value)
        kind = _LISTS[hint]
        if kind in _FITS and all(map(_FITS[kind], value)):
            return tuple(value)
        return tuple(_value(kind, one, name) for one in value)
    return None if value is None and hint != Array else _array(value, name)


def _array(value: Any, name: str) -> Array:
    try:
        made = np.array(value, dtype=np.float64)
        shape = _SHAPES.get(name, made.shape)
        if made.size == 0:
            made = made.reshape([max(n, 0) for n in shape])
        fits = made.ndim == len(shape) and all(
            n in (-1, m) for n, m in zip(shape, made.shape, strict=True)
        )
    except (TypeError, ValueError, OverflowError):
        fits = False
    if not fits or not np.isfinite(made).all():
        raise InputError(f"{_what(name)} must be {shape_words(name)} finite numbers.")
    return made


def shape_words(name: str) -> str:
    """Return the shape that an array has, such as n x 2."""
    return " x ".join("n" if n < 0 else str(n) for n in _SHAPES.get(name, ())) or "finite"


def whole(document: Mapping[str, Any], name: str) -> int:
    """Return a whole number in a message.

    Raises:
        InputError: it is none.
    """
    value: int = _value(int, document.get(name), name)
    return value


def _check(seen: Sighting) -> None:
    """Refuse a sighting that cannot be.

    Raises:
        InputError: says what.
    """
    pose, count = seen.pose, len(seen.pixels)
    for name in _PER_BOX:
        of = getattr(seen, name)
        if of is not None and len(of) != count:
            raise InputError(f"a sighting has {len(of)} {name} for {counted(count, 'box')}.")
    if seen.sizes is not None and (seen.sizes < 0.0).any():
        raise InputError("a sighting has a box of negative size.")
    if seen.scores is not None and not ((seen.scores >= 0.0) & (seen.scores <= 1.0)).all():
        raise InputError("a sighting has a score that is not within 0 to 1.")
    if count > MOST_BOXES:
        raise InputError(f"a sighting of {count} boxes is refused: at most {MOST_BOXES}.")
    named = [label for label in seen.labels if label]
    if len(set(named)) < len(named):
        raise InputError("a sighting has two boxes of one robot.")
    if len(set(seen.tracks)) < count:
        raise InputError("a sighting has two boxes of one track.")
    for label in named:
        if not is_name(label):
            raise InputError(f"a robot's name cannot be {shown(label)}.")
    _check_pose(pose)
    fix = () if pose.fix_covariance is None else (pose.fix_covariance,)
    _check_references(seen)
    of_references = [one.covariance for one in seen.references]
    matrices = np.array([*seen.doubt, *fix, *of_references]).reshape(-1, 2, 2)
    least = -1e-6 * (1.0 + np.trace(matrices, axis1=1, axis2=2))
    even = np.allclose(matrices, matrices.transpose(0, 2, 1))
    if not even or (np.linalg.eigvalsh(matrices)[:, 0] < least).any():
        raise InputError("a covariance in a sighting is not symmetric and positive.")
    if not 0.0 < seen.level < 1e6:
        raise InputError(f"the level of a sighting must lie within 0 to 1e6, not {seen.level:g}.")


def _check_references(seen: Sighting) -> None:
    names = [one.name for one in seen.references]
    if len(set(names)) < len(names):
        raise InputError("a sighting has two references of one name.")
    for one in seen.references:
        places = abs(one.latitude) <= math.pi / 2.0 and abs(one.longitude) <= 2.0 * math.pi
        if not one.moves or not is_name(one.name) or not places or one.height < 0.0:
            raise InputError(f"a sighting has an impossible reference: {cut(repr(one))}.")
        if not (one.covariance.diagonal() > 0.0).all():
            raise InputError(f"reference {one.name} of a sighting must have a covariance above 0.")


def _check_pose(pose: CameraPose) -> None:
    places = abs(pose.latitude) <= math.pi / 2.0 and abs(pose.longitude) <= 2.0 * math.pi
    if not places or not pose.height > 0.0:
        raise InputError(
            f"a camera at latitude {math.degrees(pose.latitude):g}, longitude "
            f"{math.degrees(pose.longitude):g} deg, {pose.height:g} m above the water is refused."
        )
    turned = pose.enu_from_camera
    if not np.allclose(turned @ turned.T, np.eye(3), atol=1e-6) or np.linalg.det(turned) < 0.0:
        raise InputError("the enu_from_camera of a sighting is not a rotation matrix.")
    if (pose.interpolation < 0.0).any() or (pose.gaps_s < 0.0).any():
        raise InputError("the interpolation and gaps_s of a sighting must not be negative.")
