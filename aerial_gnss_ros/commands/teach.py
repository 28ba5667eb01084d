# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss teach`: from a few clicks to labels of a whole recording and a detector.

The folder that it writes keeps frames and marks: started again with it, the work goes on.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import webbrowser
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from aerial_gnss_ros.bags.pictures import open_pictures
from aerial_gnss_ros.bags.reader import BAG_ENDINGS
from aerial_gnss_ros.commands.configuration import Configuration, configuration
from aerial_gnss_ros.commands.configuration import add_arguments as add_configuration
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.errors import ConfigError, InputError, ModelError
from aerial_gnss_ros.teaching.advice import lengths, parameters
from aerial_gnss_ros.teaching.clicks import read_clicks
from aerial_gnss_ros.teaching.dataset import FEW, FOLDER, Written, write_dataset
from aerial_gnss_ros.teaching.geometry import View
from aerial_gnss_ros.teaching.learning import NETWORK, Learnt, Plan, learn
from aerial_gnss_ros.teaching.project import FILE
from aerial_gnss_ros.teaching.recording import FOLDER as FRAMES
from aerial_gnss_ros.teaching.recording import Recording, extract
from aerial_gnss_ros.teaching.session import Question, Session
from aerial_gnss_ros.teaching.telemetry import bag_views
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.view.server import LOCAL, application
from aerial_gnss_ros.view.server import run as serve
from aerial_gnss_ros.view.teach import PAGE, PORT, Teacher, routes

MOST_FRAMES = 400
MOST_SHOWN = 12
PARAMETERS = "detector.yaml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.epilog = (
        'CLICKS is JSON: {"marks": [{"robot": "fin_1", "class": "fin", "frame": 12, '
        '"x": 640, "y": 360}, ...]}; instead of x and y "box": [left, top, width, height] in '
        'px, or "absent": true where it is not visible. "image": NAME stands for the frame\'s '
        "number. Marks are kept in MY_ROBOT: the command goes on where it was left."
    )
    parser.add_argument(
        "recording", type=Path, metavar="RECORDING", help="a bag, a video or a folder of images"
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="MY_ROBOT",
        help="folder for frames, marks and data set; one that exists is continued",
    )  # fmt: skip
    parser.add_argument("--clicks", type=Path, metavar="JSON", help="marks to add, from a file")
    parser.add_argument(
        "--class", dest="class_name", default="robot", metavar="NAME",
        help="class of robots whose marks state none (default robot)",
    )  # fmt: skip
    parser.add_argument(
        "--frames", type=int, default=MOST_FRAMES, metavar="N",
        help="greatest number of frames to label; of a longer recording every n-th is taken "
        f"(default {MOST_FRAMES})",
    )  # fmt: skip
    parser.add_argument(
        "--no-page", action="store_true", help="open no page; write the data set and end"
    )
    parser.add_argument(
        "--port", type=int, default=PORT, metavar="N",
        help="TCP port of the page (%(default)s; 0: any free)",
    )  # fmt: skip
    parser.add_argument(
        "--no-train", action="store_true", help="write the data set, and train no detector on it"
    )
    parser.add_argument(
        "--water", type=Path, metavar="FOLDER",
        help="images of water without any robot: robots are pasted onto them too, and whatever "
        "floats in them is learnt to be none",
    )  # fmt: skip
    parser.add_argument(
        "--threads", type=int, default=0, metavar="N",
        help="processor threads of the training (default 0: one for each core)",
    )  # fmt: skip
    parser.add_argument("--undo", action="store_true", help="take back the last mark first")
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")
    add_configuration(parser)


def run(args: argparse.Namespace) -> int:
    """Label a recording."""
    if not 0 <= args.port <= 65535:
        raise ConfigError(f"--port must be 0 to 65535, not {args.port}.")
    if not 0 <= args.threads <= 256:
        raise ConfigError(f"--threads must lie within 0 to 256, not {args.threads}.")
    if not 2 <= args.frames <= 5000:
        raise ConfigError(f"--frames must lie within 2 to 5000, not {args.frames}.")
    with ended_cleanly():
        _open(args)
        recording = Recording(args.output)
        if recording.name != args.recording.name:
            raise InputError(
                f"{args.output} has frames of {recording.name}, not of {args.recording.name}; give "
                "another folder."
            )
        with progress("looking for what stands out", len(recording), "frames") as report:
            recording.prepare(report)
        how = "telemetry" if recording.posed else "alignment of the images"
        print(
            f"boxes are carried by {how} ({recording.posed} of {len(recording)} cameras known)",
            file=sys.stderr,
        )
        session = Session(args.output)
        if args.undo:
            session.undo()
        if args.clicks is not None:
            session.add(read_clicks(args.clicks, recording.names, args.class_name))
        if not (args.no_page or args.clicks or args.undo):
            _page(args, session)
        if not session.project.marks:
            raise InputError(
                f"{args.output} has no marks yet; click the robots on the page, or give --clicks "
                "JSON (see aerial-gnss teach --help)."
            )
        written = write_dataset(session, args.output)
        if not args.json:
            print("\n".join(_as_text(args.output, session, written)))
        learnt = _learn(args, written)
        advised = "" if learnt is None else _parameters(args.output, session, learnt)
    if args.json:
        print(json.dumps({**_as_dict(args.output, session, written), **_figures(learnt)}, indent=2))
    elif learnt is not None:
        print("\n".join(_advice(args.output, learnt, advised)))
    return 0


def _learn(args: argparse.Namespace, written: Written) -> Learnt | None:
    """Train a detector; None, with the reason said, if that is not wanted or not possible."""
    if args.no_train or sum(written.boxes.values()) < FEW:
        return None
    try:
        return learn(args.output, Plan(args.water, threads=args.threads), progress)
    except (InputError, ModelError) as error:
        print(f"no detector: {error}", file=sys.stderr)
        return None


