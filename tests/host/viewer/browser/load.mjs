// What the page costs: frames drawn, and cores of all of Chromium's processes and of `stof`.
import { readFileSync, readdirSync } from "node:fs";
import { startSensor, startView, until } from "./programs.mjs";

const ticksPerSecond = 100;

function times() {
  const all = new Map();
  for (const name of readdirSync("/proc")) {
    if (!/^\d+$/.test(name)) continue;
    try {
      const stat = readFileSync(`/proc/${name}/stat`, "latin1");
      const fields = stat.slice(stat.lastIndexOf(")") + 2).split(" ");
      all.set(Number(name), { parent: Number(fields[1]), ticks: Number(fields[11]) + Number(fields[12]), program: stat.slice(stat.indexOf("(") + 1, stat.lastIndexOf(")")) });
    } catch {
      // it has ended
    }
  }
  return all;
}

// Bytes of a process that are in memory and its own.
export function memoryOf(process) {
  const status = readFileSync(`/proc/${process}/status`, "latin1");
  return Number(status.match(/^RssAnon:\s+(\d+) kB/m)[1]) * 1024;
}

// Seconds of the processes below `root` that are called so.
export function spent(root, name) {
  const all = times();
  let ticks = 0;
  for (const [id, one] of all) {
    let at = id;
    while (at > 1 && at !== root) at = all.get(at)?.parent ?? 0;
    if (at === root && one.program.startsWith(name)) ticks += one.ticks;
  }
  return ticks / ticksPerSecond;
}

export async function measure(browser, bin, seconds) {
  const sensor = await startSensor(bin, 0, ["--size", "640x480", "--period-ms", "33"]);
  const view = await startView(bin, sensor.port);
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 860 } })).newPage();
  await page.goto(view.address);
  await until("a frame", async () => (await page.locator("#map").evaluate((map) => map.width)) === 640);
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  for (const [name, prepare] of [
    ["depth", async () => {}],
    ["depth with the pointer on it", async () => page.locator("#map").hover()],
    ["depth, paused", async () => page.locator("#pause").click()],
    ["cloud", async () => {
      await page.locator("#pause").click();
      await page.locator("input[name=base][value=cloud]").check({ force: true });
    }],
  ]) {
    await prepare();
    await wait(3000);
    const before = { chromium: spent(process.pid, "chrom"), stof: spent(view.child.pid, "stof"), at: Date.now() };
    await wait(seconds * 1000);
    const took = (Date.now() - before.at) / 1000;
    const of = (now, then) => ((now - then) / took).toFixed(2);
    console.log(`${name}: Chromium ${of(spent(process.pid, "chrom"), before.chromium)} cores, stof ${of(spent(view.child.pid, "stof"), before.stof)} cores. ` +
      (await page.locator("#counts").innerText()));
  }
  await view.stop();
  await sensor.stop();
}
