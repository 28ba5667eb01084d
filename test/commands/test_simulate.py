# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss simulate`: what it says, what it refuses, and flights over a real log."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.simulation.experiment import Experiment, default_camera
from aerial_gnss_ros.simulation.recorded import RecordedFlight
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.scene import demo_scene
from aerial_gnss_ros.simulation.view import project_points


def test_the_summary_states_every_figure(tmp_path, capsys):
    bag = tmp_path / "flight"
    assert main(["simulate", "-o", str(bag), "--no-images", "--duration", "2", "--seed", "5"]) == 0
    said, progress = capsys.readouterr()
    assert (bag / "metadata.yaml").is_file()
    for text in (
        "hover", "seed 5", "1280x720 at 10 Hz", "aqua_3", "GNSS 1.2 m", "heading 1.5 deg",
        "correlation time 300 s", "gimbal 0.03 deg", "box centre 2 px", "height 10 Hz, 20 ms late",
    ):  # fmt: skip
        assert text in said
    assert "simulating: 20 of 20 images" in progress


def test_the_summary_as_json(tmp_path, capsys):
    arguments = ["simulate", "-o", str(tmp_path / "flight"), "--no-images", "--duration", "1"]
    arguments += ["--noise", "rtk", "--sigma", "heading_deg=1.5", "--robot-at", "13.19395,-59.6415"]
    assert main([*arguments, "--json"]) == 0
    about = json.loads(capsys.readouterr().out)
    assert about["noise"]["gnss_offset_m"] == 0.02
    assert about["noise"]["heading_deg"] == 1.5
    robot = about["robots"]["aqua_1"]
    assert (robot["latitude_deg"], robot["longitude_deg"]) == pytest.approx((13.19395, -59.6415))
    assert robot["speed_mps"] == 0.0
    assert about["messages"]["/detections"] == 10


