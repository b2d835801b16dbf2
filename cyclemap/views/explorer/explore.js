// The page: sliders to settings, settings to answers, answers to panels; one request at a time, the newest wins.
import { Panels } from "./drawing.js";

const REST_MS = 300;
const CYCLE_MS = 2600;
const find = (id) => document.getElementById(id);
const fragment = new URLSearchParams(location.hash.slice(1));
const token = fragment.get("token") ?? "";
const page = crypto.getRandomValues(new Uint32Array(2)).join("-");
const panels = new Panels(find("panels"));
const state = { moved: {}, cycles: 2000 };
const controls = new Map();
let number = 0, busy = false, waiting = null, resting = null, before = null, measured = null, latest = null;
let playing = true, begun = performance.now(), grabbed = null;

async function ask(name, body) {
  const reply = await fetch(`/api/${name}`, { method: "POST", headers: { "Content-Type": "application/json", "X-Token": token },
    body: JSON.stringify({ page, number, ...body }) });
  if (!reply.ok) throw new Error(await reply.text());
  return reply.json();
}

// One fast answer at a time, always for the newest settings; the exact one once nothing has moved for a while.
async function update(since = performance.now()) {
  number += 1;
  clearTimeout(resting);
  resting = setTimeout(refine, REST_MS);
  if (busy) { waiting = since; return; }
  busy = true;
  await answered(false, since);
  busy = false;
  if (waiting !== null) { const from = waiting; waiting = null; update(from); }
}

function refine() {
  if (busy) { resting = setTimeout(refine, REST_MS); return; }
  answered(true, performance.now());
}

async function answered(exact, since) {
  const asked = number;
  find("status").textContent = exact ? "computing exactly …" : find("status").textContent;
  let answer;
  try {
    const { start_deg: start = 0, ...settings } = state.moved;
    answer = await ask("portrait", { settings, start_deg: start, cycles: state.cycles, exact });
  } catch (fault) {
    answer = { refused: `no answer: ${fault.message}; is cyclemap explore still running?` };
  }
  if (answer.stale || (exact && asked !== number)) return;
  remember();
  const headline = find("headline");
  headline.classList.toggle("refused", "refused" in answer);
  if (answer.refused) {
    headline.textContent = answer.refused;
    find("said").textContent = "The pictures show the last settings that could be computed.";
    return;
  }
  latest = answer;
  headline.textContent = answer.said[0];
  find("said").textContent = answer.said.slice(1).join(" ");
  find("command").textContent = answer.command;
  showArrow(answer);
  panels.show(answer, before, measured);
  if (exact) begun = performance.now() - panels.moment.part * CYCLE_MS;
  await new Promise(requestAnimationFrame);
  const took = performance.now() - since;
  document.body.dataset.drawn = String(asked);
  document.body.dataset.exact = String(exact);
  document.body.dataset.milliseconds = took.toFixed(1);
  find("status").textContent = exact ? `exact, ${took.toFixed(0)} ms` : `coarse, ${took.toFixed(0)} ms`;
}

// The push as an arrow at the start of a cycle, in the world: from the rod towards where it goes.
function showArrow({ courses }) {
  const push = courses[0][0];
  const [from, to] = [push[0].slice(3), push[push.length - 1].slice(3)];
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
  panels.arrow = [0, 1].map((i) => from[i] + (60 * (to[i] - from[i])) / length);
}

function remember() {
  const kept = new URLSearchParams({ token, ...state.moved });
  history.replaceState(null, "", `#${kept}`);
}

function move(key, value) {
  const control = controls.get(key);
  if (!control || !Number.isFinite(value)) return;
  const kept = Math.min(Math.max(value, control.low), control.high);
  if (kept === control.value) delete state.moved[key];
  else state.moved[key] = kept;
  show(key);
  update();
}

function show(key) {
  const control = controls.get(key);
  const value = state.moved[key] ?? control.value;
  const decimals = Math.max(0, -Math.floor(Math.log10(control.step)));
  control.slider.value = value;
  control.number.value = value.toFixed(decimals);
  control.row.classList.toggle("moved", key in state.moved);
}

function build(list) {
  const groups = new Map();
  for (const one of list) {
    if (!groups.has(one.group)) {
      const set = find("controls").appendChild(document.createElement("fieldset"));
      set.appendChild(document.createElement("legend")).textContent = one.group;
      groups.set(one.group, set);
    }
    const row = groups.get(one.group).appendChild(document.createElement("div"));
    row.className = "slider";
    const label = row.appendChild(document.createElement("label"));
    label.textContent = one.unit ? `${one.label} (${one.unit})` : one.label;
    label.htmlFor = one.key;
    const input = (type, id) => Object.assign(row.appendChild(document.createElement("input")),
      { type, id, min: one.low, max: one.high, step: type === "range" ? one.step : "any" });
    const slider = input("range", one.key);
    const box = input("number", `${one.key}-number`);
    box.setAttribute("aria-label", label.textContent);
    controls.set(one.key, { ...one, row, slider, number: box });
    slider.addEventListener("input", () => move(one.key, slider.valueAsNumber));
    box.addEventListener("change", () => move(one.key, box.valueAsNumber));
  }
}

// Ring, contact and arrow can be dragged on the object itself, at the start of its push.
function handles() {
  const [push] = latest.courses[0];
  const world = [0, 0, 0];
  return { ring: panels.toPicture(latest.scene.ring), arrow: panels.toPicture(panels.arrow, world),
    contact: panels.toPicture(push[0].slice(3), world) };
}

