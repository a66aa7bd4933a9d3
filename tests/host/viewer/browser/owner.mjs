// What only the sensor's owner has done by the page: it is paired, and gets another release.
import { strict as assert } from "node:assert";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { configHome, folder, lastingPort, start, startSensor, startView, until } from "./programs.mjs";

const wide = { width: 1280, height: 860 };

export function ownerChecks({ bin, root, flags, open, text, live, shot, phone }) {
  const fits = async (page) => {
    await page.setViewportSize(phone);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), phone.width);
  };
  // What a screen reader calls the fields and buttons of a panel that can be seen.
  const unnamed = (page, id) => page.locator(`#${id}`).evaluate((panel) => [...panel.querySelectorAll("button, input, select, progress")].filter((one) =>
    one.checkVisibility() && !(one.getAttribute("aria-label") || one.textContent.trim() || one.closest("label")?.textContent.trim())).length);

  return {
    async "pairing: refused in the sensor's words, by keys alone, digits that are compared, and then the panel goes"() {
      const sensor = await startSensor(bin, 0, [...flags, "--settings", join(folder, "pairing.json")]);
      const keys = mkdtempSync(join(folder, "keys"));
      const view = await startView(bin, sensor.port, ["--keys", join(keys, "keys")]);
      const page = await open(view.address);
      await live(page);
      await until("the panel", async () => page.locator("#pairing").isVisible());
      assert.match(await text(page, "pair-why"), /Nobody has paired this sensor/);
      assert.equal(await unnamed(page, "pairing"), 0);
      await shot(page, "pairing_light");
      await page.locator("#pair").click();
      await until("the sensor's words", async () => (await text(page, "pair-said")).includes("does not pair now: press its button"));
      await shot(page, "pairing_refused");
      const press = async () => {
        const count = (words) => sensor.text.split(words).length;
        const before = count("pairing is open");
        const ended = count("Press it again");
        await new Promise((done) => setTimeout(done, 300));
        sensor.child.kill("SIGUSR1");
        await until("an answer to the press", () => count("pairing is open") > before || count("Press it again") > ended);
        if (count("pairing is open") === before) { // an attempt was under way: it has ended
          sensor.child.kill("SIGUSR1");
          await until("the window", () => count("pairing is open") > before);
        }
      };
      const digits = (number) => until("the sensor's digits", () => [...sensor.text.matchAll(/the digits are (\d{3} \d{3}),/g)][number]?.[1]);
      // With keys alone: the focus goes where the next thing is typed.
      await press();
      await page.locator("#pair").focus();
      await page.keyboard.press("Enter");
      await until("the digits' field", async () => page.locator("#pair-digits").evaluate((field) => field === document.activeElement));
      await page.keyboard.type("000 000");
      await shot(page, "pairing_digits");
      await page.keyboard.press("Enter");
      await until("that they differ", async () => /000000 was given, the digits here are \d{6}: mistyped/.test(await text(page, "pair-said")));
      await press();
      await page.emulateMedia({ colorScheme: "dark" });
      await page.locator("#pair").click();
      await page.locator("#pair-digits").fill(await digits(1));
      await page.keyboard.press("Enter");
      await until("that they are equal", async () => /^Equal: (\d{3} \d{3}) there and \1 here\. Now hold/.test(await text(page, "pair-now")));
      await fits(page);
      await page.locator("#pairing").scrollIntoViewIfNeeded();
      await shot(page, "phone_pairing_dark");
      await page.setViewportSize(wide);
      sensor.child.kill("SIGUSR2");
      await until("a key", async () => /^key [0-9a-f]{8} of sensor 00000001, admin, is in /.test(await text(page, "pair-said")));
      await shot(page, "paired_dark");
      const secrets = readFileSync(join(keys, "keys"), "utf8").match(/[0-9a-f]{32,}/g);
      const said = JSON.stringify(page.messages);
      assert.ok(secrets.length && !secrets.some((secret) => said.includes(secret)));
      page.messages.length = 0;
      await page.reload();
      await live(page);
      await until("what the page is told", () => page.messages.some((message) => message.type === "pairing"));
      await until("a status after it", () => page.messages.findIndex((message) => message.type === "pairing") < page.messages.findLastIndex((message) => message.type === "status"));
      assert.ok(await page.locator("#pairing").isHidden());
      await page.context().close();
      await view.stop();
      await sensor.stop();
    },

    async "update: a release of the folder is put on the sensor, and left as it crashes"() {
      const card = join(folder, "card");
      const board = (...words) => execFileSync(join(root, "scripts/emulated_board"), [words[0], card, "--stofd", join(bin, "stofd"), ...words.slice(1)]);
      const settings = join(folder, "card.json");
      const releases = join(folder, "releases");
      mkdirSync(releases);
      mkdirSync(configHome, { recursive: true });
      board("make");
      writeFileSync(join(folder, "crash"), "#!/bin/sh\nexit 1\n");
      board("release", join(releases, "crash.update"), "--program", join(folder, "crash"));
      board("release", join(releases, "good 2.0.update"), "--version", "2.0");
      const own = join(mkdtempSync(join(folder, "keys")), "keys");
      assert.equal(await start(join(bin, "stof"), ["pair", "--into", `${settings}.keys`, "--keys", own]).ended, 0);
      const port = await lastingPort();
      const sensor = start(join(root, "scripts/emulated_board"), ["run", card, "--stofd", join(bin, "stofd"), ...flags, "--port", String(port), "--settings", settings,
        "--set", "discovery.mdns=false", "--set", "discovery.beacon=false"]);
      await until("a frame", () => sensor.text.includes("publishing"));
      const view = await startView(bin, port, ["--keys", own, "--update-from", releases]);
      const page = await open(view.address);
      await live(page);
      page.on("dialog", (dialog) => { page.asked = dialog.message(); return page.agrees ? dialog.accept() : dialog.dismiss(); });
      await page.locator("#update summary").click();
      await until("what runs", async () => /Release [0-9a-f]{8} runs: each start uses it/.test(await text(page, "update-who")));
      assert.deepEqual(await page.locator("#update-file option").allInnerTexts().then((all) => all.map((one) => one.replace(/ \(.*/, ""))), ["crash.update", "good 2.0.update"]);
      assert.equal(await unnamed(page, "update"), 0);
      await shot(page, "update_light");
      await page.locator("#update-put").click();
      await until("a question", () => /sends no frame/.test(page.asked ?? ""));
      assert.equal(sensor.text.split("board: starts").length, 2);
      page.agrees = true;
      await page.locator("#update-put").click();
      await until("that it is left", async () => (await text(page, "update-said")).includes("went back to the former release"));
      assert.equal(await page.locator("#update-said").getAttribute("data-level"), "major");
      await until("frames again", async () => (await text(page, "state")) === "Live");
      await shot(page, "update_left");
      await page.emulateMedia({ colorScheme: "dark" });
      await page.locator("#update-file").selectOption("good 2.0.update");
      await page.locator("#update-put").click();
      await until("the trial", async () => (await page.locator("#update-steps [aria-current=step]").allInnerTexts())[0]?.startsWith("on trial"));
      await until("frames again", async () => (await text(page, "state")) !== "" && !(await text(page, "state")).startsWith("Old picture"));
      await fits(page);
      await shot(page, "phone_update_dark");
      await page.context().close();
      await view.stop();
      await sensor.stop();
    },
  };
}
