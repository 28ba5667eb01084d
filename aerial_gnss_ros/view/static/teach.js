// Copyright 2026 aerial_gnss_ros developers. SPDX-License-Identifier: Apache-2.0
// The page of `aerial-gnss teach`: shows frames and boxes, sends clicks, boxes and answers.
"use strict";

const at = (id) => document.getElementById(id);
const picture = at("picture"), line = at("line");
const COLOURS = ["#ff4d4d", "#ffd23f", "#4dd2ff", "#b38cff", "#5ee07a", "#ff9ad5", "#ffa04d", "#e8eef2", "#8ab4f8"];
const DRAG_PX = 5;

const page = {
  hello: null, state: { robots: [], questions: [], marks: 0 }, boxes: [], frame: 0,
  image: new Image(), shown: -1, robot: null, own: [], question: null, playing: null,
  zoom: 1, middle: [0.5, 0.5], drag: null, cross: null, corner: null,
};
let socket = null;

function send(fields) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(fields));
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/teach`);
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = () => { say("the program has ended; marks are kept"); setTimeout(connect, 2000); };
}

function receive(message) {
  if (message.kind === "hello") {
    page.hello = message;
    at("name").textContent = message.name;
    if (!at("class").value) at("class").value = message.class;
    page.cross = [message.size[0] / 2, message.size[1] / 2];
    say("");
    show(page.frame);
  } else if (message.kind === "state") {
    page.state = message;
    if (!page.robot) page.robot = names()[0] || null;
    say("");
    if (page.question && !find(page.question)) page.question = null;
    panel();
  } else if (message.kind === "frame") {
    if (message.frame === page.frame) { page.boxes = message.boxes; paint(); }
  } else if (message.kind === "busy") {
    say("carrying the box to all frames ...");
    complain("");
  } else if (message.kind === "no") {
    complain(message.words);
  } else if (message.kind === "written") {
    complain("");
    at("banner").textContent = message.words;
    at("banner").hidden = false;
    at("banner").style.background = "var(--seen)";
  }
}

function say(words) { at("status").textContent = words; }

function complain(words) {
  at("banner").style.background = "";
  at("banner").textContent = words;
  at("banner").hidden = !words;
}

function names() {
  const known = page.state.robots.map((robot) => robot.name);
  return known.concat(page.own.map((robot) => robot.name).filter((name) => !known.includes(name)));
}

function classOf(name) {
  const all = page.state.robots.concat(page.own);
  const found = all.find((robot) => robot.name === name);
  return found ? found.class : at("class").value.trim() || page.hello.class;
}

function colour(name) { return COLOURS[Math.max(0, names().indexOf(name)) % COLOURS.length]; }

function find(question) {
  return page.state.questions.find((one) => one.robot === question.robot && question.frame <= one.until && question.frame >= one.frame);
}

function show(frame) {
  const last = page.hello.frames - 1;
  page.frame = Math.max(0, Math.min(last, frame));
  page.boxes = [];
  page.corner = null;
  at("where").textContent = `frame ${page.frame} of ${last}`;
  send({ do: "frame", frame: page.frame });
  const image = new Image();
  image.onload = () => { if (image.frame === page.frame) { page.image = image; page.shown = image.frame; paint(); } };
  image.frame = page.frame;
  image.src = `frames/${page.frame}`;
  panel();
  paint();
}

// From pixels of the image to those of the canvas: scale and shift.
function view() {
  const [width, height] = page.hello.size;
  const box = picture.getBoundingClientRect();
  const scale = Math.min(box.width / width, box.height / height) * page.zoom;
  return { scale, x: box.width / 2 - page.middle[0] * width * scale, y: box.height / 2 - page.middle[1] * height * scale };
}

function pixel(event) {
  const box = picture.getBoundingClientRect(), now = view();
  return [(event.clientX - box.left - now.x) / now.scale, (event.clientY - box.top - now.y) / now.scale];
}

function fit(canvas) {
  const box = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(box.width * ratio);
  canvas.height = Math.round(box.height * ratio);
  const draw = canvas.getContext("2d");
  draw.setTransform(ratio, 0, 0, ratio, 0, 0);
  return [draw, box.width, box.height];
}

function paint() {
  if (!page.hello) return;
  const [draw] = fit(picture), now = view();
  const [width, height] = page.hello.size;
  draw.imageSmoothingEnabled = now.scale < 2;
  if (page.image.width) draw.drawImage(page.image, now.x, now.y, width * now.scale, height * now.scale);
  const asked = page.question && page.question.robot;
  for (const one of page.boxes) {
    const [x, y, w, h] = one.box.map((value) => value * now.scale);
    draw.strokeStyle = colour(one.robot);
    draw.lineWidth = one.robot === asked ? 4 : 2;
    draw.setLineDash(one.sight === "sure" ? [] : [6, 5]);
    draw.strokeRect(now.x + x - 2, now.y + y - 2, w + 4, h + 4);
    draw.fillStyle = colour(one.robot);
    draw.font = "600 14px system-ui, sans-serif";
    draw.fillText(one.robot + (one.sight === "sure" ? "" : "?"), now.x + x, now.y + y - 7);
  }
  draw.setLineDash([]);
  if (page.drag && page.drag.to) frameOf(draw, now, page.drag.from, page.drag.to);
  if (page.corner) frameOf(draw, now, page.corner, page.cross);
  if (page.crossed) {
    draw.strokeStyle = "#ffffff";
    draw.lineWidth = 1;
    const x = now.x + page.cross[0] * now.scale, y = now.y + page.cross[1] * now.scale;
    draw.beginPath();
    draw.moveTo(x - 14, y); draw.lineTo(x + 14, y); draw.moveTo(x, y - 14); draw.lineTo(x, y + 14);
    draw.stroke();
  }
}

function frameOf(draw, now, from, to) {
  draw.strokeStyle = "#ffffff";
  draw.lineWidth = 2;
  draw.strokeRect(now.x + from[0] * now.scale, now.y + from[1] * now.scale, (to[0] - from[0]) * now.scale, (to[1] - from[1]) * now.scale);
}

const SIGHTS = { s: 1, u: 0.45, l: 0.45, o: 0.12, "-": 0 };

function timeline() {
  if (!page.hello) return;
  const [draw, width, height] = fit(line), count = page.hello.frames, step = width / count;
  const robots = page.state.robots, row = Math.min(18, (height - 16) / Math.max(1, robots.length));
  const warn = getComputedStyle(document.documentElement).getPropertyValue("--warn");
  robots.forEach((robot, i) => {
    for (let k = 0; k < count; k += 1) {
      const letter = robot.sights[k];
      draw.globalAlpha = SIGHTS[letter];
      draw.fillStyle = letter === "u" || letter === "l" ? warn : colour(robot.name);
      draw.fillRect(k * step, 8 + i * row, Math.max(1, step - 0.5), row - 3);
    }
    draw.globalAlpha = 1;
    draw.fillStyle = getComputedStyle(document.body).color;
    for (const k of robot.marked) draw.fillRect((k + 0.5) * step - 2, 8 + i * row + row / 2 - 4, 4, 5);
  });
  draw.fillStyle = getComputedStyle(document.body).color;
  draw.fillRect((page.frame + 0.5) * step - 1, 0, 2, height);
}

function panel() {
  const list = at("robots");
  list.replaceChildren(...names().map((name, i) => {
    const button = document.createElement("button");
    button.className = "tool robot";
    button.setAttribute("aria-pressed", String(name === page.robot));
    const swatch = document.createElement("i"), text = document.createElement("span"), count = document.createElement("small");
    swatch.style.background = colour(name);
    text.textContent = name;
    const robot = page.state.robots.find((one) => one.name === name);
    const sure = robot ? [...robot.sights].filter((letter) => letter === "s").length : 0;
    count.textContent = `${classOf(name)}, ${sure} ${sure === 1 ? "box" : "boxes"}`;
    button.append(swatch, text, count);
    button.title = String(i + 1);
    button.onclick = () => { page.robot = name; panel(); };
    return button;
  }));
  if (!at("robot").value || names().includes(at("robot").value)) at("robot").value = free();
  const here = page.state.questions.find((one) => page.frame >= one.frame && page.frame <= one.until && (!page.question || one.robot === page.question.robot))
    || page.state.questions.find((one) => page.frame >= one.frame && page.frame <= one.until);
  page.question = here ? { robot: here.robot, frame: page.frame, until: here.until } : null;
  if (here) page.robot = here.robot;
  at("asked").hidden = !here;
  if (here) {
    at("asked-robot").textContent = here.robot;
    at("until").textContent = here.until;
    at("all").hidden = here.until === page.frame;
  }
  at("count").textContent = page.state.questions.length ? `(${page.state.questions.length})` : "(none)";
  timeline();
}

function free() {
  const stem = at("class").value.trim() || page.hello.class;
  let number = 1;
  while (names().includes(`${stem}_${number}`)) number += 1;
  return `${stem}_${number}`;
}

function add() {
  const name = at("robot").value.trim() || free();
  if (!names().includes(name)) page.own.push({ name, class: at("class").value.trim() || page.hello.class });
  page.robot = name;
  at("robot").value = "";
  panel();
}

function mark(what) {
  if (!page.robot) add();
  send({ do: "mark", robot: page.robot, class: classOf(page.robot), frame: page.frame, ...what });
}

function boxed(from, to) {
  const low = [Math.min(from[0], to[0]), Math.min(from[1], to[1])];
  const size = [Math.abs(from[0] - to[0]), Math.abs(from[1] - to[1])];
  mark({ box: [...low, ...size] });
}

function answer(yes, until) {
  if (!page.question) return;
  const fields = { do: "answer", yes, robot: page.question.robot, frame: page.frame };
  if (until) fields.until = page.question.until;
  send(fields);
}

function absent() {
  if (page.question) answer(false, false);
  else if (page.robot) mark({ absent: true });
}

function next() {
  const all = page.state.questions;
  if (!all.length) return;
  const later = all.find((one) => one.frame > page.frame) || all[0];
  page.question = later;
  show(later.frame);
}

function zoomed(factor, point) {
  const before = view();
  page.zoom = Math.max(1, Math.min(16, page.zoom * factor));
  const [width, height] = page.hello.size;
  if (page.zoom === 1) page.middle = [0.5, 0.5];
  else if (point) {
    const ratio = before.scale / view().scale;
    page.middle = [point[0] / width + (page.middle[0] - point[0] / width) * ratio, point[1] / height + (page.middle[1] - point[1] / height) * ratio];
  }
  paint();
}

function play() {
  if (page.playing) { clearInterval(page.playing); page.playing = null; return; }
  page.playing = setInterval(() => {
    if (page.frame >= page.hello.frames - 1) play(); else show(page.frame + 1);
  }, 200);
}

function moveCross(x, y) {
  page.crossed = true;
  const [width, height] = page.hello.size;
  page.cross = [Math.max(0, Math.min(width, page.cross[0] + x)), Math.max(0, Math.min(height, page.cross[1] + y))];
  paint();
}

function corner() {
  page.crossed = true;
  if (page.corner) { boxed(page.corner, page.cross); page.corner = null; }
  else page.corner = [...page.cross];
  paint();
}

const KEYS = {
  n: next, y: () => answer(true, false), a: () => answer(true, true), x: absent, delete: absent,
  u: () => send({ do: "undo" }), w: () => send({ do: "write" }), r: add, b: corner,
  " ": play, home: () => show(0), end: () => show(page.hello.frames - 1),
  "+": () => zoomed(1.5, page.crossed ? page.cross : null), "=": () => zoomed(1.5, page.crossed ? page.cross : null),
  "-": () => zoomed(1 / 1.5), 0: () => { page.zoom = 1; zoomed(1); },
  enter: () => mark({ x: page.cross[0], y: page.cross[1] }),
  escape: () => { page.corner = null; page.drag = null; complain(""); paint(); },
};

document.addEventListener("keydown", (event) => {
  if (!page.hello || event.target.tagName === "INPUT") return;
  const key = event.key.toLowerCase(), far = event.shiftKey;
  if (event.ctrlKey || event.metaKey) {
    if (key === "z") { send({ do: "undo" }); event.preventDefault(); }
    return;
  }
  const cross = { i: [0, -1], k: [0, 1], j: [-1, 0], l: [1, 0] }[key];
  if (cross) moveCross(...cross.map((value) => value * (far ? 20 : 2)));
  else if (key === "arrowright") show(page.frame + (far ? 10 : 1));
  else if (key === "arrowleft") show(page.frame - (far ? 10 : 1));
  else if (/^[1-9]$/.test(key)) { page.robot = names()[Number(key) - 1] || page.robot; panel(); }
  else if (KEYS[key] && !(event.target.tagName === "BUTTON" && (key === " " || key === "enter"))) KEYS[key]();
  else return;
  event.preventDefault();
});

picture.addEventListener("pointerdown", (event) => {
  picture.setPointerCapture(event.pointerId);
  page.drag = { from: pixel(event), x: event.clientX, y: event.clientY, to: null };
});
picture.addEventListener("pointermove", (event) => {
  if (!page.drag) return;
  if (Math.hypot(event.clientX - page.drag.x, event.clientY - page.drag.y) > DRAG_PX) page.drag.to = pixel(event);
  paint();
});
picture.addEventListener("pointerup", () => {
  const drag = page.drag;
  page.drag = null;
  if (!drag) return;
  if (drag.to) boxed(drag.from, drag.to); else mark({ x: drag.from[0], y: drag.from[1] });
  paint();
});
picture.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoomed(event.deltaY < 0 ? 1.25 : 0.8, pixel(event));
}, { passive: false });
line.addEventListener("pointerdown", (event) => {
  const box = line.getBoundingClientRect();
  show(Math.floor((event.clientX - box.left) / box.width * page.hello.frames));
});
window.addEventListener("resize", () => { paint(); timeline(); });
at("undo").onclick = () => send({ do: "undo" });
at("write").onclick = () => send({ do: "write" });
at("add").onclick = add;
at("absent").onclick = () => page.robot && mark({ absent: true });
at("yes").onclick = () => answer(true, false);
at("all").onclick = () => answer(true, true);
at("no").onclick = () => answer(false, false);
at("next").onclick = next;
connect();
