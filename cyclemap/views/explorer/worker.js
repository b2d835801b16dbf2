// What the page asks: one loop after another, first soon and roughly, then, if no other comes, as well as
// can be.

const range = (count) => Array.from({ length: count }, (_, index) => index);
const FRAMES = 18, COURSES = 8, STAIRCASE_POINTS = 1500;
// Accuracies of cycles, rad: while sliders move; of the map; of its fixed points.
const ROUGH = 1e-3, FINE = 1e-7, FINEST = 1e-10;
const MAP_TOLERANCE = 5e-7, REST_MS = 150, ROUGH_MS = 5;
const STOPPED = {
  MANY_STEPS: "The motion turns so abruptly that it takes too many steps: " +
    "take a floor nearer to isotropic, or a thicker outline.",
  NO_SLIP: "No slip of the rod balances this friction: lower the rod's friction, or the offset m0, n0.",
  POINTS_AWAY: "The push points away from the object: turn its direction into the side.",
  NOT_ALONE: "The rod gets stuck in a concave corner: push less far, or elsewhere.",
  RING_STOPS: "The ring's friction stops the object on its way back: put the ring farther from the centre.",
  CHATTERS: "The rod sticks and slips without end: change the friction a little.",
};
const NO_BALANCE = "The balance of forces cannot be solved here: take a floor nearer to isotropic.";

// Stories are looked for while questions are answered, so each has an engine of its own.
let engine = null, aside = null, newest = 0, roughCount = 24;
const pause = (ms) => new Promise((done) => { setTimeout(done, ms); });

onmessage = async ({ data }) => {
  if (data.wasm) {
    engine = new Engine(await compiled(data.wasm), data.tables);
    aside = new Engine(await compiled(data.wasm), data.tables);
    postMessage({ ready: true });
  } else if (data.stories) {
    postMessage({ stories: await stories(data) });
  } else {
    newest = data.id;
    await pause(0);
    const alive = async () => { await pause(0); return newest === data.id; };
    if (newest !== data.id) return;
    const rough = await answered(data, false, alive);
    if (rough) postMessage(rough);
    if (!rough || rough.refused) return;
    await pause(REST_MS);
    const fine = newest === data.id && (await answered(data, true, alive));
    if (fine) postMessage(fine);
  }
};

// The answer as the page draws it, or why there is none; null where a newer question has come.
async function answered({ id, values, start, cycles }, fine, alive) {
  const refusal = (status) => {
    const name = Object.keys(engine.tables.status).find((key) => engine.tables.status[key] === status);
    return { id, refused: STOPPED[name] ?? NO_BALANCE };
  };
  const refused = engine.set(values, fine ? FINE : ROUGH);
  if (refused) return { id, refused };
  const begun = performance.now();
  const made = await sampledMap(engine, fine ? 96 : roughCount, fine ? MAP_TOLERANCE : 0, alive);
  if (!made) return null;
  if (made.status < 1) return refusal(made.status);
  const { map } = made;
  // As many samples as there is time for.
  if (!fine) {
    const affordable = (roughCount * ROUGH_MS) / (performance.now() - begun);
    roughCount = Math.round(Math.min(96, Math.max(10, affordable)));
  }
  const sigma = values.noise_deg * RADIAN;
  if (fine) engine.set(values, FINEST);
  const points = fixedPoints(map, fine ? engine : null);
  engine.set(values, fine ? FINE : ROUGH);
  const density = stationaryDensity(map, sigma, fine ? 8 : 1);
  const path = staircaseOf(map, sigma, start, cycles);
  const every = Math.max(1, Math.ceil(cycles / STAIRCASE_POINTS));
  const orbit = [start], courses = [];
  for (const _ of range(fine ? COURSES : 1)) {
    const from = orbit[orbit.length - 1];
    courses.push(engine.course(from, FRAMES));
    orbit.push(map.at(from));
  }
  return {
    id, fine, density, courses,
    is_whole: fine && map.isWhole,
    samples: map.samples.length,
    jumps: map.jumps.map((theta) => theta / RADIAN),
    turn: range(CELLS + 1).map((degree) => (map.at(degree * RADIAN) - degree * RADIAN) / RADIAN),
    fixed_points: points.map(({ theta, ...point }) => ({ theta_deg: theta / RADIAN, ...point })),
    staircase: { every, turns: path.filter((_, index) => index % every === 0) },
    orbit: orbit.map((theta) => theta / RADIAN),
    milliseconds: performance.now() - begun,
  };
}

// Where the ring makes each of three stories, along the line from the object's origin: it locks in, it goes by
// a place that holds it up, it turns so that all directions are recorded alike. On the floor there is, else on
// the usual one.
async function stories({ values, floor, along, farthest }) {
  const told = {};
  for (const own of [{}, floor]) {
    const tried = [];
    for (const share of range(15).map((index) => (index + 0.7) / 14)) {
      const place = along.map((unit) => Math.round(10 * unit * share * farthest) / 10);
      const moved = { ...own, hitch_x_mm: place[0], hitch_y_mm: place[1] };
      await pause(0);
      const refused = aside.set({ ...values, ...moved }, ROUGH);
      const { status, map } = refused ? { status: 0 } : await sampledMap(aside, 32, 0);
      if (status < 1) continue;
      const density = stationaryDensity(map, values.noise_deg * RADIAN, 1);
      if (!density) continue;
      const points = fixedPoints(map, null);
      tried.push({ moved, points, peak: Math.max(...density) });
    }
    tried.sort((a, b) => a.peak - b.peak);
    const turning = tried.filter(({ points }) => points.length === 0);
    const peaked = turning.filter(({ peak }) => peak > 1.6);
    told.locks ??= tried.filter(({ points }) => points.some(({ stable }) => stable)).at(-1)?.moved;
    told.slips ??= peaked.at(-1)?.moved;
    told.even ??= turning.find(({ peak }) => peak < 1.6)?.moved;
  }
  return told;
}
