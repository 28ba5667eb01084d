# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Track confirmation: when a track is a robot, and which label it gets.

A track is confirmed by enough hits, in at least half as many of the images since its first one as
show a robot: a glint seen now and then is none. In clutter more hits are required, until no clutter
track is expected; and where other tracks have soon ended, it must last longer or score higher than
foam and glint (`transients`). Where it is stated how robots score, or how long they are, it must be
like that in the mean (`score_evidence`, `size_evidence`). A track inside the gate of a robot out of
view can inherit that robot's label (`reidentification`), unless an image has shown both.
"""

from __future__ import annotations

from dataclasses import dataclass

from aerial_gnss_ros.core.association.clutter import Clutter
from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.config.processing import DetectionsConfig, TracksConfig
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.encounters import Encounters
from aerial_gnss_ros.core.identity.label_ambiguity import Position, exchange_probabilities
from aerial_gnss_ros.core.identity.labels import ConfirmedTrack, Labels
from aerial_gnss_ros.core.identity.reidentification import Reidentification, duplicate_tracks
from aerial_gnss_ros.core.identity.return_position import VelocityLikelihood
from aerial_gnss_ros.core.identity.returns import ReturnCandidates, Returns
from aerial_gnss_ros.core.numerics.gaussian import gate_threshold
from aerial_gnss_ros.core.tracker.confirmation_rule import ConfirmationRule
from aerial_gnss_ros.core.tracker.misclassified_tracks import misclassified
from aerial_gnss_ros.core.tracker.score_evidence import chance_of_score, scores_as_robots
from aerial_gnss_ros.core.tracker.size_evidence import TUNING as SIZES
from aerial_gnss_ros.core.tracker.size_evidence import chance_of_size, expected_specks
from aerial_gnss_ros.core.tracker.track_table import TrackTable
from aerial_gnss_ros.core.tracker.transients import TUNING as TRANSIENTS
from aerial_gnss_ros.core.tracker.transients import Transients, outlasted
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Cause


@dataclass(frozen=True)
class ConfirmationTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    expected_false_tracks: float = 0.05
    """Greatest expected number of clutter tracks confirmed by an image. Judged."""
    least_seen: float = 0.5
    """Least ratio of the share of images that show a track to the share of robots that they show.
    Judged."""


TUNING = ConfirmationTuning()


class TrackConfirmation:
    """Confirms and labels tracks.

    Args:
        table: the tracks.
        identity: issues labels.
        encounters: keeps ambiguities of labels.
        rules: configured confirmation rule.
        boxes: which boxes are used.
        rates: of missed robots.

    Attributes:
        rule: the rule adapted to the image rate.
        transients: tracks that ended soon.
        least_score: `tracks.confirm_score`; may be changed while running.
    """

    def __init__(
        self,
        table: TrackTable,
        identity: Labels,
        encounters: Encounters,
        rules: TracksConfig,
        boxes: DetectionsConfig,
        rates: Clutter,
    ) -> None:
        self._table = table
        self._identity = identity
        self._encounters = encounters
        self._rates = rates
        self.rule = ConfirmationRule(rules)
        self.least_score = rules.confirm_score
        self.transients = Transients(boxes.min_score)
        self._threshold = gate_threshold(rules.gate_probability)
        motion = table.filter.motion
        self._reidentification = Reidentification(motion, self._threshold, rules.coast_s)
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self._reidentification.reset()
        self.rule.reset()
        self.transients.reset()

    def ready(self, stamp_ns: int, lasting: bool = False) -> list[int]:
        """Return the rows of tracks that can be labelled.

        Args:
            stamp_ns: of the image, ns.
            lasting: whether they must have lasted `tracks.confirm_window_s`.
        """
        tracks, new, ready = self._table.tracks, 0, []
        for row, track in enumerate(tracks):
            lasting = lasting or track.rejected
            if track.state is State.TENTATIVE:
                new += 1
                if not track.rejected and self.rule.enough(track.hits):
                    ready.append(row)
        if not ready:
            return ready
        begun_ns = stamp_ns - (self.rule.window_ns if lasting else 0)
        ready = [row for row in ready if self._is_ready(tracks[row], begun_ns, new)]
        if not ready:
            return ready
        confused = misclassified(self._table, ready, self._threshold, self.rule.window_ns)
        ready = [row for row in ready if row not in confused]
        known = not self.robots_missing(stamp_ns)
        gone = [known * self._vanished(track, stamp_ns, new) for track in tracks]
        every = sum(gone)
        return [row for row in ready if self._outlasts(tracks[row], stamp_ns, every - gone[row])]

    def confirm(
        self,
        ready: list[int],
        stamp_ns: int,
        height: float,
        local: LocalMap,
        attitude_known: bool = True,
    ) -> set[int]:
        """Label tracks; return the rows that they replace.

        Args:
            ready: rows of tracks that can be labelled.
            stamp_ns: of the image, ns.
            height: of the camera above the water, m.
            local: the map.
            attitude_known: whether reacquired robots are evidence that the camera has not turned;
                not if most of them are missing.
        """
        tracks = self._table.tracks
        labels, labelled = {track.robot_id for track in tracks}, ready
        merged = self._merge_duplicates(ready)
        ready = [row for row in ready if row not in merged]
        returns = self._reidentify(ready, stamp_ns, height)
        for row in ready:
            tracks[row].label_pending = row in returns.waiting
        ready = [row for row in ready if row not in returns.waiting]
        unknown = [row for row in ready if row not in returns.robots]
        names = self._identity.assign(
            [self._confirmed_track(tracks[row], row) for row in unknown], local
        )
        for row, name in zip(unknown, names, strict=True):
            tracks[row].robot_id, tracks[row].may_be = name, returns.may_be.get(row, {})
        self._inherit(returns)
        self._record_alternatives(returns)
        for row, old in returns.robots.items():
            self._table.merge(old, row, attitude_known)
        for row in ready:
            tracks[row].state = State.CONFIRMED
        if not attitude_known or self._table.filter.ambiguity.covariance.any():
            for row in labelled:
                tracks[row].unverified = tracks[row].robot_id not in labels
        self._report_ended(returns)
        return {*returns.robots.values(), *returns.ended, *merged}

    def _inherit(self, returns: Returns) -> None:
        """Let tracks inherit the labels of the robots that they are."""
        tracks, log = self._table.tracks, self._table.filter.log
        for row, old in returns.robots.items():
            if tracks[row].robot_id:
                log.add(
                    f"{tracks[row].robot_id} is {tracks[old].robot_id}, and is called so again."
                )
            tracks[row].inherit_label(tracks[old])
        found = {tracks[row].robot_id for row in (*returns.robots, *returns.ended)}
        for track in tracks:  # and no other track is one of these robots
            if found & {*track.may_be}:
                track.may_be = {k: one for k, one in track.may_be.items() if k not in found}

    def _report_ended(self, returns: Returns) -> None:
        """Report labels that end."""
        tracks = self._table.tracks
        for old in sorted(returns.ended):
            likely = {
                p: tracks[new].robot_id for new, p in returns.label_probabilities[old].items()
            }
            p = max(likely)
            self._table.filter.log.add(
                f"{tracks[old].robot_id} surfaced with others and cannot be distinguished from "
                f"them: its label ends. It is {likely[p]} with a probability of {p:.2f}."
            )

    def _record_alternatives(self, returns: Returns) -> None:
        """Record alternative labels for re-identified tracks."""
        tracks = self._table.tracks
        called = {row: track.robot_id for row, track in enumerate(tracks)}
        exchanges = [
            exchange_probabilities(one, other, p) for (one, other), p in returns.other.items()
        ]
        for law in [returns.label_probabilities, *exchanges]:
            self._encounters.update_ambiguity(
                {called[a]: {called[b]: p for b, p in of.items() if p} for a, of in law.items()}
            )
        for row, share in returns.unknown.items():
            old = returns.robots[row]
            mean, covariance = self._table.filter.moments()
            spot = Position(mean[old, :2], covariance[old, :2, :2])
            self._encounters.note_departure(tracks[row].robot_id, spot, share)

    def _merge_duplicates(self, ready: list[int]) -> set[int]:
        """Merge duplicate tracks without labels; return the rows merged into others."""
        if len(ready) < 2:
            return set()
        tracks, between = self._table.tracks, self._table.separations(ready, ready)
        pairs = duplicate_tracks(tracks, ready, between, self._threshold)
        for new, old in pairs.items():
            self._table.merge(old, new)
            tracks[new].absorb(tracks[old])
        return set(pairs.values())

    def _is_ready(self, track: Track, begun_ns: int, new: int) -> bool:
        """Return whether a track with enough hits can be labelled.

        Args:
            track: with enough hits.
            begun_ns: latest possible stamp of its first box, ns.
            new: number of tentative tracks.
        """
        since = sum(image >= track.hits[0] for image in self.rule.images)
        least = TUNING.least_seen * self._rates.seen_share * since
        if track.first_seen_ns > begun_ns or len(track.hits) < least:
            return False
        if self.doubt(track) is not None:
            return False
        false = new * track.clutter_probability
        return len(track.hits) == 1 or false < TUNING.expected_false_tracks

    def doubt(self, track: Track) -> Cause | None:
        """Return why a track's boxes in the mean are not like a robot's; None: they are."""
        if chance_of_size(track.sizes, track.lasted_s) < SIZES.least_chance:
            return Cause.WRONG_SIZE
        odds, count = track.odds_sum, track.score_count
        likely = scores_as_robots(odds, count, track.lasted_s, self.least_score)
        return None if likely else Cause.UNSURE

    def robots_missing(self, stamp_ns: int) -> bool:
        """Return whether most robots are missed just now, so that short tracks may be of them."""
        known = [
            (stamp_ns - track.last_seen_ns) * 1e-9
            for track in self._lasting()
            if not track.leaving_view
        ]
        recent = [unseen_s for unseen_s in known if unseen_s <= TRANSIENTS.missed_s]
        missed = sum(unseen_s > TRANSIENTS.vanished_s for unseen_s in recent)
        return missed > 0 and 2 * missed >= len(recent)

    def _vanished(self, track: Track, stamp_ns: int, new: int) -> float:
        """Return the probability that a track is a transient that has vanished.

        Args:
            track: tentative, or labelled: a robot that vanished soon may have been none.
            stamp_ns: of the image, ns.
            new: number of tentative tracks.
        """
        unseen_s = (stamp_ns - track.last_seen_ns) * 1e-9
        if track.leaving_view or not TRANSIENTS.vanished_s < unseen_s < TRANSIENTS.memory_s:
            return 0.0
        if track.state is State.TENTATIVE:
            return transience(track, new)
        return outlasted(track.known_s)

    def _outlasts(self, track: Track, stamp_ns: int, vanishing: float) -> bool:
        """Return whether a track has been seen longer, or scored higher, than any transient would.

        Its boxes tell how long: one after the other, several transients at one place last, too.
        """
        seen_s = min(track.known_s, track.score_count * self.rule.interval_s)
        false = self.transients.expected(stamp_ns, vanishing, seen_s, track.mean_score)
        least, scale = self.transients.min_score, TRANSIENTS.score_scale
        false += expected_specks(track, self._table.tracks, seen_s, least, scale)
        chance = chance_of_size(track.sizes, track.lasted_s)
        chance *= chance_of_score(track, self._lasting())
        return false < TUNING.expected_false_tracks * chance

    def _lasting(self) -> list[Track]:
        """Return the robots that have lasted longer than foam and glint do."""
        return [
            track
            for track in self._table.tracks
            if track.robot_id and outlasted(track.known_s) < TUNING.expected_false_tracks
        ]

    def _reidentify(self, ready: list[int], stamp_ns: int, height: float) -> Returns:
        """Return which new tracks are which robots out of view."""
        tracks = self._table.tracks
        away = [row for row, track in enumerate(tracks) if track.robot_id]
        if not away:
            return Returns()
        newcomers = self._identity.newcomers((stamp_ns - self.rule.first_ns) * 1e-9)
        candidates = ReturnCandidates(
            tracks, away, ready, self._table.separations(away, ready),
            self._velocity_likelihood(ready), stamp_ns, height, newcomers,
        )  # fmt: skip
        return self._reidentification.decide(candidates)

    def _velocity_likelihood(self, rows: list[int]) -> VelocityLikelihood:
        """Return the velocity likelihoods of unlabelled tracks."""
        joint = self._table.filter
        mean, covariance = joint.moments()
        return VelocityLikelihood.of(mean[rows, 2:], covariance[rows, 2:, 2:], joint.speeds(rows))

    def _confirmed_track(self, track: Track, row: int) -> ConfirmedTrack:
        mean, covariance = self._table.filter.moments()
        place = mean[row, :2], covariance[row, :2, :2]
        boxes = track.pending_boxes
        return ConfirmedTrack(track.class_id, track.last_seen_ns, *place, boxes)


def transience(track: Track, new: int) -> float:
    """Return the probability that a track that ends without a label is one of foam or glint.

    One box is no track, and what was last seen at the edge of the image has left the view.

    Args:
        track: without a label.
        new: number of tentative tracks.
    """
    if track.score_count < 2 or track.leaving_view or track.rejected:
        return 0.0
    return max(0.0, 1.0 - new * track.clutter_probability)  # else chance: boxes of several things