def _parameters(output: Path, session: Session, learnt: Learnt) -> str:
    """Write what belongs into the parameters, and return it."""
    text = parameters(output / NETWORK, learnt.threshold, learnt.confirm_score, lengths(session))
    (output / PARAMETERS).write_text(text, encoding="utf-8")
    return text


def _figures(learnt: Learnt | None) -> dict[str, Any]:
    if learnt is None:
        return {}
    figures = {
        "threshold": learnt.threshold, "precision": round(learnt.precision, 4),
        "recall": round(learnt.recall, 4), "images": learnt.images, "robots": learnt.robots,
        "training_s": learnt.training_s, "image_ms": learnt.image_ms,
    }  # fmt: skip
    return {"detector": figures}


def _advice(output: Path, learnt: Learnt, advised: str) -> list[str]:
    score = "the part kept aside has no labels, so nothing is known about its quality"
    if learnt.robots:
        score = (
            f"on the {counted(learnt.images, 'image')} kept aside, with "
            f"{counted(learnt.robots, 'label')}: precision {learnt.precision:.3f}, recall "
            f"{learnt.recall:.3f}"
        )
    return [
        (
            f"{output / NETWORK}: trained in {learnt.training_s:.0f} s on "
            f"{counted(learnt.boxes, 'box')}, {learnt.image_ms:.0f} ms an image"
        ),
        f"  {score}",
        f"put into detector.yaml (or give --params {output / PARAMETERS}):",
        advised.rstrip(),
    ]


def _page(args: argparse.Namespace, session: Session) -> None:
    """Serve the page to this computer until a signal."""

    def write(now: Session) -> str:
        written = write_dataset(now, args.output)
        lines = _as_text(args.output, now, written)
        if sum(written.boxes.values()) >= FEW and not args.no_train:
            lines.append("Ctrl-C in the terminal ends this page and trains a detector on it.")
        return "\n".join(lines)

    def began(url: str) -> None:
        print(f"open {url} in a browser; Ctrl-C ends and writes the data set.", file=sys.stderr)
        if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            webbrowser.open(url)

    teacher = Teacher(session, args.class_name, write)
    serve(application(PAGE, routes(teacher)), LOCAL, args.port, began)


def _open(args: argparse.Namespace) -> None:
    """Copy the frames, unless the folder has them."""
    if (args.output / FRAMES).is_dir():
        return
    if args.output.exists() and (not args.output.is_dir() or any(args.output.iterdir())):
        known = {FILE, f".{FRAMES}.partial"}
        if not args.output.is_dir() or {one.name for one in args.output.iterdir()} - known:
            raise InputError(f"{args.output} exists and is no work of teach; give another folder.")
    given = configuration(args)
    source = open_pictures(args.recording, given.detector.image.max_pixels)
    args.output.mkdir(parents=True, exist_ok=True)
    with progress("reading", source.count, "images") as report:
        try:
            refused = extract(
                source, args.output, args.frames, lambda stamps: _views(args, given, stamps), report
            )
        except BaseException:
            with suppress(OSError):  # it has files of its own
                args.output.rmdir()
            raise
    for sentence in refused[:MOST_SHOWN]:
        print(sentence, file=sys.stderr)


def _views(
    args: argparse.Namespace, given: Configuration, stamps: Sequence[int]
) -> list[View | None]:
    """Return the cameras of a bag; without telemetry, say so."""
    path = args.recording
    views: list[View | None] = [None] * len(stamps)
    if (path / "metadata.yaml").is_file() or path.suffix.lower() in BAG_ENDINGS:
        try:
            views = bag_views(path, stamps, given.estimator, given.detector, args.namespace)
        except InputError as error:
            if args.vehicle or args.params:
                raise
            print(f"no telemetry: {error}", file=sys.stderr)
    return views


def _as_text(output: Path, session: Session, written: Written) -> list[str]:
    boxes = sum(written.boxes.values())
    kinds = ", ".join(f"{name} {count}" for name, count in written.boxes.items())
    marks = len(session.project.marks)
    images = written.images
    lines = [
        f"{output / FOLDER}: {counted(boxes, 'box')} ({kinds}) from {counted(marks, 'mark')}",
        (
            f"  images: {images['train']} to train, {images['val']} at the end kept aside; left "
            f"out, as a robot is unsure there: {written.left_out}"
        ),
    ]
    questions = session.questions()
    if questions:
        lines.append("unsure (answer in --clicks with a box or absent):")
        lines += [f"  {_asked(one)}" for one in questions[:MOST_SHOWN]]
        if len(questions) > MOST_SHOWN:
            lines.append(f"  and {len(questions) - MOST_SHOWN} more")
    if boxes < FEW:
        lines.append(
            f"{counted(boxes, 'box')} {'is' if boxes == 1 else 'are'} too few to train on; mark "
            f"more frames, until there are {FEW} at the least."
        )
    return lines


def _asked(question: Question) -> str:
    x, y, width, height = question.box
    last = f" to {question.until}" if question.until > question.frame else ""
    return (
        f"frame {question.frame}{last}: {question.robot} at {x:.0f}, {y:.0f} px "
        f"({width:.0f}x{height:.0f})?"
    )


def _as_dict(output: Path, session: Session, written: Written) -> dict[str, Any]:
    return {
        "dataset": str(output / FOLDER),
        "marks": len(session.project.marks),
        "images": written.images,
        "boxes": written.boxes,
        "left_out": written.left_out,
        "questions": [
            {
                "robot": one.robot,
                "frame": one.frame,
                "until": one.until,
                "box": [round(float(value), 1) for value in one.box],
            }
            for one in session.questions()
        ],
    }
