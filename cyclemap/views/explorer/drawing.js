// Five panels for one answer, and a moment of the loop in two of them.

const degrees = [0, 60, 120, 180, 240, 300, 360];
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const range = (n) => Array.from({ length: n }, (_, i) => i);
const wrap = (angle) => ((angle % 360) + 360) % 360;
const extremes = (values) => [Math.min(...values), Math.max(...values)];
const minus = (number, digits = 0) => number.toFixed(digits).replace("-", "−");

const TURN_TITLE = "Turn of one cycle; filled points attract, hollow ones repel";
const DENSITY_TITLE = "Where recorded orientations gather (1: uniform)";
const STAIRCASE_TITLE = "Staircase: θ0 over the pushes, with noise";

function figure(root, title, wide = false) {
  const box = root.appendChild(document.createElement("figure"));
  if (wide) box.className = "wide";
  const place = box.appendChild(document.createElement("div"));
  const caption = box.appendChild(document.createElement("figcaption"));
  caption.textContent = title;
  return { place, caption };
}

function dot(u, x, y, size, fill, edge) {
  const { ctx } = u;
  ctx.beginPath();
  ctx.arc(u.valToPos(x, "x", true), u.valToPos(y, "y", true), size * devicePixelRatio, 0, 7);
  ctx.fillStyle = fill;
  ctx.fill();
  if (edge) { ctx.lineWidth = 2 * devicePixelRatio; ctx.strokeStyle = edge; ctx.stroke(); }
}

// Curves now and before over an axis, and whatever `over` draws on top, inside the axes.
function chart(place, { xLabel, yLabel, yRange, xSplits, over, also = () => [], square = false, name }) {
  const axis = (label, splits) => ({
    label, labelSize: 22, size: 46, stroke: () => colour("ink"),
    font: "12px system-ui", labelFont: "13px system-ui",
    grid: { stroke: () => colour("line"), width: 1 }, ticks: { stroke: () => colour("line") },
    values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : minus(tick, Number.isInteger(tick) ? 0 : 2))),
    ...(splits ? { splits: () => splits } : {}),
  });
  const size = () => {
    const width = Math.max(place.clientWidth, 200);
    return { width, height: square ? width : 250 };
  };
  const around = (_, low, high) => {
    const [least, most] = [Math.min(low ?? 0, ...also()), Math.max(high ?? 1, ...also())];
    return uPlot.rangeNum(least, most, 0.08, true);
  };
  const u = new uPlot({
    ...size(), legend: { show: false }, cursor: { drag: { x: false, y: false } },
    scales: { x: { time: false, ...(xSplits ? { range: [0, 360] } : {}) }, y: { range: yRange ?? around } },
    axes: [axis(xLabel, xSplits), axis(yLabel, yRange && yRange[1] === 360 ? degrees : null)],
    series: [{}, { label: "before", stroke: () => colour("before"), width: 1.5, dash: [5, 4] },
      { label: name, stroke: () => colour("now"), width: 2 }],
    hooks: { draw: [(chart) => {
      const { left, top, width, height } = chart.bbox;
      chart.ctx.save();
      chart.ctx.beginPath();
      chart.ctx.rect(left, top, width, height);
      chart.ctx.clip();
      over(chart);
      chart.ctx.restore();
    }] },
  }, [[0, 1], [null, null], [null, null]], place);
  new ResizeObserver(() => u.setSize(size())).observe(place);
  return u;
}

// A polyline in the units of a chart.
function line(u, points, style, width, dash = []) {
  const { ctx } = u;
  ctx.beginPath();
  for (const [x, y] of points) ctx.lineTo(u.valToPos(x, "x", true), u.valToPos(y, "y", true));
  ctx.strokeStyle = style;
  ctx.lineWidth = width * devicePixelRatio;
  ctx.setLineDash(dash.map((d) => d * devicePixelRatio));
  ctx.stroke();
  ctx.setLineDash([]);
}

