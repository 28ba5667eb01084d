# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What every test shares: its own corner of the network, and recorded data where there is any."""

from __future__ import annotations

import gc
import math
import os
import tempfile
from itertools import groupby
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# The same examples on every machine, and none that fails because the machine was busy.
settings.register_profile(
    "steady", deadline=None, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.too_slow],
)  # fmt: skip
settings.load_profile("steady")

REPOSITORY = Path(__file__).resolve().parent.parent

# Before any test imports rclpy: nodes under test neither hear nor disturb others.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ.setdefault("ROS_DOMAIN_ID", str(os.getpid() % 100 + 1))
WORKER = os.environ.get("PYTEST_XDIST_WORKER", "")
"""gw0, gw1, … where pytest-xdist runs tests side by side; they share the variables of the first."""
if WORKER:
    DOMAIN = int(os.environ["ROS_DOMAIN_ID"]) + 37 * int(WORKER.removeprefix("gw"))
    os.environ["ROS_DOMAIN_ID"] = str(DOMAIN % 102)  # above 101 ports may be taken by others
os.environ["ROS_LOG_DIR"] = os.environ.get("ROS_LOG_DIR") or tempfile.mkdtemp(prefix="ros_log_")
os.environ.setdefault("MPLBACKEND", "Agg")
# As the package does it; here for all that a test imports before the package.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.hookimpl(hookwrapper=True)
def pytest_collection():
    """Keep the garbage collector from what lives as long as the tests."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


IN_TURN = tuple(f"test/nodes/test_{name}.py" for name in ("live", "player", "fleet"))
"""Files whose programs have to keep up with the clock: never two of them at once."""
APART = ("test/nodes/", "test/test_printed_sessions.py", "test/training/test_curriculum.py")
"""Tests that mostly wait or take long, and share nothing: any process may take the next."""
LONGEST = (
    "test_printed_sessions.py",
    "nodes",
    "interfaces",
    "training",
    "test_install.py",
    "commands",
    "fuzz",
)
"""What begins first, so that no process waits for it at the end."""


def group_of(nodeid: str) -> str:
    """Return the group of a test: one process runs all tests of a group.

    A file is a group, so that its fixtures are made once; of `APART` each test is one.
    """
    path = nodeid.partition("::")[0]
    if path in IN_TURN:
        return "in turn"
    return nodeid if path.startswith(APART) else path


@pytest.hookimpl(optionalhook=True)  # pytest-xdist may not be installed
def pytest_xdist_make_scheduler(config, log):
    """Let `--dist loadscope` keep tests of a group together.

    `xdist_group` marks with `--dist loadgroup` would be the usual way, but pytest-xdist 3.8 ignores
    them with pytest 9.2.
    """
    from xdist.scheduler import LoadScopeScheduling

    class GroupScheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return group_of(nodeid)

    return GroupScheduling(config, log) if config.getvalue("dist") == "loadscope" else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Begin with what takes longest, and let tests of nodes wait beside others that compute."""

    def rank(item):
        part = item.path.relative_to(REPOSITORY / "test").parts[0]
        return LONGEST.index(part) if part in LONGEST else len(LONGEST)

    def waits(item):
        return item.nodeid.startswith("test/nodes/") and group_of(item.nodeid) == item.nodeid

    if not WORKER:
        return
    items.sort(key=rank)
    waiting = [item for item in items if waits(item)]
    computing = [item for item in items if not waits(item)]
    groups = [list(of) for _, of in groupby(computing, key=lambda item: group_of(item.nodeid))]
    share = math.ceil(len(waiting) / max(1, len(groups)))
    items[:] = []
    for group in groups:
        items += [*group, *waiting[:share]]
        del waiting[:share]
    items += waiting


@pytest.fixture(scope="session")
def repository() -> Path:
    """Return the root of the source tree."""
    return REPOSITORY


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Return the folder of recorded flights, or skip: a user's clone does not hold them."""
    path = REPOSITORY.parent / "shared" / "data"
    if not path.is_dir():
        pytest.skip(f"no recorded flights: {path} is absent (it is not part of the repository)")
    return path


@pytest.fixture(scope="session")
def independent_flights(shared_data) -> Path:
    """Return the folder of flights of another simulation, or skip."""
    path = shared_data / "independent_flights"
    if not path.is_dir():
        pytest.skip(f"no independent flights: {path} is absent")
    return path


@pytest.fixture(scope="session")
def make_set():
    """Return a function that writes a small labelled data set: coloured discs on grey water."""
    import cv2
    import numpy as np

    def make(folder, robots=(1, 2, 1, 3), splits=("train", "val"), side=64, classes=("aqua",)):
        """Write a data set; image i of each split shows robots[i] discs, of any class."""
        rng = np.random.default_rng(0)
        for split in splits:
            for kind in ("images", "labels"):
                (folder / kind / split).mkdir(parents=True)
            for i, count in enumerate(robots):
                image = np.clip(rng.normal(90, 6, (side, side, 3)), 0, 255).astype(np.uint8)
                lines = []
                for n in range(count):
                    # Each in a strip of its own, so that none hides another.
                    u, v = int(side * (n + 0.5) / count), int(rng.integers(12, side - 12))
                    number = int(rng.integers(len(classes)))
                    radius = min(8, side // (2 * count) - 1)
                    cv2.circle(image, (u, v), radius, (0, 128 + 60 * number, 255), -1)
                    size = (2 * radius + 1) / side
                    lines.append(f"{number} {(u + 0.5) / side} {(v + 0.5) / side} {size} {size}\n")
                cv2.imwrite(str(folder / "images" / split / f"{i}.png"), image)
                (folder / "labels" / split / f"{i}.txt").write_text("".join(lines))
        names = "".join(f"  {i}: {name}\n" for i, name in enumerate(classes))
        paths = "".join(f"{split}: images/{split}\n" for split in splits)
        (folder / "data.yaml").write_text(f"{paths}names:\n{names}")
        return folder

    return make
