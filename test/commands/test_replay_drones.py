# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss replay --drone`: the recordings of several drones give one result."""

from __future__ import annotations

import csv
import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.bags.drone_tables import DroneImage, DroneTables
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Summary
from aerial_gnss_ros.bags.replay_drones import DronesReplay, _Image, refuse_apart
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.core.fleet.agreement import DroneReport
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import MapDatum

QUICK = ("--no-bag", "--no-figures")


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """The bags of two drones, and parameters of one with RTK."""
    folder = tmp_path_factory.mktemp("drones")
    arguments = ["--no-images", "--duration", "6", "--drones", "2", "--robot-speed", "0"]
    arguments += ["--drone-noise", "consumer", "--drone-noise", "rtk", "--seed", "4"]
    assert main(["simulate", "-o", str(folder / "two"), *arguments]) == 0
    rtk = folder / "rtk.yaml"
    rtk.write_text("/**/estimator:\n  ros__parameters:\n    noise.set: rtk\n")
    return folder / "two", rtk


def drones(two, output, *more):
    bags, rtk = two
    arguments = ["--drone", f"a={bags / 'a'}", "--drone", f"b={bags / 'b'}"]
    return ["replay", *arguments, "--drone-params", f"b={rtk}", "-o", str(output), *QUICK, *more]


def rows(path):
    return list(csv.DictReader(path.read_text().splitlines()))


def test_two_recordings_give_one_result(two, tmp_path, capsys):
    assert main(drones(two, tmp_path / "both", "--json")) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["frames"], said["boxes"]) == (60, 360)
    assert sorted(said["robots"]) == ["aqua_1", "aqua_2", "aqua_3"]
    assert sorted(said["truth"].values()) == ["aqua_1", "aqua_2", "aqua_3"]
    positions = rows(tmp_path / "both" / "positions.csv")
    keys = [(int(row["stamp_ns"]), row["robot_id"]) for row in positions]
    assert keys == sorted(set(keys))
    # A drone with RTK carries one without: by itself the first one is unsure by 1.2 m.
    assert float(positions[0]["var_east_m2"]) > 1.0
    assert float(positions[-1]["var_east_m2"]) < 0.2**2
    named = rows(tmp_path / "both" / "names.csv")
    assert {(row["robot_id"], row["drone"]) for row in named} == {
        (f"aqua_{i}", drone) for i in (1, 2, 3) for drone in "ab"
    }
    reports = rows(tmp_path / "both" / "drones.csv")
    assert {row["drone"] for row in reports} == {"a", "b"}
    assert len(reports) == 2 * 12
    last = reports[-1]
    assert last["shared_robots"] == "3"
    assert (last["disagrees"], last["fault"]) == ("0", "")
    assert float(last["agreement"]) == pytest.approx(1.0, abs=0.5)
    assert float(last["sigma_east_m"]) < 0.3
    assert last["sees"] == "aqua_1 aqua_2 aqua_3"
    flown = np.array([[float(row["latitude_deg"]), float(row["longitude_deg"])] for row in reports])
    assert np.ptp(flown[::2], axis=0).max() < 1e-4 < abs(flown[0] - flown[1]).max()
    errors = {row["error"] for row in rows(tmp_path / "both" / "platform.csv")}
    assert {"a heading", "b heading"} <= errors


def test_what_becomes_of_a_reference_is_in_the_summary(two, tmp_path, capsys):
    """A wrong one changes nothing."""
    stated = tmp_path / "pier.yaml"
    stated.write_text("references: {pier: {class: aqua, position: [13.2, -59.6], sigma_m: 0.05}}")
    for name, more in (("with", ["--drone-params", f"a={stated}"]), ("without", [])):
        assert main(drones(two, tmp_path / name, "--json", *more)) == 0
        notes = json.loads(capsys.readouterr().out)["notes"]
        of_fleet = [one for one in notes if one.startswith("Reference pier is not used: aqua_")]
        assert len(of_fleet) == (name == "with")
    both = [(tmp_path / name / "positions.csv").read_text() for name in ("with", "without")]
    assert both[0] == both[1]


def test_an_evaluation_shows_all_drones(two, tmp_path):
    assert main(drones(two, tmp_path / "both")) == 0
    given = ["--truth", str(two[0] / "a"), "-o", str(tmp_path / "found")]
    assert main(["evaluate", str(tmp_path / "both"), *given]) == 0
    assert (tmp_path / "found" / "seen_by.png").is_file()
    assert "Which drone saw which robot." in (tmp_path / "found" / "report.html").read_text()


