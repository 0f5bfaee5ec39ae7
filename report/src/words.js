// The scenario and the outcome in sentences.

import { cleaned, count, list, percent, plain, plural, short, vector, withUnit } from "./format.js";

const ELEMENTS = {
  tet4: ["linear tetrahedra of four nodes", 1],
  tet10: ["quadratic tetrahedra of ten nodes", 2],
  hex8: ["trilinear hexahedra of eight nodes", 1],
  hex20: ["serendipity hexahedra of twenty nodes", 2],
  hex27: ["triquadratic hexahedra of 27 nodes", 2],
  "catmull-clark": ["cubic Catmull-Clark solids, whose shape and displacement are smooth", 3],
  "catmull-clark+": ["cubic Catmull-Clark solids with bubbles at the boundary", 3],
};

const SCHEMES = { sqrt3: "tetrahedral √3 subdivision", red: "splitting each cell in eight", "longest-edge": "bisection of longest edges" };

const SHAPES = {
  box: "a box", l_prism: "an L-shaped prism", "l-prism": "an L-shaped prism", fichera: "Fichera’s corner", cylinder: "a cylinder",
  tube: "a tube", "sphere-shell": "a shell between two spheres", "plate-with-hole": "a plate with a hole", le10: "the plate of benchmark LE10",
  prism: "a prism",
};

export const elementOf = (scenario) => scenario.analysis?.element ?? "tet10";
export const degreeOf = (scenario) => (ELEMENTS[elementOf(scenario)] ?? ["", 1])[1];

const number = (x) => (typeof x === "number" ? plain(x) : String(x));
const numbers = (v) => (Array.isArray(v) ? `(${v.map(number).join(", ")})` : number(v));

function body({ mesh = {} }) {
  if (mesh.file) return `the mesh ${String(mesh.file).split(/[\\/]/).at(-1)}`;
  const shape = Object.keys(mesh).find((key) => SHAPES[key]);
  const size = shape === "box" ? ` of ${mesh.box.size.map(number).join(" × ")}` : "";
  return shape ? `${SHAPES[shape]}${size}` : "a generated body";
}

function place(at) {
  if (at.group !== undefined) return `group “${at.group}”`;
  if (at.plane) return `the plane ${numbers(at.plane.normal)} · x = ${number(at.plane.offset ?? 0)}`;
  if (at.box) return `what lies between ${numbers(at.box.min)} and ${numbers(at.box.max)}`;
  if (at.sphere) return `what lies within ${number(at.sphere.radius)} of ${numbers(at.sphere.center)}`;
  if (at.cylinder) return `what lies within ${number(at.cylinder.radius)} of an axis through ${numbers(at.cylinder.point)}`;
  if (at.normal && at.normal.direction) return `faces that look along ${numbers(at.normal.direction)}`;
  if (at.any) return list(at.any.map(place));
  if (at.all) return at.all.map(place).join(", of that ");
  if (at.not) return `all but ${place(at.not)}`;
  if (at.meet) return "edges where two parts of the surface meet";
  return "part of the surface";
}

function held(support) {
  const words = [];
  if (support.fix === "normal") words.push("cannot move across its faces");
  else if (Array.isArray(support.fix)) words.push(`fixed in ${list(support.fix)}`);
  if (support.displacement === "exact" || support.fix === "exact") words.push("follows the known solution");
  else if (support.displacement) {
    const parts = Object.entries(support.displacement).map(([axis, value]) => `${axis} by ${number(value)}`);
    words.push(`moved in ${list(parts)}`);
  }
  const spring = support.spring ?? support.foundation ?? support.stiffness;
  if (spring !== undefined) words.push("on an elastic foundation");
  return words.length ? words.join(", ") : "held";
}

const KINDS = [
  ["force", "force", "in total, spread over"], ["traction", "traction", "per area on"], ["pressure", "pressure", "on"],
  ["gravity", "gravity", ""], ["acceleration", "acceleration", ""], ["body_force", "force per volume", ""], ["body-force", "force per volume", ""],
];

function acts(load, units) {
  for (const [key, word, where] of KINDS) {
    if (load[key] === undefined) continue;
    const unit = key === "force" ? units.force : key === "traction" || key === "pressure" ? units.stress : undefined;
    const at = load.point ? `at ${numbers(load.point)}` : where && `${where} ${place(load)}`;
    return `${word} ${withUnit(numbers(load[key]), unit)} ${at}`.trim();
  }
  return "a load";
}

