// A map of the circle from cycles of the engine: cubics between samples, fixed points, density, staircase.

const TURN = 2 * Math.PI;
const CELLS = 360;

// Cubics through values and slopes at places in [0, 2 pi]; values go on by a turn.
class CircleMap {
  constructor(samples) {
    this.samples = samples.sort((a, b) => a.theta - b.theta);
    const first = this.samples[0];
    this.nodes = [...this.samples, { ...first, theta: first.theta + TURN, next: first.next + TURN }];
    this.jumps = [];
  }

  at(theta) {
    const turns = Math.floor(theta / TURN);
    const angle = theta - TURN * turns;
    let [low, high] = [0, this.nodes.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.nodes[middle].theta <= angle) low = middle; else high = middle;
    }
    return cubic(this.nodes[low], this.nodes[high], angle) + TURN * turns;
  }
}

function cubic(a, b, theta) {
  const h = b.theta - a.theta, t = (theta - a.theta) / h, u = 1 - t;
  const values = a.next * (1 + 2 * t) * u * u + b.next * (1 + 2 * u) * t * t;
  return values + h * t * u * (a.slope * u - b.slope * t);
}

function samplesAt(engine, theta) {
  const { next, slope, status } = engine.cycles(theta);
  const samples = theta.map((angle, index) => ({ theta: angle, next: next[index], slope: slope[index] }));
  return { status, samples };
}

// As many samples as it takes for cubics to be within `tolerance` midway of all, in value and, over the
// interval, in slope, which tells of a kink where the value does not; or intervals to be too short to tell:
// jumps. The map is whole where they sufficed. `alive` is awaited now and then, and ends it where it returns
// false; null then.
async function sampledMap(engine, count, tolerance, alive) {
  const { status, samples } = samplesAt(engine, range(count).map((index) => (TURN * index) / count));
  if (status < 1) return { status };
  const map = new CircleMap(samples);
  if (!tolerance) return { status, map };
  let open = map.nodes.slice(1).map((node, index) => [map.nodes[index], node]);
  while (open.length) {
    if (!(await alive())) return null;
    const some = open.slice(0, 48);
    open = open.slice(48);
    const tried = samplesAt(engine, some.map(([a, b]) => (a.theta + b.theta) / 2));
    if (tried.status < 1) return { status: tried.status };
    tried.samples.forEach((middle, index) => {
      const [a, b] = some[index];
      samples.push(middle);
      const width = b.theta - a.theta;
      const slope = (1.5 * (b.next - a.next)) / width - (a.slope + b.slope) / 4;
      const off = Math.abs(cubic(a, b, middle.theta) - middle.next);
      if (Math.max(off, (Math.abs(slope - middle.slope) * width) / 4) <= tolerance) return;
      // A kink leaves an error as small as what is left of the interval: no more is to be had there.
      if (width > LEAST_WIDTH) open.push([a, middle], [middle, b]);
      else if (Math.abs(b.next - a.next) > 1e-3) map.jumps.push(middle.theta);
    });
    if (samples.length > MOST_SAMPLES) break;
  }
  const sampled = new CircleMap(samples);
  return { status, map: Object.assign(sampled, { jumps: map.jumps, isWhole: open.length === 0 }) };
}
const LEAST_WIDTH = 1e-6, MOST_SAMPLES = 3000;

// Where the map gives an orientation back: {theta, multiplier, stable}; by the engine's cycles where one is given.
function fixedPoints(map, engine) {
  const heights = map.nodes.map(({ theta, next }) => next - theta);
  const points = [];
  const [low, high] = [Math.min(...heights) - 0.1, Math.max(...heights) + 0.1];
  for (let turns = Math.ceil(low / TURN); turns <= high / TURN; turns += 1) {
    for (let index = 0; index + 1 < map.nodes.length; index += 1) {
      const [a, b] = [map.nodes[index], map.nodes[index + 1]];
      const places = range(9).map((step) => a.theta + ((b.theta - a.theta) * step) / 8);
      const above = places.map((theta) => cubic(a, b, theta) - theta - TURN * turns);
      for (let step = 0; step < 8; step += 1) {
        if (above[step] > 0 === above[step + 1] > 0) continue;
        const height = (theta) => heightAt(a, b, engine, theta, turns);
        const point = crossing(height, places[step], places[step + 1], above[step]);
        if (point) points.push(point);
      }
    }
  }
  return points.sort((a, b) => a.theta - b.theta);
}

// How far the map lifts an orientation beyond so many turns, and the map's slope.
function heightAt(a, b, engine, theta, turns) {
  if (engine) {
    const { next, slope } = engine.cycles([theta]);
    return [next[0] - theta - TURN * turns, slope[0]];
  }
  const h = 1e-5 * (b.theta - a.theta);
  const slope = (cubic(a, b, theta + h) - cubic(a, b, theta - h)) / (2 * h);
  return [cubic(a, b, theta) - theta - TURN * turns, slope];
}

