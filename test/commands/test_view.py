# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss view` of a recording, in a real browser."""

from __future__ import annotations

import json
import math
import re
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.writer import LATCHED, BagWriter

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import PHONE, TABLET, browser, complaints, requested, wait_for

ROWS = "return [...document.querySelectorAll('#robots tbody tr')].map((row) => row.innerText)"


@pytest.fixture
def page():
    """Return a function that starts `aerial-gnss view` and returns its address."""
    started = []

    def start(*arguments):
        command = [sys.executable, "-m", "aerial_gnss_ros.cli", "view", *map(str, arguments)]
        process = subprocess.Popen(
            [*command, "--port", "0"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        started.append(process)
        line = process.stdout.readline()
        found = re.fullmatch(r"open (http://127\.0\.0\.1:\d+/) in a browser; Ctrl-C ends\n", line)
        assert found, line + process.stderr.read()
        return found[1]

    yield start
    for process in started:
        process.send_signal(signal.SIGINT)
        assert process.wait(90) == 0
        assert "Traceback" not in process.stderr.read()


def refused(capsys, *arguments):
    assert cli.main(["view", *map(str, arguments)]) == 2
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert said.startswith("aerial-gnss: ")
    return said


@pytest.mark.parametrize("size", [TABLET, PHONE], ids=["tablet", "phone"])
@pytest.mark.browser
def test_a_recording_is_shown_with_its_robots_and_without_the_internet(
    page, flight, tmp_path, size
):
    url = page(flight.write(tmp_path / "bag", namespace="drone1"), "--namespace", "drone1")
    with browser(size) as driver:
        driver.get(url)
        length = wait_for(driver, "return Number(document.getElementById('slider').max)")
        assert length == pytest.approx(0.1 * (flight.images - 1), abs=0.2)
        driver.execute_script(
            "const s = document.getElementById('slider'); s.value = s.max; s.oninput()"
        )
        rows = wait_for(
            driver, f"const rows = (() => {{ {ROWS} }})(); return rows.length > 1 && rows"
        )
        assert [row.split()[:2] for row in rows] == [["aqua_1", "seen"], ["aqua_2", "seen"]]
        assert len(driver.find_elements("css selector", ".ellipse.confirmed")) == 2
        assert driver.find_element("id", "utc").text == "00:16:41"
        outside = [one for one in requested(driver) if "//127.0.0.1:" not in one]
        assert [one for one in outside if not one.startswith(("data:", "blob:"))] == []
        assert complaints(driver) == []
        wide = driver.execute_script("return document.documentElement.scrollWidth")
        assert wide <= size[0]
        small = driver.execute_script(
            "return [...document.querySelectorAll('button')].filter((one) => one.offsetParent && "
            "(one.offsetHeight < 44 || one.offsetWidth < 44)).map((one) => one.outerHTML)"
        )
        assert small == []


@pytest.mark.browser
def test_a_robots_position_is_stated_and_copied(page, flight, tmp_path):
    url = page(flight.write(tmp_path / "bag"))
    with browser() as driver:
        driver.get(url)
        driver.execute_script("navigator.clipboard.writeText = (text) => { window.copied = text; }")
        wait_for(driver, "return document.getElementById('slider').max > 0")
        driver.execute_script(
            "const s = document.getElementById('slider'); s.value = s.max; s.oninput()"
        )
        wait_for(driver, "return document.querySelectorAll('#robots tbody tr').length > 1")
        driver.find_element("css selector", "#robots tbody tr").click()
        wait_for(driver, "return !document.getElementById('card').hidden")
        driver.find_element("id", "copy").click()
        latitude, longitude = map(float, driver.execute_script("return window.copied").split(","))
        east, north = min(
            flight.true_east_north(), key=lambda one: abs(one[1] - (latitude - 13.19) * 110_600)
        )
        assert (latitude - flight.latitude) * 110_600 == pytest.approx(north, abs=0.1)
        across = 111_320 * math.cos(math.radians(flight.latitude))
        assert (longitude - flight.longitude) * across == pytest.approx(east, abs=0.1)
        assert "13° 11." in driver.find_element("id", "card-place").text


@pytest.mark.browser
def test_the_cameras_image_has_boxes_with_the_robots_names(page, flight, tmp_path):
    flight.write(tmp_path / "boxes")
    flight.write(tmp_path / "images", images=True)
    url = page(tmp_path / "boxes", tmp_path / "images")
    with browser() as driver:
        driver.get(url)
        wait_for(driver, "return document.getElementById('slider').max > 0")
        driver.execute_script(
            "const s = document.getElementById('slider'); s.value = s.max; s.oninput()"
        )
        names = "return [...document.querySelectorAll('#boxes text')].map((one) => one.textContent)"
        found = wait_for(driver, f"const n = (() => {{ {names} }})(); return n.length && n.sort()")
        assert found == ["aqua_1", "aqua_2"]
        width = "return document.getElementById('image').naturalWidth"
        assert wait_for(driver, width) == 640


@pytest.mark.browser
def test_the_result_of_a_replay_is_shown_as_it_was(page, replay, flight, tmp_path):
    assert replay(flight.write(tmp_path / "bag"), tmp_path / "result") == 0
    url = page(tmp_path / "result")
    with browser() as driver:
        driver.get(url)
        wait_for(driver, "return document.getElementById('slider').max > 1")
        driver.execute_script(
            "const s = document.getElementById('slider'); s.value = s.max; s.oninput()"
        )
        wait_for(driver, "return document.querySelectorAll('#robots tbody tr').length == 2")


def test_a_port_in_use_is_said(flight, tmp_path, capsys):
    flight.write(tmp_path / "bag")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = refused(capsys, tmp_path / "bag", "--port", port)
    assert f"port {port} of 127.0.0.1 is in use; choose another one with --port" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere"], "nowhere"),
        (["BAG", "--port", "70000"], "--port must be 0 to 65535, not 70000"),
        (["BAG", "--bind", "192.0.2.7"], "192.0.2.7 is no address of this computer"),
        (["BAG", "--tiles", "missing.mbtiles"], "there is no missing.mbtiles"),
        (["BAG", "--tiles", "BAG/metadata.yaml"], "is no MBTiles file"),
    ],
)
def test_wrong_input_is_one_sentence(flight, tmp_path, capsys, arguments, words):
    bag = flight.write(tmp_path / "bag")
    assert words in refused(capsys, *(one.replace("BAG", str(bag)) for one in arguments))


