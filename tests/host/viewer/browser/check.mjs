// check.mjs ROOT BIN OUT LOAD_SECONDS DOCS ONLY: the page of `stof view` in Chromium; scripts/viewer_check starts it.
import { strict as assert } from "node:assert";
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { calibrationChecks } from "./calibration.mjs";
import { drawDocs } from "./docs.mjs";
import { measure } from "./load.mjs";
import { ownerChecks } from "./owner.mjs";
import { panelChecks } from "./panels.mjs";
import { folder, readPfm, startSensor, startView, stopAll, until } from "./programs.mjs";

const [root, bin, out, loadSeconds, docs, only] = process.argv.slice(2);
const { chromium } = createRequire(join(root, "build/viewer_check/here.js"))("playwright-core");
const width = 160;
const height = 120;
const flags = ["--size", `${width}x${height}`, "--pmd", "64x48", "--period-ms", "200", "--seed", "1"];

const wide = { width: 1280, height: 860 };
const phone = { width: 360, height: 740 };
let browser;
const complaints = [];

// more: of the browser, as Playwright has it.
async function open(address, size = wide, scheme = "light", more = {}) {
  const context = await browser.newContext({ viewport: size, colorScheme: scheme, ...more });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  page.on("console", (message) => {
    // This test reads the canvases, the page does not.
    const ours = /willReadFrequently|GPU stall due to ReadPixels/.test(message.text());
    if (["error", "warning"].includes(message.type()) && !ours) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(error.message));
  page.messages = [];
  page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => {
    if (typeof payload === "string") page.messages.push(JSON.parse(payload));
    else page.newest = JSON.parse(payload.subarray(4, 4 + payload.readUInt32LE(0)));  // the head of the newest frame
  }));
  page.begun = Date.now();
  await page.goto(address);
  return page;
}

const text = (page, id) => page.locator(`#${id}`).innerText();
const choose = (page, name, value) => page.locator(`input[name=${name}][value=${value}]`).check({ force: true });
const live = (page, wanted = width) => until("a frame", async () => (await page.locator("#map").evaluate((map) => map.width)) === wanted);
const shot = (page, name) => page.screenshot({ path: join(out, `${name}.png`), fullPage: true });

// Moves the pointer to a pixel and reads what the page says of it.
async function probe(page, x, y) {
  await page.locator("#map").scrollIntoViewIfNeeded();
  const box = await page.locator("#map").boundingBox();
  const scale = Math.min(box.width / width, box.height / height);
  await page.mouse.move(box.x + (box.width - width * scale) / 2 + (x + 0.5) * scale, box.y + (box.height - height * scale) / 2 + (y + 0.5) * scale);
  await until("the probe", async () => (await text(page, "probe-pixel")) === `${x}, ${y}`);
  await until("width and source", async () => !(await text(page, "probe-source")).includes("not sent"));
  return page.evaluate(([column, row]) => {
    const said = (id) => document.getElementById(`probe-${id}`).textContent;
    const [r, g, b] = document.getElementById("map").getContext("2d").getImageData(column, row, 1, 1).data;
    return { depth: said("depth"), width: said("width"), source: said("source"), colour: [r, g, b] };
  }, [x, y]);
}

// RGBA of a picture of one element, decoded by an empty page.
async function pixels(page, id) {
  const png = (await page.locator(`#${id}`).screenshot()).toString("base64");
  const helper = await page.context().newPage();
  const made = await helper.evaluate(async (data) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return { width: bitmap.width, height: bitmap.height, data: Array.from(context.getImageData(0, 0, bitmap.width, bitmap.height).data) };
  }, png);
  await helper.close();
  return made;
}

function near(a, b, most) {
  return a.every((value, at) => Math.abs(value - b[at]) <= most);
}

