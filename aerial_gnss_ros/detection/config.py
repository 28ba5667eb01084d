# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The detector's parameters: every key with unit, meaning, default and consequence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.core.config.schema import build, group, key
from aerial_gnss_ros.detection.image_header import HIGHEST_MAX_PIXELS, MAX_PIXELS
from aerial_gnss_ros.detection.search_config import SearchConfig


@dataclass(frozen=True)
class ImageConfig:
    """Source of images."""

    topic: str = key(
        "camera/image_raw",
        "Image topic, relative to the namespace, without the ending /compressed.",
    )
    transport: str = key(
        "raw",
        "raw: sensor_msgs/Image on the topic; compressed: sensor_msgs/CompressedImage (jpeg or "
        "png) on the topic with /compressed added. Compressed takes a tenth of the bandwidth and "
        "some milliseconds of decoding.",
        choices=("raw", "compressed"),
    )
    max_pixels: int = key(
        MAX_PIXELS,
        "Images of more pixels (width times height) are refused before they are decoded: a damaged "
        "or hostile one of a few hundred kilobytes can otherwise fill the memory. A decoded pixel "
        "takes 3 bytes. The default is more than any drone's camera has.",
        unit="px",
        low=1,
        high=HIGHEST_MAX_PIXELS,
    )

    @property
    def full_topic(self) -> str:
        """The topic that is subscribed to."""
        return self.topic + "/compressed" if self.transport == "compressed" else self.topic


@dataclass(frozen=True)
class CameraInfoConfig:
    """CameraInfo, used only to refuse images of another size."""

    topic: str = key("camera/camera_info", "CameraInfo topic, relative to the namespace.")


@dataclass(frozen=True)
class DetectionsOutConfig:
    """Where boxes are published."""

    topic: str = key("detections", "Detection2DArray topic, relative to the namespace.")


@dataclass(frozen=True)
class AnnotatedConfig:
    """Images with drawn boxes for viewers, made only while somebody subscribes."""

    topic: str = key(
        "annotated",
        "Their topic, relative to the namespace, without the ending /compressed: JPEG in "
        "sensor_msgs/CompressedImage.",
    )
    rate_hz: float = key(
        5.0,
        "Greatest rate. Drawing and encoding take some milliseconds of the detector's time, after "
        "its boxes are published.",
        unit="Hz",
        low=0.1,
        high=60.0,
    )
    width_px: int = key(
        960, "Larger images are reduced to this width.", unit="px", low=64, high=8192
    )

    @property
    def full_topic(self) -> str:
        """The topic that is published."""
        return f"{self.topic}/compressed"


BACKENDS = ("auto", "tensorrt", "cuda", "openvino", "onnxruntime", "ultralytics")


@dataclass(frozen=True)
class DetectorConfig:
    """All parameters of the detector."""

    model: str = key(
        "aqua_yolo11n.onnx",
        "Path of the model, or the name of one in the package's folder models: aqua_yolo11n.onnx, "
        "or aqua_small.onnx, which is under Apache-2.0. They are trained on rendered images, for "
        "demonstration and tests: fine-tune them on your own. anomaly: no network, but anything "
        "whose colour is unlike the water around it, as class object.",
    )
    backend: str = key(
        "auto",
        "auto: the fastest that is available, logged at start. For .onnx: tensorrt if an .engine "
        "built from it is beside it and fits this device, then cuda (onnxruntime-gpu), openvino, "
        "onnxruntime. For .engine: tensorrt. For .pt: ultralytics. Or the one to use.",
        choices=BACKENDS,
    )
    precision: str = key(
        "auto",
        "Precision of the network on OpenVINO. auto: bf16 if the processor has it, else f32. "
        "bf16: half the time of f32; box centres move by at most 0.2 px in 95 of 100 boxes. f32: "
        "the same boxes as ONNX Runtime. Models exported to fp16 or int8 have a fixed precision.",
        choices=("auto", "f32", "bf16"),
    )
    allow_pickle: bool = key(
        False,
        "A .pt file is a pickle: loading it can run arbitrary code. Set True only if you trust "
        "the file.",
    )
    second_look: str = key(
        "auto",
        "A small network that rescores uncertain boxes from an enlarged crop with more context: "
        "fewer false boxes, for some milliseconds each. auto: MODEL_second_look.onnx beside "
        "the model, if it exists. off: none. Or the path of one. With the model anomaly: what "
        "aerial-gnss teach has trained; it names the classes.",
    )
    class_names: tuple[str, ...] = key(
        (),
        "Class names, in the model's order; empty: those in the model file. Their number must be "
        "the model's number of classes.",
    )
    score_threshold: float = key(
        0.3,
        "Boxes below are not reported. A lower value finds more robots and more clutter. The "
        "default has the best F1 score with the shipped model; your own model has another optimum.",
        low=0.001,
        high=1.0,
        dynamic=True,
    )
    iou_threshold: float = key(
        0.5,
        "Of two boxes of one class that overlap more than this, the better one is kept "
        "(non-maximum suppression). A lower value merges robots side by side.",
        low=0.01,
        high=1.0,
        dynamic=True,
    )
    max_detections: int = key(
        100, "Greatest number of boxes of an image, the best ones.", low=1, high=1000, dynamic=True
    )
    image_size: int = key(
        1280,
        "Longest side of the network's input; larger images are reduced to it, smaller ones are "
        "not enlarged. Half of it is four times as fast and misses robots below about 32 px. A "
        "model with a fixed input size uses that.",
        unit="px",
        low=32,
        high=8192,
    )
    threads: int = key(
        0, "Processor threads of the network; 0: one for each core.", low=0, high=256
    )
    device: str = key(
        "",
        "Device of the back end ultralytics, in its notation: cpu, 0, cuda:0; empty: its choice.",
    )
    autostart: bool = key(
        True,
        "False: the node loads and subscribes nothing until lifecycle transitions (configure, "
        "activate) ask for it. Deactivate and cleanup give the network's memory back in flight.",
    )
    search: SearchConfig = group(SearchConfig)
    image: ImageConfig = group(ImageConfig)
    camera_info: CameraInfoConfig = group(CameraInfoConfig)
    detections: DetectionsOutConfig = group(DetectionsOutConfig)
    annotated: AnnotatedConfig = group(AnnotatedConfig)


def detector_config(values: Mapping[str, Any]) -> DetectorConfig:
    """Return the detector's parameters from nested or dotted values, as in config/detector.yaml.

    Raises:
        ConfigError: unknown key, wrong type, or out of range.
    """
    return build(DetectorConfig, values)
