# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The page of `aerial-gnss teach` in a real browser: by mouse and by keyboard alone."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.teaching.project import FILE
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.view.teach import Teacher

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import browser, complaints, requested, wait_for

COUNT = 12


@pytest.fixture(name="video")
def _video(tmp_path):
    """Twelve images of water with a yellow and a red robot; the red one dives in 5 to 7."""
    folder, rng = tmp_path / "video", np.random.default_rng(2)
    folder.mkdir()
    for i in range(COUNT):
        noise = cv2.GaussianBlur(rng.normal(0.0, 12.0, (360, 640)), (0, 0), 1.5)[..., None]
        image = np.clip(np.array([110.0, 120.0, 70.0]) + noise, 0, 255).astype(np.uint8)
        cv2.rectangle(image, (160 + 5 * i, 100), (199 + 5 * i, 123), (40, 210, 230), -1)
        if not 5 <= i < 8:
            cv2.rectangle(image, (400, 200 + 3 * i), (439, 223 + 3 * i), (40, 40, 200), -1)
        cv2.imwrite(str(folder / f"{i:02d}.png"), image)
    return folder


@pytest.fixture(name="page")
def _page(video, tmp_path):
    """Start the command on a free port; yield its address and folder; end it as Ctrl-C does."""
    work = tmp_path / "mine"
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", "teach", str(video), "-o", str(work)]
    process = subprocess.Popen(
        [*command, "--port", "0", "--class", "fin"], text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={key: value for key, value in os.environ.items() if "DISPLAY" not in key},
    )  # fmt: skip
    for line in process.stderr:
        if line.startswith("open http"):
            break
    yield line.split()[1], work, process
    process.kill()
    process.wait()


def _marks(work: Path) -> list[dict]:
    lines = (work / FILE).read_text().splitlines()
    return [json.loads(line) for line in lines[1:]]


def _click(driver, x, y, to=None):
    """Click a pixel of the frame, or drag from it to another."""
    from selenium.webdriver.common.action_chains import ActionChains

    canvas = driver.find_element("id", "picture")
    places = driver.execute_script(
        "const now = view(), box = picture.getBoundingClientRect();"
        "return arguments[0].map((p) => [now.x + p[0] * now.scale - box.width / 2,"
        " now.y + p[1] * now.scale - box.height / 2]);",
        [[x, y], *([to] if to else [])],
    )
    chain = ActionChains(driver).move_to_element_with_offset(canvas, *places[0]).click_and_hold()
    if to:
        chain = chain.move_to_element_with_offset(canvas, *places[1])
    chain.release().perform()


def _keys(driver, *keys):
    from selenium.webdriver.common.action_chains import ActionChains

    for key in keys:
        ActionChains(driver).send_keys(key).perform()


def _ready(driver, marks):
    """Wait until so many marks are carried to all frames."""
    wait_for(driver, f"return page.state.marks === {marks} && !at('status').textContent")


@pytest.mark.browser
def test_a_person_teaches_two_robots(page):
    """A click, a drawn box, a question answered, an undo; ended, the data set is there."""
    url, work, process = page
    with browser() as driver:
        driver.get(url)
        wait_for(driver, "return page.hello && page.shown === 0")
        _click(driver, 180, 112)
        _ready(driver, 1)
        assert driver.execute_script("return page.state.robots[0].sights") == "s" * COUNT
        _keys(driver, "r")
        _click(driver, 396, 196, to=[444, 228])
        _ready(driver, 2)
        assert driver.execute_script("return names()") == ["fin_1", "fin_2"]
        assert driver.execute_script("return page.state.robots[1].sights")[5:8] == "uuu"
        picture = os.environ.get("TEACH_PICTURE")
        _keys(driver, "n")
        assert driver.execute_script("return [page.frame, page.question.robot]") == [5, "fin_2"]
        assert driver.find_element("id", "asked").is_displayed()
        if picture:
            wait_for(driver, "return page.shown === 5")
            driver.save_screenshot(picture)
        _keys(driver, "x")
        _ready(driver, 3)
        _click(driver, 40, 40)  # on water
        wait_for(driver, "return !at('banner').hidden")
        assert "nothing stands out" in driver.find_element("id", "banner").text
        _keys(driver, "u")
        _ready(driver, 2)
        driver.find_element("id", "no").click()
        _ready(driver, 3)
        assert [m["frame"] for m in _marks(work) if "frame" in m] == [0, 0, 5, 5]
        assert not [one for one in complaints(driver) if "favicon" not in one]
        assert all(one.startswith((url, url.replace("http", "ws"), "data:"))
                   for one in requested(driver))  # fmt: skip
    process.send_signal(signal.SIGINT)
    said, _ = process.communicate(timeout=300)
    assert "from 3 marks" in said
    assert process.returncode == 0
    assert open_dataset(work / "dataset").names == ("fin",)


@pytest.mark.browser
def test_the_keyboard_suffices(page):
    """A cross moved by keys clicks one robot and draws a box round the other."""
    url, work, _process = page
    with browser() as driver:
        driver.get(url)
        wait_for(driver, "return page.hello && page.shown === 0")
        driver.execute_script("page.cross = [176, 108]")
        _keys(driver, "l", "k", "\ue007")  # Enter
        _ready(driver, 1)
        driver.execute_script("page.cross = [396, 214]")
        _keys(driver, "r", "\ue014", "\ue014", "\ue014", "\ue012", "i", "b")  # right, left
        driver.execute_script("page.cross = [443, 230]")
        _keys(driver, "b")
        _ready(driver, 2)
        _keys(driver, "n", "a")
        wait_for(driver, "return page.state.marks > 2 && !at('status').textContent")
        _keys(driver, "w")
        wait_for(driver, "return at('banner').textContent.includes('boxes')", 30)
    first, second = _marks(work)[:2]
    assert (first["frame"], first["robot"], first["box"][0]) == (
        0,
        "fin_1",
        pytest.approx(180, abs=2),
    )
    assert (second["frame"], second["robot"]) == (2, "fin_2")
    assert second["box"] == pytest.approx([419.5, 221.0, 47.0, 18.0], abs=1.0)
    assert (work / "dataset" / "data.yaml").is_file()


@pytest.mark.browser
def test_a_killed_program_goes_on(page, video):
    """SIGKILL after two marks: both are there when the command is started again."""
    url, work, process = page
    with browser() as driver:
        driver.get(url)
        wait_for(driver, "return page.hello && page.shown === 0")
        _click(driver, 180, 112)
        _ready(driver, 1)
        _keys(driver, "r")
        _click(driver, 420, 212)
        _ready(driver, 2)
    process.send_signal(signal.SIGKILL)
    process.wait()
    again = [sys.executable, "-m", "aerial_gnss_ros.cli", "teach", str(video), "-o", str(work)]
    done = subprocess.run([*again, "--no-page"], capture_output=True, text=True, check=True)
    assert "from 2 marks" in done.stdout


class Idle:
    """A session without marks."""

    def __init__(self):
        self.project, self.tracks = SimpleNamespace(classes={}, marks=[]), {}

    def add(self, _clicks):
        pytest.fail("kept")

    def undo(self):
        return None


def test_what_a_page_cannot_mean_is_refused():
    teacher = Teacher(Idle(), "fin", lambda _session: "")
    with pytest.raises(InputError, match="no mark to take back"):
        teacher.do({"do": "undo"})
    with pytest.raises(InputError, match="frame 4 has no box of fin_1 to answer about"):
        teacher.do({"do": "answer", "robot": "fin_1", "frame": 4, "yes": True})
    assert teacher.do({"do": "something"}) is None
