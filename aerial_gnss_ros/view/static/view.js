// Copyright 2026 aerial_gnss_ros developers
// SPDX-License-Identifier: Apache-2.0
// The page of `aerial-gnss view`: receives scenes from the server and draws them.

import { age, course, decimal, duration, ellipse, metres, nautical, WORDS } from "./format.js";
import { ALONE, dronesOf, SeaMap } from "./map.js";
import { drawClock, Lights, Picture, RobotList } from "./panel.js";

const SILENT_S = 2; // without news for so long, positions are old
const STEP_S = 0.2;
const SPEEDS = [1, 4, 16];
const POINT_S = 0.5;
const get = (id) => document.getElementById(id);
const now = () => performance.now() / 1000;

const state = { hello: null, scene: null, arrived: 0, selected: null, spot: null, connected: false, looking: false };
const player = { playing: false, speed: 0, at: 0, asked: false };
const map = new SeaMap(get("map"), choose, pointAt);
const lights = new Lights(), list = new RobotList(choose), picture = new Picture();
let socket = null;

function connect() {
  socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => {
    state.connected = true;
    if (state.looking) send({ picture: true });
  };
  socket.onclose = () => {
    state.connected = false;
    player.asked = false;
    draw();
    setTimeout(connect, 1000);
  };
  socket.onmessage = ({ data }) => {
    if (data instanceof ArrayBuffer) picture.show(data);
    else receive(JSON.parse(data));
  };
}

function send(message) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function receive(message) {
  if (message.kind === "hello") begin(message);
  else if (message.kind === "scene") {
    if (!state.scene && !state.hello.live) player.at = (message.now_ns - state.hello.begin_ns) / 1e9;
    state.scene = message;
    state.lights = message.lights;
    state.arrived = now();
    player.asked = false;
    if (state.hello.live) extendPaths(message);
    draw();
  } else if (message.kind === "silence") {
    state.lights = message.lights;
    draw();
  } else if (message.kind === "no picture") get("caption").textContent = message.words;
}

function begin(hello) {
  const first = state.hello === null;
  state.hello = hello;
  document.title = `${hello.title} · aerial_gnss_ros`;
  if (hello.drone_path.length) hello.drone_paths[ALONE] = hello.drone_path;
  get("camera").hidden = false;
  get("picture").hidden = !hello.pictures;
  get("no-images").hidden = hello.pictures;
  get("timeline").hidden = hello.live;
  if (first && hello.tiles) map.addTiles(hello.tiles);
  if (!hello.live) {
    get("slider").max = (hello.end_ns - hello.begin_ns) / 1e9;
    if (!first) ask();
  }
  if (first && hello.pictures && window.innerWidth > 800) look(true);
}

/** Add a scene's places to the paths that the server sent at the beginning. */
function extendPaths(scene) {
  const { hello } = state, time = (scene.stamp_ns - hello.begin_ns) / 1e9;
  const add = (path, point) => {
    if (!path.length || point[0] - path.at(-1)[0] >= POINT_S) path.push(point);
  };
  for (const drone of dronesOf(scene)) add((hello.drone_paths[drone.name] ??= []), [time, ...drone.place, 1]);
  for (const robot of scene.robots) {
    if (robot.state !== "lost") add((hello.paths[robot.id] ??= []), [time, ...robot.place, robot.state === "confirmed" ? 1 : 0]);
  }
}

function draw() {
  const { hello, scene } = state;
  if (!hello) {
    banner(state.connected ? "" : "No connection to the computer that makes the positions.");
    return;
  }
  const late = hello.live && scene ? now() - state.arrived : 0;
  const silent = scene ? scene.silent_s + late : Infinity;
  const old = silent > SILENT_S || !state.connected;
  document.body.classList.toggle("stale", old);
  if (!state.connected) banner(`No connection for ${age(late)}: positions are old.`);
  else if (old) banner(scene ? `No news for ${age(silent)}: positions are old.` : "Waiting for the first positions.");
  else banner("");
  lights.draw(state.lights ?? []);
  if (!scene) return;
  if (scene.drones) get("camera").hidden = true; // a fleet has no image of its own
  const time = scene.now_ns + late * 1e9;
  drawClock(time);
  map.draw(scene, old, late);
  map.drawPaths(hello.paths, hello.drone_paths, (time - hello.begin_ns) / 1e9 + 0.01);
  list.draw(scene, old, late, state.selected);
  drawCard(scene, old, late);
  if (!hello.live) {
    const at = (scene.now_ns - hello.begin_ns) / 1e9;
    if (document.activeElement !== get("slider") || player.playing) get("slider").value = at;
    get("at").textContent = `${duration(at)} / ${duration((hello.end_ns - hello.begin_ns) / 1e9)}`;
  }
}

