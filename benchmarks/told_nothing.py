# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What is lost where nobody states anything? All kinds of flights, always default parameters.

python benchmarks/told_nothing.py --flown told_nothing.jsonl --cells 200 --flights 20 \
    --markdown docs/results/told_nothing.md --picture docs/images/told_nothing.png

Stated is only that the latency is to be found (`camera.find_latency`). Cells are a Latin hypercube
over `FACTORS`: each level of each factor is in as many cells as the others. Flights of 60 s over
three robots (and a reference), all simulated; in `dji` a recorded DJI log is the drone's true
motion, and the height is as it flew. Every error but the receiver's is `noise` times the default
set; the receiver states its covariance. RMS of the horizontal error of robots in view, each second
from 10 s on, over a cell's flights. `bound`: Cramér-Rao bound that knows noise and motion and has
the latency as a state (of sigma `noise.latency_s`, or 1 s where the filter takes another one for
exact); `latency known`: over the bound that knows it, too. `wrong`: names that end nearer to
another robot than to their own. A flight is kept as a line of JSON; the program goes on where the
file ends.

What each lacking knowledge costs: `--also latency moored noise` states it, in a file of its own.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path

import one_thread  # noqa: F401 - before numpy

# isort: split
import numpy as np
from families import RTK_OFFSET_M, Image, RandomSwimmers, results, robots_of, truth
from motion_found import Swimmers
from numpy.typing import NDArray
from tables import columns, show

from aerial_gnss_ros.adapters.dji_log import read_dji_log
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.config.noise import SETS
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, State
from aerial_gnss_ros.evaluation.bound import TrueFrame, bound
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.chance import generator
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.recorded import RecordedFlight, water_seconds
from aerial_gnss_ros.simulation.robots import SwimPlan
from aerial_gnss_ros.simulation.sensors import sensor_plan

Array = NDArray[np.float64]
Record = dict[str, object]

DURATION_S, FROM_S, LAST_S = 60.0, 10.0, 5.0
CONSTANT_S = 1e6
"""Correlation time of errors that do not change in a flight, s."""
REFERENCE_M = 0.05
SPEED_SIGMA_MPS = {"still": 0.005, "drifting": 0.3, "swimming": 0.5, "mixed": 0.5}
"""What the bound is told of velocities, one sigma of each axis, m/s."""
UNKNOWN_LATENCY_S, NOWHERE_M = 1.0, 1e4
FACTORS: dict[str, tuple[object, ...]] = {
    "motion": ("hover", "orbit", "transit", "dji"),
    "height_m": (10.0, 30.0, 80.0),
    "receiver": ("rtk", "consumer", "reference"),
    "robots": ("still", "drifting", "swimming", "mixed"),
    "noise": (0.3, 1.0, 3.0),
    "correlation_s": (30.0, 300.0, CONSTANT_S),
    "latency_s": (0.0, 0.3, -1.5),
    "rate_hz": (1.0, 5.0, 15.0),
}
ALSO = ("latency", "moored", "noise")
"""What may be stated besides: the true latency, `find_moored`, all true sigmas."""
KINDS = {"still": "all stay", "drifting": "all drift", "mixed": "two stay, one swims"}
HEADS = [
    "cells", "number", "RMS / bound, median", "95 %", "latency known, median", "published / RMS",
    "NEES/2, median", "5 %", "95 %", "positions", "extra names", "wrong",
]  # fmt: skip


@dataclass(frozen=True)
class Cell:
    """One kind of flight: a level of each of `FACTORS`."""

    motion: str
    height_m: float
    receiver: str
    robots: str
    noise: float
    correlation_s: float
    latency_s: float
    rate_hz: float

    @property
    def words(self) -> str:
        """Return it in words."""
        return " ".join(f"{value:g}" if isinstance(value, float) else value
                        for value in asdict(self).values())  # fmt: skip


def hypercube(count: int, seed: int = 18) -> list[Cell]:
    """Return a Latin hypercube: each factor goes through its levels in an order of its own."""
    rng = np.random.default_rng(seed)
    levels = {
        name: [values[i % len(values)] for i in rng.permutation(count)]
        for name, values in FACTORS.items()
    }
    return [Cell(**{name: values[i] for name, values in levels.items()}) for i in range(count)]  # type: ignore[arg-type]


class Reference:
    """The first robot, which stays, and the others: stands in for `Swarm`."""

    def __init__(self, others: RandomSwimmers, place: Array) -> None:
        self.names = ("beacon_1", *others.names)
        self.class_names = ("beacon", *others.class_names)
        self.models = (others.models[0], *others.models)
        self._others, self._place = others, np.array([*place, 0.0])

    def positions(self, t: Array) -> Array:
        """Return East, North, up (n, m, 3) at times (m,), m."""
        moving = self._others.positions(t)
        staying = np.broadcast_to(self._place, (1, moving.shape[1], 3))
        return np.concatenate([staying, moving])

    def courses(self, t: Array) -> Array:
        """Return yaws (n, m); they do not matter to boxes' centres."""
        return np.zeros((len(self.names), len(np.atleast_1d(np.asarray(t)))))


