# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The sidecar of a TensorRT engine: its target, checked before loading.

An engine is compiled code for one GPU and one version of TensorRT. On another one it is not always
refused: it can crash or be slow. So MODEL.engine comes with MODEL.engine.json.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.text.json_text import parse_json

_REBUILD = "build it on this device with aerial-gnss export"


@dataclass(frozen=True)
class EngineCard:
    """Target and source of an engine.

    Attributes:
        tensorrt: version, exactly.
        gpu: its name.
        compute_capability: such as 8.7.
        input_shape: batch, 3, height, width; -1: any (of the range it was built for).
        precision: fp32, fp16 or int8.
        source: name of the model from which it was built.
        source_sha256: of that file.
        engine_sha256: of the engine, to recognise an incomplete copy.
        metadata: names and task, as in the ONNX model.
    """

    tensorrt: str
    gpu: str
    compute_capability: str
    input_shape: tuple[int, ...]
    precision: str
    source: str
    source_sha256: str
    engine_sha256: str
    metadata: dict[str, str]

    def text(self) -> str:
        """Return the sidecar's content."""
        return json.dumps(asdict(self), indent=2) + "\n"


def card_path(engine: Path) -> Path:
    """Return the path of an engine's sidecar."""
    return engine.with_name(f"{engine.name}.json")


def read_card(engine: Path) -> EngineCard:
    """Return the sidecar of an engine.

    Raises:
        ModelError: missing or invalid.
    """
    path = card_path(engine)
    if not path.is_file():
        raise ModelError(
            f"{engine} has no {path.name} beside it, so its GPU is unknown; {_REBUILD}, or choose "
            "the back end ultralytics if that made it."
        )
    try:
        stored = parse_json(path.read_text(encoding="utf-8"))
        return EngineCard(**{**stored, "input_shape": tuple(stored["input_shape"])})
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise ModelError(f"{path} cannot be read as an engine's sidecar; {_REBUILD}.") from error


def check_fits(
    engine: Path, card: EngineCard, tensorrt: str, gpu: str, compute_capability: str
) -> None:
    """Refuse an engine that was built for another GPU or version.

    Args:
        engine: the file.
        card: its sidecar.
        tensorrt: version here.
        gpu: name of the GPU here.
        compute_capability: of the GPU here.

    Raises:
        ModelError: it does not match; the sentence names both sides.
    """
    for what, built, here in (
        ("TensorRT", card.tensorrt, tensorrt),
        ("the GPU", card.gpu, gpu),
        ("compute capability", card.compute_capability, compute_capability),
    ):
        if built != here:
            raise ModelError(
                f"{engine} was built for {what} {built}, but this device has {here}; {_REBUILD}."
            )
    if sha256(engine) != card.engine_sha256:
        raise ModelError(
            f"{engine} is not the file that {card_path(engine).name} describes: it was changed or "
            f"not copied completely; copy both again, or {_REBUILD}."
        )


def engine_of(model: Path) -> Path | None:
    """Return the engine beside a model, if it was built from exactly this model."""
    engine = model.with_suffix(".engine")
    if not (engine.is_file() and model.is_file()):
        return None
    try:
        card = read_card(engine)
    except ModelError:
        return None
    return engine if card.source_sha256 == sha256(model) else None


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
