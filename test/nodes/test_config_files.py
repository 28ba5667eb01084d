# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The shipped parameter files say what the program does."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.nodes.config_files import texts
from aerial_gnss_ros.nodes.schemas import SCHEMAS


@pytest.mark.parametrize("name", sorted(texts()))
def test_generated_files_are_up_to_date(repository, name):
    shipped = (repository / "config" / name).read_text(encoding="utf-8")
    assert shipped == texts()[name], "run python3 -m aerial_gnss_ros.nodes.config_files config"


def test_every_vehicle_profile_is_understood_by_all_nodes():
    assert "generic" in vehicle_names()
    for name in vehicle_names():
        assert set(read([vehicle_file(name)], SCHEMAS)) == {"detector", "estimator", "fleet"}


@pytest.mark.parametrize(
    ("vehicle", "sentence"),
    [
        ("submarine", "submarine is not a vehicle profile; choose from .*generic"),
        ("my/absent.yaml", "vehicle profile my/absent.yaml does not exist"),
    ],
)
def test_an_unknown_vehicle_is_refused(vehicle, sentence):
    with pytest.raises(ConfigError, match=sentence):
        vehicle_file(vehicle)