function contactAt(point) {
  const { corners, semi_axes: axes } = latest.scene;
  if (!corners) return { side: 0, fraction: (((Math.atan2(point[1] / axes[1], point[0] / axes[0]) / (2 * Math.PI)) % 1) + 1) % 1 };
  const sides = corners.map((from, side) => {
    const to = corners[(side + 1) % corners.length];
    const along = [to[0] - from[0], to[1] - from[1]];
    const share = ((point[0] - from[0]) * along[0] + (point[1] - from[1]) * along[1]) / (along[0] ** 2 + along[1] ** 2);
    const fraction = Math.min(Math.max(share, 0), 1);
    return { side, fraction, gap: Math.hypot(point[0] - from[0] - fraction * along[0], point[1] - from[1] - fraction * along[1]) };
  });
  return sides.reduce((best, one) => (one.gap < best.gap ? one : best));
}

panels.canvas.addEventListener("pointerdown", (event) => {
  if (!latest) return;
  panels.at(0, 0);
  const near = Object.entries(handles()).map(([name, [x, y]]) => [Math.hypot(x - event.offsetX, y - event.offsetY), name]);
  const [gap, name] = near.reduce((best, one) => (one[0] < best[0] ? one : best));
  if (gap > 30) return;
  grabbed = name;
  panels.canvas.setPointerCapture(event.pointerId);
});
panels.canvas.addEventListener("pointermove", (event) => {
  if (!grabbed) return;
  const point = panels.toObject(event.offsetX, event.offsetY);
  if (grabbed === "ring") {
    move("hitch_x_mm", Math.round(10 * point[0]) / 10);
    move("hitch_y_mm", Math.round(10 * point[1]) / 10);
  } else if (grabbed === "contact") {
    const { side, fraction } = contactAt(point);
    move("side", side);
    move("fraction", Math.round(200 * fraction) / 200);
  } else {
    const rod = panels.toObject(...handles().contact);
    const turned = Math.atan2(point[1] - rod[1], point[0] - rod[0]) - Math.atan2(...arrowInObject(rod).reverse());
    const angle = state.moved.angle_deg ?? controls.get("angle_deg").value;
    move("angle_deg", Math.round(2 * (angle + (Math.atan2(Math.sin(turned), Math.cos(turned)) * 180) / Math.PI)) / 2);
  }
});
const arrowInObject = (rod) => { const tip = panels.toObject(...handles().arrow); return [tip[0] - rod[0], tip[1] - rod[1]]; };
for (const end of ["pointerup", "pointercancel"]) panels.canvas.addEventListener(end, () => { grabbed = null; begun = performance.now(); });

function animate(now) {
  if (playing && !grabbed && latest) {
    const done = Math.max(0, now - begun) / CYCLE_MS;
    panels.at(Math.floor(done) % latest.courses.length, done % 1);
    document.body.dataset.frames = String(Number(document.body.dataset.frames ?? 0) + 1);
  }
  requestAnimationFrame(animate);
}

const actions = {
  play() {
    playing = !playing;
    begun = performance.now();
    find("play").textContent = playing ? "Pause" : "Play";
    find("play").setAttribute("aria-pressed", String(playing));
    if (!playing && latest) panels.at(0, 0);
  },
  keep() {
    before = before ? null : latest;
    find("keep").textContent = before ? "Drop “before”" : "Keep as “before”";
    panels.show(latest, before, measured);
  },
  reset() {
    state.moved = {};
    for (const key of controls.keys()) show(key);
    update();
  },
  copy: () => navigator.clipboard.writeText(find("command").textContent)
    .then(() => { find("status").textContent = "copied"; }, () => { find("status").textContent = "copy it from the line below"; }),
  async save() {
    const { start_deg: _, ...settings } = state.moved;
    const { text, refused } = await ask("protocol", { settings });
    if (refused) { find("headline").textContent = refused; return; }
    const link = document.createElement("a");
    link.href = `data:application/toml;charset=utf-8,${encodeURIComponent(text)}`;
    link.download = "explored.toml";
    link.click();
  },
  theme() {
    const dark = getComputedStyle(document.documentElement).colorScheme === "dark";
    document.documentElement.dataset.theme = dark ? "light" : "dark";
    panels.redraw();
  },
};
for (const [name, act] of Object.entries(actions)) find(name).addEventListener("click", act);
document.addEventListener("keydown", (event) => {
  if (event.target.matches("input, button")) return;
  if (event.key === " ") { event.preventDefault(); actions.play(); }
  if (event.key === "b") actions.keep();
});
find("controls").addEventListener("submit", (event) => event.preventDefault());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => panels.redraw());

try {
  const { controls: list, measured: laid, material } = await ask("start", {});
  document.title = `${material} · cyclemap explore`;
  measured = laid;
  build([{ key: "start_deg", label: "start θ0", unit: "°", low: 0, high: 360, step: 1, group: "Start", value: 0 }, ...list]);
  for (const [key, text] of fragment) {
    if (controls.has(key) && Number.isFinite(Number(text))) state.moved[key] = Number(text);
  }
  for (const key of controls.keys()) show(key);
  await update();
  requestAnimationFrame(animate);
} catch (fault) {
  find("headline").textContent = `cyclemap explore does not answer: ${fault.message}`;
}
