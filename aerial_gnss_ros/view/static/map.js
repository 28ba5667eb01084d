// Copyright 2026 aerial_gnss_ros developers
// SPDX-License-Identifier: Apache-2.0
// The map: drone, footprint, robots with their 95 % ellipses, paths, area, references, a ruler.

import { age, beside, course, metres, outline, WORDS } from "./format.js";

const L = window.L;
const DEEPEST = 24;
const SILENT_S = 3; // a drone of a fleet that has sent no image for so long
export const ALONE = "drone";
const icon = (path) => `<svg class="drone-icon" width="40" height="40" viewBox="-20 -20 40 40"><path d="${path}"></path></svg>`;
const DRONE = icon("M0-17 L12 13 L0 6 L-12 13 Z"), DRONE_DOWN = icon("M0-13 L13 0 L0 13 L-13 0 Z");
const SIDES = { right: [12, 0], left: [-12, 0], bottom: [0, 10], top: [0, -10] };

/** The drone of a scene, or all of a fleet. */
export function dronesOf(scene) {
  if (scene.drones) return scene.drones;
  return scene.drone ? [{ ...scene.drone, name: ALONE, stamp_ns: scene.now_ns, footprint: scene.footprint }] : [];
}

export class SeaMap {
  constructor(element, chosen, pointed) {
    this.map = L.map(element, { zoomControl: false, attributionControl: false, zoomSnap: 0.25, maxZoom: DEEPEST, minZoom: 2 });
    this.map.setView([0, 0], 18);
    L.control.scale({ imperial: false, maxWidth: 160, position: "bottomleft" }).addTo(this.map);
    this.chosen = chosen;
    this.robots = new Map();
    this.paths = new Map();
    this.references = new Map();
    this.placed = false;
    this.ends = [];
    this.grid = L.layerGroup().addTo(this.map);
    this.area = L.layerGroup().addTo(this.map);
    this.drones = new Map();
    this.ruler = L.layerGroup().addTo(this.map);
    this.map.on("moveend zoomend", () => {
      this.drawGrid();
      this.placeLabels();
    });
    new ResizeObserver(() => this.map.invalidateSize({ pan: false })).observe(element);
    this.map.on("click", (event) => (this.measuring ? this.addEnd([event.latlng.lat, event.latlng.lng]) : chosen(null)));
    this.map.on("contextmenu", (event) => pointed([event.latlng.lat, event.latlng.lng]));
  }

  addTiles({ lowest, highest, attribution }) {
    const options = { minNativeZoom: lowest, maxNativeZoom: highest, maxZoom: DEEPEST, attribution };
    L.tileLayer("tiles/{z}/{x}/{y}", options).addTo(this.map);
    if (attribution) L.control.attribution({ prefix: false }).addTo(this.map);
    this.tiled = true;
  }

  /** Draw a scene; `old` is true where there is no news. */
  draw(scene, old, late) {
    this.scene = scene;
    const drones = dronesOf(scene);
    for (const drone of drones) this.drawDrone(drone, scene, late);
    for (const [name, drawn] of this.drones) {
      if (!drones.some((drone) => drone.name === name)) drawn.group.remove();
    }
    this.drawArea(scene.area);
    this.drawReferences(scene.references);
    const names = new Set(scene.robots.map((robot) => robot.id));
    for (const robot of scene.robots) this.drawRobot(robot, scene, old, late);
    for (const [name, drawn] of this.robots) {
      if (!names.has(name)) {
        drawn.group.remove();
        this.robots.delete(name);
      }
    }
    this.placeLabels();
    if (!this.placed && (scene.robots.length || drones.length)) {
      this.placed = true;
      this.showAll();
    }
  }

  drawDrone(drone, scene, late) {
    const heading = drone.camera_heading_deg, drawn = this.droneOf(drone.name);
    const shape = L.divIcon({ html: heading === null ? DRONE_DOWN : DRONE, iconSize: [40, 40] });
    if (!drawn.marker) {
      drawn.marker = L.marker(drone.place, { icon: shape, interactive: false, zIndexOffset: 1000 });
      drawn.marker.bindTooltip("", { permanent: true, direction: "right", offset: [18, 0], className: "name drone" });
    }
    drawn.marker.addTo(drawn.group);
    drawn.group.addTo(this.map);
    drawn.footprint.setLatLngs(drone.footprint);
    drawn.marker.setIcon(shape);
    drawn.marker.setLatLng(drone.place);
    const svg = drawn.marker.getElement()?.firstElementChild;
    if (svg && heading !== null) svg.style.transform = `rotate(${heading}deg)`;
    const silent = (scene.now_ns - drone.stamp_ns) * 1e-9 + late;
    drawn.marker.getElement()?.classList.toggle("silent", silent > SILENT_S);
    drawn.note = drone.height_m === null ? "" : `${metres(drone.height_m)} up`;
    if (silent > SILENT_S) drawn.note = `silent for ${age(silent)}`;
    drawn.marker.setTooltipContent(text([drone.name, drawn.note]));
  }