def test_the_receiver_s_offset_has_the_sign_of_its_error(two, tmp_path):
    """What is added to drone a's fix brings it to that of drone b, which has RTK."""
    assert main(drones(two, tmp_path / "both")) == 0
    last = [row for row in rows(tmp_path / "both" / "drones.csv") if row["drone"] == "a"][-1]
    alone = tmp_path / "alone"
    assert main(["replay", str(two[0] / "a"), "-o", str(alone), *QUICK]) == 0
    own = {row["robot_id"]: row for row in rows(alone / "positions.csv")[-3:]}
    both = {row["robot_id"]: row for row in rows(tmp_path / "both" / "positions.csv")[-3:]}
    names = {row["drone_robot_id"]: row["robot_id"]
             for row in rows(tmp_path / "both" / "names.csv") if row["drone"] == "a"}  # fmt: skip
    north = [
        np.radians(float(both[names[k]]["latitude_deg"]) - float(own[k]["latitude_deg"])) * 6.37e6
        for k in own
    ]
    assert float(last["offset_north_m"]) == pytest.approx(np.mean(north), abs=0.35)
    assert abs(np.mean(north)) > 0.4


def test_one_drone_with_a_name_is_a_drone_alone(two, tmp_path):
    bags, _ = two
    swimming = tmp_path / "swimming.yaml"
    swimming.write_text(
        "/**/estimator:\n  ros__parameters:\n    tracks.find_moored: false\n"
        "    camera.find_latency: false\n"
    )
    own = ["--params", str(swimming), *QUICK]
    assert main(["replay", "--drone", f"a={bags / 'a'}", "-o", str(tmp_path / "one"), *own]) == 0
    assert main(["replay", str(bags / "a"), "-o", str(tmp_path / "plain"), *own]) == 0
    one, plain = (rows(tmp_path / name / "positions.csv") for name in ("one", "plain"))
    assert [(r["stamp_ns"], r["robot_id"], r["state"]) for r in one] == [
        (r["stamp_ns"], r["robot_id"], r["state"]) for r in plain
    ]
    for column, size in (("latitude_deg", 1e-8), ("var_east_m2", 0.003)):
        values = np.array([[float(row[column]) for row in table] for table in (one, plain)])
        assert np.abs(values[0] - values[1]).max() < size


def test_clocks_are_thought_of_where_drones_have_no_robot_in_common():
    """Robots that swim are elsewhere some seconds later."""
    replay = object.__new__(DronesReplay)
    replay.summary, replay.tables = Summary(), DroneTables()
    for name in "ab":
        report = DroneReport(name, 0, 1.0, 0, np.zeros(2), np.zeros(2), True)
        replay.tables.images.append(DroneImage(report, 0.0, 0.0, ()))
    replay._conclude()
    *contradict, alone = replay.summary.notes
    assert [one.partition(" in ")[0] for one in contradict] == [
        f"Drone {name} contradicts the others" for name in "ab"
    ]
    assert all("clock" in one for one in contradict)
    assert alone.startswith("No robot of 2 drones (a, b) was found to be another drone's")
    assert "their clocks differ" in alone


def test_a_copy_of_a_recording_is_no_second_drone(two, tmp_path, capsys):
    copied = shutil.copytree(two[0] / "a", tmp_path / "copied")
    given = ["--drone", f"a={two[0] / 'a'}", "--drone", f"b={copied}"]
    assert main(["replay", *given, "-o", str(tmp_path / "both"), *QUICK]) == 2
    assert "the recordings of a and b are of one drone" in capsys.readouterr().err
    assert not (tmp_path / "both").exists()


def test_drones_are_recorded_in_namespaces_of_their_own(two, tmp_path, capsys):
    """One bag has both, as one that was recorded ashore."""
    with BagWriter(tmp_path / "shore") as ashore:
        for name in "ab":
            with open_bag(two[0] / name) as bag:
                for one in bag.messages([t for t in bag.topics if "truth" not in t]):
                    ashore.write(f"/{name}{one.topic}", one.msgtype, one.log_ns, one.raw)
    shore = tmp_path / "shore"
    given = ["replay", "--drone", f"a={shore}", "--drone", f"b={shore}", *QUICK]
    spaces = ["--drone-namespace", "a=a", "--drone-namespace", "b=b"]
    assert main([*given, "-o", str(tmp_path / "none")]) == 2
    assert "a and b have the same recording" in capsys.readouterr().err
    assert main([*given, "-o", str(tmp_path / "half"), *spaces[:2]]) == 2
    assert "drone b: " in (said := capsys.readouterr().err)
    assert "give the topics' names" in said
    assert main([*given, "-o", str(tmp_path / "both"), *spaces]) == 0
    own = ["--drone", f"a={two[0] / 'a'}", "--drone", f"b={two[0] / 'b'}", *QUICK]
    assert main(["replay", *own, "-o", str(tmp_path / "plain")]) == 0
    both, plain = (rows(tmp_path / name / "positions.csv") for name in ("both", "plain"))
    assert [row["robot_id"] for row in both] == [row["robot_id"] for row in plain]
    for column in ("latitude_deg", "longitude_deg"):  # the truth of `plain` states the datum
        np.testing.assert_allclose(
            [float(row[column]) for row in both], [float(row[column]) for row in plain], atol=1e-8
        )


