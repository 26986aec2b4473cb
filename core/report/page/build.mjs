// Bundles the page of reports: node build.mjs OUTPUT_DIR writes report_template.cc there, the page as
// text in C++ (../report_template.h).
import { build } from "esbuild";
import { mkdir, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));
const out = path.resolve(process.argv[2] ?? "dist");

const bundled = await build({
  entryPoints: [
    { in: path.join(here, "src/main.ts"), out: "report" },
    { in: path.join(here, "report.css"), out: "report" },
  ],
  outdir: out,
  write: false,
  bundle: true,
  format: "iife",
  target: ["es2020"],
  minify: true,
  legalComments: "inline", // licences of the libraries inside
  logLevel: "warning",
});
const text = (extension) => bundled.outputFiles.find((file) => file.path.endsWith(extension)).text;

// RAYWALK_REPORT is where report_page() puts the JSON. A report asks nothing of any host.
const page = `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<title>Raywalk report</title>
<link rel="icon" href="data:,">
<style>${text(".css")}</style>
</head>
<body>
<noscript>This report draws itself with JavaScript from the JSON inside.</noscript>
<script type="application/json" id="report">RAYWALK_REPORT</script>
<script>${text(".js").replaceAll("</script", "<\\/script")}</script>
</body>
</html>
`;

// Compilers limit the length of a literal.
const LITERAL_LENGTH = 8000;
const literals = page.match(new RegExp(`[^]{1,${LITERAL_LENGTH}}`, "gu"));
await mkdir(out, { recursive: true });
await writeFile(
  path.join(out, "report_template.cc"),
  `#include "core/report/report_template.h"

namespace raywalk {

std::string_view report_template() {
  static constexpr std::string_view kPage =
${literals.map((literal) => `R"raywalk(${literal})raywalk"`).join("\n")};
  return kPage;
}

}  // namespace raywalk
`,
);
