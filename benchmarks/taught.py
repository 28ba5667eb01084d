# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From the first click to positions: teach a robot on one simulated flight, find it on another.

python benchmarks/taught.py torpedo --teach-on A.jpg --find-on B.jpg -o WORK

A.jpg and B.jpg are photographs of water, taken straight down; both flights are over two robots of
the model and four other things afloat. The page of `aerial-gnss teach` is driven in a real browser,
by what `teach_person.py` says: one click in the middle of each robot, a box drawn where that is
off, answers to what is asked. Then `replay` runs
with the taught detector.yaml on the other flight (another seed, another photograph), and `evaluate`
compares its positions with the truth. A stage that is done is kept in WORK.

A person is not measured but estimated, by the keystroke-level model (S. Card, T. Moran and
A. Newell, "The keystroke-level model for user performance time with interactive systems", CACM
23(7), 1980): `PERSON_S` for each thing to do.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tables import columns, show
from teach import _bag_truth as bag_truth
from teach_page import browser, shot
from teach_person import Act, next_act

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.tables import EstimatedTrack, read_positions
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.evaluation.errors import at_stamps, compare, summarise
from aerial_gnss_ros.evaluation.truth import Truth, read_truth
from aerial_gnss_ros.simulation.robots import Swarm, SwimPlan
from aerial_gnss_ros.teaching.recording import Recording
from aerial_gnss_ros.teaching.session import Session
from aerial_gnss_ros.training.labelled_bag import read_bag
from aerial_gnss_ros.training.score import Score

FALSE_M = 2.0
MOST_ACTS = 20
PERSON_S = {
    "typed": 0.28,  # K: an average typist's key
    "pointed": 1.1,  # P
    "clicked": 0.2,  # two B
    "moved hands": 0.4,  # H
    "decided": 1.35,  # M
    "watched": 0.2,  # an image while the recording plays once, to look for what is not labelled
}
HEADS = ["robot", "clicks", "boxes drawn", "answers",
         "person, s (estimate)", "teach, labels: wall (processor), s",
         "training", "replay", "boxes: precision", "recall", "images with a position",
         "error, m RMS", "false robots"]  # fmt: skip


class Log:
    """What was measured, kept on the disk."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "log.json"
        self.content: dict[str, Any] = {}
        if self._file.is_file():
            self.content = json.loads(self._file.read_text())

    def keep(self, name: str, value: Any) -> None:
        """Keep a value."""
        self.content[name] = value
        self._file.write_text(json.dumps(self.content, indent=1))
        print(f"{name}: {value}", flush=True)


class Clock:
    """Time since it was made: by the wall, and of the processor for finished processes."""

    def __init__(self) -> None:
        self._wall, self._used = time.perf_counter(), self._children()

    @staticmethod
    def _children() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    def read(self) -> list[float]:
        """Return both, s."""
        wall, used = time.perf_counter() - self._wall, self._children() - self._used
        return [round(wall, 1), round(used, 1)]


def main() -> None:
    """Teach, find, compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", nargs="+")
    parser.add_argument("--teach-on", type=Path, required=True, metavar="PHOTOGRAPH")
    parser.add_argument("--find-on", type=Path, required=True, metavar="PHOTOGRAPH")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="WORK")
    parser.add_argument("--seed", type=int, default=502, help="of the first flight")
    parser.add_argument("--size", default="1280x720", help="of the images, px")
    parser.add_argument("--height", default="12", help="of the flights, m")
    parser.add_argument("--threads", default="1", help="of the training")
    parser.add_argument("--picture", type=Path, help="write the page as JPEG")
    parser.add_argument("--markdown", type=Path, metavar="PAGE")
    args = parser.parse_args()
    rows = []
    for model in args.model:
        folder = args.output / model
        folder.mkdir(parents=True, exist_ok=True)
        log = Log(folder)
        other = _alike(model, args.seed)
        view = ["--size", args.size, "--height", args.height]
        _fly(log, folder / "taught", model, args.teach_on, args.seed, view, "transit", 3, 20)
        _fly(log, folder / "found", model, args.find_on, other, view, "orbit", 5, 20)
        if "training" not in log.content:
            _teach(log, folder, model, args.threads, args.picture)
        _replay(log, folder)
        if "boxes" not in log.content:
            _score(log, folder)
        rows.append(_row(model, log.content))
    show(columns(HEADS, rows), args.markdown)


def _alike(model: str, seed: int) -> int:
    """Return the seed of another flight with robots of the same paints: one's own robots."""

    def paints(number: int) -> set[str]:
        swarm = Swarm(np.array([[0.0, 0.0], [9.0, 9.0]]), SwimPlan(models=(model,)), number, 0.0, 1)
        return {robot.livery for robot in swarm.states(0.0)}

    return next(one for one in itertools.count(seed + 100) if paints(one) == paints(seed))