def test_the_namespace_of_one_drone_is_proposed(two, tmp_path, capsys):
    with BagWriter(tmp_path / "b") as written, open_bag(two[0] / "b") as bag:
        for one in bag.messages([t for t in bag.topics if "truth" not in t]):
            written.write(f"/drone2{one.topic}", one.msgtype, one.log_ns, one.raw)
    given = ["--drone", f"a={two[0] / 'a'}", "--drone", f"b={tmp_path / 'b'}", *QUICK]
    assert main(["replay", *given, "-o", str(tmp_path / "both")]) == 2
    assert "try --drone-namespace b=drone2." in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "give a BAG, or --drone NAME=BAG"),
        (["--drone", "a"], "'a' is not NAME=PATH"),
        (["--drone", "A b=x"], "is not NAME=PATH"),
        (["bag", "--drone", "a=x"], "give BAG or --drone, not both"),
        (["--each", "--drone", "a=x"], "give --each or --drone, not both"),
        (["--drone", "a=x", "--drone", "a=y"], "two drones are called a"),
        (["--drone", "a=x", "--drone-params", "b=y"], "names b, which is none of the drones"),
        (["--drone", "a=x", "--drone-namespace", "b=y"], "names b, which is none of the drones"),
        (["--drone", "a=x", "--drone-namespace", "b"], "'b' is not NAME=NAMESPACE"),
        (["bag", "--drone-namespace", "b=y"], "--drone-namespace applies only with --drone"),
        (["--drone", "a=x", "--gnss-share", "2"], "--gnss-share must lie within 0 to 1, not 2"),
        (["bag", "--gnss-share", "0.2"], "--gnss-share applies only with --drone"),
        (["--drone", "a=absent", "--drone", "b=absent as well"], "absent"),
        (["--drone", "a=x", "--drone", "b=./x"], "a and b have the same recording"),
        (
            ["--drone", "a=x", "--drone", "b=x", "--drone-params", "b=topics.yaml"],
            "topics.yaml: cannot be read",  # one recording may contain both drones
        ),
        (["--drone", "a=absent", "--method", "paper"], "absent"),
    ],
)
def test_wrong_arguments_are_one_sentence_and_leave_nothing(tmp_path, capsys, arguments, words):
    assert main(["replay", *arguments, "-o", str(tmp_path / "result")]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "Traceback" not in said
    assert not (tmp_path / "result").exists()


def test_what_drones_together_cannot_do_is_refused_in_words(two, tmp_path, capsys):
    assert main(drones(two, tmp_path / "result", "--method", "paper")) == 2
    assert "drone a: method must be filter, not paper" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def images(drone, latitude, seconds):
    """Return images of a drone at a latitude, rad, at some seconds."""
    return [
        _Image(round(t * 1e9), drone, None, SimpleNamespace(pose=SimpleNamespace(
            latitude=latitude, longitude=-1.04)))
        for t in seconds
    ]  # fmt: skip


def test_drones_of_another_site_or_clock_are_refused():
    local = LocalMap(MapDatum(0.23, -1.04, 0.0))
    here = images("a", 0.23, (0, 10))
    refuse_apart(here, local, {"a": 1e5})
    refuse_apart(here + images("b", 0.2301, (10, 20)), local, {"a": 1e5, "b": 1e5})
    refuse_apart(here + images("c", 0.23, (5, 15)) + images("b", 0.23, (15, 20)), local,
                 dict.fromkeys("abc", 1e5))  # fmt: skip
    with pytest.raises(InputError, match="drone b is 127 km from the origin of map"):
        refuse_apart(here + images("b", 0.25, (0, 10)), local, {"a": 1e5, "b": 1e5})
    for seconds in ((3600, 3610), (-3610, -3590)):
        with pytest.raises(
            InputError, match=r"drone [ab] is 3590 s apart from those of the others"
        ):
            refuse_apart(here + images("b", 0.23, seconds), local, {"a": 1e5, "b": 1e5})


def test_the_drone_whose_compass_is_wrong_is_named_with_its_sensor(tmp_path, capsys):
    """The parameters take drone b's true north for the magnetic one, 15 degrees off."""
    arguments = ["--no-images", "--duration", "8", "--drones", "2", "--robot-speed", "0"]
    assert main(["simulate", "-o", str(tmp_path / "two"), *arguments, "--noise", "rtk"]) == 0
    rtk, turned = tmp_path / "rtk.yaml", tmp_path / "turned.yaml"
    rtk.write_text("/**/estimator:\n  ros__parameters:\n    noise.set: rtk\n")
    turned.write_text("/**/estimator:\n  ros__parameters:\n    gimbal.north: magnetic\n")
    given = [f"--drone={name}={tmp_path / 'two' / name}" for name in "ab"]
    given += ["--params", str(rtk), "--drone-params", f"b={turned}"]
    assert main(["replay", *given, "-o", str(tmp_path / "both"), *QUICK]) == 0
    said = " ".join(capsys.readouterr().err.split())
    assert "Drone b: the compass is wrong by far more than it states, in" in said
    assert "Drone a contradicts" not in said
    assert "Drone a: the " not in said
    last = {row["drone"]: row for row in rows(tmp_path / "both" / "drones.csv")}
    assert {name: last[name]["fault"] for name in "ab"} == {"a": "", "b": "compass"}
    assert (last["a"]["disagrees"], last["b"]["disagrees"]) == ("0", "1")
