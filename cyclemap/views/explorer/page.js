// The page: sliders to values, values to the worker, its answers to panels; the newest wins.

const given = JSON.parse(document.getElementById("data").textContent);
const CYCLE_MS = 2600;
const find = (id) => document.getElementById(id);
const text = (id) => find(id).textContent;
const panels = new Panels(find("panels"));
const controls = new Map();
const state = { moved: {}, id: 0, before: null, latest: given.answer, asked: 0 };
const worker = new Worker(URL.createObjectURL(new Blob([text("worker")], { type: "text/javascript" })));
let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
let begun = performance.now();
let grabbed = null;
let ready = false;

function values() {
  const { start_deg: _, ...moved } = state.moved;
  return { ...given.values, ...moved };
}

// What the page was written with comes from Python; all else is computed here.
function update() {
  state.id += 1;
  state.asked = performance.now();
  remember();
  if (Object.keys(state.moved).length === 0) {
    show({ ...given.answer, id: state.id });
  } else if (ready) {
    const start = (startOf() * Math.PI) / 180;
    worker.postMessage({ id: state.id, values: values(), start, cycles: given.cycles });
  }
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
worker.onerror = (fault) => {
  find("status").textContent = `The engine does not run in this browser: ${fault.message}`;
};

function tell(name, moved) {
  const button = find(name);
  button.disabled = !moved;
  button.addEventListener("click", () => {
    const differs = ([key, value]) => controls.has(key) && Math.abs(value - controls.get(key).value) > 1e-9;
    state.moved = Object.fromEntries(Object.entries(moved).filter(differs));
    for (const key of controls.keys()) place(key);
    begun = performance.now();
    update();
  });
}

function show(answer) {
  const headline = find("headline");
  state.shown = answer.id;
  headline.classList.toggle("refused", "refused" in answer);
  // What cannot be computed is no command, nor a file, to take away.
  for (const name of ["copy", "save"]) find(name).disabled = "refused" in answer;
  if (answer.refused) {
    headline.textContent = answer.refused;
    find("said").textContent = "Pictures and command are of the last settings that could be computed.";
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

// The verdict in sentences: where it locks in, how soon or how it turns, the data, the noise, what is open.
function said(answer) {
  const { staircase, density, jumps } = answer;
  const stable = answer.fixed_points.filter((point) => point.stable);
  const turned = Math.abs(staircase.turns[staircase.turns.length - 1] - staircase.turns[0]);
  const sentences = [locked(stable, turned, answer.courses[0][0])];
  sentences.push(stable.length ? kept(stable[0]) : turning(answer.turn));
  if (density) sentences.push(biased(density));
  const times = Math.floor(turned);
  const around = ["it never gets around", "it gets around once"][times] ?? `it gets around ${times} times`;
  sentences.push(`In ${given.cycles} pushes with this noise ${around}.`);
  if (jumps.length) {
    const places = jumps.map((theta) => `${theta.toFixed(1)}°`).join(", ");
    sentences.push(`The map jumps near ${places}: nothing there is smoothed.`);
  }
  sentences.push(known(answer));
  return sentences;
}

function locked(stable, turned, push) {
  if (stable.length === 0) return `${given.name} locks into no direction`;
  const [, , facing, ...from] = push[0];
  const to = push[push.length - 1].slice(3);
  const world = Math.atan2(to[1] - from[1], to[0] - from[0]) / (Math.PI / 180);
  const places = stable.map(({ theta_deg: theta }) => {
    return `orientation ${minus(theta, 1)}°, pushed towards ${minus(signed(world + theta - facing), 1)}°`;
  });
  return `${given.name} ${turned >= 1 ? "rests at" : "locks into"} ${places.join(" and ")}`;
}

function kept({ multiplier, theta_deg: theta }) {
  const share = Math.abs(multiplier);
  const half = Math.ceil(Math.log(0.5) / Math.log(share));
  const slow = share > 0.5 && share < 1 ? `: half is gone after ${half}` : "";
  return `A cycle keeps ${share.toFixed(3)} of a deviation from ${minus(theta, 1)}°${slow}.`;
}

function turning(turn) {
  const [low, high] = extremes(turn);
  const isHeldUp = low * high > 0 && Math.min(Math.abs(low), Math.abs(high)) < 3;
  const least = isHeldUp ? ": it is held up where it turns least" : "";
  return `A cycle turns it by ${minus(low, 1)}° to ${minus(high, 1)}°${least}.`;
}

function biased(density) {
  const peak = Math.max(...density);
  if (peak < 1.25) {
    const most = `none more than ${peak.toFixed(2)} times as often as on average`;
    return `All directions are recorded almost alike, ${most}: no bias to speak of.`;
  }
  const times = `${peak.toFixed(peak < 10 ? 1 : 0)} times as often as on average`;
  return `${density.indexOf(peak)}° is recorded ${times}: the data are biased.`;
}

function known({ samples, fine, is_whole: whole }) {
  if (whole) return "Computed here: the map to 1e-6 rad, fixed points to 1e-8 rad.";
  const cycles = `from ${samples} cycles`;
  if (!fine) return `A sketch ${cycles} while you move: where the map is steep it may be far off.`;
  return `Computed here ${cycles}, too few where the map is steepest: there it is not known to 1e-6 rad.`;
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
  const rounded = Object.entries(moved).map(([key, value]) => [key, plain(value)]);
  return { ...given.settings, ...Object.fromEntries(rounded) };
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
  if (!control) return;
  if (Number.isFinite(value)) {
    const kept = within(control, value);
    if (Math.abs(kept - control.value) < 1e-9) delete state.moved[key];
    else state.moved[key] = kept;
    update();
  }
  // A field without a number shows again what holds.
  place(key);
}

// What its slider can be moved to, of a value that is typed or linked to.
function within({ key, low, high }, value) {
  const whole = key === "side" ? Math.round(value) : value;
  return Math.min(Math.max(whole, low), high);
}

// What a link moves; the rest stays where the page was written.
function linked() {
  const moved = {};
  for (const [key, words] of new URLSearchParams(location.hash.slice(1))) {
    const value = words.trim() ? Number(words) : NaN;
    if (controls.has(key) && Number.isFinite(value)) moved[key] = within(controls.get(key), value);
  }
  return moved;
}

function place(key) {
  const control = controls.get(key);
  const value = state.moved[key] ?? control.value;
  control.slider.value = value;
  const rounded = value.toFixed(Math.max(0, -Math.floor(Math.log10(control.step))));
  // What lies between two steps is told as it is.
  control.number.value = Math.abs(rounded - value) < 1e-9 ? rounded : Number(value.toPrecision(5));
  control.row.classList.toggle("moved", key in state.moved);
}

function build(list) {
  const groups = new Map();
  for (const control of list) {
    if (!groups.has(control.group)) {
      const set = find("controls").appendChild(document.createElement("details"));
      set.open = ["Ring", "Floor", "Noise"].includes(control.group);
      set.appendChild(document.createElement("summary")).textContent = control.group;
      groups.set(control.group, set);
    }
    const row = groups.get(control.group).appendChild(document.createElement("div"));
    row.className = "slider";
    const label = row.appendChild(document.createElement("label"));
    label.textContent = control.unit ? `${control.label} (${control.unit})` : control.label;
    label.htmlFor = control.key;
    const input = (type, id) => Object.assign(row.appendChild(document.createElement("input")),
      { type, id, min: control.low, max: control.high, step: type === "range" ? control.step : "any" });
    const number = input("number", `${control.key}-number`);
    const slider = input("range", control.key);
    number.setAttribute("aria-label", label.textContent);
    controls.set(control.key, { ...control, row, slider, number });
    slider.addEventListener("input", () => move(control.key, slider.valueAsNumber));
    number.addEventListener("change", () => move(control.key, number.valueAsNumber));
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
  if (!corners) {
    const around = Math.atan2(point[1] / axes[1], point[0] / axes[0]);
    return { side: 0, fraction: wrap((around * 180) / Math.PI) / 360 };
  }
  const sides = corners.map((from, side) => {
    const to = corners[(side + 1) % corners.length];
    const along = [to[0] - from[0], to[1] - from[1]];
    const off = [point[0] - from[0], point[1] - from[1]];
    const share = (off[0] * along[0] + off[1] * along[1]) / (along[0] ** 2 + along[1] ** 2);
    const fraction = Math.min(Math.max(share, 0), 1);
    return { side, fraction, gap: Math.hypot(off[0] - fraction * along[0], off[1] - fraction * along[1]) };
  });
  return sides.reduce((nearest, side) => (side.gap < nearest.gap ? side : nearest));
}

panels.canvas.addEventListener("pointerdown", (event) => {
  panels.at(0, 0);
  const gaps = Object.entries(handles()).map(([handle, [x, y]]) => {
    return [Math.hypot(x - event.offsetX, y - event.offsetY), handle];
  });
  const [gap, name] = gaps.reduce((nearest, handle) => (handle[0] < nearest[0] ? handle : nearest));
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
    const { contact, arrow: end } = handles();
    const [rod, head] = [panels.toObject(...contact), panels.toObject(...end)];
    const towards = (tip) => Math.atan2(tip[1] - rod[1], tip[0] - rod[0]) / (Math.PI / 180);
    const turned = signed(towards(point) - towards(head));
    move("angle_deg", Math.round(2 * (values().angle_deg + turned)) / 2);
  }
});
for (const end of ["pointerup", "pointercancel"]) {
  panels.canvas.addEventListener(end, () => {
    grabbed = null;
    begun = performance.now();
  });
}

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
  async copy() {
    try {
      await navigator.clipboard.writeText(text("command"));
      find("status").textContent = "copied";
    } catch {
      find("status").textContent = "copy it from the line beside";
    }
  },
  save() {
    const isPlain = (value) => /^(-?[\d.]+(e[+-]?\d+)?|\[.*\])$/.test(value);
    const lines = Object.entries(settings()).map(([key, value]) => {
      return `${key} = ${isPlain(value) ? value : JSON.stringify(value)}\n`;
    });
    const use = `# cyclemap portrait ${given.words.join(" ")} --protocol FILE\n`;
    const link = document.createElement("a");
    const file = encodeURIComponent(`${use}\n[explored]\n${lines.join("")}`);
    link.href = `data:application/toml;charset=utf-8,${file}`;
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
window.addEventListener("hashchange", () => {
  state.moved = linked();
  for (const key of controls.keys()) place(key);
  update();
});
find("controls").addEventListener("submit", (event) => event.preventDefault());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => panels.redraw());

find("play").textContent = playing ? "Pause" : "Play";
const begin = { key: "start_deg", label: "start θ0", unit: "°", group: "Start", value: given.start_deg };
build([{ ...begin, low: 0, high: 360, step: 1 }, ...given.controls]);
state.moved = linked();
for (const key of controls.keys()) place(key);
show({ ...given.answer, id: 0 });
// The engine starts once the first picture stands.
requestAnimationFrame(() => setTimeout(() => {
  worker.postMessage({ wasm: given.wasm, tables: given.tables });
  requestAnimationFrame(animate);
}));
