# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The command line itself: help, versions, and errors in one sentence."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import types

import pytest

from aerial_gnss_ros import __version__, cli
from aerial_gnss_ros.core.values.errors import InputError


def _command(monkeypatch: pytest.MonkeyPatch, action) -> None:
    module = types.ModuleType("aerial_gnss_ros.commands.probe")
    module.add_arguments = lambda parser: parser.add_argument("--count", type=int, default=1)
    module.run = action
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(cli.COMMANDS, "probe", ("probe", "try something"))


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--help"]) == 0
    out = capsys.readouterr().out
    assert all(f"  {name} " in out for name in cli.COMMANDS)


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"aerial-gnss {__version__}\n"


@pytest.mark.parametrize("name", sorted(cli.COMMANDS))
def test_each_command_has_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([name, "--help"]) == 0
    assert capsys.readouterr().out.startswith(f"usage: aerial-gnss {name}")


def _raise(error: BaseException):
    def action(_args: object) -> int:
        raise error

    return action


@pytest.mark.parametrize(
    ("arguments", "action", "status", "sentence"),
    [
        (["fly"], None, 2, "aerial-gnss: 'fly' is not a command; choose from"),
        (["probe", "--count", "x"], None, 2, "argument --count: invalid int value: 'x'; see"),
        (
            ["probe"],
            _raise(InputError("There is no x.mcap.")),
            2,
            "aerial-gnss: There is no x.mcap.",
        ),
        (
            ["probe"],
            _raise(OSError(errno.ENOSPC, "No space left on device", "out/positions.csv")),
            2,
            "aerial-gnss: the disk is full while writing out/positions.csv; free some space.",
        ),
        (
            ["probe"],
            _raise(PermissionError(errno.EACCES, "Permission denied", "/root/x")),
            2,
            "aerial-gnss: cannot use /root/x: Permission denied.",
        ),
        (["probe"], _raise(MemoryError()), 2, "aerial-gnss: memory ran out, and nothing was"),
        (["probe"], _raise(KeyboardInterrupt()), 130, "aerial-gnss: interrupted"),
        (["probe"], lambda _args: 0, 0, ""),
    ],
)
def test_wrong_input_is_one_sentence(
    arguments: list[str],
    action,
    status: int,
    sentence: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    _command(monkeypatch, action)
    assert cli.main(arguments) == status
    err = capsys.readouterr().err
    assert sentence in err
    assert "Traceback" not in err
    assert err.count("\n") <= 1


def test_a_file_name_that_is_no_unicode_is_printed(tmp_path):
    """Python's own output would end with a traceback."""
    log = tmp_path / os.fsdecode(b"caf\xe9.csv")
    header = "OSD.latitude,OSD.longitude,OSD.height [m],OSD.pitch,OSD.yaw,GIMBAL.pitch\n"
    log.write_text(header + "13,-59,20,0,0,-60\n" * 2)
    done = subprocess.run(
        [sys.executable, "-m", "aerial_gnss_ros.cli", "import-dji", log, "-o", tmp_path / "bag"],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONIOENCODING": "utf-8"},
    )
    assert (done.returncode, done.stderr.count("Traceback")) == (0, 0), done.stderr
    assert "caf?.csv: 2 rows" in done.stdout
