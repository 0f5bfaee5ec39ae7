// The parts of the page that are read.

import { h, table } from "./dom.js";
import { bytes, cleaned, count, percent, plain, plural, seconds, short, withUnit } from "./format.js";
import { convergence, histogram, phases, power } from "./plots.js";
import { asked, balance, degreeOf, ending, trust, what } from "./words.js";

const SIGNS = { good: "●", fair: "◐", poor: "○" };
const last = (run) => run.report.steps.at(-1);
const section = (id, title, ...children) => h("section", { id, "aria-labelledby": `${id}-title` }, h("h2", { id: `${id}-title` }, title), ...children);
const figures = (list) => list.map(([name, value, note]) => [h("dt", {}, name), h("dd", {}, value, note ? h("small", {}, note) : "")]);

/** The unit of a quantity by what it is of; none if that is not plain. */
function unitOf(scenario, units, name) {
  const q = scenario.quantities?.[name] ?? {};
  const field = q.average ?? q.maximum ?? q.value ?? q.total ?? (q.reaction ? "reaction" : "");
  if (/^(ux|uy|uz|displacement)$/.test(field)) return units.length;
  if (/^(s[xyz]{2}|von-mises)$/.test(field)) return units.stress;
  if (field === "strain-energy") return units.energy;
  return field === "reaction" || q.reaction ? units.force : field === "mass" ? units.mass : "";
}

/** The largest von Mises stress drawn of the last step. */
function peak(run) {
  const stress = run.steps.at(-1)?.sections.find((s) => s.name === "stress");
  return stress ? stress.limits[0][1] : null;
}

/** The answers of a run: what came out, in figures. */
function outcome(run) {
  const { report, scenario } = run;
  const units = report.units ?? {};
  const step = last(run);
  const rows = Object.entries(step.quantities).map(([name, q]) => {
    const unit = unitOf(scenario, units, name);
    const expected = report.expectations?.[name];
    const met = expected && `${expected.passed ? "as expected" : "not as expected"}: ${expected.between ? `between ${expected.between.map(plain).join(" and ")}` : `${plain(Number(expected.expected.toPrecision(6)))} ± ${plain(Number(expected.allowed.toPrecision(2)))}`}`;
    const corrected = q.computed !== undefined && q.computed !== q.value && `corrected by its estimated error, ${short(q.computed, 6)} without`;
    const note = [what(scenario.quantities?.[name]), corrected, met].filter(Boolean).join("; ");
    const bar = q.error === undefined ? "" : ` ± ${short(q.error, 2)}`;
    return [name, withUnit(`${short(q.value, q.error === undefined ? 5 : 6)}${bar}`, unit), note];
  });
  rows.push(["Largest displacement", withUnit(short(step.max_displacement, 4), units.length)]);
  if (peak(run) !== null) rows.push(["Largest von Mises stress", withUnit(short(peak(run), 4), units.stress), "recovered, at a point; at sharp inner edges it has no limit"]);
  rows.push(["Strain energy", withUnit(short(step.strain_energy, 5), units.energy)]);
  return h("dl", {}, figures(rows));
}

/** How to read the units. */
export function unitsLine({ report }) {
  const units = Object.entries(report.units ?? {});
  return units.length ? `Units: ${units.map(([of, unit]) => `${of} in ${unit}`).join(", ")}.` : "Numbers are in the units of the scenario, which names none.";
}

/** The first screen: what was run, what came out, whether to trust it. */
export function answers(data) {
  const run = data.runs.at(-1);
  const several = data.runs.length > 1;
  const { verdict, headline, reasons } = trust(run);
  const of = several ? ` (${run.name})` : "";
  const sentences = asked(run);
  return h("div", { class: "answers" },
    section("asked", "What was run", sentences.slice(0, -1).map((p) => h("p", {}, p)),
      h("details", {}, h("summary", {}, "How it was analysed"), h("p", {}, sentences.at(-1)), several ? data.runs.map((r) => h("p", {}, `${r.name}: ${ending(r)}`)) : h("p", {}, ending(run)))),
    several ? section("compared", "What the comparison shows", versus(data)) : null,
    section("outcome", `What came out${of}`, outcome(run), h("p", { class: "small" }, unitsLine(run))),
    section("trust", `How far to trust it${of}`, badge(verdict, headline),
      h("ul", {}, reasons.map((r) => h("li", {}, r)))));
}