const FIELDS = { "von-mises": "von Mises stress", displacement: "length of the displacement", ux: "displacement along x", uy: "displacement along y", uz: "displacement along z" };
const fieldName = (f) => FIELDS[f] ?? (/^s[xyz]{2}$/.test(f) ? `stress ${f.slice(1)}` : String(f).replaceAll("-", " "));

/** What a quantity is. */
export function what(q) {
  if (!q) return "";
  const where = q.point ? `at ${numbers(q.point)}` : q.region ? `in region “${q.region}”` : q.within ? "in a part of the body" : q.group !== undefined || q.plane || q.box ? `over ${place(q)}` : "over the body";
  if (q.average) return `average ${fieldName(q.average)} ${where}`;
  if (q.maximum) return `largest ${fieldName(q.maximum)} ${where}`;
  if (q.value) return `${fieldName(q.value)} ${where}`;
  if (q.total) return `total ${fieldName(q.total)}${q.region || q.within ? ` ${where}` : ""}`;
  return q.reaction ? `force of support “${q.reaction}” along ${q.component ?? "x, y, z"}` : "";
}

/** The unit vector along which a load acts on faces with this mean normal; null if it varies or is not known. */
export function direction(load, normal) {
  const v = load?.force ?? load?.traction ?? (typeof load?.pressure === "number" ? normal.map((n) => -n * load.pressure) : null);
  if (!Array.isArray(v) || v.some((x) => typeof x !== "number")) return null;
  const size = Math.hypot(...v);
  return size > 1e-9 ? v.map((x) => x / size) : null;
}

/** What was asked, in sentences. */
export function asked(run) {
  const { scenario, report } = run;
  const units = report.units ?? {};
  const out = [];
  if (scenario.description) out.push(scenario.description.trim());
  const materials = Object.entries(scenario.materials ?? {}).map(([name, m]) =>
    `“${name}” (Young’s modulus ${withUnit(plain(m.youngs_modulus), units.stress)}, Poisson’s ratio ${number(m.poissons_ratio)})`);
  out.push(`The body is ${body(scenario)}. ${materials.length === 1 ? "Material" : "Materials"}: ${list(materials)}.`);
  const supports = Object.entries(scenario.supports ?? {}).map(([name, support]) => `${name}: ${held(support)}, at ${place(support)}`);
  out.push(supports.length ? `It is held by ${plural(supports.length, "support")}: ${supports.join("; ")}.` : "Nothing holds it.");
  const loads = Object.entries(scenario.loads ?? {}).map(([name, load]) => `${name}: ${acts(load, units)}`);
  if (loads.length) out.push(`On it ${loads.length === 1 ? "acts" : "act"} ${plural(loads.length, "load")}: ${loads.join("; ")}.`);
  else if (!scenario.exact) out.push("No load acts; only the supports move it.");
  if (scenario.exact) out.push(`The exact solution is known (“${scenario.exact.solution}”); the body forces that it needs act too.`);
  out.push(method(run));
  return out;
}

/** How it was analysed and refined. */
export function method({ scenario }) {
  const [element] = ELEMENTS[elementOf(scenario)] ?? [elementOf(scenario)];
  const refine = scenario.refine ?? {};
  const { strategy, steps = 0, scheme = "sqrt3", stop = {} } = refine;
  let text = `Linear elasticity (small strains), with ${element}`;
  if (scenario.analysis?.smooth) text += ", on a solid that smooth tetrahedral/octahedral subdivision makes of the mesh";
  if (strategy === "none" || steps === 0) return `${text}, on one mesh that was not refined.`;
  const hexes = /^(hex|catmull)/.test(elementOf(scenario));
  const all = strategy === "global" || hexes;
  text += `; refined ${all ? "everywhere" : "where the error estimate asks for it"}, ${hexes ? "each cell into eight" : `by ${SCHEMES[scheme] ?? scheme}`}, in up to ${plural(steps, "step")}`;
  const rules = [];
  if (stop.relative_error) rules.push(`the estimated relative error is at most ${percent(stop.relative_error)}`);
  if (stop.quantity_error) rules.push(`the error of “${scenario.adapt?.goal}” is small enough`);
  if (stop.max_cells) rules.push(`a mesh has ${count(stop.max_cells)} cells`);
  if (stop.seconds) rules.push(`${stop.seconds} s are over`);
  if (stop.max_memory) rules.push("memory would run out");
  return `${text}${rules.length ? `, or until ${list(rules)}` : ""}.`;
}