def _run(*arguments: object) -> None:
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", *map(str, arguments)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # noqa: S603


def _fly(
    log: Log,
    bag: Path,
    model: str,
    water: Path,
    seed: int,
    view: list[str],
    flight: str,
    rate: int,
    duration: int,
) -> None:
    if bag.is_dir():
        return
    clock = Clock()
    _run(
        "simulate", "-o", bag, "--flight", flight, "--seed", seed, "--robot-model", model,
        "--robots", 2, "--rate", rate, "--distractors", 4, "--duration", duration, *view,
        "--water", water,
    )  # fmt: skip
    log.keep(f"simulated {bag.name}", clock.read())


def _teach(log: Log, folder: Path, model: str, threads: str, picture: Path | None) -> None:
    """Click on the page, end it, and let it train."""
    work = folder / "mine"
    clock = Clock()
    environment = {k: v for k, v in os.environ.items() if "DISPLAY" not in k}
    arguments = ["teach", str(folder / "taught"), "-o", str(work), "--class", model, "--port", "0",
                 "--threads", threads]  # fmt: skip
    server = subprocess.Popen(  # noqa: S603
        [sys.executable, "-m", "aerial_gnss_ros.cli", *arguments], text=True, env=environment,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    url = next(line.split()[1] for line in server.stderr if line.startswith("open http"))
    opened = clock.read()[0]
    with browser() as driver:
        driver.get(url)
        acts = _acts(driver, folder / "taught", work, model)
        state = driver.execute_script("return page.state")
        if picture is not None:
            shot(driver, acts[-1].frame, picture)
    log.keep("acts", [(act.kind, act.robot, act.frame) for act in acts])
    log.keep("marks", [sum(act.kind == kind for act in acts)
                       for kind in ("click", "box", "yes")])  # fmt: skip
    log.keep("questions", len(state["questions"]))
    log.keep("labelled", [round(clock.read()[0], 1), None])
    log.keep("page opened after", opened)
    log.keep("person", round(_person(arguments, acts, len(Recording(work))), 1))
    server.send_signal(signal.SIGINT)
    said, _ = server.communicate()
    print(said, flush=True)
    if server.returncode:
        raise SystemExit("teach failed.")
    about = json.loads((work / "taught.json").read_text())
    log.keep("kept aside", [about["images"], about["robots"], about["found"], about["false"]])
    log.keep("training", [about["training_s"], clock.read()[1]])


def _acts(driver: Any, bag: Path, work: Path, model: str) -> list[Act]:
    """Do on the page all that a person does; return it."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.support.ui import WebDriverWait

    wait = WebDriverWait(driver, 300)
    wait.until(lambda one: one.execute_script("return page.hello && page.shown >= 0"))
    truth, names, done = bag_truth(bag, Recording(work)), dict[str, str](), list[Act]()
    while len(done) < MOST_ACTS and (act := next_act(Session(work), truth, names)) is not None:
        fresh = act.robot not in names
        name = names.setdefault(act.robot, f"{model}_{len(names) + 1}")
        if act.kind == "yes":
            driver.execute_script(
                "page.question = page.state.questions.find(one => one.robot === arguments[0])", name
            )
        driver.execute_script("show(arguments[0])", act.frame)
        wait.until(lambda one, at=act.frame: one.execute_script(f"return page.shown === {at}"))
        keys = "y"
        if act.kind != "yes":
            keys = "r" if fresh and len(names) > 1 else str(list(names).index(act.robot) + 1)
        marks = driver.execute_script("return page.state.marks")
        ActionChains(driver).send_keys(keys).perform()
        if act.kind != "yes":
            _point(driver, act)
        wait.until(
            lambda one, had=marks: one.execute_script(
                f"return (page.state.marks > {had} || !at('banner').hidden)"
                " && !at('status').textContent"
            )
        )
        refused = driver.execute_script(
            "return at('banner').hidden ? '' : at('banner').textContent"
        )
        if refused:
            raise SystemExit(f"the page refused {act}: {refused}")
        done.append(act)
    return done


def _point(driver: Any, act: Act) -> None:
    """Click the middle of the robot, or draw its box."""
    from selenium.webdriver.common.action_chains import ActionChains

    half = np.zeros(2) if act.kind == "click" else act.box[2:] / 2.0
    canvas, actions = driver.find_element("id", "picture"), ActionChains(driver)
    first, last = (
        driver.execute_script(
            "const now = view(), box = picture.getBoundingClientRect();"
            "return [now.x + arguments[0] * now.scale - box.width / 2,"
            " now.y + arguments[1] * now.scale - box.height / 2];",
            *corner.tolist(),
        )
        for corner in (act.box[:2] - half, act.box[:2] + half)
    )
    actions.move_to_element_with_offset(canvas, *first).click_and_hold()
    actions.move_to_element_with_offset(canvas, *last).release().perform()


def _person(arguments: list[str], acts: list[Act], frames: int) -> float:
    """Return an estimate of a person's time, s."""
    of = PERSON_S
    command = of["decided"] + of["typed"] * len("aerial-gnss " + " ".join(arguments) + "\n")
    page = of["decided"] + of["moved hands"] + of["pointed"] + of["clicked"]  # opens the address
    each = 2.0 * of["decided"] + of["typed"] + 2.0 * of["moved hands"] + of["pointed"]
    end = of["decided"] + 2.0 * of["typed"]  # Ctrl-C
    looked = of["decided"] + of["watched"] * frames
    drawn = each + of["pointed"] + of["clicked"]
    answered = of["decided"] + 2.0 * of["typed"]  # N and Y
    spent = {"click": each + of["clicked"], "box": drawn, "yes": answered}
    return command + page + sum(spent[act.kind] for act in acts) + looked + end


def _replay(log: Log, folder: Path) -> None:
    result, bag = folder / "result", folder / "found"
    if not result.is_dir():
        clock = Clock()
        _run("replay", bag, "-o", result, "--params", folder / "mine/detector.yaml")
        log.keep("replay", clock.read())
    if not (folder / "evaluation").is_dir():
        _run("evaluate", result, "--truth", bag, "-o", folder / "evaluation")
    with open_bag([bag]) as opened:
        truth = read_truth(opened)
    log.keep("positions", _positions(read_positions(result / "positions.csv"), truth))


def _positions(found: dict[str, EstimatedTrack], truth: Truth) -> dict[str, float]:
    """Return errors, the share of images with a position, and names that are on no robot."""
    errors = compare(found, truth.robots, truth.drone)
    named = {one.robot_id for one in errors}
    common = np.concatenate([one.east_north for one in errors]).mean(axis=0)
    false = sum(
        _farthest(track, truth, common) > FALSE_M for name, track in found.items()
        if name not in named
    )  # fmt: skip
    seen = sum(len(truth.in_view[one.truth_id]) for one in errors)
    have = sum(int(np.isin(truth.in_view[one.truth_id], one.stamps_ns).sum()) for one in errors)
    figures = summarise(errors).figures()
    return {
        "rms_m": float(figures["rmse"]),
        "share": have / max(seen, 1),
        "nees": float(figures["nees"]),
        "names": len(found),
        "false": int(false),
    }


def _farthest(track: EstimatedTrack, truth: Truth, common: NDArray[np.float64]) -> float:
    """Return the median distance of a name from the nearest robot, m, without the common error."""
    away = []
    for robot in truth.robots.values():
        latitude, longitude, _ = at_stamps(robot, track.stamps_ns)
        east_north = [
            enu_from_geodetic(*place, 0.0, *true, 0.0)[:2] - common
            for place, true in zip(
                zip(track.latitude, track.longitude, strict=True),
                zip(latitude, longitude, strict=True), strict=True,
            )
        ]  # fmt: skip
        away.append(np.linalg.norm(east_north, axis=1))
    return float(np.median(np.min(away, axis=0)))


def _score(log: Log, folder: Path) -> None:
    """Count the boxes of the taught detector on the flight that it did not see."""
    from aerial_gnss_ros.commands.configuration import values_of
    from aerial_gnss_ros.nodes.schemas import DETECTOR

    detector = load_detector(detector_config(values_of([folder / "mine/detector.yaml"])[DETECTOR]))
    counts = Score()
    for image in list(read_bag(folder / "found"))[::4]:
        found = detector.detect(image.read())
        counts.add(found, image.truth)
    overall = counts.overall
    log.keep("boxes", [overall.robots, overall.found, overall.false])


def _row(model: str, of: dict[str, Any]) -> list[str]:
    robots, found, false = of["boxes"]
    where = of["positions"]

    def took(name: str) -> str:
        wall, used = of[name]
        return f"{wall:.0f} ({used:.0f})" if used else f"{wall:.0f}"

    return [
        model, *map(str, of["marks"]), f"{of['person']:.0f}", took("labelled"), took("training"),
        took("replay"), f"{found / max(found + false, 1):.3f}", f"{found / max(robots, 1):.3f}",
        f"{100.0 * where['share']:.0f} %", f"{where['rms_m']:.2f}", str(where["false"]),
    ]  # fmt: skip


if __name__ == "__main__":
    main()