class Panels {
  constructor(root) {
    this.answer = this.before = this.measured = null;
    this.moment = { cycle: 0, part: 0 };
    const object = figure(root, "The object, to scale: push (solid path of the rod), then drag back (dashed)");
    this.objectCaption = object.caption;
    this.canvas = object.place.appendChild(document.createElement("canvas"));
    this.canvas.className = "object";
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "the object pushed and dragged back");
    new ResizeObserver(() => this.drawObject()).observe(this.canvas);
    const make = (title, options, wide) => {
      const { place, caption } = figure(root, title, wide);
      const u = chart(place, options);
      u.caption = caption;
      return u;
    };
    const around = { xSplits: degrees, xLabel: "orientation θ0 (°)" };
    this.cobweb = make("Cobweb: next orientation over orientation", {
      ...around, name: "map", square: true, yRange: [0, 360], yLabel: "next θ0 (°)",
      over: (u) => this.overCobweb(u),
    });
    this.turn = make(TURN_TITLE, {
      ...around, name: "turn", yLabel: "turn (°)",
      over: (u) => this.overTurn(u),
      also: () => (this.measured ? extremes(this.measured.turn) : []),
    });
    this.density = make(DENSITY_TITLE, { ...around, name: "density", yLabel: "density", over: () => {} });
    this.staircase = make(STAIRCASE_TITLE, {
      name: "θ0", xLabel: "push", yLabel: "θ0 (turns)",
      over: (u) => this.overStaircase(u),
      also: () => (this.measured?.staircase ? extremes(this.measured.staircase) : []),
    }, true);
  }

  show(answer, before = null, measured = null, word = "before") {
    Object.assign(this, { answer, before, measured });
    const laid = measured ? "; orange: measured" : "";
    const kept = before ? `; dashed: ${word}` : "";
    const circle = range(361);
    this.cobweb.setData([circle, circle.map(() => null), circle.map(() => null)]);
    this.turn.setData([circle, before ? before.turn : circle.map(() => null), answer.turn]);
    const closed = (drawn) => (drawn?.density ? [...drawn.density, drawn.density[0]] : circle.map(() => null));
    this.density.setData([circle, closed(before), closed(answer)]);
    this.density.caption.textContent = answer.density ? `${DENSITY_TITLE}${kept}`
      : "Noise this small does not settle which stable direction is visited how often";
    const { every, turns } = answer.staircase;
    const same = before && before.staircase.every === every;
    const earlier = turns.map((_, i) => (same ? before.staircase.turns[i] ?? null : null));
    this.staircase.setData([turns.map((_, i) => i * every), earlier, turns]);
    const may = "; shaded: where the stable one may lie, for what is known of this floor";
    this.turn.caption.textContent = `${TURN_TITLE}${answer.may_lie.length ? may : ""}${kept}${laid}`;
    this.staircase.caption.textContent = `${STAIRCASE_TITLE}${kept}${measured?.staircase ? laid : ""}`;
    this.fit();
    this.at(Math.min(this.moment.cycle, answer.courses.length - 1), this.moment.part);
  }

  redraw() {
    for (const u of [this.cobweb, this.turn, this.density, this.staircase]) u.redraw();
    this.drawObject();
  }

  // A moment of the loop: which cycle, and how much of it is done, 0 to 1; the first half is the push.
  at(cycle, part) {
    this.moment = { cycle, part };
    this.cobweb.redraw(false);
    this.drawObject();
  }

  overCobweb(u) {
    line(u, [[0, 0], [360, 360]], colour("quiet"), 1);
    if (!this.answer) return;
    // The map, as often as turns of it pass through the square.
    const drawn = [[this.before, "before", 1.5, [5, 4]], [this.answer, "now", 2, []]];
    for (const [answer, style, width, dash] of drawn) {
      if (!answer) continue;
      const lift = answer.turn.map((turn, i) => [i, i + turn]);
      const [lowest, highest] = extremes(lift.map(([, y]) => y / 360));
      for (let shift = Math.floor(lowest); shift <= highest; shift += 1) {
        line(u, lift.map(([x, y]) => [x, y - 360 * shift]), colour(style), width, dash);
      }
    }
    const { orbit } = this.answer;
    for (let n = 0; n <= this.moment.cycle && n + 1 < orbit.length; n += 1) {
      const turns = 360 * Math.floor(orbit[n] / 360);
      const from = orbit[n] - turns;
      const to = orbit[n + 1] - turns;
      const done = n < this.moment.cycle ? 1 : this.moment.part;
      const reached = from + (to - from) * Math.min(1, 1.25 * done);
      const across = from + (to - from) * Math.max(0, 5 * done - 4);
      for (const shift of [-360, 0, 360]) {
        line(u, [[from, from + shift], [from, reached + shift]], colour("measured"), 1.6);
        if (done <= 0.8) continue;
        line(u, [[from + shift, to + shift], [across + shift, to + shift]], colour("measured"), 1.6);
      }
      if (n === this.moment.cycle) dot(u, wrap(from), wrap(reached), 4, colour("measured"));
    }
    this.drawFixed(u, (theta) => theta);
  }

  overTurn(u) {
    const { ctx, bbox } = u;
    ctx.globalAlpha = 0.15;
    ctx.fillStyle = colour("now");
    for (const [low, high] of this.answer ? this.answer.may_lie : []) {
      for (const back of high > 360 ? [0, 360] : [0]) {
        const inside = [low - back, high - back].map((x) => Math.min(Math.max(x, 0), 360));
        const [from, to] = inside.map((x) => u.valToPos(x, "x", true));
        ctx.fillRect(from, bbox.top, to - from, bbox.height);
      }
    }
    ctx.globalAlpha = 1;
    if (this.measured) {
      const { theta, turn } = this.measured;
      ctx.globalAlpha = 0.45;
      theta.forEach((x, i) => dot(u, x, turn[i], 1.5, colour("measured")));
      ctx.globalAlpha = 1;
    }
    line(u, [[0, 0], [360, 0]], colour("quiet"), 1);
    this.drawFixed(u, () => 0);
  }

  overStaircase(u) {
    const path = this.measured?.staircase;
    if (!path) return;
    const every = Math.max(1, Math.floor(path.length / 1500));
    for (let i = 0; i < path.length; i += every) dot(u, i, path[i], 1.2, colour("measured"));
  }

  drawFixed(u, height) {
    for (const { theta_deg: theta, stable } of this.answer ? this.answer.fixed_points : []) {
      dot(u, theta, height(theta), 5, colour(stable ? "stable" : "unstable"), colour("stable"));
    }
  }

  // The square of the world (mm) that holds every frame of the answer.
  fit() {
    const { courses, scene } = this.answer;
    const reach = Math.max(...scene.outline.map(([x, y]) => Math.hypot(x, y)), Math.hypot(...scene.ring));
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    for (const [x, y, , rx, ry] of courses.flat(2)) {
      box[0] = Math.min(box[0], x - reach, rx - scene.rod_radius);
      box[1] = Math.min(box[1], y - reach, ry - scene.rod_radius);
      box[2] = Math.max(box[2], x + reach, rx + scene.rod_radius);
      box[3] = Math.max(box[3], y + reach, ry + scene.rod_radius);
    }
    const size = 1.06 * Math.max(box[2] - box[0], box[3] - box[1]);
    this.view = { x: (box[0] + box[2] - size) / 2, y: (box[1] + box[3] - size) / 2, size };
  }

  // From a point of the picture (CSS pixels) to the object's frame at the start of the push (mm), and back.
  toObject(px, py) {
    const { x, y, size } = this.view;
    const k = size / this.canvas.clientWidth;
    const [ox, oy, theta] = this.answer.courses[0][0][0];
    const dx = x + px * k - ox;
    const dy = y + size - py * k - oy;
    const a = (theta * Math.PI) / 180;
    return [Math.cos(a) * dx + Math.sin(a) * dy, -Math.sin(a) * dx + Math.cos(a) * dy];
  }

  toPicture([bx, by], pose = this.answer.courses[0][0][0]) {
    const { x, y, size } = this.view;
    const a = (pose[2] * Math.PI) / 180;
    const k = this.canvas.clientWidth / size;
    const across = pose[0] + Math.cos(a) * bx - Math.sin(a) * by;
    const up = pose[1] + Math.sin(a) * bx + Math.cos(a) * by;
    return [(across - x) * k, (y + size - up) * k];
  }

  drawObject() {
    if (!this.answer || !this.canvas.clientWidth) return;
    const { scene, courses } = this.answer;
    const { cycle, part } = this.moment;
    const width = this.canvas.clientWidth;
    this.canvas.width = this.canvas.height = Math.round(width * devicePixelRatio);
    const ctx = this.canvas.getContext("2d");
    ctx.scale(devicePixelRatio, devicePixelRatio);
    const world = [0, 0, 0];
    const path = (points, pose) => {
      ctx.beginPath();
      points.forEach((point, i) => ctx[i ? "lineTo" : "moveTo"](...this.toPicture(point, pose)));
    };
    const circle = (centre, radius, pose) => {
      const [x, y] = this.toPicture(centre, pose);
      ctx.beginPath();
      ctx.arc(x, y, radius, 0, 7);
    };
    const [push, drag] = courses[cycle];
    const stroke = part < 0.5 ? push : drag;
    const place = Math.min(Math.max(part < 0.5 ? 2 * part : 2 * part - 1, 0), 1) * (stroke.length - 1);
    const [low, share] = [Math.floor(place), place - Math.floor(place)];
    const pose = stroke[low].map((value, i) => value + share * ((stroke[low + 1] ?? stroke[low])[i] - value));
    const k = width / this.view.size;
    ctx.strokeStyle = colour("quiet");
    ctx.lineWidth = 1;
    path([[-6, 0], [6, 0]], world); ctx.stroke();
    path([[0, -6], [0, 6]], world); ctx.stroke();
    for (const [frames, dash] of [[push, []], [drag, [5, 4]]]) {
      ctx.setLineDash(dash);
      path(frames.map((frame) => frame.slice(3)), world);
      ctx.strokeStyle = colour("rod");
      ctx.stroke();
    }
    ctx.setLineDash([3, 3]);
    path(scene.outline, push[0]); ctx.closePath();
    ctx.strokeStyle = colour("before");
    ctx.stroke();
    ctx.setLineDash([]);
    path(scene.outline, pose); ctx.closePath();
    ctx.fillStyle = colour("body");
    ctx.fill();
    ctx.strokeStyle = colour("ink");
    ctx.lineWidth = 1.8;
    ctx.stroke();
    ctx.fillStyle = colour("quiet");
    ctx.font = "12px system-ui";
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    (scene.corners ?? []).forEach((corner, i, all) => {
      const next = all[(i + 1) % all.length];
      const middle = [0, 1].map((axis) => 0.42 * (corner[axis] + next[axis]));
      ctx.fillText(String(i), ...this.toPicture(middle, pose));
    });
    circle(scene.ring, Math.max(4, 1.3 * scene.rod_radius * k), pose);
    ctx.strokeStyle = colour("ring");
    ctx.stroke();
    circle(pose.slice(3), Math.max(2.5, scene.rod_radius * k), world);
    ctx.fillStyle = colour("rod");
    ctx.fill();
    if (part === 0 && this.arrow) {
      path([push[0].slice(3), this.arrow], world);
      ctx.strokeStyle = colour("rod");
      ctx.lineWidth = 2.5;
      ctx.stroke();
      circle(this.arrow, 6, world);
      ctx.fillStyle = colour("paper");
      ctx.fill();
      ctx.stroke();
    }
    const [from, to] = [push[0], push[push.length - 1]].map((frame) => frame.slice(3));
    const towards = (Math.atan2(to[1] - from[1], to[0] - from[0]) * 180) / Math.PI;
    const doing = part < 0.5 ? "push" : "drag back";
    const start = `orientation ${minus(wrap(push[0][2]), 1)}°, pushed towards ${minus(towards, 1)}°`;
    this.objectCaption.textContent = `Cycle ${cycle + 1}, ${doing}: ${start}. ` +
      "The rod’s way is solid while it pushes, dashed while it drags. Drag ring, rod or arrow to move them.";
  }
}