class World:
    """A flight of a cell; equal arguments give equal flights."""

    def __init__(self, cell: Cell, seed: int, log: Path) -> None:
        self.cell, self.seed = cell, seed
        scaled = {
            name: cell.noise * value
            for name, value in SETS["consumer"].items()
            if name not in ("gnss_offset_m", "correlation_time_s", "robot_acceleration")
        }
        offset = RTK_OFFSET_M if cell.receiver == "rtk" else SETS["consumer"]["gnss_offset_m"]
        self.sigmas = scaled | {"gnss_offset_m": offset, "correlation_time_s": cell.correlation_s}
        sensors = sensor_plan("consumer", **self.sigmas)
        self.has_reference = cell.receiver == "reference"
        flight = (
            GeneratedFlight(FlightPlan(kind=cell.motion, duration_s=DURATION_S,
                                       height_m=cell.height_m, speed_mps=5.0), seed)
            if cell.motion != "dji" else recorded(log, seed)
        )  # fmt: skip
        self.made = made = Experiment(
            flight, default_camera(1280, 720), with_covariance(sensors),
            CameraClock(rate_hz=cell.rate_hz, latency_s=cell.latency_s),
            robots=4 if self.has_reference else 3, seed=seed,
            swim=SwimPlan(0.0, 0.0, roam_m=1e3, apart_m=1.5),
            detector=DetectorPlan(center_px=self.sigmas["box_center_px"]),
        )  # fmt: skip
        self.datum = MapDatum(flight.origin.latitude, flight.origin.longitude, 0.0)
        places = np.asarray(made.places)
        others = places[1:] if self.has_reference else places
        if cell.robots == "swimming":
            swimmers = RandomSwimmers(others, True, seed, DURATION_S)
        elif cell.robots == "mixed":
            swimmers = RandomSwimmers(others, True, seed, DURATION_S, beacons=2)
            swimmers.class_names = ("aqua",) * 3
        else:
            swimmers = Swimmers(KINDS[cell.robots], others, seed, DURATION_S)
        made.swarm = Reference(swimmers, places[0]) if self.has_reference else swimmers  # type: ignore[assignment]

    def stated(self, also: Sequence[str] = ()) -> dict[str, object]:
        """Return what is stated: where `map` is, what a reference is, and `find_latency`.

        Args:
            also: of `ALSO`.
        """
        origin = self.datum
        found: dict[str, object] = {
            "map.latitude_deg": math.degrees(origin.latitude),
            "map.longitude_deg": math.degrees(origin.longitude),
            "camera.find_latency": True,
        }
        if self.has_reference:
            place = self.made.swarm.positions(np.zeros(1))[0, :, :2]
            off = REFERENCE_M * generator(self.seed, "survey").standard_normal(2)
            latitude, longitude = LocalMap(origin).places(place + off)
            at = [math.degrees(latitude[0]), math.degrees(longitude[0])]
            found |= {"references.pier.class": "beacon", "references.pier.position": at,
                      "references.pier.sigma_m": REFERENCE_M}  # fmt: skip
        if "latency" in also:
            del found["camera.find_latency"]
            found["camera.latency_s"] = self.cell.latency_s
        if "moored" in also:
            found["tracks.find_moored"] = True
        if "noise" in also:
            found |= {f"noise.{name}": value for name, value in self.sigmas.items()}
        return found

    def bounds(self, true: list[TrueFrame], latency_s: float) -> Array:
        """Return the bounds (images, n, 4, 4) with a sigma of the latency; 0: it is known."""
        speed = SPEED_SIGMA_MPS[self.cell.robots]
        swims = self.cell.robots in ("swimming", "mixed")
        values = {f"noise.{name}": value for name, value in self.sigmas.items()}
        values |= {"noise.latency_s": latency_s, "tracks.max_speed": 2.0 * speed}
        values |= {"noise.robot_acceleration": 0.05 if swims else 0.0}
        first = int(self.has_reference)
        known = {0: REFERENCE_M} if self.has_reference else {}
        if self.cell.robots == "mixed":  # those that stay, nobody knows where
            known |= {first: NOWHERE_M, first + 1: NOWHERE_M}
        return bound(estimator_config(values), self.made.camera, true, LocalMap(self.datum), known)


def with_covariance(plan: object) -> object:
    """Return sensors whose receiver states its covariance."""
    return replace(plan, covariance=True)  # type: ignore[type-var]


@cache
def _log(path: Path) -> object:
    return read_dji_log(path)