const checks = {
  async "depth, colours and probe are those of the scene, at most 2 s after the page was opened"({ address, truth }) {
    const page = await open(address);
    await live(page);
    console.log(`  first depth after ${Date.now() - page.begun} ms`);
    await until("calibrated health", () => page.messages.some((message) => message.type === "status"));
    const hello = page.messages.find((message) => message.type === "hello");
    const table = hello.colours.map((colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)));
    let right = 0;
    let judged = 0;
    const wrong = [];
    for (let n = 0; n < 24; ++n) {
      const [x, y] = [8 + (n * 53) % (width - 16), 8 + (n * 31) % (height - 16)];
      const said = await probe(page, x, y);
      if (said.depth === "none") continue;
      const metres = parseFloat(said.depth);
      const place = Math.min(1, Math.max(0, Math.log(metres / hello.near_m) / Math.log(hello.far_m / hello.near_m)));
      // A frame may have come between the two readings: a step of the table away.
      assert.ok([-25, 0, 25].some((off) => near(said.colour, table[Math.min(1023, Math.max(0, Math.round(place * 1023) + off))], 25)),
        `${x}, ${y}: ${said.depth} in ${said.colour}`);
      assert.match(said.width, /^± \d+\.\d mm$/);
      assert.match(said.source, /^(stereo|PMD|both|resolved)$/);
      ++judged;
      const z = truth.z[y * width + x];
      if (Math.abs(metres - z) < 0.08 * z) ++right;
      else wrong.push(`${x}, ${y}: ${said.depth} by ${said.source}, is ${z.toFixed(3)} m`);
    }
    assert.ok(judged >= 18 && right >= 0.8 * judged, `${right} of ${judged} probes are right; wrong: ${wrong.join("; ")}`);
    await shot(page, "depth_light");
    await page.context().close();
  },

  async "the cloud seen from the sensor's place is the depth map, and turns"({ address }) {
    const page = await open(address);
    await live(page);
    await page.mouse.move(0, 0);
    const map = await pixels(page, "map");
    await choose(page, "base", "cloud");
    await page.locator("#pause").click();
    await new Promise((done) => setTimeout(done, 1500));
    const cloud = await pixels(page, "cloud");
    assert.deepEqual([cloud.width, cloud.height], [map.width, map.height]);
    const alike = (a, b) => {
      let same = 0;
      let all = 0;
      for (let at = 0; at < a.data.length; at += 4 * 97) {
        const [one, other] = [a.data.slice(at, at + 3), b.data.slice(at, at + 3)];
        if (Math.max(...one) - Math.min(...one) < 20) continue;  // no depth
        ++all;
        same += near(one, other, 40) ? 1 : 0;
      }
      return same / all;
    };
    const still = alike(map, cloud);
    assert.ok(still > 0.8, `only ${still} of the cloud is where the map has it`);
    await page.locator("#cloud").focus();
    for (let n = 0; n < 4; ++n) await page.keyboard.press("ArrowRight");
    await new Promise((done) => setTimeout(done, 800));
    const turned = alike(map, await pixels(page, "cloud"));
    assert.ok(turned < still - 0.1, `turned: ${turned}, before: ${still}`);
    await shot(page, "cloud_paused");
    await page.context().close();
  },

  async "overlays, left picture, scale and dark"({ address }) {
    const page = await open(address, wide, "dark");
    await live(page);
    await shot(page, "depth_dark");
    const before = await text(page, "ticks");
    await choose(page, "scale", "auto");
    await until("another scale", async () => (await text(page, "ticks")) !== before);
    await shot(page, "depth_auto_dark");
    await choose(page, "scale", "fixed");
    for (const overlay of ["source", "width"]) {
      await choose(page, "overlay", overlay);
      await new Promise((done) => setTimeout(done, 700));
      await shot(page, `${overlay}_dark`);
    }
    await choose(page, "overlay", "none");
    await choose(page, "base", "left");
    await until("the left picture", async () => page.locator("#map").evaluate((map) => {
      const data = map.getContext("2d").getImageData(0, 0, map.width, map.height).data;
      const greys = new Set();
      for (let at = 0; at < data.length; at += 4) if (data[at] === data[at + 1]) greys.add(data[at]);
      return greys.size > 40;
    }));
    await shot(page, "left_dark");
    // A picture that stands has all planes.
    await choose(page, "base", "depth");
    await page.locator("#pause").click();
    await until("a frame with all planes", async () => { await probe(page, 40, 60); return true; });
    await choose(page, "overlay", "source");
    await new Promise((done) => setTimeout(done, 1500));
    assert.ok(await page.locator("#note").isHidden());
    await shot(page, "source_paused_dark");
    await page.context().close();
  },

  async "a wide window: the tools are one row, and both columns end about where the other does"({ address }) {
    for (const size of [wide, { width: 1440, height: 900 }]) {
      const page = await open(address, size);
      await live(page);
      await until("health", async () => (await text(page, "health")) !== "Nothing is known yet.");
      await until("the panel that pairs", async () => page.locator("#pairing").isVisible());
      const { ends, left, right } = await page.evaluate(() => {
        const record = document.getElementById("record");
        record.textContent = "Stop recording";  // the longest that it is called
        const end = (one) => Math.round(one.getBoundingClientRect().bottom);
        return { ends: [...record.parentElement.children].map(end), left: end(document.getElementById("minute")), right: end(document.getElementById("events-card")) };
      });
      assert.equal(new Set(ends).size, 1, `${size.width}: ${ends}`);
      assert.ok(Math.abs(left - right) < 200, `${size.width}: the left column ends at ${left}, the right one at ${right}`);
      await shot(page, `wide_${size.width}`);
      await page.emulateMedia({ colorScheme: "dark" });
      await new Promise((done) => setTimeout(done, 600));
      await shot(page, `wide_${size.width}_dark`);
      await page.context().close();
    }
  },

  async "the ends of the scale: what is wrong with one is said of that one"({ address }) {
    const page = await open(address);
    await live(page);
    const before = await text(page, "ticks");
    const said = async (id, value) => {
      await page.locator(`#${id}`).fill(value);
      await page.locator(`#${id}`).dispatchEvent("change");
      return page.evaluate(() => ["near", "far"].map((end) => document.getElementById(end)).map((end) => end.validity.customError ? end.validationMessage : ""));
    };
    const near = await page.locator("#near").inputValue();
    assert.deepEqual(await said("near", "-3"), ["has to be more than 0 m", ""]);
    assert.deepEqual(await said("near", ""), ["give a distance in metres", ""]);
    assert.deepEqual(await said("near", "99"), ["has to be below the other end", ""]);
    assert.deepEqual(await said("far", "-1"), ["", "has to be more than 0 m"]);
    assert.equal(await text(page, "ticks"), before);
    await said("near", near);
    assert.deepEqual(await said("far", "2"), ["", ""]);
    assert.notEqual(await text(page, "ticks"), before);
    await page.context().close();
  },

  async "touch: the hint speaks of fingers, and a tap reads a pixel"({ address }) {
    const page = await open(address, phone, "dark", { hasTouch: true, isMobile: true });
    await live(page);
    const hint = await text(page, "keys");
    assert.match(hint, /^Touch a pixel\. Drag/);
    assert.doesNotMatch(hint, /keys|Point/);
    await page.locator("#map").tap();
    await until("a pixel", async () => /^\d+, \d+$/.test(await text(page, "probe-pixel")));
    // A picture of the whole page is taken as of a screen that is not touched.
    await page.locator("#keys").scrollIntoViewIfNeeded();
    await page.screenshot({ path: join(out, "phone_touch_dark.png") });
    await page.context().close();
    const other = await open(address);
    assert.match(await text(other, "keys"), /^Point at a pixel.*0 goes back\.$/);
    await other.context().close();
  },

  async "a phone: nothing is wider than 360 px, and the keys reach everything"({ address }) {
    const page = await open(address, phone);
    await live(page);
    for (const base of ["depth", "left", "cloud"]) {
      await choose(page, "base", base);
      await new Promise((done) => setTimeout(done, 500));
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), phone.width, base);
      await shot(page, `phone_${base}`);
    }
    await choose(page, "base", "depth");
    const reached = new Set();
    for (let n = 0; n < 30; ++n) {
      await page.keyboard.press("Tab");
      reached.add(await page.evaluate(() => document.activeElement?.id || document.activeElement?.getAttribute("name")));
    }
    for (const id of ["theme", "base", "overlay", "scale", "near", "far", "pause", "map", "events"]) assert.ok(reached.has(id), `${id}: ${[...reached]}`);
    await page.locator("#map").focus();
    await page.keyboard.press("ArrowRight");
    await until("words for who listens", async () => (await text(page, "said")).startsWith(`Pixel ${width / 2 + 1}, ${height / 2}: depth `));
    const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, canvas")].filter((one) =>
      !one.closest("[aria-hidden=true]") && !(one.getAttribute("aria-label") || one.textContent.trim() || one.closest("label")?.textContent.trim())).length);
    assert.equal(unnamed, 0);
    await page.context().close();
  },

  async "a hidden page asks for nothing"({ address }) {
    const page = await open(address);
    await live(page);
    const hide = (is) => page.evaluate((hidden) => {
      Object.defineProperty(document, "hidden", { configurable: true, get: () => hidden });
      document.dispatchEvent(new Event("visibilitychange"));
    }, is);
    await hide(true);
    await new Promise((done) => setTimeout(done, 700));
    const asked = () => page.messages.filter((message) => message.type !== "event").length;
    const before = asked();
    await new Promise((done) => setTimeout(done, 2000));
    assert.equal(asked(), before);
    await hide(false);
    await until("a status", () => asked() > before);
    await page.context().close();
  },

  async "a fault is shown, a restart is shown, and both end by themselves"() {
    // The PMD camera goes at its 25th call and is back later.
    const sensor = await startSensor(bin, 0, [...flags, "--fault", "pmd:vanish:25+60"]);
    const view = await startView(bin, sensor.port);
    const page = await open(view.address);
    await live(page);
    await until("the fault", async () => (await text(page, "active")).includes("pmd lost"));
    assert.match(await text(page, "state"), /pmd lost/);
    assert.match(await text(page, "events"), /pmd_lost began/);
    await shot(page, "fault");
    await until("its end", async () => (await text(page, "events")).includes("pmd_lost ended"));
    await sensor.stop();
    await until("silence", async () => (await text(page, "state")).startsWith("Old picture: no frame comes"));
    await until("the event", async () => /the sensor is silent, its last frame/.test(await text(page, "events")));
    await shot(page, "silent");
    const again = await startSensor(bin, sensor.port, flags);
    await until("frames again", async () => (await text(page, "state")) === "Live");
    await until("both events", async () => /the sensor sends again[^]*the sensor started again/.test(await text(page, "events")));
    await page.reload();
    await live(page);
    await until("events again", async () => (await text(page, "events")).includes("pmd_lost ended"));
    complaints.length = 0;
    await view.stop();
    await until("the end", async () => (await text(page, "state")).includes("ended or cannot be reached"));
    await shot(page, "ended");
    complaints.length = 0;  // Chromium tells of each connection that is refused
    await page.context().close();
    await again.stop();
  },
};

