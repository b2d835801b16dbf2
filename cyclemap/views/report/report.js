// The report's page: a scrubber through the cycles, a slider over precomputed rings; nothing is asked of anyone.
const { answer, rings, measured } = JSON.parse(document.getElementById("data").textContent);
const panels = new Panels(document.getElementById("panels"));
const find = (id) => document.getElementById(id);
const CYCLE_MS = 2600;
let shown = answer, playing = false, begun = 0;

function scrub(share) {
  const cycles = shown.courses.length;
  const done = Math.min(share * cycles, cycles - 1e-9);
  panels.at(Math.floor(done), done % 1);
}

function choose(number) {
  const ring = rings[number];
  find("ring-told").textContent = ring ? `${ring.ring_mm} mm${ring.refused ? `: ${ring.refused}` : `: ${ring.said[0]}`}` : "its place";
  shown = ring && !ring.refused ? ring : answer;
  panels.show(shown, shown === answer ? null : answer, measured, "ring at its place");
  scrub(find("moment").valueAsNumber);
  document.body.dataset.ring = String(number);
}

function animate(now) {
  if (!playing) return;
  const share = ((now - begun) / CYCLE_MS / shown.courses.length) % 1;
  find("moment").value = share;
  scrub(share);
  requestAnimationFrame(animate);
}

find("moment").addEventListener("input", () => { playing = false; scrub(find("moment").valueAsNumber); });
find("ring").addEventListener("input", () => choose(find("ring").valueAsNumber));
find("play").addEventListener("click", () => {
  playing = !playing;
  find("play").textContent = playing ? "Pause" : "Play";
  begun = performance.now() - find("moment").valueAsNumber * CYCLE_MS * shown.courses.length;
  requestAnimationFrame(animate);
});
choose(-1);
document.body.dataset.drawn = "true";
