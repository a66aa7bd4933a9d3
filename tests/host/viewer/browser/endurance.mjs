// endurance.mjs MODULES BIN MINUTES: 640x480 at 30 Hz for so long, the cloud closed: frames that are drawn, cores of all of Chromium's
// processes and of `stof view`, and memory of `stof view` and of the page, which must not grow.
import { createRequire } from "node:module";
import { join } from "node:path";
import { memoryOf, spent } from "./load.mjs";
import { startSensor, startView, stopAll, until } from "./programs.mjs";

const [modules, bin, minutesText] = process.argv.slice(2);
const minutes = Number(minutesText);
const { chromium } = createRequire(join(modules, "here.js"))("playwright-core");
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const warmUpMs = 15_000;  // until tables, pools and compiled code are there
const mebi = 1 << 20;
// What a garbage collector and an allocator keep for themselves; a leak of one frame in a hundred is more within a minute.
const mostGrowth = { server: 16 * mebi, page: 8 * mebi };

let browser;
let code = 0;
try {
  browser = await chromium.launch({
    executablePath: "/usr/bin/chromium",
    args: [...(process.getuid() === 0 ? ["--no-sandbox"] : []), "--disable-gpu", "--enable-unsafe-swiftshader"],
  });
  const sensor = await startSensor(bin, 0, ["--size", "640x480", "--period-ms", "33"]);
  const view = await startView(bin, sensor.port);
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 860 } })).newPage();
  const complaints = [];
  page.on("pageerror", (error) => complaints.push(error.message));
  await page.goto(view.address);
  await until("a frame", async () => (await page.locator("#map").evaluate((map) => map.width)) === 640);
  await wait(warmUpMs);

  const devtools = await page.context().newCDPSession(page);
  await devtools.send("HeapProfiler.enable");
  // Live bytes of the page, and of the program.
  const memory = async () => {
    await devtools.send("HeapProfiler.collectGarbage");
    const { usedSize, backingStorageSize = 0 } = await devtools.send("Runtime.getHeapUsage");
    return { server: memoryOf(view.child.pid), page: usedSize + backingStorageSize };
  };
  const first = await memory();
  let most = first;
  const before = { chromium: spent(process.pid, "chrom"), stof: spent(view.child.pid, "stof"), at: Date.now() };
  for (let tenth = 1; tenth <= 10; ++tenth) {
    await wait(minutes * 6000);
    const now = await memory();
    most = { server: Math.max(most.server, now.server), page: Math.max(most.page, now.page) };
    const took = (Date.now() - before.at) / 1000;
    const of = (later, then) => ((later - then) / took).toFixed(2);
    console.log(`${took.toFixed(0)} s: stof ${(now.server / mebi).toFixed(1)} MiB, page ${(now.page / mebi).toFixed(1)} MiB; Chromium ` +
      `${of(spent(process.pid, "chrom"), before.chromium)} cores, stof ${of(spent(view.child.pid, "stof"), before.stof)} cores. ` +
      (await page.locator("#counts").innerText()));
  }
  for (const part of ["server", "page"]) {
    const growth = most[part] - first[part];
    if (growth > mostGrowth[part]) {
      console.log(`FAIL  the ${part} grew by ${(growth / mebi).toFixed(1)} MiB`);
      code = 1;
    }
  }
  if (complaints.length > 0) {
    console.log(`FAIL  ${complaints[0]}`);
    code = 1;
  }
  if (code === 0) console.log("ok    nothing grew");
  await view.stop();
  await sensor.stop();
} finally {
  await browser?.close();
  stopAll();
}
process.exit(code);
