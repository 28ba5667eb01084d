# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The camera's motion as telemetry tells it: smooth in time, each input at its own samples.

A latency is found by comparing boxes with poses at other times. What telemetry's own errors do from
sample to sample (white noise, drifts) looks like motion, and a fit takes it for information on the
latency: it would be biased, and surer than it is. So only that part of the motion is used which
exceeds the errors that the noise set states, as a Wiener filter does. Differences of the second
order over a time h have a variance of 2 q h + 6 w² if they are errors that drift by q a second and
are white with w; a cubic smoothing spline lets through what is slower than the shortest h over
which they are clearly larger than that at the time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline, make_smoothing_spline
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.core.config.noise import Noise
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.gimbal import Reference
from aerial_gnss_ros.core.georeferencing.covariance import white_rotation
from aerial_gnss_ros.core.models.measurement_model import MapPose
from aerial_gnss_ros.core.values.rejection import Input

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

ERRORS = ("gnss_east", "gnss_north", "height", "gimbal_roll", "gimbal_pitch", "heading")
"""What is added to the measured pose to have the true one: m, m, m, rad, rad, rad."""
MOST_SAMPLES = 4000
LEAST_SAMPLES = 6
CLEARLY, WINDOW = 4.0, 12
HALVED, AROUND = 0.5, 5
"""Interpolating every other sample errs by so much more than interpolating all, as a share; how
large that is at a time is judged by so many samples round it."""
"""Bends are motion where their mean square over so many lags is so many times that of errors."""
REFERENCE_S = 1.0
"""Turns slower than this are left out before a camera's roll, pitch and heading are smoothed."""


@dataclass(frozen=True)
class Poses:
    """Camera poses in `map` at n times.

    Attributes:
        position: (n, 3) East, North, Up, m.
        rotation: (n, 3, 3) camera FLU in `map`.
        velocity: (n, 3) m/s.
        turning: (n, 3) about East, North, Up, rad/s.
        known: (n,) False where telemetry lacks; the values there mean nothing.
    """

    position: Array
    rotation: Array
    velocity: Array
    turning: Array
    known: NDArray[np.bool_]


