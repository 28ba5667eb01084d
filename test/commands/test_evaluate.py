# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss evaluate`: latency, hover truth, CSV truth, figures and report."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.evaluation.truth import read_truth
from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import HOLETOWN, FlightPlan, GeneratedFlight, Motion
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.scenario import scenario
from aerial_gnss_ros.simulation.sensors import sensor_plan

STILL = SwimPlan(0.0, 0.0, heave_m=0.0)


class OverThenAside:
    """Hovers straight over the origin for 6 s, then backs off 12 m while looking at it."""

    origin, duration_s, words = HOLETOWN, 16.0, "over, then aside"

    def sample(self, t):
        times = np.atleast_1d(np.asarray(t, dtype=np.float64))
        share = np.clip((times - 6.0) / 6.0, 0.0, 1.0)
        place = np.column_stack([-12.0 * share, np.zeros(len(times)), np.full(len(times), 10.0)])
        level = np.tile(np.eye(3), (len(times), 1, 1))
        zeros = np.zeros(len(times))
        look = matrix_from_rpy(zeros, np.arctan2(10.0, 12.0 * share), zeros)
        return Motion(times, place, place, level, look)


def _run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def replayed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A perfect drone past moving robots whose images are 0.5 s late."""
    folder = tmp_path_factory.mktemp("late")
    flight = GeneratedFlight(FlightPlan("transit", 12.0, 15.0, speed_mps=3.0), 3)
    experiment = Experiment(
        flight, default_camera(1280, 720), sensor_plan("none", box_center_px=0.0),
        CameraClock(5.0, 0.5), robots=2, swim=SwimPlan(0.5, 0.6, heave_m=0.0),
        detector=DetectorPlan(0.0), seed=3,
    )  # fmt: skip
    write_bag(folder / "bag", experiment, None, scenario=scenario(experiment, "none"))
    (folder / "late.yaml").write_text("estimator: {ros__parameters: {camera: {latency_s: 0.5}}}")
    assert _run("replay", folder / "bag", "-o", folder / "result", "--method", "single",
                "--params", folder / "late.yaml") == 0  # fmt: skip
    return folder


@pytest.fixture
def late(replayed: Path, tmp_path: Path) -> Path:
    """That flight and its replay, for a test to change."""
    shutil.copytree(replayed, tmp_path, dirs_exist_ok=True)
    return tmp_path


def test_truth_is_compared_at_the_time_of_the_scene(late, capsys):
    capsys.readouterr()
    assert _run("evaluate", late / "result", "--truth", late / "bag", "--json") == 0
    aligned = json.loads(capsys.readouterr().out)
    assert aligned["latency_s"] == 0.5
    assert _run("evaluate", late / "result", "--truth", late / "bag", "--latency", 0, "--json") == 0
    wrong = json.loads(capsys.readouterr().out)
    # robots at 0.5 to 0.6 m/s are 0.25 to 0.3 m further half a second later
    assert wrong["all"]["rmse"] == pytest.approx(0.28, abs=0.08)
    assert aligned["all"]["rmse"] < 0.02
    assert aligned["all"]["haversine_rmse"] == pytest.approx(aligned["all"]["rmse"], rel=0.006)


def test_truth_before_and_after_the_images_does_not_count(late):
    """The flight's truth begins 1.5 s before its first image; images come 5 a second."""
    with open_bag([late / "bag"]) as bag:
        truth = read_truth(bag)
        images = [
            nanoseconds(one.message().header.stamp) for one in bag.messages({"/truth/detections"})
        ]
    for track in truth.robots.values():
        early, over = min(images) - track.stamps_ns[0], track.stamps_ns[-1] - max(images)
        assert 0 <= early <= 200_000_000
        assert 0 <= over <= 200_000_000


@pytest.mark.usefixtures("drawn")
def test_report_figures_and_tables(late):
    assert _run("evaluate", late / "result", "--truth", late / "bag", "-o", late / "out") == 0
    assert {path.name for path in (late / "out").iterdir()} == {
        "report.html", "summary.json", "errors.csv", "map.png", "error_over_frames.png",
        "latitude_longitude_error.png", "error_against_range.png",
    }  # fmt: skip
    with (late / "out" / "errors.csv").open() as file:
        rows = list(csv.DictReader(file))
    summary = json.loads((late / "out" / "summary.json").read_text())
    assert len(rows) == summary["all"]["count"]
    distance = [float(row["geodesic_m"]) for row in rows]
    assert summary["all"]["cep"] == pytest.approx(np.median(distance), abs=1e-4)
    legs = [math.hypot(float(r["latitude_error_m"]), float(r["longitude_error_m"])) for r in rows]
    np.testing.assert_allclose(legs, distance, atol=2e-4)


