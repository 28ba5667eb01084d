# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How far a camera may have turned while no robots explained its boxes, and later evidence."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerial_gnss_ros.core.faults.attitude_ambiguity import TUNING as ATTITUDE_AMBIGUITY
from aerial_gnss_ros.core.faults.attitude_ambiguity import AttitudeAmbiguity
from aerial_gnss_ros.core.faults.formation import TUNING as FORMATION
from aerial_gnss_ros.core.faults.rotation_fault import RotationFault
from aerial_gnss_ros.core.faults.velocity_changes import VelocityChanges
from aerial_gnss_ros.core.models.measurement_model import pose_jacobian

OFFSETS = np.array([[10.0, 60.0, -80.0], [-20.0, 30.0, -80.0]])
BY_ANGLES = pose_jacobian(OFFSETS)[:, :, 3:]


def _degrees(unexplained):
    return np.degrees(np.sqrt(np.diag(unexplained.covariance)))


def _lost(seconds):
    """Return it after boxes that no robots explained, 10 a second."""
    unexplained = AttitudeAmbiguity(FORMATION.turn_sigma_rad)
    for _ in range(round(10 * seconds)):
        unexplained.predict(0.1, 1.0)
        unexplained.update(0.1)
    return unexplained


def test_boxes_that_nobody_explains_make_the_angle_unknown_until_robots_are_back():
    unexplained = AttitudeAmbiguity(FORMATION.turn_sigma_rad)
    unexplained.update(0.5)
    unexplained.update(0.5)
    # 20 deg/s for a second and what was not noticed at first
    assert _degrees(unexplained) == pytest.approx(26.0)
    for _ in range(10):
        unexplained.update(0.5)
    assert _degrees(unexplained) == pytest.approx(math.degrees(FORMATION.turn_sigma_rad))
    unexplained.update(0.0, over=True)
    assert not unexplained.covariance.any()
    unexplained.update(0.1)
    unexplained.update(0.0)  # one image
    assert not unexplained.covariance.any()
    unexplained.update(0.5)
    unexplained.update(0.5)
    unexplained.update(0.0)  # others than before, or elsewhere
    assert unexplained.covariance.any()


def test_robots_found_where_they_should_be_end_the_doubt():
    """One box beside a lone robot, which then needs 2 s until it is that robot again."""
    unexplained = _lost(2.0)
    spread = 1.8**2 * np.eye(2)  # m², of a robot unseen for 2 s
    unexplained.update_reacquired(2.0, BY_ANGLES[0], np.array([0.3, -0.5]), spread)
    unexplained.update(0.0)
    assert (_degrees(unexplained) < 1.0).all()
    # of a robot far from it too, though about the sight of the first one all angles are possible
    assert (
        np.sqrt(np.linalg.eigvalsh(BY_ANGLES[1] @ unexplained.covariance @ BY_ANGLES[1].T)).max()
        < 1.0
    )
    unexplained.predict(1.0, 1.0)
    before = unexplained.covariance
    unexplained.update_reacquired(3.0, BY_ANGLES[1], np.array([2.0, 1.0]), 6.0 * np.eye(2))
    assert np.trace(unexplained.covariance) <= 0.3 * np.trace(before)


def test_robots_found_elsewhere_or_anew_do_not():
    """A camera that turned by 20 deg shows a robot 34 m off; at its gate's edge it is in doubt."""
    turned = BY_ANGLES[0] @ np.radians([0.0, 20.0, 0.0])
    unexplained = _lost(2.0)
    unexplained.update_reacquired(2.0, BY_ANGLES[0], turned, 1.8**2 * np.eye(2))
    assert _degrees(unexplained)[1] > 10.0
    # the same in a gate as wide: neither
    unexplained = _lost(2.0)
    unexplained.update_reacquired(60.0, BY_ANGLES[0], turned, 40.0**2 * np.eye(2))
    assert _degrees(unexplained)[1] > 10.0
    # last seen when the camera had already turned
    unexplained = _lost(2.0)
    before = unexplained.covariance
    unexplained.update_reacquired(1.0, BY_ANGLES[0], np.zeros(2), 1.8**2 * np.eye(2))
    assert unexplained.covariance == pytest.approx(before)


def test_any_number_of_robots_may_be_found():
    unexplained = _lost(2.0)
    for _ in range(1000):
        unexplained.update_reacquired(2.0, BY_ANGLES[0], np.zeros(2), 1e-4 * np.eye(2))
        unexplained.update_reacquired(2.0, BY_ANGLES[1], np.array([50.0, 0.0]), 1e-4 * np.eye(2))
        assert np.isfinite(unexplained.covariance).all()
        assert np.linalg.eigvalsh(unexplained.covariance).min() > -1e-12


def test_robots_tell_of_all_times_since_they_were_seen():
    unexplained = _lost(2.0)
    unexplained.update(0.0)
    unexplained.predict(5.0, 1.0)
    for _ in range(10):
        unexplained.predict(0.1, 1.0)
        unexplained.update(0.1)
    spread = 0.1**2 * np.eye(2)
    # one seen between the two times informs about the second only
    unexplained.update_reacquired(2.0, BY_ANGLES[0], np.zeros(2), spread)
    assert _degrees(unexplained) == pytest.approx(
        [math.degrees(FORMATION.turn_sigma_rad)] * 3, rel=1e-3
    )
    # two seen before both: it has not turned, or as much back
    unexplained.update_reacquired(8.0, BY_ANGLES[0], np.zeros(2), spread)
    unexplained.update_reacquired(8.0, BY_ANGLES[1], np.zeros(2), spread)
    assert not unexplained.covariance.any()