class Smooth:
    """A smooth function of time through noisy samples; none within gaps.

    Args:
        t: (n,) times, s, increasing.
        values: (n, k).
        max_gap_s: samples farther apart are not joined.
        smoothed: makes a spline of a piece.
    """

    def __init__(
        self, t: Array, values: Array, max_gap_s: float, smoothed: Callable[[Array, Array], BSpline]
    ) -> None:
        ends = np.flatnonzero(np.diff(t) > max_gap_s) + 1
        self._pieces: list[tuple[float, float, BSpline, BSpline]] = []
        for one, piece in zip(np.split(t, ends), np.split(values, ends), strict=True):
            if len(one) >= LEAST_SAMPLES:
                spline = smoothed(one, piece)
                self._pieces.append((float(one[0]), float(one[-1]), spline, spline.derivative()))
        self._width = values.shape[1]

    def at(self, t: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return values (n, k), their rates a second, and where they are known (n,)."""
        values, rates = np.zeros((2, len(t), self._width))
        known = np.zeros(len(t), dtype=np.bool_)
        for first, last, spline, rate in self._pieces:
            inside = (t >= first) & (t <= last)
            values[inside], rates[inside] = spline(t[inside]), rate(t[inside])
            known |= inside
        return values, rates, known


class Motion:
    """A recording's poses at any time, the delay of fixes being asked for separately.

    Args:
        recording: after the replay.

    Attributes:
        start_ns: time 0 of the splines.
        sample_s: median time between two samples of the slowest input.
        calm_s: by the names of ERRORS, the shortest time over which motion is told from errors.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        config, stamps = recording.config, recording.stamps
        known = [t for values in stamps.values() for t in (values[:1] + values[-1:])]
        self.start_ns = min(known, default=0)
        turning = _most(stamps, Input.GIMBAL, Input.ATTITUDE)
        level, rising = stamps[Input.FIX], stamps[Input.HEIGHT] or stamps[Input.FIX]
        anything = turning or level or rising or self._mast()
        errors = _Errors(config.noise, config.gimbal.reference)
        gap = config.fix.max_gap
        self._level = self._smooth(
            level or anything, gap, lambda p: p.position[:2], True, errors.level
        )
        height_gap = config.height.max_gap if stamps[Input.HEIGHT] else gap
        self._height = self._smooth(
            rising or anything, height_gap, lambda p: p.position[2:], True, errors.height
        )
        turn_gap = config.gimbal.max_gap if stamps[Input.GIMBAL] else config.attitude.max_gap
        self._turn = self._smooth(
            turning or anything, turn_gap, lambda p: quaternion_from_matrix(p.rotation), False,
            errors.turn,
        )  # fmt: skip
        self._lever = self._levers(turning or anything, turn_gap, errors)
        level_s, turn_s = max(errors.calm["level"]), errors.calm["turn"]
        calm = (level_s, level_s, max(errors.calm["height"]), *turn_s)
        self.calm_s = dict(zip(ERRORS, calm, strict=True))
        self._interpolation = errors.interpolation
        spacing = [float(np.median(np.diff(s))) for s in (turning, level) if len(s) > 1]
        self.sample_s = max(spacing, default=1e9) * 1e-9

    def at(self, stamps_ns: Stamps, latency_s: float, extra_s: float) -> Poses:
        """Return poses (n,) of the scenes of images.

        Args:
            stamps_ns: of the images.
            latency_s: the scene was so much earlier.
            extra_s: fixes and heights were stamped so much later than they held.
        """
        t: Array = np.asarray((stamps_ns - self.start_ns) * 1e-9 - latency_s, dtype=np.float64)
        level, level_rate, known = self._level.at(t + extra_s)
        height, height_rate, high = self._height.at(t + extra_s)
        quaternion, rate, turned = self._turn.at(t)
        length = np.linalg.norm(quaternion, axis=1)
        known &= high & turned & (length > 0.5)
        quaternion[~known] = 0.0, 0.0, 0.0, 1.0
        length[~known] = 1.0
        quaternion, rate = quaternion / length[:, None], rate / length[:, None]
        position, velocity = np.hstack([level, height]), np.hstack([level_rate, height_rate])
        if self._lever is not None:
            lever, lever_rate, _ = self._lever.at(t)
            position, velocity = position + lever, velocity + lever_rate
        rotation = matrix_from_quaternion(quaternion)
        return Poses(position, rotation, velocity, _turning(quaternion, rate), known)

    def interpolation(self, stamps_ns: Stamps, latency_s: float, ranges_m: Array) -> Array:
        """Return one sigma (n, 3) of what interpolated poses err by, rad about the error axes.

        Args:
            stamps_ns: (n,) of the images.
            latency_s: the scene was so much earlier.
            ranges_m: (n,) distances, by which an error of the place is one of direction.
        """
        t: Array = np.asarray((stamps_ns - self.start_ns) * 1e-9 - latency_s, dtype=np.float64)
        turned = self._interpolation["turn"](t)
        moved = self._interpolation["level"](t).mean(axis=1, keepdims=True)
        return np.asarray(np.sqrt(turned + moved / np.square(ranges_m)[:, None]))

    def _mast(self) -> list[int]:
        """Return times for a camera of which everything is constant."""
        frames = sorted(self._recording.frames)
        if not frames:
            return []
        return list(range(frames[0] - 4_000_000_000, frames[-1] + 4_000_000_000, 500_000_000))

    def _smooth(
        self,
        stamps: list[int],
        gap_s: float,
        value: Callable[[MapPose], Array],
        antenna: bool,
        smoothed: Callable[[Array, Array], BSpline],
    ) -> Smooth:
        times, values = [], []
        for stamp in _thinned(stamps):
            pose = self._recording.pose(stamp, antenna)
            if pose is not None:
                times.append((stamp - self.start_ns) * 1e-9)
                values.append(value(pose))
        table = np.array(values) if values else np.zeros((0, 4))
        spread = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
        return Smooth(np.array(times), table, max(gap_s, 1.5 * spread), smoothed)

    def _levers(self, stamps: list[int], gap_s: float, errors: _Errors) -> Smooth | None:
        if not any(self._recording.config.camera.offset_m):
            return None
        times, values = [], []
        for stamp in _thinned(stamps):
            camera, antenna = self._recording.pose(stamp), self._recording.pose(stamp, True)
            if camera is not None and antenna is not None:
                times.append((stamp - self.start_ns) * 1e-9)
                values.append(camera.position - antenna.position)
        table = np.array(values).reshape(-1, 3)
        return Smooth(np.array(times), table, gap_s, errors.lever)


class _Errors:
    """Splines through samples whose errors are as the noise set says."""

    def __init__(self, noise: Noise, reference: str) -> None:
        time_s = max(noise.value("correlation_time_s"), 1e-3)

        def drift(key: str) -> float:
            scale = math.radians(1.0) if key.endswith("_deg") else 1.0
            return 2.0 * (noise.value(key) * scale) ** 2 / time_s

        white = np.sqrt(white_rotation(noise, Reference(reference)))
        angles = drift("gimbal_roll_deg"), drift("gimbal_pitch_deg"), drift("heading_deg")
        self._angles = list(zip(angles, white, strict=True))
        self.calm: dict[str, list[float]] = {}
        self.interpolation: dict[str, Callable[[Array], Array]] = {}
        self._level = drift("gnss_offset_m"), noise.value("gnss_white_m")
        self._height = drift("height_m"), noise.value("height_white_m")

    def level(self, t: Array, values: Array) -> BSpline:
        """Return East and North."""
        left = left_out(t, values)
        self.interpolation["level"] = interpolation(t, values - left, [self._level[1]] * 2)
        return self._smoothed("level", t, values, [self._level] * 2)

    def height(self, t: Array, values: Array) -> BSpline:
        """Return Up."""
        return self._smoothed("height", t, values, [self._height])

    def lever(self, t: Array, values: Array) -> BSpline:
        """Return the camera's place relative to the antenna: as calm as its angles."""
        return self._smoothed("lever", t, values, [(1e-6, 1e-3)] * 3)

    def turn(self, t: Array, values: Array) -> BSpline:
        """Return quaternions, not of unit length: each angle is as calm as its own error says.

        Angles are told from a slow turn, for roll, pitch and heading have no meaning over a whole
        flight where the camera looks down.
        """
        flips = np.sum(values[1:] * values[:-1], axis=1) < 0.0
        values = values.copy()
        values[1:] *= np.where(np.cumsum(flips) % 2 == 1, -1.0, 1.0)[:, None]
        left = left_out(t, values)
        base = Rotation.from_quat(left)
        off = np.einsum(
            "nji,nj->ni",
            error_axes_of(base.as_matrix()),
            (Rotation.from_quat(values) * base.inv()).as_rotvec(),
        )
        white = [one[1] for one in self._angles]
        self.interpolation["turn"] = interpolation(t, off, white)
        slow = _penalised(t, values, np.full(4, _penalty(t, REFERENCE_S)))
        reference = slow(t)
        base = Rotation.from_quat(reference)
        axes = error_axes_of(base.as_matrix())
        turned = (Rotation.from_quat(values) * base.inv()).as_rotvec()
        angles = np.einsum("nji,nj->ni", axes, turned)
        found = self._smoothed("turn", t, angles, self._angles)(t)
        whole = (Rotation.from_rotvec(np.einsum("nij,nj->ni", axes, found)) * base).as_quat()
        signs = np.where(np.sum(whole * values, axis=1) < 0.0, -1.0, 1.0)
        return make_interp_spline(t, whole * signs[:, None], k=3)

    def _smoothed(
        self, name: str, t: Array, values: Array, errors: list[tuple[float, float]]
    ) -> BSpline:
        found, calm = adapted(t, values, errors)
        before = self.calm.get(name, calm)
        self.calm[name] = [max(pair) for pair in zip(before, calm, strict=True)]
        return found


def left_out(t: Array, values: Array) -> Array:
    """Return values (n, k) as interpolated from every other sample, those being left out."""
    found = values.copy()
    for left in (0, 1):
        kept = np.arange(len(t)) % 2 != left
        spline = make_interp_spline(t[kept], values[kept], k=min(3, int(kept.sum()) - 1))
        found[~kept] = spline(t[~kept])
    return found


def interpolation(t: Array, errors: Array, white: list[float]) -> Callable[[Array], Array]:
    """Return the variance (n, k) that interpolation errs by, as a function of time.

    Args:
        t: (n,) times of the samples, s.
        errors: (n, k) of interpolating each from every other one.
        white: (k,) one sigma of the samples' white noise.
    """
    # Weights of -1/16, 9/16, 9/16, -1/16 pass on 0.64 of the white variance.
    noise = 1.64 * np.square(white)
    squares = uniform_filter1d(errors**2, AROUND, axis=0, mode="nearest")
    variance = HALVED**2 * np.maximum(squares - noise, 0.0)
    return lambda at: np.stack([np.interp(at, t, one) for one in variance.T], axis=1)


def adapted(
    t: Array, values: Array, errors: list[tuple[float, float]]
) -> tuple[BSpline, list[float]]:
    """Return what of values (n, k) is motion, and over how long bends mostly have to be for that.

    A flight is calm at times: how much is smoothed is judged at each time by the bends round it.

    Args:
        t: (n,) times, s.
        values: (n, k).
        errors: of each column: variance that a drift grows by a second, one sigma of white noise.
    """
    spread = float(np.median(np.diff(t)))
    grid = np.arange(t[0], t[-1] + 0.5 * spread, spread)
    lags = 2 ** np.arange(max(1, int(math.log2(max(len(grid) // 8, 1))) + 1), dtype=np.int64)
    columns, calm = [], []
    for column, error in zip(values.T, errors, strict=True):
        shares = np.array(
            [np.interp(t, grid, one) for one in _levels(grid, t, column, error, lags)]
        )
        smooth = [
            make_smoothing_spline(t, column, lam=_penalty(t, float(lag) * spread))(t)
            if share.max() > 1e-3
            else column
            for lag, share in zip(lags, shares, strict=True)
        ]
        columns.append(np.sum(shares * np.array(smooth), axis=0))
        calm.append(float(2.0 ** np.median(np.log2(lags) @ shares)) * spread)
    return make_interp_spline(t, np.stack(columns, axis=1), k=3), calm


def _levels(
    grid: Array, t: Array, column: Array, error: tuple[float, float], lags: NDArray[np.int64]
) -> Array:
    """Return how much each lag's smoothing counts at each time of an even grid, (lags, n).

    It is that of the shortest lag whose bends are clearly larger than errors there.
    """
    even, spread = np.interp(grid, t, column), float(grid[1] - grid[0])
    level = np.full(len(grid), len(lags) - 1)
    for number in reversed(range(len(lags))):
        lag = int(lags[number])
        bend = np.zeros(len(grid))
        if 2 * lag < len(grid):
            bend[lag:-lag] = even[2 * lag :] - 2.0 * even[lag:-lag] + even[: -2 * lag]
            bend[:lag], bend[-lag:] = bend[lag], bend[-lag - 1]
        noise = 2.0 * error[0] * lag * spread + 6.0 * error[1] ** 2
        around = uniform_filter1d(bend**2, WINDOW * lag, mode="nearest")
        level[around > CLEARLY * noise] = number
    chosen = (level == np.arange(len(lags))[:, None]).astype(np.float64)
    widths = np.maximum(2 * lags[level], 1)
    blur = int(np.median(widths))
    blurred: Array = uniform_filter1d(chosen, blur, axis=1, mode="nearest")
    return blurred


def _penalty(t: Array, shortest_s: float) -> float:
    """Return the penalty on squared curvature at which bends over such a time are half let through.

    A smoothing spline lets 1 / (1 + p (2 pi f)^4 dt) of a frequency f through, and a bend over a
    time h is one of f = 1 / 2h.
    """
    return (shortest_s / math.pi) ** 4 / float(np.median(np.diff(t)))


def _penalised(t: Array, values: Array, penalties: Array) -> BSpline:
    columns = [
        make_smoothing_spline(t, column, lam=float(one))
        for column, one in zip(values.T, penalties, strict=True)
    ]
    return BSpline(columns[0].t, np.stack([one.c for one in columns], axis=1), 3)


def _most(stamps: dict[Input, list[int]], *sources: Input) -> list[int]:
    return max((stamps[source] for source in sources), key=len)


def _thinned(stamps: list[int]) -> list[int]:
    unique = sorted(set(stamps))
    return unique[:: 1 + len(unique) // MOST_SAMPLES]


def _turning(quaternion: Array, rate: Array) -> Array:
    """Return (n, 3) rad/s in the world of quaternions x, y, z, w and their rates.

    The rate's part along the quaternion, which only changes its length, drops out.
    """
    vector, scalar = quaternion[:, :3], quaternion[:, 3:]
    found: Array = 2.0 * (
        scalar * rate[:, :3] - rate[:, 3:] * vector - np.cross(rate[:, :3], vector)
    )
    return found


def error_axes_of(rotations: Array) -> Array:
    """Return the axes of `gimbal.error_axes` of many cameras, (n, 3, 3)."""
    east, north = rotations[:, 0, 1], rotations[:, 1, 1]
    rolled = np.hypot(east, north) < 1e-6
    east = np.where(rolled, -rotations[:, 1, 0], east)
    north = np.where(rolled, rotations[:, 0, 0], north)
    length = np.hypot(east, north)
    east, north = east / length, north / length
    axes = np.zeros((len(rotations), 3, 3))
    axes[:, 0, 0], axes[:, 0, 1] = north, east
    axes[:, 1, 0], axes[:, 1, 1] = -east, north
    axes[:, 2, 2] = 1.0
    return axes