@pytest.mark.parametrize("without", ["--no-bag", None])
@pytest.mark.browser
def test_a_result_without_overviews_shows_its_table(page, replay, flight, tmp_path, without):
    made = replay(
        flight.write(tmp_path / "bag"), tmp_path / "result", *([without] if without else [])
    )
    assert made == 0
    if without is None:  # as versions before wrote it
        with open_bag(tmp_path / "result" / "bag") as bag, BagWriter(tmp_path / "old") as old:
            for one in bag.messages({"/robots/aqua_1/fix"}):
                old.write("robots/aqua_1/fix", one.msgtype, one.log_ns, {}, LATCHED)
        shutil.rmtree(tmp_path / "result" / "bag")
        (tmp_path / "old").rename(tmp_path / "result" / "bag")
    url = page(tmp_path / "result")
    with browser() as driver:
        driver.get(url)  # opens at the first image with a robot
        rows = wait_for(driver, f"const rows = (() => {{ {ROWS} }})(); return rows.length && rows")
        assert rows[0].split()[:2] == ["aqua_1", "seen"]
        assert "no images" in driver.find_element("id", "camera").text
        assert driver.find_elements("css selector", ".drone-icon") == []


@pytest.mark.browser
def test_all_drones_of_a_fleet_are_on_the_map(page, tmp_path):
    two, joined = tmp_path / "two", tmp_path / "joined"
    made = ["--drones", "2", "--no-images", "--duration", "4", "-o", str(two)]
    assert cli.main(["simulate", *made]) == 0
    given = [f"--drone={name}={two / name}" for name in "ab"]
    assert cli.main(["replay", *given, "-o", str(joined), "--no-bag", "--no-figures"]) == 0
    url = page(joined)
    with browser() as driver:
        driver.get(url)
        rows = wait_for(driver, f"const rows = (() => {{ {ROWS} }})(); return rows.length && rows")
        assert rows[0].split()[:2] == ["aqua_1", "seen"]
        shown = "return [...document.querySelectorAll('.name.drone')].map((one) => one.innerText)"
        assert sorted(wait_for(driver, shown)) == ["a", "b"]
        assert len(driver.find_elements("css selector", ".drone-icon")) == 2
        assert not driver.find_element("id", "camera").is_displayed()
        driver.execute_script(
            "const s = document.getElementById('slider'); s.value = s.max; s.oninput()"
        )
        driver.find_element("css selector", "#robots tbody tr").click()
        words = wait_for(driver, "return document.getElementById('card-text').innerText")
        assert "in the last image of a, b; " in words
        assert re.search(r"m from a, bearing \d{3}°; .* m from b, bearing", words)
        assert complaints(driver) == []


def test_two_results_are_one_too_many(replay, flight, tmp_path, capsys):
    bag = flight.write(tmp_path / "bag")
    for name in ("a", "b"):
        assert replay(bag, tmp_path / name, "--no-bag") == 0
    assert "are two results; give one" in refused(capsys, tmp_path / "a", tmp_path / "b")


def test_a_bag_that_is_no_flight_is_refused_in_a_sentence(tmp_path, capsys):
    with BagWriter(tmp_path / "bag") as bag:
        for i in range(9):
            bag.write(f"topic_{i}", "std_msgs/msg/String", 5, {"data": "x"}, LATCHED)
    said = refused(capsys, tmp_path / "bag")
    assert "neither detections on /detections nor images" in said
    assert "topic_" not in said


def test_another_topic_of_that_name_is_refused(tmp_path, capsys):
    with BagWriter(tmp_path / "bag") as bag:
        bag.write("overview", "std_msgs/msg/String", 5, {"data": json.dumps({"a": 1})}, LATCHED)
    assert "does not hold what this version writes there" in refused(capsys, tmp_path / "bag")