let failed = 0;

async function checkAll() {
  const truthFile = join(folder, "truth.pfm");
  const sensor = await startSensor(bin, 0, [...flags, "--truth", truthFile]);
  const view = await startView(bin, sensor.port);
  await until("the truth", () => { try { return readFileSync(truthFile).length > width * height * 4; } catch { return false; } });
  const rig = { address: view.address, truth: readPfm(truthFile) };
  const tools = { bin, root, flags, open, text, choose, live, shot, probe, phone };
  for (const [name, check] of Object.entries({ ...checks, ...panelChecks(tools), ...ownerChecks(tools), ...calibrationChecks(tools) })) {
    if (!name.includes(only)) continue;
    try {
      await check(rig);
      assert.deepEqual(complaints, [], "the browser's console");
      console.log(`ok    ${name}`);
    } catch (error) {
      ++failed;
      complaints.length = 0;
      console.log(`FAIL  ${name}\n  ${error.stack}`);
    }
  }
  await view.stop();
  await sensor.stop();
  if (Number(loadSeconds) > 0) await measure(browser, bin, Number(loadSeconds));
}

try {
  browser = await chromium.launch({
    executablePath: "/usr/bin/chromium",
    args: [...(process.getuid() === 0 ? ["--no-sandbox"] : []), "--disable-gpu", "--enable-unsafe-swiftshader"],
  });
  if (docs) await drawDocs({ bin, out: docs, open, text, choose, live });
  else await checkAll();
} finally {
  await browser?.close();
  stopAll();
}
console.log(`pictures: ${docs || out}`);
process.exit(failed ? 1 : 0);
