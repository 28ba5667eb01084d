// Copyright 2026 aerial_gnss_ros developers
// SPDX-License-Identifier: Apache-2.0
// Numbers for people, and the little geometry that the page needs.

export const WORDS = { confirmed: "seen", coasting: "predicted", lost: "lost", old: "old" };
const CIRCLE_95 = 2.4477; // sigmas, two degrees of freedom
const RADIUS_M = 6371008.8;
const RAD = Math.PI / 180;

/** Seconds as "0.4 s", "45 s", "12 min", "3 h". */
export function age(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const s = Math.max(0, seconds);
  if (s < 9.95) return `${s.toFixed(1)} s`;
  if (s < 120) return `${Math.round(s)} s`;
  return s < 7200 ? `${Math.round(s / 60)} min` : `${Math.round(s / 3600)} h`;
}

/** Metres with two significant digits at least. */
export function metres(m) {
  if (m < 10) return `${m.toFixed(m < 1 ? 2 : 1)} m`;
  return m < 10000 ? `${Math.round(m)} m` : `${(m / 1000).toFixed(1)} km`;
}

/** Seconds as mm:ss or h:mm:ss. */
export function duration(seconds) {
  const s = Math.max(0, Math.floor(seconds));
  const two = (n) => String(n).padStart(2, "0");
  const minutes = Math.floor(s / 60);
  return minutes < 60 ? `${minutes}:${two(s % 60)}` : `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(s % 60)}`;
}

/** Decimal degrees, as other programs take them. */
export function decimal([latitude, longitude]) {
  return `${latitude.toFixed(7)}, ${longitude.toFixed(7)}`;
}

/** Degrees and decimal minutes, as charts have them. */
export function nautical([latitude, longitude]) {
  const one = (value, digits, signs) => {
    const total = Math.round(Math.abs(value) * 60 * 1e4);
    const minutes = (total % 600000) / 1e4;
    const degrees = String(Math.floor(total / 600000)).padStart(digits, "0");
    return `${degrees}° ${minutes.toFixed(4).padStart(7, "0")}′ ${signs[value < 0 ? 1 : 0]}`;
  };
  return `${one(latitude, 2, "NS")}  ${one(longitude, 3, "EW")}`;
}

/** Semi-axes (m) of the 95 % ellipse and the long one's angle from east (rad). */
export function ellipse([ee, en, nn]) {
  const mean = (ee + nn) / 2;
  const root = Math.hypot((ee - nn) / 2, en);
  const axis = (variance) => CIRCLE_95 * Math.sqrt(Math.max(variance, 0));
  return { long: axis(mean + root), short: axis(mean - root), angle: Math.atan2(2 * en, ee - nn) / 2 };
}

/** A place that lies east and north (m) of another one. */
export function beside([latitude, longitude], east, north) {
  return [latitude + north / RADIUS_M / RAD, longitude + east / (RADIUS_M * Math.cos(latitude * RAD)) / RAD];
}

/** The corners of a 95 % ellipse around a place. */
export function outline(place, covariance) {
  const { long, short, angle } = ellipse(covariance);
  return Array.from({ length: 48 }, (_, i) => {
    const t = (i / 24) * Math.PI;
    const along = long * Math.cos(t), across = short * Math.sin(t);
    return beside(place, along * Math.cos(angle) - across * Math.sin(angle), along * Math.sin(angle) + across * Math.cos(angle));
  });
}

/** Distance (m) and bearing (deg from true north) of one place from another. */
export function course([latitude1, longitude1], [latitude2, longitude2]) {
  const a = latitude1 * RAD, b = latitude2 * RAD, turn = (longitude2 - longitude1) * RAD;
  const h = Math.sin((b - a) / 2) ** 2 + Math.cos(a) * Math.cos(b) * Math.sin(turn / 2) ** 2;
  const y = Math.sin(turn) * Math.cos(b);
  const x = Math.cos(a) * Math.sin(b) - Math.sin(a) * Math.cos(b) * Math.cos(turn);
  return { distance: 2 * RADIUS_M * Math.asin(Math.min(1, Math.sqrt(h))), bearing: ((Math.atan2(y, x) / RAD) + 360) % 360 };
}
