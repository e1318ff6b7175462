// SPDX-License-Identifier: MIT OR Apache-2.0
// Equations to HTML by KaTeX: a line {"tex", "display"} on standard input, a line {"html"} or {"error"} on standard output.
// Ends with its input.

import { createRequire } from "node:module";
import { join } from "node:path";
import { createInterface } from "node:readline";

const modules = join(process.env.ELLGRAN_SITE_NODE_MODULES, "x.js");
const katex = createRequire(modules)("katex");

for await (const line of createInterface({ input: process.stdin })) {
  const { tex, display } = JSON.parse(line);
  let answer;
  try {
    answer = { html: katex.renderToString(tex, { displayMode: display, throwOnError: true, strict: "ignore" }) };
  } catch (error) {
    answer = { error: error.message };
  }
  process.stdout.write(JSON.stringify(answer) + "\n");
}
