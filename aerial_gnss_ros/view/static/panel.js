// Copyright 2026 aerial_gnss_ros developers
// SPDX-License-Identifier: Apache-2.0
// Everything beside the map: lights, clock, list of robots, the camera's image.

import { age, ellipse, metres, WORDS } from "./format.js";

const SIGNS = { ok: "✓", warning: "!", error: "✕" };
const ORDER = { error: 0, warning: 1, ok: 2 };
const get = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";

/** A row of lights, what is wrong first, and the sentence of the first or of the touched one. */
export class Lights {
  draw(lights) {
    const sorted = grouped(lights).sort((a, b) => ORDER[a.level] - ORDER[b.level]);
    const written = JSON.stringify([sorted, this.touched]);
    if (written === this.written) return;
    this.written = written;
    get("lights").replaceChildren(...sorted.map((light) => {
      const button = document.createElement("button");
      button.className = `light ${light.level}`;
      button.textContent = `${SIGNS[light.level]} ${light.name}`;
      button.title = light.words;
      button.onclick = () => {
        this.touched = this.touched === light.name ? null : light.name;
        this.draw(lights);
      };
      return button;
    }));
    const shown = sorted.find((light) => light.name === this.touched) ?? sorted.find((light) => light.level !== "ok");
    get("trouble").hidden = !shown;
    if (shown) {
      get("trouble").className = shown.level;
      get("trouble").textContent = `${shown.name}: ${shown.words}`;
    }
  }
}

/** One light for the whole detector while all of its own are well. */
function grouped(lights) {
  const ofDetector = lights.filter((light) => light.name.startsWith("detector "));
  if (!ofDetector.length || ofDetector.some((light) => light.level !== "ok")) return [...lights];
  const rest = lights.filter((light) => !ofDetector.includes(light));
  return [...rest, { name: "detector", level: "ok", words: ofDetector.map((light) => `${light.name.slice(9)}: ${light.words}`).join("; ") }];
}

/** UTC and the tablet's local time of a moment, ns since 1970. */
export function drawClock(ns) {
  const date = new Date(ns / 1e6);
  get("utc").textContent = date.toISOString().slice(11, 19);
  const zone = -date.getTimezoneOffset() / 60;
  get("day").textContent = `${date.toISOString().slice(0, 10)} · `;
  get("local").textContent = `${date.toTimeString().slice(0, 8)} local (UTC${zone < 0 ? "−" : "+"}${Math.abs(zone)})`;
}

/** The list of robots. */
export class RobotList {
  constructor(chosen) {
    this.chosen = chosen;
    this.rows = new Map();
  }

  draw(scene, old, late, selected) {
    const rank = { confirmed: 0, coasting: 1, lost: 2 };
    const robots = [...scene.robots].sort((a, b) => rank[a.state] - rank[b.state] || a.id.localeCompare(b.id, undefined, { numeric: true }));
    get("none").hidden = robots.length > 0;
    get("robots").hidden = robots.length === 0;
    const body = document.querySelector("#robots tbody");
    const rows = robots.map((robot) => {
      const row = this.row(robot.id);
      const state = old && robot.state !== "lost" ? "old" : robot.state;
      row.className = robot.id === selected ? `${state} chosen` : state;
      const [name, seen, within, depth] = row.cells;
      put(name.querySelector(".label"), robot.id);
      put(name.querySelector(".state"), WORDS[state]);
      put(seen, age((scene.now_ns - robot.last_seen_ns) * 1e-9 + late));
      put(within, within95(robot, state));
      put(depth, depthOf(robot));
      return row;
    });
    if (rows.length !== body.children.length || rows.some((row, i) => row !== body.children[i])) body.replaceChildren(...rows);
  }

  row(name) {
    if (this.rows.has(name)) return this.rows.get(name);
    const row = document.createElement("tr");
    row.tabIndex = 0;
    row.setAttribute("role", "button");
    const first = row.insertCell(), dot = document.createElement("span"), label = document.createElement("b"), state = document.createElement("span");
    dot.className = "dot";
    label.className = "label";
    state.className = "state";
    first.append(dot, label, state);
    for (let i = 0; i < 3; i++) row.insertCell();
    row.onclick = () => this.chosen(name);
    row.onkeydown = (event) => {
      if (event.key === "Enter" || event.key === " ") this.chosen(name);
    };
    this.rows.set(name, row);
    return row;
  }
}

/** The camera's image with boxes and names. */
export class Picture {
  /** Show what the server packed: header length, JSON header, JPEG. */
  show(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
    const url = URL.createObjectURL(new Blob([new Uint8Array(buffer, 4 + length)], { type: "image/jpeg" }));
    const image = get("image");
    image.onload = () => {
      if (this.url) URL.revokeObjectURL(this.url);
      this.url = url;
    };
    image.src = url;
    this.stamp = header.stamp_ns;
    this.drawBoxes(header);
    const boxes = header.boxes_known ? `${header.boxes.length} ${header.boxes.length === 1 ? "box" : "boxes"}` : "boxes of this image are not known";
    get("caption").textContent = `${new Date(header.stamp_ns / 1e6).toISOString().slice(11, 21)} UTC · ${boxes}`;
  }

  drawBoxes({ width, height, boxes }) {
    const svg = get("boxes"), size = width / 26, taken = [];
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.replaceChildren(...boxes.flatMap((box) => {
      const rect = document.createElementNS(SVG, "rect"), label = document.createElementNS(SVG, "text");
      const left = box.x - box.width / 2, top = box.y - box.height / 2;
      for (const [key, value] of Object.entries({ x: left, y: top, width: box.width, height: box.height })) rect.setAttribute(key, value);
      rect.setAttribute("class", box.name ? "named" : "unnamed");
      label.textContent = box.name ?? `${box.class} ?`;
      const wide = size * 0.62 * label.textContent.length, above = top - size * 0.3, below = top + box.height + size;
      const x = Math.max(2, Math.min(left, width - wide));
      const free = (y) => y > size && !taken.some((other) => Math.abs(other.y - y) < size && x < other.x + other.wide && other.x < x + wide);
      const y = free(above) || !free(below) ? Math.max(above, size) : below;
      taken.push({ x, y, wide });
      label.setAttribute("x", x);
      label.setAttribute("y", y);
      label.setAttribute("font-size", size);
      label.setAttribute("stroke-width", size / 6);
      return [rect, label];
    }));
  }
}

function within95({ covariance_m2: covariance }, state) {
  if (!covariance) return "unknown";
  const radius = metres(ellipse(covariance).long);
  return state === "old" ? `was ${radius}` : radius;
}

function depthOf({ depth_m: depth }) {
  if (depth === null) return "–";
  return depth < 0.05 ? "surface" : metres(depth);
}

function put(element, words) {
  if (element.textContent !== words) element.textContent = words;
}
