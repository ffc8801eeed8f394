// Serves a folder of static files on this machine: `node serve.mjs FOLDER [PORT]`.

import { spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = {
  ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".json": "application/json",
  ".toml": "text/plain; charset=utf-8",
};

/** A server of the files in `folder`, once it listens. */
export function serve(folder, port = 0) {
  const server = http.createServer((request, answer) => {
    const name = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
    const file = path.join(folder, name.endsWith("/") ? `${name}index.html` : name);
    if (!file.startsWith(path.resolve(folder)) || !fs.existsSync(file) || !fs.statSync(file).isFile()) {
      answer.writeHead(404, { "content-type": "text/plain" }).end("not found");
      return;
    }
    answer.writeHead(200, { "content-type": TYPES[path.extname(file)] ?? "application/octet-stream" });
    fs.createReadStream(file).pipe(answer);
  });
  return new Promise((ready) => server.listen(port, "127.0.0.1", () => ready(server)));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const server = await serve(path.resolve(process.argv[2]), Number(process.argv[3] ?? 8080));
  const url = `http://localhost:${server.address().port}/`;
  console.log(`the page is at ${url} until Ctrl-C`);
  const opener = { darwin: "open", win32: "explorer" }[process.platform] ?? "xdg-open";
  spawn(opener, [url], { stdio: "ignore", detached: true }).on("error", () => {}).unref();
}