const badge = (verdict, ...words) => h("p", { class: `verdict ${verdict}` }, h("span", { "aria-hidden": "true" }, SIGNS[verdict]), h("strong", {}, words));

/** The verdict in a line, for the top of the page. */
export function summary(data) {
  const run = data.runs.at(-1);
  const { verdict, headline } = trust(run);
  return h("a", { href: "#trust", class: "summary" }, badge(verdict, data.runs.length > 1 ? `${run.name}: ` : "", headline));
}

/** Runs beside each other in a sentence and a small table. */
function versus({ runs, ratios }) {
  const rows = runs.map((run) => [run.name, percent(last(run).error.relative), count(last(run).cells), count(last(run).free_dofs), seconds(run.report.steps.reduce((t, x) => t + x.seconds.total - x.seconds.write, 0))]);
  const equal = ratios?.equal_error;
  const parts = equal && equal.error !== null && equal.error !== undefined
    ? [equal.unknowns && `${short(equal.unknowns, 3)} times the unknowns`, equal.seconds && `${short(equal.seconds, 3)} times the time`].filter(Boolean) : [];
  return [
    parts.length ? h("p", {}, `For an error of ${percent(equal.error)}, global refinement needs ${parts.join(" and ")} of adaptive refinement.`) : null,
    equal?.reason ? h("p", {}, `Not at equal error: ${equal.reason}.`) : null,
    table("At the end of each run", ["", "error", "cells", "unknowns", "computing"], rows),
  ];
}

/** All that is below the picture. */
export function story(data) {
  const { runs } = data;
  const degree = Math.min(...runs.map((run) => degreeOf(run.scenario)));
  const several = runs.length > 1;
  const plots = ["dofs", "seconds", ...(several ? ["memory"] : [])].map((cost) => (runs.some((r) => r.report.steps.length > 1) || several ? convergence(runs, cost, degree) : null)).filter(Boolean);
  return h("div", { class: "story" },
    warnings(runs),
    section("forces", "Forces", runs.map((run) => forces(run, several))),
    section("convergence", "What refinement did", plots.length ? h("div", { class: "figures" }, plots) : h("p", {}, "There was one mesh, so there is no curve to draw."), runs.map(steps)),
    section("mesh", "The cells", runs.map((run) => [several ? h("h3", {}, run.name) : null, histograms(run)])),
    section("cost", "Time and memory", h("div", { class: "figures" }, runs.map(phases)), runs.map(cost)),
    section("repeat", "How to repeat it", repeat(data)));
}

function warnings(runs) {
  const all = runs.flatMap((run) => run.report.warnings.map((w) => (runs.length > 1 ? `${run.name}: ${w}` : w)));
  const unique = [...new Set(all)];
  return section("warnings", "Warnings", unique.length ? h("ul", { class: "warnings" }, unique.map((w) => h("li", {}, w))) : h("p", {}, "None."));
}

function forces(run, several) {
  const { reactions } = last(run);
  const unit = run.report.units?.force;
  const { sum, text } = balance(run);
  const scale = Math.max(...Object.values(reactions).flat().map(Math.abs), 1e-300);
  const row = (name, v) => [name, ...cleaned(v, scale).map((x) => short(x, 6))];
  const title = `Reactions of the supports${several ? `, ${run.name}` : ""}${unit ? `, in ${unit}` : ""}`;
  return [h("p", {}, text), table(title, ["", "x", "y", "z"], [...Object.entries(reactions).map(([n, v]) => row(n, v)), row("sum", sum)])];
}