function banner(words) {
  get("banner").hidden = !words;
  get("banner").textContent = words;
}

/** What is known of the chosen robot or of a place on the map, with the position to copy. */
function drawCard(scene, old, late) {
  const robot = scene.robots.find((one) => one.id === state.selected);
  get("card").hidden = !robot && !state.spot;
  if (!robot && !state.spot) return;
  const place = robot ? robot.place : state.spot;
  state.copied = decimal(place);
  get("card-title").textContent = robot ? robot.id : "Position";
  get("card-place").textContent = `${nautical(place)}\n${decimal(place)}`;
  const words = [];
  if (robot) {
    const shown = old && robot.state !== "lost" ? "old" : robot.state;
    words.push(`${WORDS[shown]}, last seen ${age((scene.now_ns - robot.last_seen_ns) * 1e-9 + late)} ago`);
    const within = robot.covariance_m2 ? `95 % ${shown === "old" ? "was" : "is"} within ${metres(ellipse(robot.covariance_m2).long)}` : "";
    words.push(within || "nothing bounds where it is now");
  }
  const seen = robot ? (scene.drones ?? []).filter((drone) => drone.sees.includes(robot.id)).map((drone) => drone.name) : [];
  if (seen.length) words.push(`in the last image of ${seen.join(", ")}`);
  for (const drone of dronesOf(scene)) {
    const { distance, bearing } = course(drone.place, place);
    const from = scene.drones ? drone.name : "the drone";
    words.push(`${metres(distance)} from ${from}, bearing ${String(Math.round(bearing) % 360).padStart(3, "0")}°`);
  }
  get("card-text").textContent = `${words.join("; ")}.`;
}

function choose(name) {
  state.selected = name;
  state.spot = null;
  get("copy").textContent = "Copy position";
  if (name) map.centre(name);
  draw();
}

function pointAt(place) {
  state.selected = null;
  state.spot = place;
  get("copy").textContent = "Copy position";
  draw();
}

/** Copy to the clipboard; browsers offer the newer way only to pages of this very computer. */
async function copy() {
  let done = false;
  try {
    await navigator.clipboard.writeText(state.copied);
    done = true;
  } catch {
    const field = document.createElement("textarea");
    field.value = state.copied;
    document.body.append(field);
    field.select();
    done = document.execCommand("copy");
    field.remove();
  }
  get("copy").textContent = done ? "Copied" : "Copying is not allowed here";
}

function look(wanted) {
  state.looking = wanted;
  get("frame").hidden = !wanted;
  get("picture").textContent = wanted ? "Hide" : "Show";
  get("picture").setAttribute("aria-pressed", wanted);
  send({ picture: wanted });
}

function ask() {
  player.asked = true;
  send({ at_s: player.at });
}

function tick() {
  if (state.hello && !state.hello.live && player.playing && !player.asked) {
    const length = (state.hello.end_ns - state.hello.begin_ns) / 1e9;
    player.at = Math.min(player.at + STEP_S * SPEEDS[player.speed], length);
    if (player.at >= length) play(false);
    ask();
  }
}

function play(wanted) {
  player.playing = wanted;
  get("play").textContent = wanted ? "❚❚" : "▶";
  get("play").setAttribute("aria-label", wanted ? "Pause" : "Play");
}

get("closer").onclick = () => map.map.zoomIn(1);
get("wider").onclick = () => map.map.zoomOut(1);
get("all").onclick = () => map.showAll();
get("measure").onclick = () => {
  const wanted = get("measure").getAttribute("aria-pressed") !== "true";
  get("measure").setAttribute("aria-pressed", wanted);
  map.measure(wanted);
};
get("night").onclick = () => {
  const wanted = document.documentElement.toggleAttribute("data-night");
  get("night").setAttribute("aria-pressed", wanted);
};
get("close").onclick = () => choose(null);
get("copy").onclick = copy;
get("picture").onclick = () => look(!state.looking);
get("play").onclick = () => {
  if (!player.playing && state.scene && state.scene.now_ns >= state.hello.end_ns) player.at = 0;
  play(!player.playing);
};
get("speed").onclick = () => {
  player.speed = (player.speed + 1) % SPEEDS.length;
  get("speed").textContent = `${SPEEDS[player.speed]}×`;
};
get("slider").oninput = () => {
  player.at = Number(get("slider").value);
  ask();
};
setInterval(tick, STEP_S * 1000);
setInterval(draw, 500);
connect();
