# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A click labels all frames; what is not sure is asked; what cannot be meant is refused."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.teaching.clicks import Click
from aerial_gnss_ros.teaching.dataset import write_dataset
from aerial_gnss_ros.teaching.session import Session
from aerial_gnss_ros.teaching.tracks import Sight, overlap

THREE = {"red": (150.0, 200.0, 3.0, 0.0), "yellow": (300.0, 150.0, 0.0, 2.0),
         "white": (420.0, 250.0, -3.0, -1.0)}  # fmt: skip


def _click(robot, frame, box):
    return Click(robot, robot, frame, point=box[:2])


def _overlaps(session, truth, robot):
    """Return the overlap of a robot's sure boxes with the truth, by frame."""
    return {
        frame: overlap(track.box, truth[frame][robot])
        for frame, track in session.tracks[robot].items()
        if track.sight is Sight.SURE and robot in truth[frame]
    }


def test_one_click_each_labels_every_frame_in_both_directions(film, work):
    """The camera moves by 10 px a frame, robots by 3 of their own; the click is in frame 4."""
    made = film(THREE)
    session = Session(work(made))
    assert session.add([_click(name, 4, made.truth[4][name]) for name in THREE]) == 3
    for name in THREE:
        overlaps = _overlaps(session, made.truth, name)
        assert sorted(overlaps) == list(range(10)), name
        assert min(overlaps.values()) > 0.7, name
    assert not session.questions()
    assert all(len(session.labels(frame)) == 3 for frame in range(10))


def test_robots_of_different_colour_that_pass_each_other_keep_their_names(film, work):
    """They meet within their own length in frame 5."""
    made = film({"red": (250.0, 180.0, 12.0, 0.0), "white": (370.0, 205.0, -12.0, 0.0),
                 "yellow": (320.0, 100.0, 0.0, 0.0)}, camera=(0.0, 0.0))  # fmt: skip
    session = Session(work(made))
    session.add([_click(name, 0, made.truth[0][name]) for name in made.truth[0]])
    for name in ("red", "white"):
        overlaps = _overlaps(session, made.truth, name)
        assert 9 in overlaps
        assert min(overlaps.values()) > 0.5


def test_a_robot_that_dives_is_asked_about_and_its_frames_are_left_out(film, work):
    made = film(THREE, hidden={"white": range(5, 8)})
    session = Session(work(made))
    session.add([_click(name, 1, made.truth[1][name]) for name in THREE])
    (question,) = session.questions()
    assert (question.robot, question.frame, question.until) == ("white", 5, 9)
    assert [frame for frame in range(10) if session.labels(frame) is None] == [5, 6, 7, 8, 9]
    # Answered: not visible from 5 on, and there again in 8.
    session.add([Click("white", "white", 5), _click("white", 8, made.truth[8]["white"])])
    session.add([Click("white", "white", 7)])
    assert not session.questions()
    assert [len(session.labels(frame)) for frame in range(10)] == [3] * 5 + [2] * 3 + [3] * 2
    assert session.undo().mark.frame == 7
    assert session.project.marks[-1].frame == 8


def test_a_robot_that_was_hidden_for_a_moment_needs_no_answer(film, work):
    """In 1 s it moves by less than its length: what is found is the same."""
    made = film(THREE, hidden={"white": range(5, 6)})
    session = Session(work(made))
    session.add([_click(name, 1, made.truth[1][name]) for name in THREE])
    (question,) = session.questions()
    assert (question.frame, question.until) == (5, 5)


def test_a_robot_that_leaves_the_image_is_out_of_view_and_returns(film, work):
    """The camera pans away for four frames; neither a question nor a label is left there."""
    made = film({"red": (560.0, 180.0, 0.0, 0.0), "yellow": (300.0, 150.0, 0.0, 0.0),
                 "white": (200.0, 250.0, 0.0, 0.0)}, camera=(15.0, 0.0))  # fmt: skip
    session = Session(work(made))
    session.add([_click(name, 0, made.truth[0][name]) for name in made.truth[0]])
    sights = [session.tracks["red"][frame].sight for frame in range(10)]
    assert sights[0] is Sight.SURE
    assert set(sights[7:]) == {Sight.OUT}  # its middle is then 20 px beyond the edge
    assert len(session.labels(9)) == 2