def recorded(path: Path, seed: int) -> RecordedFlight:
    """Return a piece of a log, chosen by the seed, in which the camera sees water."""
    log = _log(path)
    starts = water_seconds(log, DURATION_S)  # type: ignore[arg-type]
    start = float(generator(seed, "piece").choice(starts))
    return RecordedFlight(log, start, DURATION_S)  # type: ignore[arg-type]


def fly(cell: Cell, seed: int, log: Path, also: Sequence[str] = ()) -> Record:
    """Return the figures of one flight: sums of squares, m², and counts."""
    world = World(cell, seed, log)
    images: list[Image] = list(world.made.detections())
    config = estimator_config(world.stated(also))
    true = truth(world.made, images)
    found = results(world.made, config, images)
    prior = config.noise.value("latency_s") or (UNKNOWN_LATENCY_S if cell.latency_s else 0.0)
    known = world.bounds(true, 0.0)
    limits = world.bounds(true, prior) if prior else known
    return score(world, images, true, found, limits, known)


def score(
    world: World, images: list[Image], true: list[TrueFrame], found: list[FrameResult],
    limits: Array, known: Array,
) -> Record:  # fmt: skip
    """Return the sums over the positions that are judged."""
    # In its first seconds a name may be nearest to another robot: a latency is not found yet. Where
    # it coasts it may drift past any.
    shown = [
        replace(one, estimates=tuple(e for e in one.estimates if e.state is State.CONFIRMED))
        for one in found
    ]
    names = robots_of(shown, true, {"beacon": 0} if world.has_reference else {}, math.inf)
    first = int(world.has_reference)
    sums = dict.fromkeys(("squares", "bound", "known", "published", "nees"), 0.0)
    samples = wanted = 0
    nearer: dict[str, list[bool]] = {}
    start = images[0][0].stamp_ns
    for k, (result, (frame, _, _)) in enumerate(zip(shown, images, strict=True)):
        t = (frame.stamp_ns - start) * 1e-9
        judged = t >= FROM_S and abs(t - round(t)) < 1e-6
        wanted += int(true[k].seen[first:].sum()) if judged else 0
        for one in result.estimates:
            robot = names[one.robot_id]
            if not true[k].seen[robot] or robot < first:
                continue
            error = one.position - true[k].positions[robot]
            if t > DURATION_S - LAST_S:
                apart = np.linalg.norm(true[k].positions - one.position, axis=1)
                nearer.setdefault(one.robot_id, []).append(int(np.argmin(apart)) != robot)
            if judged:
                covariance = one.covariance[:2, :2]
                samples += 1
                sums["squares"] += float(error @ error)
                sums["nees"] += float(error @ np.linalg.solve(covariance, error))
                sums["published"] += float(np.trace(covariance))
                sums["bound"] += float(np.trace(limits[k, robot, :2, :2]))
                sums["known"] += float(np.trace(known[k, robot, :2, :2]))
    seen = int(np.any([frame.seen for frame in true], axis=0).sum())
    return {
        "cell": world.cell.words, "seed": world.seed, **sums, "samples": samples, "wanted": wanted,
        "extra_names": len(names) - seen,
        "wrong": sum(float(np.mean(one)) > 0.5 for one in nearer.values()),
    }  # fmt: skip


@dataclass(frozen=True)
class Figures:
    """A cell's figures over its flights."""

    cell: Cell
    ratio: float
    known: float
    published: float
    nees: float
    positions: float
    extra_names: int
    wrong: int


def figures(cell: Cell, flights: list[Record]) -> Figures:
    """Return the figures of a cell; ratios are NaN without any position."""
    total = {key: sum(float(one[key]) for one in flights)  # type: ignore[arg-type]
             for key in flights[0] if key not in ("cell", "seed")}  # fmt: skip
    n = total["samples"] or math.nan
    return Figures(
        cell, math.sqrt(total["squares"] / total["bound"]) if total["samples"] else math.nan,
        math.sqrt(total["squares"] / total["known"]) if total["samples"] else math.nan,
        math.sqrt(total["published"] / total["squares"]) if total["samples"] else math.nan,
        total["nees"] / n / 2.0, total["samples"] / max(total["wanted"], 1.0),
        int(total["extra_names"]), int(total["wrong"]),
    )  # fmt: skip


def row(words: str, cells: list[Figures]) -> list[str]:
    """Return one line of the table: some cells together."""

    def at(name: str, percent: float) -> str:
        values = np.array([getattr(one, name) for one in cells])
        values = values[np.isfinite(values)]
        return f"{np.percentile(values, percent):.2f}" if len(values) else "–"

    return [
        words, str(len(cells)), at("ratio", 50), at("ratio", 95), at("known", 50),
        at("published", 50), at("nees", 50), at("nees", 5), at("nees", 95),
        f"{100.0 * np.mean([one.positions for one in cells]):.0f} %",
        str(sum(one.extra_names for one in cells)), str(sum(one.wrong for one in cells)),
    ]  # fmt: skip