def test_positions_of_no_true_robot_are_not_passed_over(late, tmp_path, capsys):
    table = late / "result" / "positions.csv"
    head, *rows = table.read_text().splitlines()
    false = [row.replace(",aqua_1,", ",aqua_7,").replace(",13.", ",13.0001") for row in rows[:6]]
    more = [row for row in false if ",aqua_7," in row]
    (tmp_path / "positions.csv").write_text("\n".join([head, *rows, *more]) + "\n")
    assert _run("evaluate", tmp_path, "--truth", late / "bag") == 0
    said = f"in none of the errors: aqua_7 ({len(more)} positions).\n"
    assert said in capsys.readouterr().out
    assert _run("evaluate", late / "result", "--truth", late / "bag") == 0
    assert "in none of the errors" not in capsys.readouterr().out


def test_another_result_can_be_the_truth(late, capsys):
    truth = late / "result" / "positions.csv"
    capsys.readouterr()
    assert _run("evaluate", late / "result", "--truth", truth, "--json") == 0
    assert json.loads(capsys.readouterr().out)["all"]["rmse"] == pytest.approx(0.0, abs=1e-6)
    excel = late / "excel.csv"
    excel.write_text(truth.read_text().replace(",", ";"), encoding="utf-8-sig")
    assert _run("evaluate", late / "result", "--truth", excel, "--json") == 0
    assert json.loads(capsys.readouterr().out)["all"]["rmse"] == pytest.approx(0.0, abs=1e-6)