  droneOf(name) {
    if (!this.drones.has(name)) {
      const group = L.layerGroup().addTo(this.map);
      const footprint = L.polygon([], { className: "shape footprint", interactive: false }).addTo(group);
      const flown = L.polyline([], { className: "shape path flown", interactive: false }).addTo(this.map);
      this.drones.set(name, { group, footprint, flown, note: "" });
    }
    return this.drones.get(name);
  }

  drawRobot(robot, scene, old, late) {
    let drawn = this.robots.get(robot.id);
    if (!drawn) {
      const group = L.layerGroup().addTo(this.map);
      const area = L.polygon([], { className: "shape ellipse", smoothFactor: 0, bubblingMouseEvents: false }).addTo(group);
      const spot = L.circleMarker(robot.place, { radius: 8, className: "shape spot", bubblingMouseEvents: false }).addTo(group);
      spot.bindTooltip("", { permanent: true, direction: "right", offset: [10, 0], className: "name" });
      for (const layer of [area, spot]) layer.on("click", () => this.touched(robot.id));
      drawn = { group, area, spot };
      this.robots.set(robot.id, drawn);
    }
    const state = old && robot.state !== "lost" ? "old" : robot.state;
    drawn.place = robot.place;
    drawn.spot.setLatLng(robot.place);
    drawn.area.setLatLngs(robot.covariance_m2 ? outline(robot.place, robot.covariance_m2) : []);
    setState(drawn.spot.getElement(), state);
    setState(drawn.area.getElement(), state);
    const seen = (scene.now_ns - robot.last_seen_ns) * 1e-9 + late;
    drawn.state = state;
    drawn.note = state === "confirmed" ? "" : `${WORDS[state]} ${age(seen)}`;
    drawn.spot.setTooltipContent(text([robot.id, drawn.note]));
    setState(drawn.spot.getTooltip().getElement(), state);
  }

  /** Put each name to the side where it covers least of the others; what is seen comes first. */
  placeLabels() {
    const taken = [], rank = { confirmed: 0, coasting: 1, old: 1, lost: 2 };
    for (const [name, { marker, note }] of this.drones) {
      if (marker) taken.push(labelBox(this.map.latLngToContainerPoint(marker.getLatLng()), "right", name, note));
    }
    const drawn = [...this.robots.entries()].sort(([, a], [, b]) => rank[a.state] - rank[b.state]);
    const points = drawn.map(([, one]) => this.map.latLngToContainerPoint(one.place));
    for (const point of points) taken.push([point.x - 9, point.y - 9, point.x + 9, point.y + 9]);
    drawn.forEach(([name, one], i) => {
      const boxes = Object.keys(SIDES).map((side) => labelBox(points[i], side, name, one.note));
      const costs = boxes.map((box) => taken.reduce((sum, other) => sum + overlap(box, other), 0));
      const best = costs.indexOf(Math.min(...costs)), side = Object.keys(SIDES)[best];
      taken.push(boxes[best]);
      const tooltip = one.spot.getTooltip();
      if (tooltip.options.direction !== side) {
        tooltip.options.direction = side;
        tooltip.options.offset = L.point(SIDES[side]);
        tooltip.update();
      }
    });
  }

  /** Draw the paths up to a time. */
  drawPaths(paths, drones, untilS) {
    const until = (points) => points.filter((point) => point[0] <= untilS);
    for (const [name, points] of Object.entries(drones)) this.droneOf(name).flown.setLatLngs(until(points).map(place));
    for (const [name, points] of Object.entries(paths)) {
      if (!this.paths.has(name)) {
        const line = (kind) => L.polyline([], { className: `shape path ${kind}`, interactive: false }).addTo(this.map);
        this.paths.set(name, { measured: line("measured"), predicted: line("predicted") });
      }
      const parts = split(until(points));
      this.paths.get(name).measured.setLatLngs(parts.measured);
      this.paths.get(name).predicted.setLatLngs(parts.predicted);
    }
  }

  drawArea(area) {
    const written = JSON.stringify(area);
    if (written === this.areaWritten) return;
    this.areaWritten = written;
    this.area.clearLayers();
    for (const polygon of area) L.polygon(polygon, { className: "shape area", interactive: false }).addTo(this.area);
  }

  drawReferences(references) {
    const names = new Set(references.map((one) => one.name));
    for (const one of references) {
      if (!this.references.has(one.name)) {
        const spot = L.circleMarker(one.place, { radius: 7, className: "shape spot reference", interactive: false }).addTo(this.map);
        spot.bindTooltip(text([one.name, ""]), { permanent: true, direction: "left", offset: [-8, 0], className: "name reference" });
        this.references.set(one.name, spot);
      }
      this.references.get(one.name).setLatLng(one.place);
    }
    for (const [name, spot] of this.references) {
      if (!names.has(name)) {
        spot.remove();
        this.references.delete(name);
      }
    }
  }

