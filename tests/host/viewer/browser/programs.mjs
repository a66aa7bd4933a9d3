// The emulated sensor and `stof view`, as long as a test needs them.
import { spawn } from "node:child_process";
import { existsSync, readFileSync, mkdtempSync } from "node:fs";
import { createSocket } from "node:dgram";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const enoughMs = 60_000;
export const folder = mkdtempSync(join(tmpdir(), "stof_viewer_"));
const running = new Set();

export async function until(what, condition) {
  const end = Date.now() + enoughMs;
  for (;;) {
    const value = await condition();
    if (value) return value;
    if (Date.now() > end) throw new Error(`${what}: did not come`);
    await new Promise((done) => setTimeout(done, 50));
  }
}

// Keys of nobody else.
export const configHome = join(folder, "config");

export function start(program, words) {
  const child = spawn(program, words, { stdio: ["ignore", "pipe", "pipe"], env: { ...process.env, XDG_CONFIG_HOME: configHome } });
  running.add(child);
  const made = { child, text: "" };
  for (const stream of [child.stdout, child.stderr]) stream.on("data", (data) => { made.text += data; });
  made.ended = new Promise((done) => child.on("close", (code) => { running.delete(child); done(code); }));
  made.stop = () => { child.kill("SIGTERM"); return made.ended; };
  return made;
}

// A port that is free now, and that the system gives to nobody by itself: each start of a sensor takes it anew.
export async function lastingPort() {
  for (;;) {
    const port = 20_000 + Math.floor(12_000 * Math.random());
    const free = await new Promise((done) => {
      const socket = createSocket("udp4");
      socket.once("error", () => done(false));
      socket.bind(port, () => socket.close(() => done(true)));
    });
    if (free) return port;
  }
}

let count = 0;
export async function startSensor(bin, port, flags) {
  const file = join(folder, `port${++count}`);
  const sensor = start(join(bin, "stofd"), ["--port", String(port), "--port-file", file, "--set", "discovery.mdns=false", "--set",
    "discovery.beacon=false", "--set", "streams.grey_left=rvl", ...flags]);
  await until("the sensor's port", () => existsSync(file) && readFileSync(file, "utf8").endsWith("\n"));
  sensor.port = Number(readFileSync(file, "utf8"));
  return sensor;
}

// port: of a sensor; or the name of a recording.
export async function startView(bin, port, flags = []) {
  const shown = typeof port === "string" ? port : `127.0.0.1:${port}`;
  const view = start(join(bin, "stof"), ["view", shown, "--http-port", "0", "--timeout", "30", ...flags]);
  view.address = (await until("the page's address", () => view.text.match(/^page: (\S+)\n/m)))[1];
  return view;
}

export function stopAll() {
  for (const child of running) child.kill("SIGKILL");
}

// Z in metres, rows from the top; Infinity: unknown.
export function readPfm(file) {
  const bytes = readFileSync(file);
  const head = bytes.subarray(0, 80).toString("latin1").match(/^Pf\s+(\d+)\s+(\d+)\s+(-?[\d.]+)\s/);
  const [width, height] = [Number(head[1]), Number(head[2])];
  const z = new Float32Array(width * height);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) z[(height - 1 - y) * width + x] = bytes.readFloatLE(head[0].length + 4 * (y * width + x));
  }
  return { width, height, z };
}
