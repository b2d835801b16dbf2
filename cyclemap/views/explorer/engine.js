// The compiled engine in WebAssembly: a loop's record and tables in its memory, its cycles and their courses.
// Lengths in extents of the footprint, as in C; `values` are those of the sliders, by the keys of --set.

const RADIAN = Math.PI / 180;
const MOST_TASKS = 512, MOST_ROWS = 4096;

function numbersOf(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

async function compiled(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const whole = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const { instance } = await WebAssembly.instantiate(await new Response(whole).arrayBuffer(), {});
  instance.exports._initialize();
  return instance.exports;
}

class Engine {
  constructor(library, tables) {
    this.library = library;
    this.tables = tables;
    this.end = library.__heap_base.value;
    const { columns, layout, parts, pressed } = tables;
    const rooms = { pieces: numbersOf(tables.pieces), goals: numbersOf(tables.goals) };
    for (const [kind, given] of Object.entries({ parts, pressed })) {
      if (!given) continue;
      for (const [name, text] of Object.entries(given.tables)) rooms[`${kind}.${name}`] = numbersOf(text);
    }
    if (pressed) rooms.balance = new Float64Array(pressed.balance_size);
    this.at = { loop: this.reserve(layout.size), signal: this.reserve(16) };
    for (const [name, table] of Object.entries(rooms)) this.at[name] = this.reserve(table.byteLength);
    const { task, result } = columns;
    const sizes = { tasks: task.size, varied: 3, results: result.size, slopes: result.size };
    for (const [name, size] of Object.entries(sizes)) this.at[name] = this.reserve(8 * size * MOST_TASKS);
    this.at.rows = this.reserve(8 * columns.record.size * MOST_ROWS);
    this.view = new DataView(library.memory.buffer);
    this.numbers = new Float64Array(library.memory.buffer);
    for (const [name, table] of Object.entries(rooms)) this.numbers.set(table, this.at[name] / 8);
    this.pieces = rooms.pieces;
    this.balanced = "";
  }

  reserve(bytes) {
    const { memory } = this.library;
    const start = Math.ceil(this.end / 16) * 16;
    this.end = start + bytes;
    const missing = this.end - memory.buffer.byteLength;
    if (missing > 0) memory.grow(Math.ceil(missing / 65536));
    return start;
  }

  put(name, values) {
    const [place, kind] = this.tables.layout.fields[name];
    [values].flat().forEach((value, index) => {
      if (kind === "number") this.view.setFloat64(this.at.loop + place + 8 * index, value, true);
      else if (kind === "whole") this.view.setBigInt64(this.at.loop + place + 8 * index, BigInt(value), true);
      else this.view.setUint32(this.at.loop + place, value, true);
    });
  }

  // Write the loop that sliders tell of; the reason, in words for people, where there is none.
  set(values, accuracy) {
    const { tables } = this;
    const mm = 1e-3 / tables.unit;
    const { mu_a: along, mu_b: across, m0, n0 } = values;
    if (Math.hypot(m0 / along, n0 / across) >= 1) {
      return "The offset is larger than the friction: the floor would drive the object. " +
        "Choose m0 and n0 smaller.";
    }
    const scale = Math.sqrt(along) * Math.sqrt(across);
    const refused = this.press(values);
    if (refused) return refused;
    const ellipse = [along, across, m0, n0].map((friction) => friction / scale);
    this.put("object.friction", [...ellipse, values.phi_deg * RADIAN, ...tables.centre]);
    this.put("object.radius", values.pusher_radius_mm * mm);
    this.put("object.tolerance", tables.step_share * accuracy);
    const { size, geometry } = tables.columns.piece;
    this.hitch = [values.hitch_x_mm * mm, values.hitch_y_mm * mm];
    this.numbers.set(this.hitch, this.at.pieces / 8 + this.pieces.length - size + geometry);
    this.put("object.pieces", this.at.pieces);
    this.put("object.piece_count", this.pieces.length / size - 1);
    const touch = this.touched(values);
    if (!touch) return "A concave corner keeps the rod from that place: push elsewhere on the side.";
    this.put("start_piece", touch.piece);
    this.put("start_coordinate", touch.coordinate);
    this.put("direction", touch.normal + Math.PI + values.angle_deg * RADIAN);
    this.put("length", values.push_mm * mm);
    this.put("rod_friction", values.pusher_mu);
    this.put("pin_friction", tables.pin_friction);
    this.put("with_object", 1);
    this.put("goal_count", numbersOf(tables.goals).length / 2);
    this.put("goals", this.at.goals);
    return "";
  }

  // How the weight rests: by shares of it, or by the shapes of plate and floor.
  press(values) {
    const { parts, pressed } = this.tables;
    const of = (key) => values[key] ?? 0;
    const shapes = [["floor_dome", "floor_bow"], ["plate_dome", "plate_warp"]].map(([dome, bow]) => {
      const turned = 2 * RADIAN * of(`${bow}_deg`);
      return [of(dome), of(bow) * Math.cos(turned), of(bow) * Math.sin(turned)];
    });
    const isFlat = !pressed || (shapes.flat().every((number) => number === 0) && !pressed.has_field);
    const shares = parts.shares.map((name) => (name ? of(name) : 0));
    const shared = shares.reduce((sum, share) => sum + share, 0);
    if (!isFlat && shared > 0) {
      return "Loads inside, on rim or corners, and shapes of floor or plate both tell how it rests: " +
        "set one of them to 0.";
    }
    const most = 1 - parts.least_even;
    if (isFlat && shared > most + 1e-12) {
      return `Loads inside, on rim and corners come to ${shared.toFixed(2)}: ` +
        `together they may be ${most.toFixed(2)} at most.`;
    }
    const [kind, given] = isFlat ? ["parts", parts] : ["pressed", pressed];
    for (const [name, text] of Object.entries(given.record)) {
      this.put(`object.pressure.${name}`, [...numbersOf(text)]);
    }
    for (const name of ["rows", "nodes", "outline"]) {
      this.put(`object.pressure.${name}`, this.at[`${kind}.${name}`]);
    }
    if (isFlat) {
      const load = numbersOf(parts.record.load);
      shares.forEach((share, part) => {
        if (parts.shares[part]) load[part] = share;
      });
      load[0] = 1 - shared;
      if (parts.can_share) this.put("object.pressure.load", [...load]);
      return "";
    }
    this.put("object.pressure.table", this.at.balance);
    const [floor, plate] = shapes.map((shape) => shape.map((number) => pressed.bend_unit * number));
    this.put("object.pressure.floor", floor);
    this.put("object.pressure.plate", plate);
    if (this.balanced === JSON.stringify(shapes)) return "";
    this.balanced = "";
    const [load] = this.tables.layout.fields["object.pressure.load"];
    const rows = this.library.cm_balance(this.at.loop + load, this.at.balance);
    if (Number(rows) < pressed.table_count) {
      return "On shapes like these the weight finds no balance: choose smaller ones.";
    }
    this.balanced = JSON.stringify(shapes);
    return "";
  }

  // Where the rod first touches: piece of the contact curve, coordinate, normal.
  touched({ side = 0, fraction }) {
    const { semi_axes: axes, sides, lengths } = this.tables;
    if (axes) {
      const coordinate = 2 * Math.PI * fraction;
      const normal = Math.atan2(axes[0] * Math.sin(coordinate), axes[1] * Math.cos(coordinate));
      return { piece: 0, coordinate, normal };
    }
    const coordinate = fraction * lengths[side];
    const touched = sides.find((reach) => {
      return reach.side === side && reach.low <= coordinate && coordinate <= reach.high;
    });
    return touched && { piece: touched.piece, coordinate, normal: touched.normal };
  }

  start(theta) {
    const [c, s] = [Math.cos(theta), Math.sin(theta)];
    return [c * this.hitch[0] - s * this.hitch[1], s * this.hitch[0] + c * this.hitch[1]];
  }

  // The next orientation of each (lift, rad) and its slope; a status below 1 tells why not.
  cycles(theta) {
    const { task, result } = this.tables.columns;
    const { numbers, at, view } = this;
    const done = { next: new Float64Array(theta.length), slope: new Float64Array(theta.length), status: 1 };
    const outputs = result.size - result.pushed, ended = result.ended + 2;
    for (let from = 0; from < theta.length; from += MOST_TASKS) {
      const some = theta.slice(from, from + MOST_TASKS);
      some.forEach((angle, index) => {
        const [x, y] = this.start(angle);
        numbers.set([0, -x, -y, angle], at.tasks / 8 + task.size * index);
        numbers.set([y, -x, 1], at.varied / 8 + 3 * index);
      });
      view.setBigInt64(at.signal, 0n, true);
      view.setBigInt64(at.signal + 8, 0n, true);
      const count = BigInt(some.length), next = at.signal, stop = at.signal + 8;
      this.library.cm_run(at.loop, at.tasks, at.varied, count, 1n, at.results, at.slopes, next, stop);
      some.forEach((_, index) => {
        const row = at.results / 8 + result.size * index;
        done.status = Math.min(done.status, numbers[row + result.status]);
        done.next[from + index] = numbers[row + ended];
        done.slope[from + index] = numbers[at.slopes / 8 + outputs * index + ended - result.pushed];
      });
    }
    return done;
  }

  // Frames of the push and of the drag, spread over the rod's way: x, y in mm, theta in degrees, rod x, rod y
  // in mm.
  course(theta, frames) {
    const { record } = this.tables.columns;
    const { numbers, at } = this;
    const [x, y] = this.start(theta);
    numbers.set([0, -x, -y, theta], at.tasks / 8);
    const longest = this.view.getFloat64(at.loop + this.tables.layout.fields.length[0], true) / frames;
    const count = Number(this.library.cm_record(at.loop, at.tasks, longest, at.rows, BigInt(MOST_ROWS)));
    const strokes = [[], []];
    for (let row = 0; row < count; row += 1) {
      const of = (name, index = 0) => numbers[at.rows / 8 + record.size * row + record[name] + index];
      const places = [of("place"), of("place", 1), of("rod"), of("rod", 1)];
      const [px, py, rx, ry] = places.map((length) => 1e3 * this.tables.unit * length);
      strokes[of("stroke") === 0 ? 0 : 1].push([of("way"), px, py, of("theta") / RADIAN, rx, ry]);
    }
    return strokes.map((rows) => spread(rows, frames));
  }
}

function spread(rows, count) {
  const frames = [];
  let row = 0;
  for (let index = 0; index < count; index += 1) {
    const place = rows[0][0] + ((rows[rows.length - 1][0] - rows[0][0]) * index) / (count - 1);
    while (row + 2 < rows.length && rows[row + 1][0] < place) row += 1;
    const [low, high] = [rows[row], rows[Math.min(row + 1, rows.length - 1)]];
    const share = high[0] > low[0] ? Math.min((place - low[0]) / (high[0] - low[0]), 1) : 0;
    frames.push(low.slice(1).map((value, column) => value + share * (high[column + 1] - value)));
  }
  return frames;
}
