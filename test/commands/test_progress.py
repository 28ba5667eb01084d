# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Progress in a log file and on a terminal."""

from __future__ import annotations

import io

from aerial_gnss_ros.commands.progress import progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_log_file_gets_few_plain_lines_and_the_last_one():
    log = io.StringIO()
    with progress("rendering", 605, "images", log) as report:
        for done in range(606):
            report(done)
    lines = log.getvalue().splitlines()
    assert lines[0] == "rendering: 60 of 605 images"
    assert lines[-1] == "rendering: 605 of 605 images"
    assert len(lines) == 11


def test_a_terminal_gets_a_bar_with_the_end_reached():
    terminal = Terminal()
    with progress("rendering", 3, "images", terminal) as report:
        report(3)
    assert "rendering" in terminal.getvalue()
    assert "3/3" in terminal.getvalue()