// Newton's method, kept between ends of which the first has the sign of `first`; null at a jump.
function crossing(of, low, high, first) {
  let theta = (low + high) / 2, value = 0, slope = 1;
  for (let step = 0; step < 60; step += 1) {
    [value, slope] = of(theta);
    if (value > 0 === first > 0) low = theta; else high = theta;
    const next = theta - value / (slope - 1);
    const kept = next >= low && next <= high ? next : (low + high) / 2;
    if (Math.abs(kept - theta) < 1e-12) break;
    theta = kept;
  }
  if (!(Math.abs(value) < 1e-6)) return null;
  return { theta: ((theta % TURN) + TURN) % TURN, multiplier: slope, stable: Math.abs(slope) < 1 };
}

// The stationary density at every degree, 1: uniform. Nystroem's method on places so near that a normal
// kernel's sum is exact to 1e-4 of its peak, unless degrees are to do; the balance by GMRES among densities
// without mass. Null where noise does not settle it.
function stationaryDensity(map, sigma, most = 8) {
  const slopes = map.nodes.map(({ slope }) => Math.abs(slope)).sort((a, b) => a - b);
  // All but the steepest fiftieth of the samples.
  const steepest = Math.max(1, ...slopes.slice(0, Math.ceil(0.98 * slopes.length)));
  const finer = Math.min(most, Math.max(1, Math.ceil((0.75 * steepest * TURN) / CELLS / sigma)));
  const count = CELLS * finer, h = TURN / count;
  const half = Math.ceil((6.5 * sigma) / h), width = 2 * half + 1;
  const first = new Int32Array(count), weight = new Float64Array(count * width);
  for (let j = 0; j < count; j += 1) {
    const image = map.at(h * j) / h, centre = Math.round(image);
    let sum = 0;
    for (let k = 0; k < width; k += 1) {
      const off = ((centre + k - half - image) * h) / sigma;
      sum += weight[j * width + k] = Math.exp(-0.5 * off * off);
    }
    for (let k = 0; k < width; k += 1) weight[j * width + k] /= sum;
    first[j] = (((centre - half) % count) + count) % count;
  }
  const carried = (from) => {
    const to = new Float64Array(count);
    for (let j = 0; j < count; j += 1) {
      for (let k = 0, i = first[j]; k < width; k += 1) {
        to[i] += weight[j * width + k] * from[j];
        i = i + 1 === count ? 0 : i + 1;
      }
    }
    return to;
  };
  const even = new Float64Array(count).fill(1);
  const unbalanced = (density) => {
    const moved = carried(density);
    return density.map((value, i) => value - moved[i]);
  };
  const tolerance = most > 1 ? 1e-9 : 1e-4;
  const change = gmres(unbalanced, carried(even).map((value) => value - 1), tolerance);
  return change && range(CELLS).map((cell) => Math.max(0, 1 + change[cell * finer]));
}

// Solve A x = b for b and x without mean; null where 240 directions do not suffice.
function gmres(apply, b, tolerance) {
  const dot = (x, y) => {
    let sum = 0;
    for (let i = 0; i < x.length; i += 1) sum += x[i] * y[i];
    return sum;
  };
  const norm = Math.sqrt(dot(b, b));
  if (norm < 1e-13 * b.length) return b.map(() => 0);
  const basis = [b.map((value) => value / norm)], columns = [], turns = [], rest = [norm];
  for (let k = 0; k < 240; k += 1) {
    const next = apply(basis[k]);
    const mean = next.reduce((sum, value) => sum + value, 0) / next.length;
    for (let i = 0; i < next.length; i += 1) next[i] -= mean;
    const column = [];
    for (const direction of basis) {
      const along = dot(next, direction);
      column.push(along);
      for (let i = 0; i < next.length; i += 1) next[i] -= along * direction[i];
    }
    const size = Math.sqrt(dot(next, next));
    for (let i = 0; i < k; i += 1) {
      const [c, s] = turns[i], above = column[i];
      column[i] = c * above + s * column[i + 1];
      column[i + 1] = c * column[i + 1] - s * above;
    }
    const radius = Math.hypot(column[k], size);
    const [c, s] = [column[k] / radius, size / radius];
    turns.push([c, s]);
    column[k] = radius;
    columns.push(column);
    rest.push(-s * rest[k]);
    rest[k] *= c;
    if (Math.abs(rest[k + 1]) < tolerance * norm || size === 0) {
      const y = rest.slice(0, k + 1);
      for (let i = k; i >= 0; i -= 1) {
        for (let j = i + 1; j <= k; j += 1) y[i] -= columns[j][i] * y[j];
        y[i] /= columns[i][i];
      }
      return b.map((_, i) => y.reduce((sum, share, j) => sum + share * basis[j][i], 0));
    }
    basis.push(next.map((value) => value / size));
  }
  return null;
}

// Orientations of noisy cycles, turns; the same for the same seed.
function staircaseOf(map, sigma, start, cycles, seed = 1) {
  let state = seed;
  const uniform = () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
  const path = [start];
  for (let n = 0; n < cycles; n += 1) {
    const normal = Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(TURN * uniform());
    path.push(map.at(path[n]) + sigma * normal);
  }
  return path.map((theta) => theta / TURN);
}
