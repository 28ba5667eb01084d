# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One drone's filter as references read it: its own arrays, not copies."""

from __future__ import annotations

import numpy as np

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.filter.joint_filter import JointFilter
from aerial_gnss_ros.core.references.source import FilterSource


def test_it_reads_what_the_filter_has_now():
    joint = JointFilter(estimator_config({"noise.set": "consumer"}))
    source = FilterSource(joint)
    for law, group in zip(source.laws, joint.groups, strict=True):
        assert law.rows is group.rows  # by which laws are recognised
        assert law.mean is group.mean
        assert law.covariance is group.covariance
    assert len(source.laws) == 1
    joint.trajectory.jumps.believed[:] = 3.0, -1.0
    np.testing.assert_array_equal(source.believed, [3.0, -1.0])
    np.testing.assert_array_equal(source.stationary, joint.stationary)
    np.testing.assert_array_equal(source.decay(7.0), joint.model.decay(7.0))
