// The page: sliders to values, values to the worker, its answers to panels; the newest wins.

const given = JSON.parse(document.getElementById("data").textContent);
const CYCLE_MS = 2600;
const find = (id) => document.getElementById(id);
const text = (id) => find(id).textContent;
const panels = new Panels(find("panels"));
const controls = new Map();
const state = { moved: {}, id: 0, before: null, latest: given.answer, asked: 0 };
const worker = new Worker(URL.createObjectURL(new Blob([text("worker")], { type: "text/javascript" })));
let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, begun = performance.now(), grabbed = null, ready = false;

function values() {
  const { start_deg: _, ...moved } = state.moved;
  return { ...given.values, ...moved };
}

// What the page was written with comes from Python; all else is computed here.
function update() {
  state.id += 1;
  state.asked = performance.now();
  remember();
  if (Object.keys(state.moved).length === 0) show({ ...given.answer, id: state.id });
  else if (ready) worker.postMessage({ id: state.id, values: values(), start: (startOf() * Math.PI) / 180, cycles: given.cycles });
}
const startOf = () => state.moved.start_deg ?? given.start_deg;

worker.onmessage = ({ data }) => {
  if (data.ready) {
    ready = true;
    if (Object.keys(state.moved).length) update();
    const { floor, along, farthest } = given.stories;
    worker.postMessage({ stories: true, values: given.values, floor, along, farthest });
  } else if (data.stories) {
    for (const [name, moved] of Object.entries(data.stories)) tell(name, moved);
  } else if (data.id === state.id || !data.fine) {
    if (data.id === state.id || !data.refused) show(data);
  }
};
worker.onerror = (fault) => { find("status").textContent = `The engine does not run in this browser: ${fault.message}`; };

function tell(name, moved) {
  const button = find(name);
  button.disabled = !moved;
  button.addEventListener("click", () => {
    state.moved = Object.fromEntries(Object.entries(moved).filter(([key, value]) => controls.has(key) && Math.abs(value - controls.get(key).value) > 1e-9));
    for (const key of controls.keys()) place(key);
    begun = performance.now();
    update();
  });
}

function show(answer) {
  const headline = find("headline");
  state.shown = answer.id;
  headline.classList.toggle("refused", "refused" in answer);
  if (answer.refused) {
    headline.textContent = answer.refused;
    find("said").textContent = "The pictures show the last settings that could be computed.";
    document.body.dataset.drawn = `${answer.id}-refused`;
    return;
  }
  const drawn = answer.scene ? answer : { ...answer, may_lie: [], scene: scene(), said: said(answer) };
  state.latest = drawn;
  panels.arrow = arrow(drawn);
  headline.textContent = drawn.said[0];
  find("said").textContent = [...drawn.said.slice(1), ...ringOutside(drawn.scene)].join(" ");
  find("command").textContent = command();
  panels.show(drawn, state.before, given.measured);
  requestAnimationFrame(() => setTimeout(() => {
    if (state.shown !== answer.id) return;
    document.body.dataset.milliseconds = (performance.now() - state.asked).toFixed(1);
    document.body.dataset.drawn = `${answer.id}-${answer.scene ? "written" : answer.fine ? "fine" : "rough"}`;
    globalThis.cyclemap = { answer: drawn, values: values() };
  }));
}

// The object in its own frame (mm), with ring and rod where the sliders have them.
function scene() {
  const { hitch_x_mm: x, hitch_y_mm: y, pusher_radius_mm: radius } = values();
  return { ...given.answer.scene, ring: [x, y], rod_radius: radius };
}

function ringOutside({ outline, ring: [x, y] }) {
  const crossed = outline.filter(([ax, ay], index) => {
    const [bx, by] = outline[(index + 1) % outline.length];
    return ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay);
  });
  return crossed.length % 2 ? [] : ["The ring lies outside the object: it needs an arm there."];
}