def test_truth_from_hovers(tmp_path, capsys):
    """The receiver's offset of 3 m cancels, a compass wrong by 4 deg shows at 12 m."""
    flight = OverThenAside()
    plan = sensor_plan("none", gnss_offset_m=3.0, heading_deg=4.0, correlation_time_s=1e9)
    experiment = Experiment(
        flight, default_camera(1280, 720), plan, CameraClock(5.0), swim=STILL,
        places=np.zeros((1, 2)), seed=2,
    )  # fmt: skip
    write_bag(tmp_path / "bag", experiment, None)
    result = tmp_path / "result"
    assert _run("replay", tmp_path / "bag", "-o", result, "--method", "single") == 0
    capsys.readouterr()
    assert _run("evaluate", result, "--hover", tmp_path / "bag", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    (hover,) = found["hovers"]
    assert (hover["end_ns"] - hover["start_ns"]) * 1e-9 == pytest.approx(6.0, abs=1.5)
    heading = abs(float(experiment.sensors.error("heading", np.zeros(1))[0]))
    expected = 12.0 * math.radians(heading)  # at the end; on the way there less
    assert 0.5 * expected < found["all"]["p95"] < 1.2 * expected + 0.1
    assert found["all"]["rmse"] < 1.0
    # Images of the hover count neither as compared nor as missed.
    assert found["robots"]["aqua_1"]["availability"] > 0.9
    head, *rows = (result / "positions.csv").read_text().splitlines()
    rows = [row for row in rows if int(row.split(",")[0]) < hover["end_ns"]]
    (result / "positions.csv").write_text("\n".join([head, *rows]))
    assert _run("evaluate", result, "--hover", tmp_path / "bag") == 2
    assert "nothing is left to compare" in capsys.readouterr().err


def test_a_second_drone_above_verifies_the_first_one(tmp_path, capsys):
    """Its compass does not matter there; that of the first one shows."""
    flown = tmp_path / "two"
    arguments = ("--drones", 2, "--formation", "above", "--flight", "hover", "--duration", 12)
    noise = ("--noise", "none", "--sigma", "heading_deg=8", "--robots", 8)
    assert _run("simulate", "-o", flown, "--no-images", *arguments, *noise, "--seed", 3) == 0
    result = tmp_path / "result"
    assert _run("replay", flown / "a", "-o", result, "--no-figures", "--method", "single") == 0
    capsys.readouterr()
    verified = "evaluate", result, "--json", "--verify", flown / "b", "--nadir-deg", 12
    assert _run(*verified) == 0
    found = json.loads(capsys.readouterr().out)
    assert "another drone" in found["notes"][0]
    assert _run("evaluate", result, "--json", "--truth", flown / "a") == 0
    true = json.loads(capsys.readouterr().out)
    assert found["all"]["count"] > 30
    assert found["all"]["rmse"] == pytest.approx(true["all"]["rmse"], rel=0.4)
    assert _run(*verified, "--still", 3) == 2
    assert "--still applies only with --hover" in capsys.readouterr().err


def test_that_there_is_no_hover_is_known_before_any_image_is_looked_at(
    tmp_path, capsys, monkeypatch
):
    flight = GeneratedFlight(FlightPlan("orbit", 6.0, 30.0, tilt=math.radians(45.0)), 3)
    experiment = Experiment(
        flight, default_camera(1280, 720), sensor_plan("none"), CameraClock(5.0), robots=1,
        swim=STILL, seed=2,
    )  # fmt: skip
    write_bag(tmp_path / "bag", experiment, None)
    result = tmp_path / "result"
    assert _run("replay", tmp_path / "bag", "-o", result, "--method", "single") == 0
    monkeypatch.setattr("aerial_gnss_ros.commands.evaluate.Replay", None)
    assert _run("evaluate", result, "--hover", tmp_path / "bag") == 2
    said = capsys.readouterr().err.strip().splitlines()[-1]
    found = re.fullmatch(
        r"aerial-gnss: there is no hover: every line of sight is ([\d.]+) deg or more from "
        r"straight down, and at most 10 deg counts; give --truth, or a wider --nadir-deg.", said,
    )  # fmt: skip
    half_view_deg = math.degrees(math.atan(360.0 / experiment.camera.K[0, 0]))
    assert float(found[1]) == pytest.approx(45.0 - half_view_deg, abs=1.5)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--truth", "positions.csv", "--latency", "9"], "-3 to 3 s"),
        (["--truth", "bad.csv"], "lacks the columns robot_id"),
        (["--truth", "far.csv"], "line 2: 99.0, 0.0 is not on Earth"),
        (["--truth", "seconds.csv"], "stamp_ns must be a whole number of nanoseconds, not '1.5'"),
        (["--truth", "words.csv"], "latitude_deg must be a number of degrees, not 'here'"),
        (["--truth", "latin.csv"], "latin.csv: is not text in UTF-8 (line"),
        (["--truth", "then.csv"], "no time in common: truth is from 1 to 1 ns"),
        (["--truth", "exchanged.csv"], "latitude and longitude exchanged"),
        (["--truth", "positions.csv", "--hover", "bag"], "not allowed with"),
        (["--truth", "positions.csv", "--still", "0"], "--still applies only with --hover"),
        (["--truth", "positions.csv", "--params", "p"], "--params applies only with --hover"),
    ],
)
def test_one_sentence_for_wrong_input(late, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(late)
    (late / "bad.csv").write_text("stamp_ns\n1\n")
    head = "stamp_ns,robot_id,latitude_deg,longitude_deg\n"
    for name, row in {
        "far": "1,a,99,0", "seconds": "1.5,a,13,-59", "words": "1,a,here,0", "then": "1,a,13,-59",
    }.items():  # fmt: skip
        (late / f"{name}.csv").write_text(head + row)
    (late / "latin.csv").write_text(head + "1,bjørn,13,-59", encoding="latin-1")
    (late / "positions.csv").write_bytes((late / "result" / "positions.csv").read_bytes())
    head, rest = (late / "positions.csv").read_text().split("\n", 1)
    head = head.replace("latitude_deg,longitude_deg", "longitude_deg,latitude_deg")
    (late / "exchanged.csv").write_text(f"{head}\n{rest}")
    capsys.readouterr()
    assert _run("evaluate", late / "result", *arguments, "-o", late / "out") == 2
    assert words in capsys.readouterr().err
    assert not (late / "out").exists()


def test_a_table_that_was_cut_off_is_refused(late, capsys):
    table = late / "result" / "positions.csv"
    table.write_bytes(table.read_bytes()[:-20])
    capsys.readouterr()
    assert _run("evaluate", late / "result", "--truth", late) == 2
    assert "state is missing, not confirmed or coasting: the table was cut off" in (
        capsys.readouterr().err
    )
