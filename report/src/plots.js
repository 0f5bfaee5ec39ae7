// Plots, as drawings that follow the page's colours, each with its numbers as a table.

import { decades, ticks } from "./colour.js";
import { h, s, table } from "./dom.js";
import { count, percent, plain, plural, seconds, short, withUnit } from "./format.js";

const share = (x) => withUnit(plain(Number((100 * x).toPrecision(3))), "%");

const BOX = { width: 460, height: 300, left: 58, right: 14, top: 28, bottom: 46 };

function figure(title, drawing, numbers) {
  return h("figure", {}, h("figcaption", {}, title), drawing, h("details", {}, h("summary", {}, "As a table"), numbers));
}

export const power = (x) => {
  const d = Math.round(x);
  if (Math.abs(x - d) > 1e-9) return plain(Number((10 ** x).toPrecision(2)));
  return d >= 0 && d < 7 ? count(10 ** d) : plain(Number((10 ** d).toPrecision(2)));
};

function axes(x, y, labels) {
  const { width, height, left, right, top, bottom } = BOX;
  const px = (v) => left + ((v - x.lo) / (x.hi - x.lo || 1)) * (width - left - right);
  const py = (v) => height - bottom - ((v - y.lo) / (y.hi - y.lo || 1)) * (height - top - bottom);
  const parts = [
    ...x.ticks.map((v) => [s("line", { class: "grid", x1: px(v), x2: px(v), y1: top, y2: height - bottom }), s("text", { class: "x", x: px(v), y: height - bottom + 16 }, x.word(v))]),
    ...y.ticks.map((v) => [s("line", { class: "grid", x1: left, x2: width - right, y1: py(v), y2: py(v) }), s("text", { class: "y", x: left - 7, y: py(v) + 4 }, y.word(v))]),
    s("text", { class: "x label", x: (left + width - right) / 2, y: height - 8 }, labels[0]),
    s("text", { class: "label", x: 2, y: 12 }, labels[1]),
  ];
  return { px, py, parts };
}

function logAxis(values, word = power) {
  let [lo, hi] = [Math.min(...values), Math.max(...values)];
  const pad = Math.max(0.06 * (hi - lo), 0.08);
  [lo, hi] = [lo - pad, hi + pad];
  return { lo, hi, ticks: decades(lo, hi), word };
}

/** The relative error of each step against what it cost; of unknowns with the best slope of smooth solutions. */
export function convergence(runs, cost, degree) {
  const label = { dofs: "unknowns", seconds: "seconds of computing", memory: "memory, MB" }[cost];
  const curves = runs.map((run) => {
    let spent = 0;
    return run.report.steps.map((step) => {
      const t = step.seconds;
      spent += t.refine + t.assemble + t.solve + t.estimate + t.mark;
      return { step, paid: { dofs: step.free_dofs, seconds: spent, memory: step.peak_memory_bytes / 1e6 }[cost], error: step.error.relative, truth: step.error.true_relative };
    });
  });
  const at = (p, e) => [Math.log10(p), Math.log10(e)];
  const finite = ([a, b]) => Number.isFinite(a) && Number.isFinite(b);
  const points = curves.map((c) => c.map((p) => at(p.paid, p.error)).filter(finite));
  const truths = curves.map((c) => c.filter((p) => p.truth > 0).map((p) => at(p.paid, p.truth)).filter(finite));
  const all = [...points, ...truths].flat();
  if (!all.length) return null;
  let optimal = null;
  if (cost === "dofs" && degree) {
    const [from, to] = [Math.min(...all.map((p) => p[0])), Math.max(...all.map((p) => p[0]))];
    const start = Math.min(...points.flat().filter((p) => p[0] === Math.min(...points.flat().map((q) => q[0]))).map((p) => p[1])) - 0.12;
    if (to > from) optimal = [[from, start], [to, start - (degree / 3) * (to - from)]];
  }
  const shown = [...all, ...(optimal ?? [])];
  const { px, py, parts } = axes(logAxis(shown.map((p) => p[0])), logAxis(shown.map((p) => p[1]), (v) => share(10 ** v)), [label, "relative error"]);
  const path = (list) => `M${list.map(([a, b]) => `${px(a).toFixed(1)},${py(b).toFixed(1)}`).join("L")}`;
  if (optimal) parts.push(s("path", { class: "optimal", d: path(optimal) }), s("text", { class: "note", x: px(optimal[1][0]), y: py(optimal[1][1]) - 6, "text-anchor": "end" }, `slope −${degree}/3`));
  const colour = (r) => `c${1 + (r % 5)}`;
  points.forEach((list, r) => {
    if (truths[r].length) parts.push(s("path", { class: `curve truth ${colour(r)}`, d: path(truths[r]) }));
    parts.push(s("path", { class: `curve ${colour(r)}`, d: path(list) }), list.map(([a, b]) => s("circle", { class: `dot ${colour(r)}`, cx: px(a), cy: py(b), r: 3.6 })));
  });
  const legend = [];
  if (runs.length > 1) runs.forEach((run, r) => legend.push(h("span", {}, h("i", { class: `key ${colour(r)}` }), run.name)));
  if (truths.some((t) => t.length)) legend.push(h("span", {}, h("i", { class: "key truth" }), "dashed: true error"));
  const word = cost === "dofs" ? count : cost === "seconds" ? seconds : (x) => `${short(x, 3)} MB`;
  const rows = curves.flatMap((c, r) => c.map((p) => [runs.length > 1 ? `${runs[r].name}, step ${p.step.step}` : `step ${p.step.step}`, word(p.paid), percent(p.error), ...(p.truth > 0 ? [percent(p.truth)] : [])]));
  const says = runs.map((run, r) => `${run.name || "This run"}: from ${percent(curves[r][0].error)} at ${word(curves[r][0].paid)} to ${percent(curves[r].at(-1).error)} at ${word(curves[r].at(-1).paid)}.`).join(" ");
  const title = `Error against ${{ dofs: "unknowns", seconds: "time", memory: "memory" }[cost]}`;
  return figure(title, [
    legend.length ? h("p", { class: "legend" }, legend) : null,
    s("svg", { viewBox: `0 0 ${BOX.width} ${BOX.height}`, role: "img", "aria-label": `${title}. ${says}` }, parts),
  ], table(title, ["", label, "estimated", ...(truths.some((t) => t.length) ? ["true"] : [])], rows));
}

