# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""report.html in a real browser: a phone's width, and printed."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.evaluation.errors import compare
from aerial_gnss_ros.evaluation.report import Report, draw, write_report

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import browser

PHONE_PX, A4_PX = 390, 680  # 18 cm between the margins
SECONDS = np.arange(40)


def report():
    """Return a report of two robots by two methods; the second one dives after 20 s."""
    stamps = SECONDS * 1_000_000_000
    truth, estimates = {}, {}
    for number, name in enumerate(("aqua_1", "aqua_2")):
        north = 0.2 + 1e-5 * number + 1e-7 * SECONDS
        truth[name] = Track(stamps, north, np.full(40, -1.0))
        measured = SECONDS < 20 if number else SECONDS >= 0
        covariance = np.tile(np.eye(2), (40, 1, 1))
        estimates[name] = EstimatedTrack(
            stamps, north + 1e-7, np.full(40, -1.0), covariance, measured
        )
    errors = compare(estimates, truth)
    note = "/a/long/folder/" + 12 * "name_without_a_break_" + "/flight.mcap"
    return Report(
        "Evaluation of " + 3 * "a_long_name_", [f"Truth of {note}."], estimates, truth, None,
        Counter({"unconfirmed": 3}), {"filter": errors, "single": errors}, facts=[("truth", note)],
    )  # fmt: skip


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """Return a browser that shows the report."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(path, report())
    with browser() as driver:
        driver.get(path.as_uri())
        yield driver


def _shown(page, width, medium):
    """Return the page's width, px, and what lies outside the screen without its own scroll bar."""
    size = {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": medium == "screen"}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": medium})
    return page.execute_script("return document.documentElement.scrollWidth")


@pytest.mark.browser
def test_a_phone_shows_the_whole_width(page):
    assert _shown(page, PHONE_PX, "screen") == PHONE_PX
    size = "return parseFloat(getComputedStyle(document.querySelector(arguments[0])).fontSize)"
    assert page.execute_script(size, "td") >= 12.0
    width = "return document.querySelector(arguments[0]).getBoundingClientRect().width"
    assert page.execute_script(width, "figure.map img") < PHONE_PX
    assert page.execute_script(width, "figure:not(.map) img") > 600.0  # legible, by scrolling it


@pytest.mark.browser
def test_paper_shows_all_columns_and_what_is_folded(page):
    assert _shown(page, A4_PX, "print") == A4_PX
    hidden = (
        "return [...document.querySelectorAll('table, img')]"
        ".filter(e => { const r = e.getBoundingClientRect();"
        f"  return !e.checkVisibility() || r.right > {A4_PX} + 1; }}).length"
    )
    assert page.execute_script(hidden) == 0


def test_predictions_have_a_figure_where_a_robot_was_out_of_sight():
    assert "error_unseen.png" in {picture.name for picture in draw(report())}
