# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A real browser for tests of pages: Debian's Chromium without a window, driven by Selenium."""

from __future__ import annotations

import contextlib
import json
import shutil
from collections.abc import Iterator
from typing import Any

import pytest

TABLET, PHONE = (1180, 820), (390, 844)


@contextlib.contextmanager
def browser(size: tuple[int, int] = TABLET) -> Iterator[Any]:
    """Yield a driver whose page has `size` in px; skip where there is no browser."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    driver_program = shutil.which("chromedriver")
    if program is None or driver_program is None:
        pytest.skip("chromium and chromium-driver are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for one in (
        "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
        "--disable-background-networking", "--no-first-run", "--hide-scrollbars",
    ):  # fmt: skip
        options.add_argument(one)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    service = webdriver.ChromeService(executable_path=driver_program)
    driver = webdriver.Chrome(options=options, service=service)
    try:
        width, height = size
        driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 800},
        )
        yield driver
    finally:
        driver.quit()


def requested(driver: Any) -> list[str]:
    """Return the URLs that the page asked for since the last call, also of WebSockets."""
    found = []
    for entry in driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            found.append(message["params"]["request"]["url"])
        elif message["method"] == "Network.webSocketCreated":
            found.append(message["params"]["url"])
    return found


def complaints(driver: Any) -> list[str]:
    """Return the errors that the browser logged since the last call."""
    return [one["message"] for one in driver.get_log("browser") if one["level"] == "SEVERE"]


def wait_for(driver: Any, script: str, seconds: float = 90.0) -> Any:
    """Return a script's first true value; fail after some time."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(driver, seconds).until(
        lambda one: one.execute_script(script), f"never true: {script}"
    )
