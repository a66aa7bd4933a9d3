// A calibration that the page guides: of a board that is waved before the emulated pair, to a file that is installed.
import { strict as assert } from "node:assert";
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync } from "node:fs";
import { join } from "node:path";
import { folder, start, startSensor, startView, until } from "./programs.mjs";

const size = ["--size", "320x240"];
const scene = ["--scene", "board:chess,9x6,0.06", "--misbuilt", "2,1,3"];

async function hasRig(bin) {
  const help = start(join(bin, "stof"), ["calib", "stereo", "--help"]);
  await help.ended;
  return !help.text.includes("Not in this build");
}

export function calibrationChecks({ bin, open, text, live, shot, phone }) {
  return {
    async "calibration: the page says which view is missing, what came of it, and installs it"() {
      const to = join(folder, "calibrations");
      mkdirSync(to);
      const rig = await hasRig(bin);
      const views = join(to, "calibration_00000001_20261101_120000", "views");
      const settings = join(folder, "calibrated.json");
      const own = join(mkdtempSync(join(folder, "keys")), "keys");
      const pair = (file, more) => start(join(bin, "stof"), ["pair", "--into", `${settings}.keys`, "--keys", file, ...more]).ended;
      assert.equal(await pair(own, ["--role", "admin"]), 0);
      if (rig) {
        // Of 26 views that are enough the first eight are held before the sensor, the others were kept before.
        mkdirSync(views, { recursive: true });
        execFileSync(join(bin, "stof_emu_pair"), [views, ...scene, "--poses", "wave:26,3", "--pmd", "none", ...size]);
        for (let n = 0; n < 8; ++n) rmSync(join(views, `pose_00${n}`), { recursive: true });
      }
      const sensor = await startSensor(bin, 0, [...size, "--period-ms", "100", "--no-tof", "--settings", settings, ...scene, "--poses", "wave:26,3", "--hold", "20"]);
      const page = await openWith(own);
      assert.match(await text(page.page, "cal-help"), /--board charuco:12x9:0.04 --paper a1/);
      if (!rig) {
        await until("one line", async () => (await text(page.page, "cal-absent")).startsWith("calibration: this stof was built without it: "));
        assert.ok(await page.page.locator("#cal-start").isHidden());
        await shot(page.page, "calibration_absent");
        await page.close();
        await sensor.stop();
        return;
      }
      // The command that it gives prints the board.
      for (const kind of ["charuco", "aprilgrid", "chess"]) {
        await page.page.locator("#cal-kind").selectOption(kind);
        const words = (await text(page.page, "cal-help")).match(/stof (calib target .*)board\.pdf$/)[1].trim().split(" ");
        execFileSync(join(bin, "stof"), [...words, join(folder, `${kind}.pdf`)]);
      }
      await page.page.locator("#cal-size").fill("60");
      await until("views of before", async () => /^Go on with 18 views/.test(await text(page.page, "cal-go-on")));
      await shot(page.page, "calibration_begin");
      await page.page.locator("#cal-go-on").click();
      await until("corners", async () => page.page.messages.some((message) => message.look?.left.length === 54));
      await until("its picture", async () => page.page.locator("#cal-left").evaluate((canvas) => canvas.width === 640));
      await shot(page.page, "calibration_live");
      // Another page sees it and has no hand in it.
      const second = await open(page.view.address, phone, "dark");
      await live(second, 320);
      await second.locator("#calibration summary").click();
      await until("what the first one does", async () => (await second.locator("#cal-other").isVisible()) && (await second.locator("#cal-left").evaluate((canvas) => canvas.width === 640)));
      assert.ok(await second.locator("#cal-end").isHidden());
      assert.equal(await second.evaluate(() => document.documentElement.scrollWidth), phone.width);
      await second.locator("#cal-live").scrollIntoViewIfNeeded();
      await shot(second, "phone_calibration_dark");
      await second.context().close();
      await until("a result", async () => page.page.locator("#cal-result").isVisible());
      assert.match(await text(page.page, "cal-figures"), /Reprojection error\s+0\.\d{3} px/);
      await shot(page.page, "calibration_result");
      const result = page.page.messages.findLast((message) => message.result).result;
      assert.ok(result.corner_sigma_px < 0.3, JSON.stringify(result));
      page.page.on("dialog", (dialog) => { page.asked = dialog.message(); return dialog.accept(); });
      await page.page.locator("#cal-install").click();
      await until("it is in force", async () => /calibration [0-9a-f]{8} is in force and kept/.test(await text(page.page, "cal-said")));
      assert.match(page.asked, /Install it\?/);
      await shot(page.page, "calibration_installed");
      await page.page.setViewportSize(phone);
      assert.equal(await page.page.evaluate(() => document.documentElement.scrollWidth), phone.width);
      await shot(page.page, "phone_calibration_result");
      await page.close();
      await sensor.stop();

      async function openWith(keys) {
        const view = await startView(bin, sensor.port, ["--keys", keys, "--record-to", to]);
        const made = await open(view.address);
        await live(made, 320);
        await until("rights", () => made.messages.some((message) => message.type === "status" && message.health));
        await made.locator("#calibration summary").click();
        return { view, page: made, close: async () => { await made.context().close(); await view.stop(); } };
      }
    },
  };
}
