// OR-Tools' routing model, as WebAssembly, on the min-max problem. See run.
//
//   minimise  sum of arcs + sum over agents of   linear      100 max(0, L - bound)
//                                                quadratic   max(0, L - bound)^2
//
// The package offers neither the global span's cost, by which min-max is usually put, nor a time limit:
// the search starts from GLOBAL_CHEAPEST_ARC and ends at its first local optimum. bound: there and back
// to the farthest city, which no solution is below. Lengths are integers, 10 000 to the unit.
import { readFileSync } from "node:fs";
import {
  BoundCost,
  DefaultRoutingSearchParameters,
  FirstSolutionStrategy,
  RoutingIndexManager,
  RoutingModel,
  initRouting,
} from "or-tools-wasm/routing";

const UNIT = 10000;

function fail(message) {
  console.error(`routing_or_tools: ${message}`);
  process.exit(2);
}

const [file, agentsText, countText = "5", span = "linear"] = process.argv.slice(2);
const agents = Number(agentsText);
const count = Number(countText);
if (!Number.isInteger(agents) || agents < 1) fail(`AGENTS: expected a whole number, got ${agentsText}`);
if (!Number.isInteger(count) || count < 1) fail(`COUNT: expected a whole number, got ${countText}`);
if (span !== "linear" && span !== "quadratic") fail(`SPAN: expected linear or quadratic, got ${span}`);

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

function boundSpans(way, bound) {
  for (let agent = 0; agent < agents; ++agent) {
    if (span === "linear") way.SetSoftSpanUpperBoundForVehicle(new BoundCost(bound, 100), agent);
    else way.SetQuadraticCostSoftSpanUpperBoundForVehicle(new BoundCost(bound, 1), agent);
  }
}

function longestTour(model, manager, assignment, points) {
  let longest = 0;
  for (let agent = 0; agent < agents; ++agent) {
    let length = 0;
    for (let at = model.Start(agent); !model.IsEnd(at); ) {
      const next = assignment.Value(model.NextVar(at));
      length += distance(points[manager.IndexToNode(at)], points[manager.IndexToNode(next)]);
      at = next;
    }
    longest = Math.max(longest, length);
  }
  return longest;
}

async function solve({ depot, points }) {
  const manager = new RoutingIndexManager(points.length, agents, depot);
  await manager.ready;
  const model = new RoutingModel(manager);
  await model.ready;
  const table = points.map((a) => points.map((b) => Math.round(UNIT * distance(a, b))));
  const arcs = model.RegisterTransitMatrix(table);
  model.SetArcCostEvaluatorOfAllVehicles(arcs);
  model.AddDimension(arcs, 0, 2 ** 31 - 1, true, "way");
  boundSpans(model.GetDimensionOrDie("way"), 2 * Math.max(...table[depot]));
  const parameters = DefaultRoutingSearchParameters();
  parameters.firstSolutionStrategy = FirstSolutionStrategy.GLOBAL_CHEAPEST_ARC;
  const assignment = await model.SolveWithParameters(parameters);
  return assignment ? longestTour(model, manager, assignment, points) : null;
}

await initRouting();
const instances = JSON.parse(readFileSync(file, "utf8")).slice(0, count);
let sum = 0;
let seconds = 0;
for (const [index, instance] of instances.entries()) {
  const start = process.cpuUsage();
  const longest = await solve(instance);
  const used = process.cpuUsage(start);
  const taken = (used.user + used.system) / 1e6;
  if (longest === null) fail(`instance ${index}: no solution`);
  console.log(`instance ${index}: longest ${longest.toFixed(4)}, ${taken.toFixed(1)} s of processor time`);
  sum += longest / instances.length;
  seconds += taken / instances.length;
}
console.log(
  `${agents} agents, ${instances[0].points.length} cities, ${instances.length} instances, ${span}: ` +
    `mean longest ${sum.toFixed(3)}, ${seconds.toFixed(1)} s`,
);
process.exit(0); // its threads would go on
