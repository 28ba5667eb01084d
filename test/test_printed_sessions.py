# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The command blocks of README, tutorials and how-tos run as printed, in the order of their page.

A comment right above a block says how, where it is not simply run:

    <!-- parsed only: needs a drone -->
    <!-- a terminal for each line -->
    <!-- an example -->            of what is printed, which depends on the recording

Recorded data that a page takes for granted is simulated here. Text that a tutorial says is printed
must be, numbers aside.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion

ROOT = Path(__file__).resolve().parent.parent
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs" / "start").glob("*.md")),
    *sorted((ROOT / "docs" / "howto").glob("*.md")),
]
SHELL = (
    ".",
    "aerial-gnss",
    "cd",
    "docker",
    "export",
    "make",
    "pip",
    "python",
    "python3",
    "ros2",
    "rviz2",
    "sudo",
)
ONLY_PARSED, TERMINALS, EXAMPLE = "parsed only: ", "a terminal for each line", "an example"


@dataclass(frozen=True)
class Block:
    """An indented block of a page: commands, or what they print."""

    line: int
    mark: str
    text: str

    @property
    def is_shell(self) -> bool:
        """Whether it is commands."""
        words = [line.split()[0] for line in self.text.splitlines() if line[:1] not in ("", "#")]
        return bool(words) and words[0] in SHELL

    @property
    def runs(self) -> bool:
        """Whether its commands are run."""
        return self.is_shell and not self.mark.startswith(ONLY_PARSED)

    @property
    def script(self) -> str:
        """The script for bash."""
        if self.mark != TERMINALS:
            return self.text
        *others, last = self.text.splitlines()
        begin = "".join(f"{line.partition(' #')[0]} & began+=($!)\n" for line in others)
        return f"began=()\n{begin}{last}\nkill -INT ${{began[@]}}; wait ${{began[@]}} || true"


def blocks(page: Path) -> list[Block]:
    """Return the indented blocks of a page."""
    found, mark, lines, first = [], "", [], 0
    for number, line in enumerate([*page.read_text(encoding="utf-8").splitlines(), "."], start=1):
        if line.startswith("    ") or (lines and not line):
            first = first or number
            lines.append(line.removeprefix("    "))
            continue
        if lines:
            found.append(Block(first, mark, "\n".join(lines).rstrip()))
            lines, first, mark = [], 0, ""
        comment = re.fullmatch(r"<!-- (.*) -->", line)
        mark = comment[1] if comment else mark if not line else ""
    return found


def sessions() -> list[Path]:
    """Return the pages of which something is run."""
    return [page for page in PAGES if any(block.runs for block in blocks(page))]


def simulated(name: str, *more: str) -> None:
    """Make a bag in the working folder."""
    assert cli.main(["simulate", "-o", name, *more]) == 0


def dji_card() -> None:
    """Make a flight record and its video: a camera that looks steeply down and passes robots."""
    simulated(
        "card", "--flight", "transit", "--tilt", "75", "--height", "15", "--duration", "16",
        "--rate", "5", "--size", "960x720", "--field-of-view", "71.5", "--noise", "none",
        "--robot-at=13.19394,-59.64151",
    )  # fmt: skip
    columns: dict[str, list[tuple[int, list[float]]]] = {}
    with open_bag("card") as bag:
        for one in bag.messages({"/fix", "/height", "/attitude", "/gimbal"}):
            message = one.message()
            if one.topic == "/fix":
                values = [message.latitude, message.longitude]
            elif one.topic == "/height":
                values = [message.data]
            else:
                q = getattr(message, "orientation", None) or message.quaternion
                values = ned_degrees([q.x, q.y, q.z, q.w])
            columns.setdefault(one.topic, []).append((one.log_ns, values))
        images = [
            cv2.imdecode(np.asarray(one.message().data), cv2.IMREAD_COLOR)
            for one in bag.messages({"/camera/image_raw/compressed"})
        ]
    times = np.array([t for t, _ in columns["/fix"]], dtype=np.int64)
    rows = [np.array([v for _, v in columns["/fix"]])]
    for topic in ("/height", "/attitude", "/gimbal"):
        stamps = np.array([t for t, _ in columns[topic]], dtype=np.int64)
        values = np.array([v for _, v in columns[topic]])
        rows.append(values[np.searchsorted(stamps, times).clip(max=len(stamps) - 1)])
    table = np.column_stack([(times - times[0]) * 1e-9, *rows])
    video = table[:, 0] <= len(images) / 5.0
    names = (
        "OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height [m],OSD.roll,OSD.pitch,OSD.yaw,"
        "GIMBAL.roll,GIMBAL.pitch,GIMBAL.yaw,CAMERA.isVideo"
    )
    lines = [
        ",".join(f"{v:.9f}" for v in row) + f",{on}" for row, on in zip(table, video, strict=True)
    ]
    Path("DJIFlightRecord.csv").write_text("\n".join([names, *lines]) + "\n")
    writer = cv2.VideoWriter("DJI_0042.MP4", cv2.VideoWriter_fourcc(*"mp4v"), 5.0, (960, 720))
    if not writer.isOpened():
        pytest.skip("this OpenCV has no encoder for mp4v")
    for image in images:
        writer.write(image)
    writer.release()
    shutil.rmtree("card")