def groups(cells: list[Figures]) -> list[tuple[str, list[Figures]]]:
    """Return all cells, and those of each level of each factor, in words."""
    found = [("all", cells)]
    for name, values in FACTORS.items():
        for value in values:
            some = [one for one in cells if getattr(one.cell, name) == value]
            words = "constant" if value == CONSTANT_S else f"{value}"
            if some:
                found.append((f"{name.split('_')[0]} {words}", some))
    return found


def picture(cells: list[Figures], path: Path) -> None:
    """Draw the ratio to the bound of each cell over the levels of each factor."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    drawing, axes = plt.subplots(2, 4, figsize=(12, 6), sharey=True)
    for axis, (name, values) in zip(axes.flat, FACTORS.items(), strict=True):
        levels = [[c.ratio for c in cells if getattr(c.cell, name) == value] for value in values]
        for place, ratios in enumerate(levels):
            spread = np.linspace(-0.2, 0.2, max(len(ratios), 1))[: len(ratios)]
            axis.semilogy(place + spread, ratios, "o", color="tab:blue", alpha=0.4, ms=4)
            if ratios:
                middle = np.full(2, np.nanmedian(ratios))
                (bar,) = axis.plot(place + np.array([-0.3, 0.3]), middle, color="black", lw=2)
        aim = axis.axhline(1.2, color="tab:green", lw=1)
        most = axis.axhline(1.6, color="tab:red", lw=1)
        axis.set_xticks(range(len(values)), [_LEVELS.get(value, f"{value}") for value in values])
        axis.set_title(_TITLES[name])
        axis.yaxis.set_major_formatter("{x:g}")
    for axis in axes[:, 0]:
        axis.set_ylabel("RMS / bound of a cell")
    words = ["median", "aim for the median", "aim for 95 % of the cells"]
    drawing.legend([bar, aim, most], words, loc="lower center", ncols=3, frameon=False)
    drawing.tight_layout(rect=(0.0, 0.05, 1.0, 1.0))
    drawing.savefig(path, dpi=80)


_TITLES = {
    "motion": "motion of the drone",
    "height_m": "height, m",
    "receiver": "receiver",
    "robots": "robots",
    "noise": "true noise / default noise",
    "correlation_s": "its correlation time, s",
    "latency_s": "latency of the images, s",
    "rate_hz": "images a second",
}
_LEVELS = {
    CONSTANT_S: "constant",
    "rtk": "RTK",
    "dji": "recorded",
    "drifting": "adrift",
    "reference": "consumer,\nreference",
}


def _done(path: Path) -> dict[tuple[str, int], Record]:
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    return {(one["cell"], one["seed"]): one for one in map(json.loads, lines)}


def main() -> int:
    """Fly what lacks, and print the table."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--flown", type=Path, required=True, help="JSON lines; goes on there")
    parser.add_argument("--cells", type=int, default=200, help="of the hypercube (default 200)")
    parser.add_argument("--flights", type=int, default=20, help="flights a cell (default 20)")
    parser.add_argument("--first", type=int, default=0, help="the first one's seed (default 0)")
    parser.add_argument("--every", type=int, default=1, help="fly every nth cell only (default 1)")
    parser.add_argument("--also", nargs="*", choices=ALSO, default=[], help="stated besides")
    parser.add_argument("--log", type=Path, default=Path("../shared/data/dji_tracking.csv"))
    parser.add_argument("--minutes", type=float, default=math.inf, help="begin no flight later")
    parser.add_argument("--picture", type=Path, help="PNG to write")
    parser.add_argument("--markdown", type=Path, help="where to write the table")
    given = parser.parse_args()
    done, until = _done(given.flown), time.monotonic() + 60.0 * given.minutes
    cells = hypercube(given.cells)[:: given.every]
    seeds = range(given.first, given.first + given.flights)
    for seed in seeds:
        for cell in cells:
            if (cell.words, seed) in done or time.monotonic() > until:
                continue
            record = done[cell.words, seed] = fly(cell, seed, given.log, given.also)
            with given.flown.open("a", encoding="utf-8") as file:
                file.write(json.dumps(record) + "\n")
    flown = {
        cell: [done[cell.words, s] for s in seeds if (cell.words, s) in done] for cell in cells
    }
    found = [figures(cell, flights) for cell, flights in flown.items() if flights]
    if not found:
        print("No flight has been flown yet.", file=sys.stderr)
        return 1
    count = sum(map(len, flown.values()))
    table = columns(HEADS, [row(*group) for group in groups(found)])
    show(f"Cells: {len(found)}, flights: {count}\n\n{table}", given.markdown)
    if given.picture is not None:
        picture(found, given.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
