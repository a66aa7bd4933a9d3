// The pictures of the README and of docs/VIEWER.md, of what a new user sees: scripts/viewer_check --docs DIR.
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { configHome, folder, start, startSensor, startView, until } from "./programs.mjs";

const size = { width: 1000, height: 620 };

export async function drawDocs({ bin, out, open, text, choose, live }) {
  mkdirSync(out, { recursive: true });
  mkdirSync(configHome, { recursive: true });
  const [socket, keys] = [join(folder, "docs_faults"), join(folder, "docs_keys")];
  await start(join(bin, "stof"), ["pair", "--into", keys]).ended;
  const sensor = await startSensor(bin, 0, ["--scene", "corridor", "--size", "640x480", "--pmd", "176x144", "--period-ms", "250", "--seed", "1", "--keys", keys,
    "--fault-socket", socket]);
  const view = await startView(bin, sensor.port, ["--fault-socket", socket]);
  const page = await open(view.address, size);
  await live(page, 640);
  await until("health and ten seconds of plots", () => page.messages.filter((message) => message.type === "status" && message.health).length > 20);
  // Noise makes PNG files four times as large.
  const shot = (name, of = page) => of.screenshot({ path: join(out, `${name}.jpg`), type: "jpeg", quality: 82, animations: "disabled" });
  const map = await page.locator("#map").boundingBox();
  await page.mouse.move(map.x + 0.45 * map.width, map.y + 0.6 * map.height);
  await until("the probe", async () => !/not sent|–/.test((await text(page, "probe-source")) + (await text(page, "probe-depth"))));
  await shot("depth");
  await page.mouse.move(0, 0);
  await choose(page, "base", "cloud");
  await page.locator("#pause").click();
  await new Promise((done) => setTimeout(done, 2500));
  await page.locator("#cloud").focus();
  for (const key of ["ArrowLeft", "ArrowLeft", "ArrowDown"]) await page.keyboard.press(key);
  await page.locator("#cloud").evaluate((cloud) => cloud.blur());
  await new Promise((done) => setTimeout(done, 2500));
  await shot("cloud");
  await page.locator("#pause").click();
  await choose(page, "base", "depth");
  await until("the panel", async () => page.locator("#faults").isVisible());
  await page.locator("#fault-device").selectOption("pmd");
  await page.locator("#fault-kind").selectOption("vanish");
  await page.locator("#fault-edges").fill("");
  await page.locator("#fault-give").click();
  await until("its effect", async () => (await text(page, "active")).includes("pmd lost"));
  await page.evaluate(() => { document.activeElement.blur(); scrollTo(0, 0); });
  await new Promise((done) => setTimeout(done, 1500));
  await shot("fault");
  await page.locator("#fault-list button").click();
  await until("its end", async () => !(await text(page, "active")).includes("pmd lost"));
  await page.locator("#settings summary").click();
  await until("the settings", async () => (await page.locator(".field").count()) > 40);
  await page.locator("#settings-search").fill("max_range");
  await page.locator("[id='set-depth.max_range_mm']").fill("4000");
  await page.locator("#settings-apply").click();
  await until("an answer", async () => (await text(page, "settings-said")) !== "");
  await page.evaluate(() => document.activeElement.blur());
  await new Promise((done) => setTimeout(done, 1500));
  await shot("settings", page.locator("#settings"));
  await page.context().close();
  await view.stop();
  await sensor.stop();
}
