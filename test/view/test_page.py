# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the server does with what a page asks."""

from __future__ import annotations

import json
import runpy
from pathlib import Path

import pytest

from aerial_gnss_ros.view.page import RecordingSocket
from aerial_gnss_ros.view.recording import Recording

MADE = runpy.run_path(str(Path(__file__).with_name("overviews.py")))


@pytest.mark.parametrize("asked", ["1e300", "-1e300", "1" * 400, "NaN", "Infinity", '"1"', "null"])
def test_a_time_that_no_page_asks_for_is_ignored(asked):
    page = object.__new__(RecordingSocket)  # without a connection
    page.initialize(Recording([json.dumps(MADE["overview"](0.0))], "flight"), None, None)
    sent = []
    page.send = sent.append
    page.received(json.loads(f'{{"at_s": {asked}}}'))
    assert not sent
    page.received({"at_s": 0.5})
    assert [one["kind"] for one in sent] == ["scene"]
