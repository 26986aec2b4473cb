import assert from "node:assert/strict";
import { test } from "node:test";
import { counted, decimalsOf, flattened, heading, length, meaning, text, textOf } from "./values";

test("keys end with their unit", () => {
  assert.equal(heading(meaning("position_sigma_mm")), "position sigma / mm");
  assert.equal(heading(meaning("pareto.ws_psnr_db")), "pareto WS-PSNR / dB");
  assert.deepEqual(meaning("filled_share"), { name: "filled", unit: "%", factor: 100 });
  assert.deepEqual(meaning("m"), { name: "m", unit: "", factor: 1 });
});

test("numbers have four digits, in a column as many decimals as the largest needs", () => {
  assert.equal(text(37.719710293), "37.72");
  assert.equal(text(0.9751970820834381), "0.9752");
  assert.equal(text(0.01), "0.01");
  assert.equal(text(123456), "123456");
  assert.equal(text(-0.0000001), "-1.00e-7");
  assert.equal(decimalsOf([668.11, 2.2]), 1);
  assert.equal(decimalsOf([1, 20]), 0);
  assert.equal(decimalsOf([0]), 0);
  assert.equal(decimalsOf([0.5, 0.025]), 4);
  assert.equal(text(-0.00001, 1, 2), "0.00");
});

test("every other value reads plainly", () => {
  assert.equal(text(null), "–");
  assert.equal(text(true), "yes");
  assert.equal(text(["x0", 1.5]), "x0, 1.5");
  assert.equal(textOf("masked_share", 0.0431), "4.31 %");
  assert.equal(textOf("gain_db", null), "–");
  assert.equal(counted(1, "line"), "1 line");
  assert.equal(counted([1, 2], "line"), "2 lines");
  assert.equal(length(0.0049), "4.9 mm");
  assert.equal(length(1.2), "120.0 cm");
  assert.equal(length(null, "any"), "any");
});

test("nested objects are flattened, lists stay", () => {
  assert.deepEqual(flattened({ a: { b_mm: 1, c: [1] }, d: null }), {
    "a.b_mm": 1,
    "a.c": [1],
    d: null,
  });
});
