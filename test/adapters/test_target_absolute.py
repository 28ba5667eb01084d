# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""TARGET_ABSOLUTE, as a parser that pymavlink generates from MAVLink's definition reads it."""

from __future__ import annotations

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from aerial_gnss_ros.adapters.target_absolute import target_absolute
from aerial_gnss_ros.core.geometry.geoid import undulation

sys.path.insert(0, str(Path(__file__).parent))

from one_robot import SEEN

# Fields in the order of MAVLink's development.xml.
DEFINITION = """<?xml version="1.0"?>
<mavlink><version>3</version><dialect>0</dialect><enums/><messages>
<message id="510" name="TARGET_ABSOLUTE"><description>Motion of a target</description>
<field type="uint64_t" name="timestamp" units="us">Timestamp</field>
<field type="uint8_t" name="id">Number</field>
<field type="uint8_t" name="sensor_capabilities">Flags</field>
<field type="int32_t" name="lat" units="degE7">Latitude</field>
<field type="int32_t" name="lon" units="degE7">Longitude</field>
<field type="float" name="alt" units="m">Altitude</field>
<field type="float[3]" name="vel" units="m/s">Velocity</field>
<field type="float[3]" name="acc" units="m/s/s">Acceleration</field>
<field type="float[4]" name="q_target">Orientation</field>
<field type="float[3]" name="rates" units="rad/s">Rates</field>
<field type="float[2]" name="position_std" units="m">Errors</field>
<field type="float[3]" name="vel_std" units="m/s">Errors</field>
<field type="float[3]" name="acc_std" units="m/s/s">Errors</field>
</message></messages></mavlink>
"""


@pytest.fixture(scope="module")
def dialect(tmp_path_factory):
    """Return the module that pymavlink's generator makes of the definition."""
    mavgen = pytest.importorskip("pymavlink.generator.mavgen", reason="pymavlink is absent")
    folder = tmp_path_factory.mktemp("dialect")
    (folder / "follow.xml").write_text(DEFINITION)
    options = mavgen.Opts(
        str(folder / "follow.py"), wire_protocol="2.0", language="Python3", validate=False
    )
    mavgen.mavgen(options, [str(folder / "follow.xml")])
    spec = importlib.util.spec_from_file_location("follow", folder / "follow.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["follow"] = module
    spec.loader.exec_module(module)
    return module


def test_a_foreign_parser_reads_position_and_errors_and_that_no_more_is_known(dialect):
    height = undulation(SEEN.latitude, SEEN.longitude)
    parser = dialect.MAVLink(None)
    [read] = parser.parse_buffer(
        target_absolute(replace(SEEN, altitude=height + 1.5), 3, 7, 100, 255)
    )
    assert (read.get_type(), read.get_srcSystem(), read.get_srcComponent(), read.get_seq()) == (
        "TARGET_ABSOLUTE", 7, 100, 255,
    )  # fmt: skip
    assert (read.id, read.sensor_capabilities) == (3, 1)
    assert (read.lat, read.lon) == (131939400, -596415100)
    assert read.timestamp == SEEN.stamp_ns // 1000
    assert read.alt == pytest.approx(1.5, abs=1e-4)
    assert list(read.position_std) == pytest.approx([math.sqrt(2.0) * SEEN.sigma, 5.0])
    unknown = (*read.vel, *read.acc, *read.q_target, *read.rates, *read.vel_std, *read.acc_std)
    assert len(unknown) == 19
    assert all(map(math.isnan, unknown))


def test_an_unknown_altitude_is_not_a_number(dialect):
    [read] = dialect.MAVLink(None).parse_buffer(target_absolute(SEEN, 0, 1, 100, 0))
    assert math.isnan(SEEN.altitude)
    assert math.isnan(read.alt)
    assert math.isnan(read.position_std[1])
