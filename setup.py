# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Installs the package with pip, and with colcon (ament_python)."""

import sys
from pathlib import Path

from setuptools import find_packages, setup

NAME = "aerial_gnss_ros"
HERE = Path(__file__).resolve().parent

# Lower bounds are what Ubuntu 24.04 brings, so that apt's versions satisfy them.
REQUIRES = [
    "numpy>=1.26",
    "scipy>=1.11",
    "pyproj>=3.6",
    "opencv-python-headless>=4.6",
    "PyYAML>=6.0",
    "rosbags>=0.11.7",
    "onnxruntime>=1.17",
    "rich>=13.7",
    "matplotlib>=3.6",
    "pillow>=10.2",
    "jinja2>=3.1",
    "pygeomag>=1.0",
    "tornado>=6.4",
]
TEST = [
    "pytest>=7.4",
    "pytest-xdist>=3.7",  # make test runs on two processes
    "hypothesis>=6.90",
    "pymap3d>=3.0",
    "onnx>=1.15",  # builds small detection models
    "pymavlink>=2.4.41",  # reads back what --mavlink and --gps-input send
    "pynmea2>=1.19",  # reads back what --nmea sends
    "pyais>=3.3",  # reads back what --ais sends
    "motmetrics>=1.4",
    "trimesh>=4.5",  # meshes of robots
    "selenium>=4.10",  # drives the browser that opens the page of `view`
    # other programs' readers of our maps
    "gpxpy>=1.6",
    "fastkml>=1.0",
    "lxml>=5.0",
    "geojson>=3.0",
    "pycocotools>=2.0.7",  # the reference for average precision
    # test_install.py builds the package as pip and as colcon do
    "colcon-common-extensions>=0.3",
    "setuptools>=68",
    "wheel>=0.42",
]
DOCS = ["sphinx>=7.2", "docutils>=0.21", "myst-parser>=3.0", "furo>=2024.1"]
LINT = ["ruff>=0.6", "mypy>=1.11", "types-PyYAML", "types-setuptools"]
EXTRAS = {
    # ROS 2 Jazzy where no ROS is installed; exactly the versions that interfaces/ is built against.
    "ros": [
        "ros-jazzy-rclpy==7.1.6",
        "ros-jazzy-common-interfaces==5.3.6",
        "ros-jazzy-rmw-fastrtps-cpp==8.4.3",
    ],
    "openvino": ["openvino>=2024.0"],
    "tensorrt": ["tensorrt>=10.0", "cuda-python>=12.0"],  # with an NVIDIA GPU; JetPack brings both
    "export": ["onnx>=1.15"],  # aerial-gnss export to 16 and 8 bits; needs no torch
    # aerial-gnss simulate --renderer blender; bpy 5.0 exists for no other Python
    "blender": ['bpy>=5.0,<5.1; python_version == "3.11"'],
    "mavlink": ["pymavlink>=2.4.41"],  # aerial-gnss stream --mavlink, --gps-input
    "ais": ["pyais>=3.3"],  # aerial-gnss stream --ais
    "training": [
        "torch>=2.2",
        "onnx>=1.15",
    ],  # aerial-gnss teach, second looks: BSD-3-Clause, Apache-2.0
    "ultralytics": ["ultralytics>=8.3", "onnx>=1.15"],  # AGPL-3.0: training, .pt and .engine models
    "mesh": ["trimesh>=4.5"],  # aerial-gnss simulate --robot-model FILE
    "identity": ["motmetrics>=1.4"],  # IDF1 and identity switches in `aerial-gnss evaluate`
    "test": TEST,
    "lint": LINT,
    "docs": DOCS,
}
# fmt: off
PACKAGE_DATA = [
    "py.typed", "**/*.msg", "**/*.html", "**/*.css", "**/*.js", "**/*.xml", "**/*.npz",
    "view/static/vendor/*/LICENSE",
]
# fmt: on


def shared_files() -> list[tuple[str, list[str]]]:
    """Return what goes to share/aerial_gnss_ros; `resources.py` finds it there."""
    files = [
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
    ]
    for top in ("config", "launch", "models", "rviz"):
        folders = [HERE / top, *(path for path in sorted((HERE / top).rglob("*")) if path.is_dir())]
        for folder in folders:
            names = [
                path.relative_to(HERE).as_posix()
                for path in sorted(folder.iterdir())
                if path.is_file() and not path.name.startswith(".") and path.suffix != ".pyc"
            ]
            if names:
                files.append((f"share/{NAME}/{folder.relative_to(HERE).as_posix()}", names))
    return files


def console_scripts() -> list[str]:
    """Return the commands: `ros2 run aerial_gnss_ros detector`, but no `detector` on the PATH.

    colcon installs through `setup.py install` or `develop`, into lib/aerial_gnss_ros, where each
    name is the package's own. pip puts the commands beside everybody else's in bin/, so there
    they carry the package's name.
    """
    by_colcon = not {"install", "develop"}.isdisjoint(sys.argv)
    prefix = "" if by_colcon else "aerial-gnss-"
    return [
        f"aerial-gnss = {NAME}.cli:main",
        f"{prefix}detector = {NAME}.nodes.detector:main",
        f"{prefix}estimator = {NAME}.nodes.estimator:main",
        f"{prefix}fleet = {NAME}.nodes.fleet:main",
    ]


setup(
    name=NAME,
    version="0.1.0",
    description="Finds marine robots in a drone's images and publishes where they are (WGS84)",
    author="aerial_gnss_ros developers",
    maintainer="aerial_gnss_ros developers (see CONTRIBUTING.md)",
    maintainer_email="maintainers@example.org",
    license="Apache-2.0 AND AGPL-3.0-only AND BSD-2-Clause",
    license_files=["LICENSE", "models/LICENSE", f"{NAME}/view/static/vendor/leaflet/LICENSE"],
    python_requires=">=3.10",
    install_requires=REQUIRES,
    extras_require=EXTRAS,
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: PACKAGE_DATA},
    data_files=shared_files(),
    entry_points={"console_scripts": console_scripts()},
    zip_safe=False,
)
