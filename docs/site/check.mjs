// SPDX-License-Identifier: MIT OR Apache-2.0
// Opens every page of the site from its file, in a browser without a network, and says what is wrong with it:
// links that lead nowhere, pictures that do not load, errors on the console, equations that were not rendered.
//
//   node check.mjs SITE BROWSER [SCREENSHOT-OF-THE-THEORY-PAGE]

import { readdirSync } from "node:fs";
import { createRequire } from "node:module";
import { join, relative } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const [site, browserPath, screenshot] = process.argv.slice(2);
const modules = join(process.env.ELLGRAN_SITE_NODE_MODULES, "x.js");
const { chromium } = createRequire(modules)("playwright-core");

const pages = readdirSync(site, { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile() && entry.name.endsWith(".html"))
  .map((entry) => join(entry.parentPath, entry.name))
  .filter((path) => !path.includes("/_static/") && !path.includes("/_sources/"))
  .sort();

const faults = [];
const files = new Set(
  readdirSync(site, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => join(entry.parentPath, entry.name)),
);
// page -> the ids that links may name; and the links, judged when all ids are known
const ids = new Map();
const links = [];
let equations = 0;

const browser = await chromium.launch({
  executablePath: browserPath,
  args: ["--allow-file-access-from-files"],
  chromiumSandbox: false,
});
const context = await browser.newContext({ offline: true, viewport: { width: 1280, height: 900 } });
const tab = await context.newPage();
let here = "";
const fault = (text) => faults.push(`${here}: ${text}`);
tab.on("console", (message) => {
  if (message.type() === "error") fault(`console: ${message.text()}`);
});
tab.on("pageerror", (error) => fault(`script: ${error.message}`));
tab.on("requestfailed", (request) => fault(`does not load: ${request.url()}`));
tab.on("request", (request) => {
  if (!/^(file|data|blob):/.test(request.url())) fault(`asks the network for ${request.url()}`);
});

for (const path of pages) {
  here = relative(site, path);
  await tab.goto(pathToFileURL(path).href, { waitUntil: "load" });
  if (here === "index.html") {
    await tab.waitForURL(/\/docs\/index\.html$/).catch(() => fault("does not lead to docs/index.html"));
    continue;
  }
  const found = await tab.evaluate(async () => {
    await document.fonts.ready;
    const text = [];
    const walker = document.createTreeWalker(document.querySelector("article, main, body"), NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const node = walker.currentNode;
      if (!node.parentElement.closest("pre, code, script, style, .katex, .sig")) text.push(node.data);
    }
    return {
      url: location.href,
      ids: [...document.querySelectorAll("[id], a[name]")].map((node) => node.id || node.name),
      links: [...document.querySelectorAll("a[href]")].map((node) => node.href),
      pictures: [...document.images].filter((image) => image.naturalWidth === 0).map((image) => image.src),
      math: document.querySelectorAll(".math").length,
      rendered: document.querySelectorAll(".math .katex").length,
      errors: [...document.querySelectorAll(".katex-error")].map((node) => node.textContent),
      unrendered: text.join("").match(/\$\$|\$[^$\n]*[\\_^][^$\n]*\$|\\\(|\\\[/g) ?? [],
      fonts: [...document.fonts].filter((font) => font.status === "error").map((font) => font.family),
      title: document.title,
    };
  });
  ids.set(path, new Set(found.ids));
  links.push(...found.links.map((href) => [here, href]));
  found.pictures.forEach((source) => fault(`picture does not load: ${source}`));
  found.errors.forEach((text) => fault(`KaTeX: ${text}`));
  found.unrendered.forEach((text) => fault(`equation is not rendered: ${text}`));
  found.fonts.forEach((family) => fault(`font does not load: ${family}`));
  if (!found.title) fault("no title");
  if (found.math !== found.rendered) fault(`${found.math} equations, ${found.rendered} of them rendered`);
  equations += found.rendered;
  if (screenshot && here === "docs/theory.html") await tab.screenshot({ path: screenshot, fullPage: true });
}

// The search works from files too: a word of the theory is found.
here = "search.html";
await tab.goto(`${pathToFileURL(join(site, "search.html")).href}?q=Weingarten`, { waitUntil: "load" });
await tab
  .waitForSelector("#search-results li a", { timeout: 20000 })
  .catch(() => fault("the search finds no page for a word of the theory"));
await browser.close();

let checked = 0;
for (const [from, href] of links) {
  here = from;
  if (!href.startsWith("file:")) continue;
  checked += 1;
  const url = new URL(href);
  const anchor = decodeURIComponent(url.hash.slice(1));
  url.hash = url.search = "";
  const target = fileURLToPath(url);
  if (!files.has(target)) fault(`dead link: ${relative(site, target)}`);
  else if (anchor && ids.has(target) && !ids.get(target).has(anchor))
    fault(`dead link: ${relative(site, target)} has no #${anchor}`);
}

// A check that saw nothing has not passed.
here = "the site";
if (pages.length < 10 || equations < 100 || checked < 100) fault("too few pages, equations or links were seen");
for (const text of new Set(faults)) console.error(text);
console.log(`${pages.length} pages, ${checked} links between them, ${equations} equations: ${new Set(faults).size} faults`);
process.exit(faults.length ? 1 : 0);