function said({ fixed_points: points, density, staircase, courses, turn, fine, jumps, samples, is_whole: whole }) {
  const [push] = courses[0];
  const facing = push[0][2];
  const [from, to] = [push[0], push[push.length - 1]].map((frame) => frame.slice(3));
  const towards = (theta) => signed(Math.atan2(to[1] - from[1], to[0] - from[0]) / (Math.PI / 180) + theta - facing);
  const stable = points.filter((point) => point.stable);
  const places = stable.map(({ theta_deg: theta }) => `orientation ${minus(theta, 1)}°, pushed towards ${minus(towards(theta), 1)}°`);
  const turned = Math.abs(staircase.turns[staircase.turns.length - 1] - staircase.turns[0]);
  const loose = stable.length > 0 && turned > 1.5;
  const sentences = [stable.length ? `${given.name} ${loose ? "rests at" : "locks into"} ${places.join(" and ")}` : `${given.name} locks into no direction`];
  if (stable.length) {
    const kept = Math.abs(stable[0].multiplier);
    sentences.push(`A cycle keeps ${kept.toFixed(3)} of a deviation from ${minus(stable[0].theta_deg, 1)}°${kept > 0.5 && kept < 1 ? `: half is gone after ${Math.ceil(Math.log(0.5) / Math.log(kept))}` : ""}.`);
  } else {
    const [low, high] = extremes(turn);
    sentences.push(`A cycle turns it by ${minus(low, 1)}° to ${minus(high, 1)}°${low * high > 0 && Math.min(Math.abs(low), Math.abs(high)) < 3 ? ": it is held up where it turns least" : ""}.`);
  }
  if (density) {
    const peak = Math.max(...density);
    sentences.push(peak < 1.25 ? `All directions are recorded almost alike, none more than ${peak.toFixed(2)} times as often as on average: no bias to speak of.`
      : `${density.indexOf(peak)}° is recorded ${peak.toFixed(peak < 10 ? 1 : 0)} times as often as on average: the data are biased.`);
  }
  sentences.push(turned < 1.5 ? `In ${given.cycles} pushes with this noise it never gets around.` : `In ${given.cycles} pushes with this noise it gets around ${Math.round(turned)} times.`);
  if (jumps.length) sentences.push(`The map jumps near ${jumps.map((theta) => `${theta.toFixed(1)}°`).join(", ")}: nothing there is smoothed.`);
  const sketched = `A sketch from ${samples} cycles while you move: where the map is steep it may be far off.`;
  const short = `Computed here from ${samples} cycles, too few where the map is steepest: there it is not known to 1e-6 rad.`;
  sentences.push(whole ? "Computed here: the map to 1e-6 rad, fixed points to 1e-8 rad." : fine ? short : sketched);
  return sentences;
}
const signed = (angle) => wrap(angle + 180) - 180;

// The push as an arrow at the start of a cycle, in the world: from the rod towards where it goes.
function arrow({ courses }) {
  const push = courses[0][0];
  const [from, to] = [push[0].slice(3), push[push.length - 1].slice(3)];
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
  return [0, 1].map((i) => from[i] + (60 * (to[i] - from[i])) / length);
}

const plain = (number) => String(Number(number.toPrecision(10)));
function settings() {
  const { start_deg: _, ...moved } = state.moved;
  return { ...given.settings, ...Object.fromEntries(Object.entries(moved).map(([key, value]) => [key, plain(value)])) };
}

function command() {
  const quoted = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`);
  const words = Object.entries(settings()).flatMap(([key, value]) => ["--set", `${key}=${value}`]);
  return ["cyclemap", "portrait", ...given.words, ...words].map(quoted).join(" ");
}

function remember() {
  const kept = new URLSearchParams(state.moved).toString();
  // A page inside another has no address of its own.
  if (window === parent) history.replaceState(null, "", kept ? `#${kept}` : "#");
}

function move(key, value) {
  const control = controls.get(key);
  if (!control || !Number.isFinite(value)) return;
  const kept = Math.min(Math.max(value, control.low), control.high);
  if (Math.abs(kept - control.value) < 1e-9) delete state.moved[key];
  else state.moved[key] = kept;
  place(key);
  update();
}

function place(key) {
  const control = controls.get(key);
  const value = state.moved[key] ?? control.value;
  control.slider.value = value;
  control.number.value = value.toFixed(Math.max(0, -Math.floor(Math.log10(control.step))));
  control.row.classList.toggle("moved", key in state.moved);
}

