// A static host of one folder, like those that exports are put on; tests can let it fail.
import { readFile } from "node:fs/promises";
import http from "node:http";
import path from "node:path";

const TYPES = {
  ".css": "text/css",
  ".html": "text/html",
  ".jpg": "image/jpeg",
  ".js": "text/javascript",
  ".json": "application/json",
};

export class StaticHost {
  /** By path, such as "/manifest.json": the bytes to send instead, or null for status 404. */
  replaced = new Map();
  /** Awaited with the path before every answer. */
  before = async () => {};
  requests = 0;
  #folder;
  #server = null;
  #port = 0;

  constructor(folder) {
    this.#folder = folder;
  }

  get address() {
    return `http://127.0.0.1:${this.#port}/`;
  }

  /** Again on the same port after a stop. */
  async start() {
    this.#server = http.createServer((request, response) => void this.#answer(request, response));
    await new Promise((resolve) => this.#server.listen(this.#port, "127.0.0.1", resolve));
    this.#port = this.#server.address().port;
  }

  /** Cuts all connections. */
  async stop() {
    const server = this.#server;
    this.#server = null;
    if (!server) return;
    const closed = new Promise((resolve) => server.close(resolve));
    server.closeAllConnections();
    await closed;
  }

  /** The bytes of a file of the export. */
  read(name) {
    return readFile(path.join(this.#folder, name));
  }

  async #answer(request, response) {
    ++this.requests;
    const asked = new URL(request.url, this.address).pathname;
    const name = asked === "/" ? "/index.html" : asked;
    await this.before(name);
    const body = await this.#body(name);
    if (body === null) {
      response.writeHead(404).end();
      return;
    }
    const type = TYPES[path.extname(name)] ?? "application/octet-stream";
    response.writeHead(200, { "content-type": type, "content-length": body.length });
    response.end(body);
  }

  async #body(name) {
    if (this.replaced.has(name)) return this.replaced.get(name);
    return readFile(path.join(this.#folder, name)).catch(() => null);
  }
}
