# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameter files: read as ROS reads them, but nothing is ignored; writing and reading agree."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from aerial_gnss_ros.adapters.parameter_documents import document
from aerial_gnss_ros.adapters.parameter_files import read, ros_parameters
from aerial_gnss_ros.core.config.estimator import EstimatorConfig, estimator_config
from aerial_gnss_ros.core.config.schema import build, key, leaves
from aerial_gnss_ros.core.values.errors import ConfigError


@dataclass(frozen=True)
class Seeing:
    """A second node's parameters, as small as can be."""

    model: str = key("aqua", "Model.")
    rate: float = key(1.0, "Rate.", unit="Hz", low=0.5, high=50.0)


SCHEMAS = {"seeing": Seeing, "estimator": EstimatorConfig}


def given(tmp_path, text, namespace="/"):
    path = tmp_path / "p.yaml"
    path.write_text(text)
    return read([path], SCHEMAS, namespace)


def test_the_written_document_reads_back_as_the_defaults(tmp_path):
    for node, schema in SCHEMAS.items():
        text = document(node, schema, "a command", "robots: an example")
        values = given(tmp_path, text)[node]
        assert repr(build(schema, values)) == repr(schema())  # repr: NaN equals NaN
        assert len(values) == len(list(leaves(schema)))


ROS = "{0}:\n  ros__parameters: {{{1}}}\n"


@pytest.mark.parametrize(
    ("text", "namespace", "max_wait"),
    [
        (ROS.format("/**", "max_wait: 2"), "/", 2.0),
        (ROS.format("estimator", "max_wait: 2.0"), "/", 2.0),
        (ROS.format("/**/estimator", "max_wait: 2.0"), "/a/b", 2.0),
        (ROS.format("/a/*/estimator", "max_wait: 2.0"), "/a/b", 2.0),
        (ROS.format("/a/b/estimator", "max_wait: 2.0"), "a/b", 2.0),
        ("a:\n  estimator:\n    ros__parameters: {max_wait: 2.0}\n", "a", 2.0),
        # an exact name beats a pattern, wherever it stands
        (ROS.format("estimator", "max_wait: 2") + ROS.format("/**", "max_wait: 9"), "/", 2.0),
        (ROS.format("/**", "max_wait: 9") + ROS.format("/**/estimator", "max_wait: 2"), "/", 2.0),
        ("max_wait: 2\n", "/", 2.0),
        ("max_wait: 2e0\n", "/", 2.0),
    ],
)
def test_sections_are_chosen_as_ros_chooses_them(tmp_path, text, namespace, max_wait):
    assert given(tmp_path, text, namespace)["estimator"] == {"max_wait": max_wait}


def test_a_shared_section_serves_each_node_with_what_it_knows(tmp_path):
    values = given(tmp_path, "rate: 5\nfix: {max_gap: 1}\nrobots: {a: {class: x, start: [1, 2]}}\n")
    assert values["seeing"] == {"rate": 5.0}
    assert values["estimator"]["fix.max_gap"] == 1.0
    assert [robot.name for robot in estimator_config(values["estimator"]).robots] == ["a"]


def test_the_later_file_wins(tmp_path):
    for name, value in (("a", 1), ("b", 2)):
        (tmp_path / name).write_text(f"max_wait: {value}\n")
    values = read([tmp_path / "a", tmp_path / "b"], SCHEMAS)
    assert values["estimator"] == {"max_wait": 2.0}


def test_use_sim_time_is_kept_for_ros(tmp_path):
    text = ROS.format("/**", "use_sim_time: true, max_wait: 2.0")
    assert given(tmp_path, text)["estimator"] == {"max_wait": 2.0}
    assert ros_parameters([tmp_path / "p.yaml"], "estimator") == {"use_sim_time": True}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (ROS.format("/**", "max_wiat: 2.0"), "max_wiat is not a parameter; did you mean max_wait?"),
        (
            "max_gap: 2.0",
            "did you mean fix.max_gap, attitude.max_gap, gimbal.max_gap or height.max_gap?",
        ),
        ("fix: {altitude_dtum: home}", "fix.altitude_dtum is not a parameter; did you mean"),
        # known, but to the other node
        (ROS.format("/**/estimator", "rate: 5.0"), "rate is not a parameter"),
        ("max_wait: soon", "max_wait must be a number (s), not 'soon'."),
        ('camera: {topic: "a\\0b"}', "camera.topic must be text without control characters, not"),
        ("max_wait: 99", "max_wait must lie within 0 to 30 (s), not 99."),
        ("max_wait: .nan", "max_wait must be a number (s), not NaN."),
        ("max_wait:", "max_wait has no value; give one or remove the line."),
        ("gimbal: {reference: nose}", "gimbal.reference must be one of earth, heading"),
        ("camera: {offset_m: [1.0, 2.0]}", "camera.offset_m must have 3 elements, not 2"),
        ("tracks: {confirm_hits: 2.5}", "tracks.confirm_hits must be a whole number, not 2.5"),
        ("camera: {rectified: 1}", "camera.rectified must be true or false, not 1."),
        ("a: 1\na: 2\n", "a is given twice (line 2); keep one of them."),
        ("a: [1\n", "is not YAML: expected ',' or ']', but got '<stream end>' in line 2."),
        ("- 1\n- 2\n", "must hold parameter names with values, not '[1, 2]'."),
        (ROS.format("camera_driver", "x: 1"), "has no section for /seeing or /estimator, only for"),
        ("/**:\n  ros__parameters: 5\n", "**.ros__parameters must be a mapping, not 5."),
    ],
)
def test_bad_files_are_refused_by_name(tmp_path, text, sentence):
    with pytest.raises(ConfigError) as refusal:
        given(tmp_path, text)
    assert sentence in str(refusal.value)
    assert str(refusal.value).startswith(str(tmp_path / "p.yaml"))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"absent\.yaml: cannot be read: No such file"):
        read([tmp_path / "absent.yaml"], SCHEMAS)