/** Shares of cells in bins, of the first and the last step. */
export function histogram(title, label, series, word) {
  const sums = series.map((x) => x.counts.reduce((a, b) => a + b, 0));
  const lo = Math.min(...series.map((x) => x.from));
  const hi = Math.max(...series.map((x) => x.from + x.width * x.counts.length));
  const most = Math.max(...series.flatMap((x, i) => x.counts.map((n) => n / (sums[i] || 1))), 1e-9);
  const y = { lo: 0, hi: 1.06 * most, ticks: ticks(0, most, 4), word: share };
  const x = { lo, hi, ticks: series[0].log ? decades(lo, hi) : ticks(lo, hi, 6), word };
  const { px, py, parts } = axes(x, y, [label, "share of the cells"]);
  series.forEach((one, i) => {
    const step = (n, k) => `${px(one.from + one.width * k).toFixed(1)},${py(n / (sums[i] || 1)).toFixed(1)} ${px(one.from + one.width * (k + 1)).toFixed(1)},${py(n / (sums[i] || 1)).toFixed(1)}`;
    const line = one.counts.map(step).join(" ");
    const ends = [px(one.from), px(one.from + one.width * one.counts.length)].map((v) => `${v.toFixed(1)},${py(0).toFixed(1)}`);
    parts.push(s("polygon", { class: `bars c${one.colour}`, points: `${ends[0]} ${line} ${ends[1]}` }));
  });
  const rows = [];
  const width = series[0].width;
  for (let k = 0; lo + k * width < hi - 1e-9; k++) {
    const own = series.map((one) => one.counts[Math.round((lo + k * width - one.from) / width)] ?? 0);
    if (own.some(Boolean)) rows.push([`${word(lo + k * width)} to ${word(lo + (k + 1) * width)}`, ...own.map((n) => count(n))]);
  }
  return figure(title, [
    h("p", { class: "legend" }, series.map((one) => h("span", {}, h("i", { class: `key c${one.colour}` }), one.name))),
    s("svg", { viewBox: `0 0 ${BOX.width} ${BOX.height}`, role: "img", "aria-label": `${title}: ${series.map((one, i) => `${one.name}, ${plural(sums[i], "cell")}`).join("; ")}` }, parts),
  ], table(title, [label, ...series.map((one) => one.name)], rows));
}

const PHASES = [["refine", "refine"], ["assemble", "assemble"], ["solve", "solve"], ["estimate", "estimate the error"], ["mark", "mark"], ["write", "write files"]];

/** Bars of the seconds of the steps by phase. */
export function phases(run) {
  const { steps } = run.report;
  const most = Math.max(...steps.map((step) => step.seconds.total), 1e-9);
  const rows = steps.map((step) => h("div", { class: "bar" }, h("span", {}, `step ${step.step}`),
    h("div", { class: "track" }, PHASES.map(([key], i) => h("i", { class: `p${i}`, style: `width:${((100 * step.seconds[key]) / most).toFixed(2)}%` }))),
    h("span", { class: "number" }, seconds(step.seconds.total))));
  const title = `Time by phase${run.name ? `, ${run.name}` : ""}`;
  return figure(title, [
    h("p", { class: "legend" }, PHASES.map(([, word], i) => h("span", {}, h("i", { class: `key p${i}` }), word))),
    h("div", { class: "barchart", "aria-hidden": "true" }, rows),
  ], table(title, ["", ...PHASES.map(([, word]) => word), "total", "memory"], steps.map((step) => [`step ${step.step}`, ...PHASES.map(([key]) => seconds(step.seconds[key])), seconds(step.seconds.total), `${Math.round(step.peak_memory_bytes / 1e6)} MB`])));
}
