// Draws the report whose JSON stands in the page.
import { imagesOf, show, type Describe } from "./page";
import { calibration } from "./reports/calibration";
import { depth } from "./reports/depth";
import { errorModel } from "./reports/error_model";
import { plan } from "./reports/plan";
import { require } from "./reports/require";
import { trade } from "./reports/trade";
import { validation } from "./reports/validation";

const KINDS: Record<string, Describe> = {
  calibration,
  depth,
  "error-model": errorModel,
  plan,
  require,
  trade,
  validation,
};

const {
  kind,
  document: values,
  images,
  sources,
} = JSON.parse(document.getElementById("report")?.textContent ?? "");
const describe = KINDS[kind];
if (!describe) throw new Error(`unknown kind of report: ${kind}`);
show(describe(values, imagesOf(images, sources)), values);