function steps(run) {
  const names = Object.keys(last(run).quantities);
  const truth = last(run).error.true_relative !== null && last(run).error.true_relative !== undefined;
  const head = ["step", "cells", "unknowns", "estimated error", ...(truth ? ["true error"] : []), "largest displacement", "strain energy", ...names];
  const rows = run.report.steps.map((s) => [String(s.step), count(s.cells), count(s.free_dofs), percent(s.error.relative), ...(truth ? [percent(s.error.true_relative)] : []),
    short(s.max_displacement, 5), short(s.strain_energy, 6), ...names.map((n) => `${short(s.quantities[n]?.value, 6)}${s.quantities[n]?.error === undefined ? "" : ` ± ${short(s.quantities[n].error, 2)}`}`)]);
  return table(run.name ? `Steps, ${run.name}` : "Steps", head, rows);
}

function histograms(run) {
  const [first, end] = [run.steps[0], run.steps.at(-1)];
  const pair = (make) => (first === end ? [make(first, 1)] : [make(first, 0), make(end, 1)]);
  const name = (step) => `step ${step.step}`;
  const angle = histogram("Smallest angle of each cell", "degrees", pair((step, colour) => ({ name: name(step), colour, from: 0, width: 2, counts: step.quality_counts })), (x) => String(x));
  const errors = [first, end].every((step) => step.error_counts.length)
    ? histogram("Estimated error of each cell", "energy norm", pair((step, colour) => ({ name: name(step), colour, log: true, from: step.error_from, width: 0.25, counts: step.error_counts })), power) : null;
  const q = last(run).quality;
  return [h("div", { class: "figures" }, angle, errors), h("p", { class: "small" }, `Worst angle ${short(q.worst, 3)}°, mean ${short(q.average, 3)}°. At most ${count(q.max_valence)} cells meet at a vertex.${q.inverted ? ` ${plural(q.inverted, "cell")} inverted.` : ""}`)];
}

function cost(run) {
  const { solver } = last(run);
  const parts = [`${run.name ? `${run.name}: ` : ""}${seconds(run.report.seconds_total)} in all on ${plural(run.report.threads, "thread")}, at most ${bytes(run.report.peak_memory_bytes)} of memory.`,
    `The last system was solved by ${{ "amg-cg": "conjugate gradients with multigrid", direct: "sparse Cholesky factorisation" }[solver.method] ?? solver.method}`,
    solver.iterations ? `in ${plural(solver.iterations, "iteration")}` : "", `to a residual of ${short(solver.residual, 2)}.`];
  return h("p", {}, parts.filter(Boolean).join(" "));
}

function repeat({ runs }) {
  const [run] = runs;
  const quoted = (text) => (/^[\w./=:@%+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
  const verb = runs.length > 1 ? "compare" : "run";
  // Runs of several elements override it themselves.
  const elements = runs.length > 1 && runs.every(({ name }) => /^(hex|catmull)/.test(name)) ? ` --elements ${runs.map(({ name }) => name).join(",")}` : "";
  const own = elements ? run.overrides.filter((o) => !o.startsWith("analysis.element")) : run.overrides;
  const sets = own.map((o) => ` --set ${quoted(o)}`).join("");
  return [
    h("p", {}, `Made by ${run.report.program}.${runs.length > 1 ? "" : " The folder of this page holds scenario.toml, the scenario as it was run; so does this repeat it:"}`),
    runs.length > 1 ? h("pre", {}, h("code", {}, `subsolid ${verb} ${quoted(run.report.scenario)}${elements}${sets}`)) : h("pre", {}, h("code", {}, `subsolid run scenario.toml --output again`)),
    runs.length > 1 ? h("p", {}, "Each run has its files in a folder of its name.") : h("p", {}, "It was started as ", h("code", {}, `subsolid run ${quoted(run.report.scenario)}${sets}`), ". The same input gives the same numbers on any number of threads."),
    h("details", {}, h("summary", {}, "What is in this page"), h("p", {}, "Surfaces of all steps, inner cells up to 50,000 a step, in codes of 16 bits between the least and largest value of each kind; all else is in report.json and the .vtu files of the run (unless output.vtk is false), which ParaView opens."),
      h("pre", { class: "licence" }, document.getElementById("licence").textContent)),
  ];
}