@pytest.mark.parametrize(
    ("click", "words"),
    [
        (Click("red", "red", 0, point=np.array([600.0, 340.0])), "nothing stands out .* 600, 340"),
        (Click("red", "red", 0, point=np.array([700.0, 20.0])), "outside the image, .* 640x360"),
        (Click("red", "red", 0, box=np.array([800.0, 20.0, 30.0, 30.0])), "the box at 800, 20 px"),
        (Click("blue", "red", 0, point=np.array([300.0, 150.0])), "the same box as yellow"),
        (Click("yellow", "fish", 1, point=np.array([309.0, 148.0])), "class 'yellow', not 'fish'"),
    ],
)
def test_clicks_that_cannot_be_meant_are_refused_and_nothing_is_lost(film, work, click, words):
    made = film(THREE, count=2)
    session = Session(work(made))
    session.add([_click("yellow", 0, made.truth[0]["yellow"])])
    with pytest.raises(InputError, match=words):
        session.add([click])
    assert [mark.robot for mark in Session(work_of(session)).project.marks] == ["yellow"]


def test_one_robot_under_two_names_is_said_so(film, work):
    """The second name is clicked where the first one's box was only carried to."""
    made = film(THREE, count=6)
    session = Session(work(made))
    session.add([_click("yellow", 0, made.truth[0]["yellow"])])
    assert session.twins() == []
    session.add([Click("gold", "gold", 5, point=made.truth[5]["yellow"][:2])])
    assert [pair[:2] for pair in session.twins()] == [("yellow", "gold")]
    with pytest.raises(InputError, match=r"yellow and gold have the same box in . frames: if they"):
        write_dataset(session, work_of(session))
    session.undo()
    assert write_dataset(session, work_of(session)).boxes == {"yellow": 6}


def test_marks_before_a_refused_one_are_said_to_be_kept(film, work):
    made = film(THREE, count=2)
    session = Session(work(made))
    nowhere = Click("red", "red", 0, point=np.array([600.0, 340.0]))
    with pytest.raises(InputError, match=r"round the robot\. 1 mark before it is kept; --undo"):
        session.add([_click("yellow", 0, made.truth[0]["yellow"]), nowhere])


def work_of(session):
    """Return the folder of a session."""
    return session.recording.files[0].parent.parent


def test_a_second_click_keeps_the_robots_size_amid_glint(film, work):
    """Where all round the robot is as bright as it, a click says where it is, not how large."""
    made = film(THREE)
    image = cv2.imread(str(made.folder / "007.png"))
    middle = made.truth[7]["white"][:2]
    cv2.rectangle(image, (middle - 60).astype(int).tolist(), (middle + 60).astype(int).tolist(),
                  (235, 235, 235), -1)  # fmt: skip
    cv2.imwrite(str(made.folder / "007.png"), image)
    session = Session(work(made))
    session.add([_click("white", 4, made.truth[4]["white"])])
    session.add([_click("white", 7, made.truth[7]["white"])])
    box = session.tracks["white"][7].box
    assert box[:2] == pytest.approx(middle, abs=3.0)
    assert box[2:] == pytest.approx(made.truth[7]["white"][2:], rel=0.35)


def test_a_drawn_box_sets_how_tight_labels_are(film, work):
    """A person who draws 20 % wider boxes gets them everywhere."""
    made = film(THREE)
    session = Session(work(made))
    x, y, width, height = made.truth[3]["red"]
    drawn = np.array([x - 0.6 * width, y - 0.6 * height, 1.2 * width, 1.2 * height])
    session.add([Click("red", "red", 3, box=drawn)])
    widths = [track.box[2] for track in session.tracks["red"].values()]
    assert np.median(widths) == pytest.approx(1.2 * width, rel=0.08)