/** Why the run ended. */
export function ending({ scenario, report }) {
  const last = report.steps.at(-1);
  const stop = scenario.refine?.stop ?? {};
  const why = {
    steps: scenario.refine?.strategy === "none" || !scenario.refine?.steps ? "nothing was to be refined" : report.warnings.some((w) => w.startsWith("marking selected no cell"))
      ? "no cell was selected for refinement" : `all ${plural(scenario.refine.steps, "step")} asked for ${scenario.refine.steps === 1 ? "was" : "were"} made`,
    relative_error: `the estimated relative error, ${percent(last.error.relative)}, is below the ${percent(stop.relative_error)} asked for`,
    quantity: "the quantity aimed at is exact enough",
    max_cells: `the mesh has the ${count(stop.max_cells ?? 0)} cells at which refinement ends`,
    max_memory: "the next step would need more memory than there is",
    seconds: "the time was up",
    exact: "the estimated error is rounding",
    straight_edges: "refined meshes have straight edges, which alone exceed the error asked for",
    zero: "the quantity aimed at is zero within its error bar",
    interrupted: "it was interrupted",
  }[report.stop_reason] ?? report.stop_reason;
  return `It ended after ${last.step === 0 ? "the first mesh" : `step ${last.step}`}, with ${plural(last.cells, "cell")}: ${why}.`;
}

/** The rate at which an error falls with unknowns, between two steps. */
export function rate(a, b) {
  const slope = -Math.log(b.error.relative / a.error.relative) / Math.log(b.free_dofs / a.free_dofs);
  return Number.isFinite(slope) ? slope : null;
}

/** How far the result can be trusted: a verdict of `good`, `fair` or `poor`, a headline, and reasons. */
export function trust(run) {
  const { scenario, report } = run;
  const last = report.steps.at(-1);
  const { relative, true_relative: truth } = last.error;
  const failed = Object.entries(report.expectations ?? {}).filter(([, e]) => !e.passed);
  const stop = scenario.refine?.stop ?? {};
  const goal = Object.entries(last.quantities).find(([, q]) => q.error !== undefined);
  const reached = ["relative_error", "quantity"].includes(report.stop_reason);
  // Where the solution is known, the true error judges.
  const error = truth ?? relative;
  const asked = stop.relative_error ? `: ${percent(stop.relative_error)} was asked for, ${percent(relative)} reached` : stop.quantity_error && goal ? `: ${missing(stop.quantity_error, goal)}` : "";
  const missed = (stop.relative_error || stop.quantity_error) && !reached && !["exact"].includes(report.stop_reason);
  const reasons = [];
  let verdict, headline;
  if (failed.length) [verdict, headline] = ["poor", `Not as expected: ${list(failed.map(([name]) => `“${name}”`))} misses the value that the scenario expects.`];
  else if (relative === null) [verdict, headline] = ["poor", "The error of this result is not known."];
  else if (last.strain_energy === 0) [verdict, headline] = ["poor", "Nothing moves: no load acts, and no support moves the body."];
  else if (report.stop_reason === "interrupted") [verdict, headline] = ["poor", `Not finished: the run was interrupted after step ${last.step} of ${scenario.refine?.steps ?? last.step}.`];
  else if (missed) [verdict, headline] = ["poor", `The accuracy that was asked for was not reached${asked}.`];
  else if (reached) [verdict, headline] = ["good", "The accuracy that was asked for was reached."];
  else if (error > 0.2) [verdict, headline] = ["poor", "Rough: the mesh is too coarse for more than a first idea."];
  else if (error > 0.05) [verdict, headline] = ["fair", "Usable for deformations; stresses with care."];
  else if (unsettled(run)) [verdict, headline] = ["fair", "With care: the error is small, but the last refinement does not confirm it."];
  else [verdict, headline] = ["good", `Good: the ${truth === null || truth === undefined ? "estimated" : "true"} error is small.`];
  if (report.warnings.length && verdict === "good") verdict = "fair";
  if (report.warnings.length) reasons.push(`${plural(report.warnings.length, "warning")} below should be read first.`);
  reasons.push(`Estimated error ${percent(relative)} of the solution, in the energy norm, which weighs strains and stresses over the whole body.`);
  if (truth !== null && truth !== undefined) reasons.push(`The exact solution is known here: the true error is ${percent(truth)}; the estimate is ${short(last.error.effectivity, 3)} times that.`);
  const before = report.steps.at(-2)?.error.true_relative;
  if (truth > before) reasons.push(`The true error grew from ${percent(before)} with the last step: the body that is refined may not be that of the known solution.`);
  if (failed.length && missed) reasons.push(`The accuracy that was asked for was not reached either${asked}.`);
  if (report.stop_reason === "interrupted") reasons.push("The same command with --resume goes on with it.");
  if (goal) reasons.push(`“${goal[0]}” has an error bar of its own: ${short(goal[1].value, 6)} ± ${short(goal[1].error, 2)}.`);
  reasons.push(convergence(run));
  const passed = Object.keys(report.expectations ?? {}).length - failed.length;
  if (passed > 0) reasons.push(`${plural(passed, "expected value")} of the scenario ${passed === 1 ? "is" : "are"} met.`);
  return { verdict, headline, reasons: reasons.filter(Boolean) };
}