def ned_degrees(quaternion: list[float]) -> list[float]:
    """Return roll, pitch and yaw (NED, forward-right-down, deg) of FLU in ENU."""
    r = matrix_from_quaternion(quaternion)
    n = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]]) @ r @ np.diag([1.0, -1, -1])
    angles = np.arctan2(n[2, 1], n[2, 2]), -np.arcsin(n[2, 0]), np.arctan2(n[1, 0], n[0, 0])
    return [float(np.degrees(angle)) for angle in angles]


def prepare(page: str, make_set) -> None:
    """Put into the working folder what a page takes for granted."""
    if page in ("dji_recording", "import_dji"):
        dji_card()
    elif page == "simulation":
        dji_log()
    elif page == "calibration":
        simulated("flight_bag", "--no-images", "--flight", "orbit", "--duration", "40")
    elif page == "playing":
        simulated("flight_bag", "--no-images", "--duration", "3")
    elif page == "training":
        make_set(Path("mine"))
    elif page == "security":
        Path("mine.yaml").write_text("/**/estimator: {ros__parameters: {fix: {topic: gps/fix}}}\n")
    elif page == "first_flight":
        Path(".venv/bin").mkdir(parents=True)
        Path(".venv/bin/activate").touch()
    elif page == "README":
        ignored = shutil.ignore_patterns(".*", "build", "install", "log", "*.egg-info")
        shutil.copytree(ROOT, ".", ignore=ignored, dirs_exist_ok=True)


def dji_log() -> None:
    """Make a flight record of eleven minutes over water."""
    names = (
        "OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch"
    )
    rows = [
        f"{i / 10:.1f},{13.2 + 2e-7 * i:.8f},-59.6,20,0,0,{-60 + np.sin(i / 50):.3f}"
        for i in range(6700)
    ]
    Path("DJIFlightRecord.csv").write_text("\n".join([names, *rows]) + "\n")


def programs(folder: Path) -> Path:
    """Return a folder with the commands that an installation brings."""
    folder.mkdir()
    commands = {"aerial-gnss": f"{sys.executable} -m aerial_gnss_ros.cli"}
    commands |= dict.fromkeys(("python", "python3"), sys.executable)
    for name, command in commands.items():
        (folder / name).write_text(f'#!/bin/sh\nexec {command} "$@"\n')
        (folder / name).chmod(0o755)
    return folder


@pytest.mark.pages
@pytest.mark.parametrize("page", sessions(), ids=lambda page: page.stem)
def test_a_page_runs_as_printed(page: Path, tmp_path: Path, monkeypatch, make_set) -> None:
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    prepare(page.stem, make_set)
    parts = ["set -eu"]
    for block in blocks(page):
        if block.runs:
            parts += [f"echo '=== line {block.line}'", block.script]
    environment = os.environ | {
        "PATH": f"{programs(tmp_path / 'bin')}{os.pathsep}{os.environ['PATH']}"
    }
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, sys.path)])
    if page.name == "README.md":
        del environment["PYTHONPATH"]
    done = subprocess.run(
        ["bash", "-c", "\n".join(parts)],
        cwd=work,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900.0,
        check=False,
    )
    assert done.returncode == 0, f"{page.name}:\n{done.stdout}"
    if page.parent.name == "start":
        said = _plain(done.stdout)
        for block in blocks(page):
            if not block.is_shell and block.mark != EXAMPLE:
                for line in block.text.splitlines():
                    assert _plain(line) in said, f"{page.name}, line {block.line}: {line}"


def _plain(text: str) -> str:
    """Return a text without numbers and line breaks."""
    return re.sub(r"\s+", " ", re.sub(r"-?\d[\d.]*", "#", text)).strip()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_bash_understands_every_block(page: Path) -> None:
    for block in blocks(page):
        if block.is_shell:
            text = block.text.replace("<this repository>", "REPOSITORY")
            done = subprocess.run(
                ["bash", "-n", "-c", text], capture_output=True, text=True, check=False
            )
            assert done.returncode == 0, f"{page.name}, line {block.line}: {done.stderr}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_mark_belongs_to_a_block_of_commands(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    marks = re.findall(rf"^<!-- ((?:{ONLY_PARSED}|{TERMINALS}).*) -->$", text, flags=re.MULTILINE)
    assert marks == [block.mark for block in blocks(page) if block.mark and block.is_shell]
