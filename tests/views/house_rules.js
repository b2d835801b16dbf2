// What breaks the rules of the page's scripts, a line each, told by the parser that Node brings.
// The files of a page or of a worker are one script: names are declared in any of them.
//
//     node --expose-internals house_rules.js FILE ...

const { readFileSync } = require("fs");
const acorn = require("internal/deps/acorn/acorn/dist/acorn");
const { full } = require("internal/deps/acorn/acorn-walk/dist/walk");

const WIDEST = 120;
const BROWSER = ["ResizeObserver", "Worker", "clearTimeout", "devicePixelRatio", "document",
  "getComputedStyle", "history", "location", "matchMedia", "navigator", "onmessage", "parent",
  "postMessage", "requestAnimationFrame", "require", "uPlot", "window"];
const known = new Set([...BROWSER, ...Object.getOwnPropertyNames(globalThis)]);
const problems = [];
const declared = new Map();
const counts = new Map();
const changing = [];
const assigned = new Set();

function namesOf(pattern) {
  switch (pattern?.type) {
    case "Identifier": return [pattern.name];
    case "Property": return namesOf(pattern.value);
    case "ObjectPattern": return pattern.properties.flatMap(namesOf);
    case "ArrayPattern": return pattern.elements.flatMap(namesOf);
    case "AssignmentPattern": return namesOf(pattern.left);
    case "RestElement": return namesOf(pattern.argument);
    default: return [];
  }
}

function visit(node, place) {
  const declare = (pattern) => namesOf(pattern).forEach((name) => declared.set(name, place));
  if (node.type === "Identifier") {
    counts.set(node.name, { times: (counts.get(node.name)?.times ?? 0) + 1, place });
  } else if (node.type === "VariableDeclaration") {
    if (node.kind === "var") problems.push(`${place}: var`);
    const names = node.declarations.flatMap(({ id }) => namesOf(id));
    node.declarations.forEach(({ id }) => declare(id));
    if (node.kind === "let") changing.push({ names, place });
  } else if (node.type.includes("Function")) {
    [node.id, ...node.params].forEach(declare);
  } else if (node.type === "ClassDeclaration") {
    declare(node.id);
  } else if (node.type === "AssignmentExpression") {
    namesOf(node.left).forEach((name) => assigned.add(name));
  } else if (node.type === "UpdateExpression") {
    assigned.add(node.argument.name);
  } else if (["==", "!="].includes(node.operator)) {
    problems.push(`${place}: ${node.operator} converts`);
  }
}

for (const file of process.argv.slice(2)) {
  const text = readFileSync(file, "utf8");
  text.split("\n").forEach((line, index) => {
    if (line.length > WIDEST) problems.push(`${file}:${index + 1}: wider than ${WIDEST}`);
  });
  const options = { ecmaVersion: "latest", locations: true, sourceType: "module" };
  full(acorn.parse(text, options), (node) => visit(node, `${file}:${node.loc.start.line}`));
}
for (const [name, { times, place }] of counts) {
  const isOurs = declared.has(name);
  if (!isOurs && !known.has(name)) problems.push(`${place}: ${name} is declared nowhere`);
  if (isOurs && times === 1 && name !== "_") problems.push(`${place}: ${name} is not used`);
}
for (const { names, place } of changing) {
  if (!names.some((name) => assigned.has(name))) problems.push(`${place}: let of what stays`);
}
problems.forEach((problem) => console.log(problem));
