// The page: its parts, and the controls of its pictures.

import { decades, gradient, ticks } from "./colour.js";
import { decode } from "./decode.js";
import { h } from "./dom.js";
import { count, percent, plain, plural, short, vector, withUnit } from "./format.js";
import { FIELDS, Model } from "./model.js";
import { answers, story, summary } from "./story.js";
import { View } from "./view.js";
import { elementOf } from "./words.js";

const data = JSON.parse(document.getElementById("data").textContent);
const { runs } = data;
const units = runs[0].report.units ?? {};
const shown = runs.length > 1 ? [0, runs.length > 2 ? runs.length - 1 : 1] : [0];
const models = new Map();
const state = { field: "von_mises", amount: 0, edges: false, features: true, actions: true, robust: true, clip: { axis: "off", at: 0.5, flip: false } };
const views = [];

/** The model of a step, decoded when it is first shown. */
function modelOf(r, s) {
  const key = `${r}-${s}`;
  if (!models.has(key)) {
    const info = runs[r].steps[s];
    models.set(key, decode(document.getElementById(`step-${key}`).textContent, info.sections).then((arrays) => new Model(arrays, info)));
  }
  return models.get(key);
}

const unitOf = (field) => FIELDS[field].fixedUnit ?? units[FIELDS[field].unit] ?? "";

// The colour bar.
const bar = h("div", { class: "colourbar" });

function paintBar({ range: [lo, hi], diverging }, whole) {
  const field = FIELDS[state.field];
  bar.replaceChildren();
  bar.hidden = !field;
  if (!field) return;
  const all = field.log ? decades(lo, hi) : field.whole ? ticks(lo, hi, Math.min(6, Math.max(1, hi - lo))).filter(Number.isInteger) : ticks(lo, hi, 6);
  const word = (x) => plain(field.log ? Number((10 ** x).toPrecision(2)) : x);
  const unit = unitOf(state.field);
  const beyond = state.robust && field.at === "point" ? ` (from ${short(whole[0], 3)} to ${short(whole[1], 3)}; beyond the bar, where 1 % of the surface lies at each end, colours are those of its ends)` : "";
  bar.append(
    h("p", {}, field.name, unit ? `, ${unit}` : "", h("span", { class: "small" }, beyond)),
    h("div", { class: "ramp", style: `background:${gradient(diverging)}` }),
    h("div", { class: "ticks" }, all.map((x) => h("span", { style: `left:${(100 * (x - lo)) / (hi - lo || 1)}%` }, word(x)))),
  );
}

function range() {
  const over = (robust) => {
    const ranges = views.map((v) => v.range(state.field, robust));
    return [Math.min(...ranges.map((r) => r[0])), Math.max(...ranges.map((r) => r[1]))];
  };
  const both = over(state.robust);
  let painted;
  for (const view of views) painted = view.setRange(both);
  paintBar(painted, over(false));
}

// What was picked.
const readout = h("div", { class: "readout", "aria-live": "polite" });

function paintReadout() {
  const rows = [];
  const list = views.filter((v) => v.picked);
  readout.replaceChildren();
  if (!list.length) {
    readout.append(h("p", { class: "small" }, "Click the body to read the values at the nearest point of the mesh."));
    return;
  }
  const of = (view) => {
    const { picked: p, model } = view;
    const d = model.rounding("displacement");
    const stress = model.rounding("stress");
    const length = (x, n = 5) => withUnit(short(x, n), units.length);
    const pressure = (x) => withUnit(short(x, 5), units.stress);
    return [
      ["point", `${count(p.point)} at ${vector(p.position, 5)}`],
      ["displacement", `${length(Math.hypot(...p.displacement))}, ${vector(p.displacement, 4)}`],
      ["von Mises stress", pressure(p.stress[0])],
      ["principal stresses", `${pressure(p.stress[1])} to ${pressure(p.stress[2])}`],
      ["cell", `${count(p.cell)}, level ${p.level}`],
      ["error of the cell", short(p.error, 3)],
      ["smallest angle", `${short(p.quality, 3)}°`],
      ["rounding", `displacement ± ${short(d, 1)}, stress ± ${short(stress, 1)}`],
    ];
  };
  for (const view of list) {
    rows.push(h("div", {}, list.length > 1 || views.length > 1 ? h("h3", {}, view.run.name) : null,
      h("dl", {}, of(view).map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]))));
  }
  readout.append(...rows, h("button", { type: "button", onclick: () => views.forEach((v) => v.unpick()) }, "Clear"));
}

// Controls.
const option = (key) => h("option", { value: key }, FIELDS[key].name);
const fieldSelect = h("select", { id: "field", onchange: () => set({ field: fieldSelect.value }) },
  h("optgroup", { label: "At points" }, Object.keys(FIELDS).filter((k) => FIELDS[k].at === "point").map(option)),
  h("optgroup", { label: "In cells" }, Object.keys(FIELDS).filter((k) => FIELDS[k].at === "cell").map(option)),
  h("option", { value: "none" }, "No colours"));
