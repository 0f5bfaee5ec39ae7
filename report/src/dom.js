// Elements of the page.

/** An element with attributes and children; `on…` are listeners. */
export function h(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** As `h`, of a drawing. */
export function s(tag, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(element, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.flat(Infinity).filter((c) => c !== null && c !== undefined && c !== false && c !== ""));
  return element;
}

/** A table with a head; cells of `numbers` columns are set right. */
export function table(caption, head, rows, numbers = 1) {
  const cell = (tag, c, i) => h(tag, { class: i >= numbers ? "number" : null, scope: tag === "th" ? "col" : null }, c);
  return h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    h("table", {}, h("caption", {}, caption), h("thead", {}, h("tr", {}, head.map((c, i) => cell("th", c, i)))),
      h("tbody", {}, rows.map((row) => h("tr", {}, row.map((c, i) => (i ? cell("td", c, i) : h("th", { scope: "row" }, c))))))));
}
