// Bundles the page of reports: node build.mjs OUTPUT_DIR writes report_template.cc there, the page of
// each kind as text in C++ (../report_template.h). A page holds what draws its kind only, deflated, so
// that small reports stay small files.
import { build } from "esbuild";
import { mkdir, readdir, writeFile } from "node:fs/promises";
import path from "node:path";
import { deflateSync } from "node:zlib";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));
const out = path.resolve(process.argv[2] ?? "dist");

const bundled = (kind) =>
  build({
    entryPoints: [{ in: path.join(here, "report.css"), out: "report" }],
    stdin: {
      contents: `import { draw } from "./page"; import { report } from "./kinds/${kind}"; draw(report);`,
      resolveDir: path.join(here, "src"),
      loader: "ts",
    },
    outdir: out,
    write: false,
    bundle: true,
    format: "iife",
    target: ["es2020"],
    minify: true,
    legalComments: "inline", // licences of the libraries inside
    logLevel: "warning",
  });

// Adds what `id` holds to the page: base64 of deflated text.
const inflate = async (id, element) => {
  const packed = atob(document.getElementById(id).textContent);
  const bytes = Uint8Array.from(packed, (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const added = document.createElement(element);
  added.textContent = await new Response(stream).text();
  document.head.append(added);
};

// RAYWALK_REPORT is where report_page() puts the JSON. A report asks nothing of any host.
async function page(kind) {
  const { outputFiles } = await bundled(kind);
  const packed = (extension) => {
    const texts = outputFiles.filter((file) => file.path.endsWith(extension));
    return deflateSync(texts.map((file) => file.text).join("\n"), { level: 9 }).toString("base64");
  };
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>Raywalk report</title>
<link rel="icon" href="data:,">
</head>
<body>
<noscript>This report draws itself with JavaScript from the JSON inside.</noscript>
<script type="application/json" id="report">RAYWALK_REPORT</script>
<script type="text/plain" id="style">${packed(".css")}</script>
<script type="text/plain" id="script">${packed(".js")}</script>
<script>
const inflate = ${inflate};
inflate("style", "style").then(() => inflate("script", "script"))
  .catch(() => document.body.append("This report needs a browser of 2023 or newer."));
</script>
</body>
</html>
`;
}

// Compilers limit the length of a literal.
const LITERAL_LENGTH = 8000;
const literals = (text) =>
  text
    .match(new RegExp(`[^]{1,${LITERAL_LENGTH}}`, "gu"))
    .map((literal) => `R"raywalk(${literal})raywalk"`)
    .join("\n");
const kinds = (await readdir(path.join(here, "src/kinds"))).map((file) => path.parse(file).name);
const cases = await Promise.all(
  kinds.sort().map(
    async (kind) => `  if (kind == "${kind}") {
    static constexpr std::string_view kPage =
${literals(await page(kind))};
    return kPage;
  }
`,
  ),
);
await mkdir(out, { recursive: true });
await writeFile(
  path.join(out, "report_template.cc"),
  `#include "core/report/report_template.h"

#include <stdexcept>

namespace raywalk {

std::string_view report_template(std::string_view kind) {
${cases.join("")}  throw std::invalid_argument("no such kind of report: " + std::string(kind));
}

}  // namespace raywalk
`,
);
