// Makes dist/page.html of src/: one file with the style, the program and what it uses of three.js, and its licence.
//
//     npm ci && npm run build
//
// The result is kept in the repository, so that building Subsolid needs neither node nor a network.

import { build } from "esbuild";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";

const read = (path) => readFileSync(new URL(path, import.meta.url), "utf8");
const { outputFiles } = await build({
  entryPoints: [new URL("src/main.js", import.meta.url).pathname],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  legalComments: "none",
  write: false,
});
const program = outputFiles[0].text.replaceAll("</script", "<\\/script").trimEnd();
const style = (await build({
  stdin: { contents: read("src/style.css"), loader: "css" },
  minify: true,
  write: false,
})).outputFiles[0].text.trimEnd();
const version = JSON.parse(read("node_modules/three/package.json")).version;
const licence = `three.js ${version} (https://threejs.org), which this page contains in part:\n\n${read("node_modules/three/LICENSE").trim()}`;
const page = read("src/page.html")
  .replace("/*STYLE*/", () => style)
  .replace("/*LICENCE*/", () => licence)
  .replace("/*PROGRAM*/", () => program);
mkdirSync(new URL("dist", import.meta.url), { recursive: true });
writeFileSync(new URL("dist/page.html", import.meta.url), page);
console.log(`dist/page.html: ${(page.length / 1024).toFixed(0)} KB`);