  /** Lines at round distances where there is no chart, so that eyes see the scale. */
  drawGrid() {
    this.grid.clearLayers();
    if (this.tiled || !this.placed) return;
    const bounds = this.map.getBounds(), south = bounds.getSouth(), west = bounds.getWest();
    const height = course([south, west], [bounds.getNorth(), west]).distance;
    const width = course([south, west], [south, bounds.getEast()]).distance;
    if (!(height > 0 && height < 200000)) return;
    const rough = Math.max(height, width) / 8, power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
    const origin = this.gridOrigin ?? (this.gridOrigin = [south, west]);
    const options = { className: "grid", interactive: false };
    const lines = (low, high, line) => {
      for (let n = Math.ceil(low / step); n * step <= high; n++) L.polyline(line(n * step), options).addTo(this.grid);
    };
    const offset = (to) => course(origin, to).distance * Math.sign((to[0] - origin[0]) || (to[1] - origin[1]));
    const low = offset([south, origin[1]]), left = offset([origin[0], west]);
    lines(low, low + height, (y) => [[beside(origin, 0, y)[0], west], [beside(origin, 0, y)[0], bounds.getEast()]]);
    lines(left, left + width, (x) => [[south, beside(origin, x, 0)[1]], [bounds.getNorth(), beside(origin, x, 0)[1]]]);
  }

  showAll() {
    if (!this.scene) return;
    const places = this.scene.robots.map((robot) => robot.place);
    for (const drone of dronesOf(this.scene)) places.push(drone.place, ...drone.footprint);
    if (places.length) this.map.fitBounds(L.latLngBounds(places).pad(0.1), { maxZoom: 21, animate: false });
    this.drawGrid();
  }

  centre(name) {
    const drawn = this.robots.get(name);
    if (drawn && !this.map.getBounds().pad(-0.1).contains(drawn.place)) this.map.panTo(drawn.place);
  }

  touched(name) {
    if (this.measuring) this.addEnd(this.robots.get(name).place, name);
    else this.chosen(name);
  }

  measure(wanted) {
    this.measuring = wanted;
    this.ends = [];
    this.ruler.clearLayers();
  }

  addEnd(end) {
    if (this.ends.length === 2) this.measure(true);
    this.ends.push(end);
    L.circleMarker(end, { radius: 5, className: "shape ruler", interactive: false }).addTo(this.ruler);
    if (this.ends.length < 2) return;
    const { distance, bearing } = course(...this.ends);
    const line = L.polyline(this.ends, { className: "shape ruler", interactive: false }).addTo(this.ruler);
    const words = text([metres(distance), `bearing ${String(Math.round(bearing) % 360).padStart(3, "0")}° true`]);
    line.bindTooltip(words, { permanent: true, direction: "center", className: "name measured" }).openTooltip();
  }
}

/** Left, top, right, bottom (px) of a label beside a point. */
function labelBox({ x, y }, side, name, note) {
  const width = 10 + Math.max(9 * name.length, 8 * (note?.length ?? 0)), height = note ? 38 : 20;
  if (side === "right") return [x + 12, y - height / 2, x + 12 + width, y + height / 2];
  if (side === "left") return [x - 12 - width, y - height / 2, x - 12, y + height / 2];
  const top = side === "bottom" ? y + 10 : y - 10 - height;
  return [x - width / 2, top, x + width / 2, top + height];
}

function overlap(a, b) {
  const width = Math.min(a[2], b[2]) - Math.max(a[0], b[0]), height = Math.min(a[3], b[3]) - Math.max(a[1], b[1]);
  return width > 0 && height > 0 ? width * height : 0;
}

const place = (point) => [point[1], point[2]];

/** Stretches of a path that were measured, and those that were predicted. */
function split(points) {
  const parts = { measured: [], predicted: [] };
  let run = null, kind = null;
  for (const point of points) {
    const now = point[3] ? "measured" : "predicted";
    if (now !== kind) {
      const last = run?.at(-1);
      run = last ? [last] : [];
      parts[now].push(run);
      kind = now;
    }
    run.push(place(point));
  }
  return parts;
}

function setState(element, state) {
  if (!element) return;
  element.classList.remove("confirmed", "coasting", "lost", "old");
  element.classList.add(state);
}

/** A label of two lines; names come from files and messages, so never as HTML. */
function text([first, second]) {
  const element = document.createElement("span");
  element.textContent = first;
  if (second) {
    const small = document.createElement("small");
    small.textContent = second;
    element.append(small);
  }
  return element;
}