const check = (key, text) => h("label", { class: "check" }, h("input", { type: "checkbox", id: key, checked: state[key], onchange: (e) => set({ [key]: e.target.checked }) }), text);
const deformation = h("input", { type: "range", id: "deformation", min: 0, max: 1, step: 0.005, value: 0, oninput: () => setAmount(deformation.value * most, false), onchange: () => setAmount(deformation.value * most, true) });
const factor = h("output", { for: "deformation" });
const clipAxis = h("select", { id: "clip-axis", onchange: () => set({ clip: { ...state.clip, axis: clipAxis.value } }) },
  ["off", "x", "y", "z"].map((a) => h("option", { value: a }, a === "off" ? "no cut" : `across ${a}`)));
const clipAt = h("input", { type: "range", id: "clip-at", min: 0, max: 1, step: 0.005, value: 0.5, "aria-label": "Place of the cut", oninput: () => set({ clip: { ...state.clip, at: Number(clipAt.value) } }) });
const clipFlip = h("input", { type: "checkbox", id: "clip-flip", onchange: () => set({ clip: { ...state.clip, flip: clipFlip.checked } }) });
const clipNote = h("p", { class: "small", id: "clip-note" });
let most = 1;

function setAmount(amount, settled) {
  state.amount = amount;
  deformation.value = most ? amount / most : 0;
  factor.textContent = `× ${plain(Number(amount.toPrecision(3)))}`;
  views.forEach((view) => view.model && view.move(settled));
}

/** The largest factor: the largest displacement becomes a fifth of the body, but is never less than itself. */
function scaleDeformation(model) {
  const [size, moved] = [model.diagonal, model.moved];
  most = moved > 0 ? Math.max((0.2 * size) / moved, 1) : 1;
  const power = 10 ** Math.floor(Math.log10(most));
  most = Math.max(1, Math.ceil(most / power) * power);
  const start = moved > 0 ? (0.06 * size) / moved : 0;
  setAmount(start > 0.3 && start < 3 ? 1 : Number(start.toPrecision(1)), true);
}

async function set(change) {
  Object.assign(state, change);
  fieldSelect.value = FIELDS[state.field] ? state.field : "none";
  for (const key of ["edges", "features", "actions", "robust"]) document.getElementById(key).checked = state[key];
  [clipAxis.value, clipAt.value, clipFlip.checked] = [state.clip.axis, state.clip.at, state.clip.flip];
  clipAt.disabled = clipFlip.disabled = state.clip.axis === "off";
  await Promise.all(views.map((view) => refresh(view)));
  range();
  note();
}

async function refresh(view) {
  const model = await modelOf(view.index, view.step);
  if (view.model === undefined && views[0] === view) scaleDeformation(model);
  view.show(model, state);
  caption(view);
}

function note() {
  const notes = views.map((view) => {
    const { info } = view.model;
    const name = views.length > 1 ? `${view.run.name}: ` : "";
    const parts = [];
    if (state.clip.axis !== "off" && info.cells_drawn === 0) parts.push(`${name}the ${count(info.cells)} cells are too many for this page: a cut shows the surface only.`);
    else if (state.clip.axis !== "off" && info.merged !== null) {
      parts.push(`${name}of ${plural(info.cells, "cell")} the cut shows ${count(info.cells_drawn)}: points nearer than ${withUnit(short(info.merged, 2), units.length)} are drawn as one, and cells between them left out. Their values are true ones.`);
    }
    if (info.without_middles) parts.push(`${name}faces are drawn flat between their corners; there are too many for more.`);
    return parts.join(" ");
  });
  clipNote.textContent = notes.filter(Boolean).join(" ");
}

function caption(view) {
  const record = view.run.report.steps[view.step];
  const step = view.run.report.steps.length > 1 ? `Step ${record.step} of ${view.run.report.steps.length - 1}: ` : "";
  view.caption.textContent = `${step}${plural(record.cells, "cell")}, error ${percent(record.error.relative)}`;
}

function picture(r) {
  const view = new View(runs[r], runs[r].name);
  Object.assign(view, { index: r, step: runs[r].steps.length - 1, caption: h("output", { class: "caption" }) });
  view.canvas.setAttribute("aria-label", `The body${runs[r].name ? `, ${runs[r].name}` : ""}, in colours of the field chosen. Arrow keys turn it, plus and minus zoom, R resets, Enter picks what is in the middle.`);
  view.onPick = paintReadout;
  view.onCamera = (from) => {
    if (linking) return;
    linking = true;
    views.forEach((other) => other !== from && other.model && other.follow(from));
    linking = false;
  };
  const slider = h("input", { type: "range", min: 0, max: runs[r].steps.length - 1, step: 1, value: view.step, "aria-label": `Step${runs[r].name ? ` of ${runs[r].name}` : ""}`, class: "step", oninput: () => setStep(view, Number(slider.value)) });
  const choice = runs.length > 2 ? h("select", { "aria-label": "Run", onchange: () => setRun(view, Number(choice.value)) }, runs.map((run, i) => h("option", { value: i, selected: i === r }, run.name))) : runs.length > 1 ? h("strong", {}, runs[r].name) : null;
  view.slider = slider;
  view.frame = h("div", { class: "picture" }, h("div", { class: "head" }, choice, view.caption, runs[r].steps.length > 1 || runs.length > 1 ? slider : null), view.element);
  return view;
}