function build(list) {
  const groups = new Map();
  for (const one of list) {
    if (!groups.has(one.group)) {
      const set = find("controls").appendChild(document.createElement("details"));
      set.open = ["Ring", "Floor", "Noise"].includes(one.group);
      set.appendChild(document.createElement("summary")).textContent = one.group;
      groups.set(one.group, set);
    }
    const row = groups.get(one.group).appendChild(document.createElement("div"));
    row.className = "slider";
    const label = row.appendChild(document.createElement("label"));
    label.textContent = one.unit ? `${one.label} (${one.unit})` : one.label;
    label.htmlFor = one.key;
    const input = (type, id) => Object.assign(row.appendChild(document.createElement("input")),
      { type, id, min: one.low, max: one.high, step: type === "range" ? one.step : "any" });
    const number = input("number", `${one.key}-number`);
    const slider = input("range", one.key);
    number.setAttribute("aria-label", label.textContent);
    controls.set(one.key, { ...one, row, slider, number });
    slider.addEventListener("input", () => move(one.key, slider.valueAsNumber));
    number.addEventListener("change", () => move(one.key, number.valueAsNumber));
  }
}

// Ring, contact and arrow can be dragged on the object itself, at the start of its push.
function handles() {
  const [push] = state.latest.courses[0];
  const world = [0, 0, 0];
  return { ring: panels.toPicture(state.latest.scene.ring), arrow: panels.toPicture(panels.arrow, world),
    contact: panels.toPicture(push[0].slice(3), world) };
}

function contactAt(point) {
  const { corners, semi_axes: axes } = state.latest.scene;
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
    const { contact, arrow: tip } = handles();
    const [rod, head] = [panels.toObject(...contact), panels.toObject(...tip)];
    const turned = Math.atan2(point[1] - rod[1], point[0] - rod[0]) - Math.atan2(head[1] - rod[1], head[0] - rod[0]);
    move("angle_deg", Math.round(2 * (values().angle_deg + signed((turned * 180) / Math.PI))) / 2);
  }
});
for (const end of ["pointerup", "pointercancel"]) panels.canvas.addEventListener(end, () => { grabbed = null; begun = performance.now(); });

function animate(now) {
  if (playing && !grabbed) {
    const done = Math.max(0, now - begun) / CYCLE_MS;
    panels.at(Math.floor(done) % state.latest.courses.length, done % 1);
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
    if (!playing) panels.at(0, 0);
  },
  keep() {
    state.before = state.before ? null : state.latest;
    find("keep").textContent = state.before ? "Drop “before”" : "Keep as “before”";
    panels.show(state.latest, state.before, given.measured);
  },
  reset() {
    state.moved = {};
    for (const key of controls.keys()) place(key);
    update();
  },
  copy: () => navigator.clipboard.writeText(text("command"))
    .then(() => { find("status").textContent = "copied"; }, () => { find("status").textContent = "copy it from the line beside"; }),
  save() {
    const lines = Object.entries(settings()).map(([key, value]) => `${key} = ${/^(-?[\d.]+(e[+-]?\d+)?|\[.*\])$/.test(value) ? value : JSON.stringify(value)}`);
    const link = document.createElement("a");
    link.href = `data:application/toml;charset=utf-8,${encodeURIComponent(`# cyclemap portrait ${given.words.join(" ")} --protocol FILE\n\n[explored]\n${lines.join("\n")}\n`)}`;
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
  if (event.target.matches("input, button, summary")) return;
  if (event.key === " ") { event.preventDefault(); actions.play(); }
  if (event.key === "b") actions.keep();
});
find("controls").addEventListener("submit", (event) => event.preventDefault());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => panels.redraw());

find("play").textContent = playing ? "Pause" : "Play";
build([{ key: "start_deg", label: "start θ0", unit: "°", low: 0, high: 360, step: 1, group: "Start", value: given.start_deg }, ...given.controls]);
for (const [key, told] of new URLSearchParams(location.hash.slice(1))) {
  if (controls.has(key) && Number.isFinite(Number(told))) state.moved[key] = Number(told);
}
for (const key of controls.keys()) place(key);
show({ ...given.answer, id: 0 });
// The engine starts once the first picture stands.
requestAnimationFrame(() => setTimeout(() => {
  worker.postMessage({ wasm: given.wasm, tables: given.tables });
  requestAnimationFrame(animate);
}));