@pytest.mark.parametrize(("back_deg", "share"), [(-30.0, 1.0 / 21.0), (20.0, 1.0)])
def test_telemetry_that_jumps_back_was_wrong_meanwhile(back_deg, share):
    unexplained = AttitudeAmbiguity(FORMATION.turn_sigma_rad)
    assert not unexplained.update_jump(np.radians([0.0, 0.0, 30.0]), 0.1)
    for _ in range(10):
        unexplained.update(0.1)
        unexplained.predict(0.1, 1.0)
    before = unexplained.covariance
    assert unexplained.update_jump(np.radians([0.5, 0.0, back_deg]), 0.1) is (share < 1.0)
    assert unexplained.covariance == pytest.approx(share * before)


def test_only_the_orientation_tells_of_a_jump_that_nobody_saw():
    """Boxes that fit robots may be others', displaced by the jump."""
    unexplained = AttitudeAmbiguity(FORMATION.turn_sigma_rad)
    turn = np.radians([0.0, 0.0, 30.0])
    unexplained.update_jump(turn, 0.1)
    unexplained.keep_jump(unseen=True)
    jump = pytest.approx(np.outer(turn, turn))
    assert unexplained.active
    unexplained.predict(5.0, 1.0)
    unexplained.update(0.0, over=True)
    unexplained.note_return()
    unexplained.update_reacquired(8.0, BY_ANGLES[0], np.zeros(2), 0.01 * np.eye(2))
    assert unexplained.covariance == jump
    assert unexplained.update_jump(-turn, 0.1)
    assert unexplained.covariance == pytest.approx(np.outer(turn, turn) / 21.0)
    unexplained.note_return()
    assert not unexplained.covariance.any()


def test_a_jump_of_the_height_may_displace_robots_until_it_is_reversed():
    unexplained = AttitudeAmbiguity(FORMATION.turn_sigma_rad)
    unexplained.climbed(0.0)
    assert not unexplained.active
    unexplained.climbed(4.0)
    unexplained.predict(1.0, 0.5)
    assert (unexplained.active, unexplained.apart) == (True, 1.0)
    unexplained.note_return()
    assert unexplained.apart == 1.0
    unexplained.climbed(0.0)
    assert unexplained.apart == 0.0


def test_many_times_are_kept_as_few():
    unexplained = AttitudeAmbiguity(FORMATION.turn_sigma_rad)
    for _ in range(20):
        for _ in range(3):
            unexplained.predict(0.1, 1.0)
            unexplained.update(0.1)
        unexplained.update(0.0)
        unexplained.predict(1.0, 1.0)
    assert len(unexplained.episodes) == ATTITUDE_AMBIGUITY.episodes
    # 12 deg each: 20 (0.3 + 0.3)
    assert _degrees(unexplained) == pytest.approx([12.0 * math.sqrt(20.0)] * 3)


def test_robots_that_all_were_elsewhere_may_be_as_far_off_in_any_direction():
    """What displaced them is not known: a turn, a height, a zoom or a picture of another time."""
    unexplained = _lost(0.5)
    unexplained.note_displacement(np.zeros(3), np.zeros((3, 3)), 36.0)
    assert unexplained.apart == 36.0
    changes = VelocityChanges()
    changes.add(2)
    RotationFault(unexplained).spread(changes, np.arange(2), BY_ANGLES, seen=False)
    assert (np.linalg.eigvalsh(changes.position_covariances) >= 36.0 - 1e-9).all()
    unexplained.predict(1.0, 0.9)
    assert unexplained.apart == pytest.approx(0.81 * 36.0)
    unexplained.note_return()
    assert unexplained.apart == 0.0


def test_a_receiver_that_is_back_takes_its_own_doubt_away_and_no_other():
    unexplained = AttitudeAmbiguity(FORMATION.turn_sigma_rad)
    unexplained.shifted(2500.0)
    assert unexplained.active
    unexplained.note_displacement(np.zeros(3), np.zeros((3, 3)), 36.0)
    assert unexplained.apart == 2536.0
    unexplained.shifted(0.0)
    assert unexplained.apart == 36.0


def test_a_robot_found_farther_off_than_it_swims_was_displaced_by_something():
    """Nothing so small is expected of a turn, and yet something contradicted the robots before."""
    unexplained = _lost(2.0)
    unexplained.update_reacquired(2.0, BY_ANGLES[0], np.array([1.0, 1.0]), 1.1 * np.eye(2))
    assert unexplained.apart == 0.0
    unexplained.update_reacquired(2.0, BY_ANGLES[0], np.array([3.0, 2.0]), 1.5 * np.eye(2))
    assert unexplained.apart == pytest.approx(13.0 - 3.0)
    unexplained.update(0.0, over=True)  # it was seen before, and most are where they should be
    assert unexplained.apart == 0.0
    later = _lost(2.0)
    later.update_reacquired(1.0, BY_ANGLES[0], np.array([3.0, 2.0]), 1.5 * np.eye(2))
    assert later.apart == 0.0  # no evidence on times before it was last seen