let linking = false;

async function setStep(view, step) {
  view.step = step;
  view.slider.value = step;
  await set({});
}

async function setRun(view, r) {
  Object.assign(view, { index: r, run: runs[r], step: runs[r].steps.length - 1 });
  view.slider.max = view.step;
  await setStep(view, view.step);
}

function controls() {
  const group = (name, ...children) => h("div", { class: "group", role: "group", "aria-label": name }, ...children);
  return h("div", { class: "controls" },
    group("Colours", h("label", { for: "field" }, "Colours"), fieldSelect, check("robust", "cut off peaks"),
      h("button", { type: "button", id: "extreme", onclick: () => views.forEach((v) => v.pickExtreme()) }, "Find the peak")),
    group("Deformation", h("label", { for: "deformation" }, "Deformation"), deformation, factor,
      h("button", { type: "button", onclick: () => setAmount(0, true) }, "none"), h("button", { type: "button", onclick: () => setAmount(1, true) }, "true")),
    group("Cut", h("label", { for: "clip-axis" }, "Cut"), clipAxis, clipAt, h("label", { class: "check" }, clipFlip, "other side")),
    group("Shown", check("edges", "edges of cells"), check("features", "feature edges"), check("actions", "supports and loads")),
    group("View", h("span", {}, "View along"), ["x", "y", "z"].map((name, axis) => h("button", { type: "button", "aria-label": `Look along ${name}`, onclick: () => look(axis) }, name)),
      h("button", { type: "button", onclick: () => views[0].home() }, "Reset")),
    clipNote);
}

const look = (axis) => views[0].home([[1, 0, 0], [0, -1, 0], [1e-4, -1e-3, 1]][axis]);

function theme() {
  const button = h("button", { type: "button", class: "theme", onclick: () => {
    const dark = getComputedStyle(document.documentElement).getPropertyValue("--dark").trim() === "1";
    document.documentElement.dataset.theme = dark ? "light" : "dark";
    views.forEach((view) => view.draw());
  } }, "Light or dark");
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => views.forEach((view) => view.draw()));
  return button;
}

function skeleton() {
  const steps = runs.map((run) => run.report.steps.length - 1);
  const kind = runs.length > 1 ? `Comparison of ${runs.map((r) => r.name).join(", ")}` : "Simulation report";
  const what = `${kind} · ${runs[0].report.scenario} · ${runs[0].report.program} · ${runs.length > 1 ? "" : `${elementOf(runs[0].scenario)}, `}${Math.max(...steps) ? plural(Math.max(...steps), "refinement step") : "not refined"}`;
  const links = [["asked", "Answers"], ["model", "Model"], ["warnings", "Warnings"], ["forces", "Forces"], ["convergence", "Convergence"], ["mesh", "Cells"], ["cost", "Cost"], ["repeat", "Repeat"]];
  return [
    h("header", {}, h("div", {}, h("h1", {}, data.title), h("p", { class: "small" }, what), summary(data)), theme()),
    h("nav", { "aria-label": "Parts of this page" }, links.map(([id, name]) => h("a", { href: `#${id}` }, name))),
    h("main", {}, h("div", { class: "top" }, answers(data), h("section", { id: "model", "aria-label": "The model" })), story(data)),
  ];
}

function webgl(section) {
  try {
    for (const r of shown) views.push(picture(r));
  } catch (error) {
    section.append(h("p", { class: "verdict fair" }, "This browser cannot draw the model (it has no WebGL). All else on the page is complete."));
    return false;
  }
  section.append(h("div", { class: `pictures n${views.length}` }, views.map((v) => v.frame)), bar, controls(), readout);
  return true;
}

async function start() {
  document.getElementById("page").append(...skeleton());
  if (!webgl(document.getElementById("model"))) return;
  paintReadout();
  try {
    await set({});
  } catch (error) {
    document.getElementById("model").replaceChildren(h("p", { class: "verdict fair" }, `The model cannot be drawn here: ${error.message}. All else on the page is complete.`));
    return;
  }
  views.forEach((view) => view.render());
  for (const [event, printed] of [["beforeprint", true], ["afterprint", false]]) {
    window.addEventListener(event, () => views.forEach((view) => {
      view.printed = printed;
      view.render();
    }));
  }
}

/** For tests: the pictures and what can be done with them. */
window.subsolid = { data, state, views, models, set, setStep, setAmount: (x) => setAmount(x, true), ready: start() };
