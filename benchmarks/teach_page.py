# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes the documentation's picture of the page of `aerial-gnss teach`, with Chromium.

python benchmarks/teach_page.py FLIGHT_BAG clicks.json docs/images/teach_page.jpg
"""

from __future__ import annotations

import argparse
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from selenium import webdriver
from selenium.webdriver.support.ui import WebDriverWait

SIZE = (1180, 820)


def main() -> None:
    """Take the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording")
    parser.add_argument("clicks")
    parser.add_argument("picture", type=Path)
    parser.add_argument("--frame", type=int, default=10)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        teach = [sys.executable, "-m", "aerial_gnss_ros.cli", "teach", args.recording]
        teach += ["-o", f"{name}/work"]
        subprocess.run([*teach, "--clicks", args.clicks], check=True)  # noqa: S603
        command = [*teach, "--port", "0"]
        server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)  # noqa: S603
        try:
            url = next(line.split()[1] for line in server.stderr if line.startswith("open http"))
            with browser() as driver:
                driver.get(url)
                shot(driver, args.frame, args.picture)
        finally:
            server.send_signal(signal.SIGINT)
            server.wait()


@contextmanager
def browser() -> Iterator[Any]:
    """Yield a driver of Chromium without a window."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or "chromium"
    for one in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                f"--window-size={SIZE[0]},{SIZE[1]}"):  # fmt: skip
        options.add_argument(one)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(
        executable_path=shutil.which("chromedriver")))  # fmt: skip
    try:
        yield driver
    finally:
        driver.quit()


def shot(driver: Any, frame: int, picture: Path) -> None:
    """Show a frame of the page and write a picture of it."""
    wait = WebDriverWait(driver, 60)
    wait.until(lambda one: one.execute_script("return page.hello && page.shown >= 0"))
    driver.execute_script("show(arguments[0])", frame)
    wait.until(lambda one: one.execute_script(f"return page.shown === {frame}"))
    wait.until(lambda one: one.execute_script("return page.boxes.length > 0"))
    seen = cv2.imdecode(np.frombuffer(driver.get_screenshot_as_png(), np.uint8), cv2.IMREAD_COLOR)
    cv2.imwrite(str(picture), seen, [cv2.IMWRITE_JPEG_QUALITY, 85])


if __name__ == "__main__":
    main()