/** What was asked of a quantity and what was reached, in words. */
function missing(wanted, [name, q]) {
  const share = typeof wanted === "number" ? wanted : wanted.relative;
  if (share === undefined) return `an error bar of ${short(wanted.absolute, 3)} of “${name}” was asked for, ${short(q.error, 3)} reached`;
  return `${percent(share)} of “${name}” was asked for, ${percent(q.error / Math.abs(q.value))} reached`;
}

/** Whether the last step changed much, or its error did not fall. */
function unsettled({ report }) {
  const [before, last] = report.steps.slice(-2);
  if (!last) return false;
  const truth = (step) => step.error.true_relative ?? step.error.relative;
  return Math.abs(last.strain_energy / before.strain_energy - 1) > 0.05 || truth(last) >= truth(before);
}

function convergence({ scenario, report }) {
  const { steps } = report;
  if (steps.length < 2) return "One mesh only: no second one confirms the estimate. Refine (refine.steps) to see whether the numbers settle.";
  const [before, last] = steps.slice(-2);
  if (!(last.error.relative > 0)) return "";
  const slope = rate(before, last);
  const energy = Math.abs(last.strain_energy / before.strain_energy - 1);
  const settles = `The last refinement changed the strain energy by ${percent(energy)}`;
  if (slope === null) return `${settles}.`;
  if (slope <= 0) return `${settles}, but the estimate did not fall: do not rely on it yet.`;
  return `${settles}; the error falls like the unknowns to the power −${short(slope, 2)} (on smooth solutions these elements can do −${short(degreeOf(scenario) / 3, 2)}).`;
}

/** The forces at the supports beside the loads, where these are known: a sentence, and whether they balance. */
export function balance({ scenario, report }) {
  const last = report.steps.at(-1);
  const sum = Object.values(last.reactions).reduce((s, r) => s.map((x, i) => x + r[i]), [0, 0, 0]);
  const loads = Object.values(scenario.loads ?? {});
  const known = loads.length && loads.every((l) => Array.isArray(l.force) && l.force.every((x) => typeof x === "number"));
  const unit = report.units?.force;
  const scale = Math.max(...Object.values(last.reactions).flat().map(Math.abs), 1e-300);
  if (!known) return { sum, text: `Together the supports push with ${withUnit(vector(cleaned(sum, scale)), unit)}; the equations are solved to ${short(last.solver.residual, 2)} of the loads.` };
  const total = loads.reduce((s, l) => s.map((x, i) => x + l.force[i]), [0, 0, 0]);
  const off = Math.hypot(...sum.map((x, i) => x + total[i])) / Math.max(Math.hypot(...total), 1e-300);
  return { sum, text: `The loads are ${withUnit(`(${total.map(plain).join(", ")})`, unit)} in total, the supports push back with ${withUnit(vector(cleaned(sum, scale)), unit)}: ${off < 1e-5 ? `in balance, to ${short(off, 1)}` : `out of balance by ${percent(off)}`}.` };
}