def test_several_drones_get_a_bag_each_with_one_truth(tmp_path, capsys):
    arguments = ["--no-images", "--duration", "1", "--drones", "2", "--formation", "beside"]
    arguments += ["--drone-noise", "consumer", "--drone-noise", "rtk", "--json"]
    assert main(["simulate", "-o", str(tmp_path / "two"), *arguments]) == 0
    one, other = json.loads(capsys.readouterr().out)["drones"]
    assert [Path(item["bag"]).name for item in (one, other)] == ["a", "b"]
    assert all((Path(item["bag"]) / "metadata.yaml").is_file() for item in (one, other))
    assert other["drone"] == {"name": "b", "drones": 2, "formation": "beside", "gnss_share": 0.5}
    assert (one["noise"]["gnss_offset_m"], other["noise"]["gnss_offset_m"]) == (1.2, 0.02)
    places = [
        [(robot["latitude_deg"], robot["longitude_deg"]) for robot in item["robots"].values()]
        for item in (one, other)
    ]
    assert places[0] == places[1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--flight", "loop"], "invalid choice: 'loop'"),
        (["--size", "wide"], "'wide' is not a size such as 1280x720"),
        (["--sigma", "speed=1"], "'speed=1' is not NAME=VALUE"),
        (["--robot-at", "13.19"], "'13.19' is not 2 numbers"),
        (["--reference", "0"], "--reference must lie within 0.001 to 100 m, not 0"),
        (["--reference", "1", "--robot-at", "13.2,-59.6"], "cannot be used with --robot-at"),
        (["--robot-at", "91,0"], "--robot-at 91,0 is not on Earth"),
        (["--water-width", "9"], "--water-width applies only with --water"),
        (["--water", "lake.jpg"], "--water cannot be used with --no-images"),
        (["--no-images", "--raw"], "--raw cannot be used with --no-images"),
        (["--robot-at", "50.0,8.0"], "km from the flight"),
        (["--robot-at", "13.19,-59.64", "--robots", "2"], "not both"),
        (["--height", "-5"], "height must lie within"),
        (["--latency", "9"], "latency must lie within -3 to 3 s"),
        (["--start", "9"], "only with --telemetry"),
        (["--telemetry", "absent.csv"], "absent.csv: cannot be read"),
        (["--missed", "0.1"], "need --no-images"),
        (["--drones", "9"], "1 to 8 drones fly together, not 9"),
        (["--formation", "far"], "--formation applies only with --drones"),
        (["--drones", "2", "--gnss-share", "1.5"], "common share must lie within 0 to 1"),
        (["--drones", "2", "--drone-noise", "rtk"], "once for each of 2 drones, not 1 times"),
        (["--drones", "2", "--telemetry", "absent.csv"], "the log is of one drone"),
    ],
)
def test_wrong_input_is_one_sentence_and_leaves_nothing(tmp_path, capsys, arguments, words):
    no_images = [] if "--missed" in arguments else ["--no-images"]
    status = main(["simulate", "-o", str(tmp_path / "flight"), *no_images, *arguments])
    said = capsys.readouterr().err
    assert status == 2
    assert words in said
    assert "Traceback" not in said
    assert len(said.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_reference_is_a_beacon_more_that_replay_can_use(tmp_path, capsys):
    bag, parameters = tmp_path / "flight", tmp_path / "references.yaml"
    arguments = ["simulate", "-o", str(bag), "--no-images", "--duration", "12", "--flight", "orbit"]
    assert main([*arguments, "--reference", "0.05", "--json"]) == 0
    about = json.loads(capsys.readouterr().out)
    assert list(about["robots"]) == ["beacon_1", "aqua_1", "aqua_2", "aqua_3"]
    assert about["robots"]["beacon_1"]["speed_mps"] == 0.0
    (beacon,) = about["references"].values()
    assert (beacon["class"], beacon["sigma_m"]) == ("beacon", 0.05)
    there = about["robots"]["beacon_1"]
    apart = np.subtract(beacon["position"], [there["latitude_deg"], there["longitude_deg"]])
    assert 0.0 < np.abs(apart).max() < 2e-6
    parameters.write_text(json.dumps({"references": about["references"]}))
    out = tmp_path / "out"
    assert main(["replay", str(bag), "-o", str(out), "--params", str(parameters)]) == 0
    assert "Reference beacon is beacon_1: positions refer to it." in capsys.readouterr().err


def test_an_existing_output_is_refused_before_the_work(tmp_path, capsys):
    assert main(["simulate", "-o", str(tmp_path), "--no-images"]) == 2
    assert "exists already" in capsys.readouterr().err


def test_a_log_decides_the_flight_and_says_how_it_was_read(tmp_path, capsys, shared_data):
    log = str(shared_data / "dji_tracking.csv")
    arguments = ["simulate", "-o", str(tmp_path / "flight"), "--no-images", "--telemetry", log]
    assert main([*arguments, "--height", "20"]) == 2
    assert "--height cannot be used with --telemetry" in capsys.readouterr().err
    assert main([*arguments, "--start", "660", "--duration", "5"]) == 0
    said = capsys.readouterr().out
    assert "OSD.altitude [ft] (feet, converted to m), above sea level as DJI computes it" in said
    assert "gimbal roll: 0" in said
    assert "refused rows: none" in said


def test_a_piece_that_sees_only_sky_is_refused_with_one_that_sees_water(tmp_path, capsys):
    rows = [f"13,-59,8,0,0,{60 if i < 30 else -40}" for i in range(81)]
    log = tmp_path / "log.csv"
    log.write_text("latitude,longitude,height [m],pitch,yaw,GIMBAL.pitch\n" + "\n".join(rows))
    arguments = ["simulate", "-o", str(tmp_path / "flight"), "--no-images", "--duration", "2"]
    assert main([*arguments, "--telemetry", str(log)]) == 2
    said = capsys.readouterr().err
    assert "the camera sees no water" in said
    assert "With --start 3 it does" in said
    assert not (tmp_path / "flight").exists()
    assert main([*arguments, "--telemetry", str(log), "--start", "3"]) == 0


@pytest.mark.parametrize("start", [480.0, 660.0])
def test_robots_rendered_under_the_real_flight_lie_where_their_truth_projects(shared_data, start):
    """Rendered boxes of floating robots lie round the projections of their true positions."""
    flight = RecordedFlight(read_dji_log(shared_data / "dji_tracking.csv"), start, 60.0)
    made = Experiment(flight, default_camera(640, 360), swim=SwimPlan(heave_m=0.0), seed=2)
    renderer = Renderer(demo_scene(2))
    distances = []
    for frame in made.frames()[::75]:
        _, labels = renderer.render(made.camera, frame.pose, frame.t, made.states(frame))
        truth = made.swarm.positions([frame.t])[:, 0]
        pixels, _ = project_points(made.camera, frame.pose, truth)
        for label in labels:
            pixel = pixels[made.swarm.names.index(label.robot_id)]
            if label.visible > 0.95:
                np.testing.assert_allclose(label.pixel, pixel, atol=0.1)
                center, size = np.array(label.xywh[:2]), np.array(label.xywh[2:])
                distances.append(np.abs(pixel - center) / size)
    assert len(distances) > 10
    assert np.max(distances) < 0.25


def _started(path):
    """A rendering run and its worker processes, once the first image is done."""
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", "simulate", "-o", str(path)]
    command += ["--duration", "30", "--size", "320x180"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert "--no-images" in process.stderr.readline()  # what takes long, before it does
    assert "rendering" in process.stderr.readline()
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    return process, [int(pid) for pid in children.read_text().split()]


def _wait_until_gone(pids):
    deadline = time.monotonic() + 90.0
    while any(Path(f"/proc/{pid}").exists() for pid in pids) and time.monotonic() < deadline:
        time.sleep(0.05)
    return not any(Path(f"/proc/{pid}").exists() for pid in pids)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize(
    ("number", "status"),
    [(signal.SIGTERM, 130), (signal.SIGKILL, -signal.SIGKILL)],
)
def test_an_ended_run_leaves_no_bag_and_no_process(tmp_path, number, status):
    process, children = _started(tmp_path / "flight")
    assert len(children) >= 2
    process.send_signal(number)
    _, said = process.communicate(timeout=90)
    assert process.returncode == status
    assert _wait_until_gone(children)
    assert not (tmp_path / "flight").exists()
    if number != signal.SIGKILL:
        assert "interrupted" in said
        assert list(tmp_path.iterdir()) == []
