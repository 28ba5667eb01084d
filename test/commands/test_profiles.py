# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss profiles` lists what `--vehicle` takes, and prints one to start from."""

from __future__ import annotations

import json
import re

import pytest
import yaml

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters.vehicles import vehicle_file, vehicle_names


def test_every_profile_is_listed_with_what_it_is_for(capsys):
    assert cli.main(["profiles"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == vehicle_names()
    assert all(len(line.split(maxsplit=1)[1]) > 20 for line in lines)
    assert cli.main(["profiles", "--json"]) == 0
    assert list(json.loads(capsys.readouterr().out)) == vehicle_names()


def test_one_is_printed_as_a_file_that_can_be_given_back(capsys, tmp_path):
    assert cli.main(["profiles", "px4_uxrce"]) == 0
    text = capsys.readouterr().out
    assert "/**/estimator" in yaml.safe_load(text)
    own = tmp_path / "own.yaml"
    own.write_text(text)
    assert cli.main(["profiles", str(own)]) == 0
    assert capsys.readouterr().out == text


def test_an_unknown_one_is_refused_with_those_there_are(capsys):
    assert cli.main(["profiles", "submarine"]) == 2
    said = capsys.readouterr().err
    assert "submarine is not a vehicle profile; choose from anafi, ardupilot_dds, dji_psdk" in said


def test_all_keys_are_printed_with_their_meaning(capsys):
    assert cli.main(["profiles", "--keys"]) == 0
    out = capsys.readouterr().out
    assert "/**/detector:" in out
    assert "# An image stamped t shows the scene at t - latency_s" in out
    assert cli.main(["profiles", "generic", "--keys"]) == 2
    assert "--keys takes no profile" in capsys.readouterr().err
    assert cli.main(["profiles", "generic", "--json"]) == 2
    assert "--json is for the list" in capsys.readouterr().err


@pytest.mark.parametrize("name", vehicle_names())
def test_every_key_of_a_profile_says_what_it_means(name):
    lines = vehicle_file(name).read_text(encoding="utf-8").splitlines()
    values = [i for i, line in enumerate(lines) if re.match(r"\s+\w+: [^#\s]", line)]
    assert values
    for i in values:
        explained = " # " in lines[i] or lines[i - 1].strip().startswith("#")
        assert explained, f"{name}.yaml says nothing of {lines[i].strip()}"
