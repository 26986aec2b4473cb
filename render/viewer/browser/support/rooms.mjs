// The rooms of the tests, and what the engine shows of them.
import { execFile } from "node:child_process";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { promisify } from "node:util";
import { decodePng } from "./png.mjs";
import { setup } from "./setup.mjs";

const execute = promisify(execFile);

const ONE_CELL = "grid: {spacing_mm: 50, overhang_share: 0.1}";
const TWO_CELLS = "grid: {cells_x: 2, spacing_mm: 100, overhang_share: 0.1}";

/** Makes FOLDER/{white,virtual,cells}.lf and their exports FOLDER/{white,virtual,cells}-web. */
export async function makeRooms(bin, white_room, folder) {
  await makeRoom(bin, white_room, folder, "white");
  await makeVirtualRoom(bin, folder, "virtual", "room", ONE_CELL, [
    "--width",
    "384",
    "--truth-views",
    "0",
  ]);
  const small = ["--width", "256", "--every-distance", "2", "--truth-views", "2"];
  const walk = path.join(folder, "walk.csv");
  await writeFile(walk, "name,x,y,z,yaw\na,-0.3,0,0,0\nb,0,0.04,0.2,30\nc,0.3,0,0,0\n");
  const more = ["--path", walk, "--truth", path.join(folder, "cells-capture", "gt.csv")];
  await makeVirtualRoom(bin, folder, "cells", "wide-room", TWO_CELLS, small, more);
}

async function makeVirtualRoom(bin, folder, name, scene, settings, flags, web_flags = []) {
  const scenes = path.join(bin, "..", "share", "raywalk", "configs", "scenes");
  const config = path.join(folder, `${name}.yaml`);
  await writeFile(config, `scene: {file: ${scenes}/${scene}.yaml}\n${settings}\n`);
  const capture = path.join(folder, `${name}-capture`);
  const where = ["room", config, "--out", capture];
  await execute(path.join(bin, "raywalk-simulate"), [...where, ...flags, "-q"]);
  await makeRoom(bin, capture, folder, name, web_flags);
}

async function makeRoom(bin, capture, folder, name, web_flags = []) {
  const room = path.join(folder, `${name}.lf`);
  const frames = ["--frames", path.join(capture, "poses.csv")];
  const distances = ["--distance", path.join(capture, "dist")];
  const pack = ["pack", ...frames, ...distances, "--out", room, "-q"];
  await execute(path.join(bin, "raywalk-build-lf"), pack);
  const web = ["export-web", room, "--out", path.join(folder, `${name}-web`), ...web_flags, "-q"];
  await execute(path.join(bin, "raywalk-render"), web);
}

export function roomFolder(name) {
  return path.join(setup().folder, `${name}.lf`);
}

export function exportFolder(name) {
  return path.join(setup().folder, `${name}-web`);
}

/** The flat pictures of the engine at places (as in place.mjs), in their order. */
export async function enginePictures(room, places, { size_px, method }) {
  const job = path.join(setup().folder, `${room}-${method}-${process.pid}`);
  const rows = places.map(({ x, z, yaw, pitch }, i) => `${i},${x},${z},${yaw},${pitch}`);
  await writeFile(`${job}.csv`, `name,x,z,yaw,pitch\n${rows.join("\n")}\n`);
  const { fov, k } = places[0];
  const flat = ["--fov-deg", String(fov), "--size", `${size_px}x${size_px}`];
  const how = ["--method", method, "--k", String(k)];
  const out = ["--out", job, "-f", "-q"];
  const path_job = ["path", roomFolder(room), `${job}.csv`, ...flat, ...how, ...out];
  await execute(path.join(setup().bin, "raywalk-render"), path_job);
  return Promise.all(
    places.map(async (_, i) => decodePng(await readFile(path.join(job, `${i}.png`)))),
  );
}
