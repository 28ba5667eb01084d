# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The machine's description, and a process's resources (Linux; elsewhere figures are missing)."""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import threading
import time
from pathlib import Path

_SYS = Path("/sys")
_PROC = Path("/proc")
_SAMPLE_S = 0.5


def describe() -> dict[str, str | int | float]:
    """Return the machine in words and numbers."""
    found: dict[str, str | int | float] = {
        "device": _device(),
        "cores": len(os.sched_getaffinity(0)),
        "memory_gb": round(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1e9, 1),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
    }
    gpu = _gpu()
    return found | ({"gpu": gpu} if gpu else {})


def _device() -> str:
    tree = _text(_PROC / "device-tree" / "model").rstrip("\0")  # a Jetson has its name here
    if tree:
        return tree
    match = re.search(r"^model name\s*:\s*(.+)$", _text(_PROC / "cpuinfo"), re.MULTILINE)
    return match.group(1).strip() if match else platform.processor() or "unknown processor"


def _gpu() -> str:
    program = shutil.which("nvidia-smi")
    if program is None:
        return ""
    try:
        asked = [program, "--query-gpu=name", "--format=csv,noheader"]
        return subprocess.run(  # noqa: S603
            asked, capture_output=True, text=True, timeout=10.0, check=True
        ).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


def processor_s(pid: int) -> float:
    """Return the CPU time that a process has used, s; NaN if unknown."""
    text = _text(_PROC / str(pid) / "stat")
    if not text:
        return float("nan")
    fields = text.rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def peak_memory_mb(pid: int) -> float:
    """Return the peak memory of a process, MB; NaN if unknown."""
    return _status_mb(pid, "VmHWM")


def own_memory_mb(pid: int) -> float:
    """Return a process's resident memory without shared memory, MB; NaN if unknown."""
    return _status_mb(pid, "RssAnon") + _status_mb(pid, "RssFile")


def shared_memory_mb(pid: int) -> float:
    """Return the shared memory that a process has touched, MB; NaN if unknown.

    Every process that maps it counts it, although it exists once.
    """
    return _status_mb(pid, "RssShmem")


def _status_mb(pid: int, name: str) -> float:
    match = re.search(rf"^{name}:\s*(\d+) kB", _text(_PROC / str(pid) / "status"), re.MULTILINE)
    return int(match.group(1)) * 1024 / 1e6 if match else float("nan")


def segments_mb(pid: int) -> float:
    """Return the size of the shared-memory files that a process maps, MB: it can touch no more."""
    ranges = re.findall(
        r"^([0-9a-f]+)-([0-9a-f]+) .* /dev/shm/", _text(_PROC / str(pid) / "maps"), re.MULTILINE
    )
    return sum(int(end, 16) - int(start, 16) for start, end in ranges) / 1e6


def threads(pid: int) -> int:
    """Return how many threads a process has; 0 if unknown."""
    match = re.search(r"^Threads:\s*(\d+)", _text(_PROC / str(pid) / "status"), re.MULTILINE)
    return int(match.group(1)) if match else 0


def descriptors(pid: int) -> int:
    """Return how many files and sockets a process has open; 0 if unknown."""
    try:
        return sum(1 for _ in (_PROC / str(pid) / "fd").iterdir())
    except OSError:
        return 0


def children(pid: int) -> dict[int, list[str]]:
    """Return the command line of each process that a process started, by its number."""
    found = {}
    for path in _PROC.glob("[0-9]*"):
        fields = _text(path / "stat").rsplit(")", 1)[-1].split()
        if len(fields) > 1 and int(fields[1]) == pid:
            found[int(path.name)] = _text(path / "cmdline").split("\0")
    return found


class Power:
    """The device's mean power while in use, as far as it is reported.

    Args:
        sys: where the kernel shows its sensors.
    """

    def __init__(self, sys: Path = _SYS) -> None:
        self._counters = sorted(sys.glob("class/powercap/intel-rapl:[0-9]/energy_uj"))
        self._rails = _rails(sys)
        self._end = threading.Event()
        self._samples: list[float] = []
        self._thread = threading.Thread(target=self._sample, daemon=True)

    def begin(self) -> None:
        """Start measuring."""
        self._started = time.monotonic()
        self._energy = self._joules()
        if self._rails:
            self._thread.start()

    def end(self) -> dict[str, float]:
        """Return the mean power in W by sensor; empty if unknown."""
        self._end.set()
        seconds = time.monotonic() - self._started
        found = {}
        before, after = self._energy, self._joules()
        if before is not None and after is not None and after >= before:  # the counters wrap
            found["processor_package_w"] = round((after - before) / seconds, 2)
        if self._samples:
            found["board_w"] = round(sum(self._samples) / len(self._samples), 2)
        return found

    def _joules(self) -> float | None:
        texts = [_text(path) for path in self._counters]
        return sum(map(int, texts)) / 1e6 if texts and all(texts) else None

    def _sample(self) -> None:
        while not self._end.wait(_SAMPLE_S):
            watts = [_watts(rail) for rail in self._rails]
            self._samples.append(sum(watts))


def _rails(sys: Path) -> list[tuple[Path, Path]]:
    """Return files of voltage and current of a Jetson's rails: its input, or all it has."""
    found: dict[Path, tuple[Path, Path]] = {}
    for label in sorted(sys.glob("bus/i2c/drivers/ina3221*/*/hwmon/hwmon*/in[1-3]_label")):
        number = label.name[2]
        rail = (label.with_name(f"in{number}_input"), label.with_name(f"curr{number}_input"))
        if all(_text(path) for path in rail):
            found[label] = rail
    inputs = [rail for label, rail in found.items() if _text(label).strip() in ("VDD_IN", "VIN")]
    return inputs or list(found.values())


def _watts(rail: tuple[Path, Path]) -> float:
    millivolts, milliamperes = (float(_text(path) or "nan") for path in rail)
    return millivolts * milliamperes / 1e6


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
