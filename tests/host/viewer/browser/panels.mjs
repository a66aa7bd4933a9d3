// What the page's panels do: settings, faults, recording, the seek bar.
import { strict as assert } from "node:assert";
import { existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { configHome, folder, start, startSensor, startView, until } from "./programs.mjs";

const wide = { width: 1280, height: 860 };

async function run(program, words) {
  const made = start(program, words);
  return { code: await made.ended, text: made.text };
}

export function panelChecks({ bin, flags, open, text, live, shot, probe, phone }) {
  const openSettings = async (page) => {
    await page.locator("#settings summary").click();
    await until("the settings", async () => (await page.locator(".field").count()) > 40);
  };
  const field = (page, path) => page.locator(`[id="set-${path}"]`);
  const apply = async (page) => {
    await page.locator("#settings-apply").click();
    await until("an answer", async () => (await text(page, "settings-said")) !== "");
    return text(page, "settings-said");
  };
  const fits = async (page, size) => assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), size.width);

  return {
    async "settings: without a key the harmless ones, in the sensor's words, and the stream follows"({ address, truth }) {
      const page = await open(address);
      await live(page);
      await openSettings(page);
      assert.match(await text(page, "settings-who"), /not paired: without a key only the harmless/);
      assert.ok(await field(page, "depth.preset").isDisabled());
      assert.ok(await page.locator("#settings-save").isHidden());
      // Of the schema: choices, ends, unit and help.
      assert.deepEqual(await field(page, "streams.depth").locator("option").allInnerTexts(), ["off", "raw", "rvl", "fit"]);
      assert.equal(await field(page, "depth.max_range_mm").getAttribute("max"), "16380");
      assert.match(await page.locator("[id='set-depth.max_range_mm-help']").innerText(), /nothing is further away \(500 to 16380 mm\)/);
      await shot(page, "settings_light");
      // A far pixel loses its depth.
      const width = truth.width;
      const at = truth.z.findIndex((z, place) => z > 4 && z < 8 && place % width > 20 && place % width < 140 && place > 20 * width);
      const far = [at % width, Math.floor(at / width)];
      await field(page, "depth.max_range_mm").fill("2000");
      assert.equal(await text(page, "settings-apply"), "Apply 1 change");
      assert.match(await apply(page), /^revision \d+.*in force, until the next start$/); // nobody here may save it
      await until("no depth there", async () => (await probe(page, ...far)).depth === "none");
      await until("a field that is as it was", async () => await page.locator("#settings-apply").isDisabled());
      await page.mouse.move(0, 0);
      await shot(page, "settings_applied");
      // The sensor refuses, and says why; nothing has changed.
      await field(page, "depth.max_range_mm").fill("500");
      assert.match(await apply(page), /max_range_mm.*1000/);
      assert.equal(await page.locator("#settings-said").getAttribute("data-level"), "major");
      await shot(page, "settings_refused");
      await page.locator("#settings-drop").click();
      assert.equal(await field(page, "depth.max_range_mm").inputValue(), "2000");
      // What is beyond the schema is not even asked.
      await field(page, "depth.max_range_mm").fill("99999");
      await page.locator("#settings-apply").click();
      assert.ok(await field(page, "depth.max_range_mm").evaluate((input) => !input.checkValidity()));
      assert.match(await text(page, "settings-said"), /^depth\.max_range_mm: .*16380/);
      assert.equal(await page.locator("#settings-said").getAttribute("data-level"), "major");
      await field(page, "depth.max_range_mm").fill("");
      await page.locator("#settings-apply").click();
      assert.equal(await text(page, "settings-said"), "depth.max_range_mm: give a number, 500 to 16380 mm");
      await page.locator(".field", { has: field(page, "depth.max_range_mm") }).locator("button").click();
      assert.equal(await field(page, "depth.max_range_mm").inputValue(), "10000");
      assert.match(await apply(page), /^revision/);
      await until("all is as it was", async () => await page.locator("#settings-apply").isDisabled());
      await page.locator("#settings-search").fill("grey_left");
      assert.equal(await page.locator(".field:visible").count(), 1);
      await page.context().close();
      const small = await open(address, phone, "dark");
      await live(small);
      await openSettings(small);
      await fits(small, phone);
      await shot(small, "phone_settings_dark");
      await small.context().close();
    },

    async "settings: a key of the user changes and saves all, and no page sees it"() {
      const keys = join(folder, "sensor.keys");
      mkdirSync(configHome, { recursive: true });
      assert.equal((await run(join(bin, "stof"), ["pair", "--into", keys])).code, 0);
      const saved = join(folder, "settings.json");
      const sensor = await startSensor(bin, 0, [...flags, "--keys", keys, "--settings", saved]);
      const view = await startView(bin, sensor.port);
      const page = await open(view.address, wide, "dark");
      await live(page);
      await openSettings(page);
      assert.match(await text(page, "settings-who"), /changes everything/);
      await field(page, "name").fill("left arm");
      await field(page, "depth.guided").check();
      await field(page, "limits.streams").selectOption("none");
      assert.equal(await text(page, "settings-apply"), "Apply 3 changes");
      assert.match(await apply(page), /^revision/);
      await until("what is not saved", async () => (await page.locator(".field", { has: field(page, "name") }).innerText()).includes("not saved: the next start begins with stof"));
      await shot(page, "settings_admin_dark");
      await page.locator("#settings-save").click();
      await until("it is saved", async () => (await text(page, "settings-said")).includes("saved"));
      assert.ok(existsSync(saved));
      // Whoever changes it elsewhere is seen here.
      assert.equal((await run(join(bin, "stof"), ["config", `127.0.0.1:${sensor.port}`, "set", "name=other"])).code, 0);
      await until("the other name", async () => (await field(page, "name").inputValue()) === "other");
      const said = JSON.stringify(page.messages);
      assert.ok(!/secret/i.test(said));
      await page.context().close();
      await view.stop();
      await sensor.stop();
    },

    async "faults: one that is injected shows as such, and ends"() {
      const socket = join(folder, "faults");
      const sensor = await startSensor(bin, 0, [...flags, "--fault-socket", socket]);
      const view = await startView(bin, sensor.port, ["--fault-socket", socket]);
      const page = await open(view.address);
      await live(page);
      await until("the panel", async () => page.locator("#faults").isVisible());
      assert.deepEqual(await page.locator("#fault-device option").allInnerTexts(), ["Trigger", "Stereo pair", "PMD camera"]);
      await page.locator("#fault-device").selectOption("pmd");
      await page.locator("#fault-kind").selectOption("vanish");
      await page.locator("#fault-edges").fill("0"); // as little as stof fault takes
      assert.ok(await page.locator("#fault-edges").evaluate((input) => !input.checkValidity()));
      await page.locator("#fault-edges").fill("");
      await page.locator("#fault-give").click();
      await until("the condition", async () => (await text(page, "active")).includes("pmd lost"));
      assert.match(await text(page, "state"), /pmd lost/);
      await until("the event", async () => (await text(page, "events")).includes("pmd_lost began"));
      assert.match(await text(page, "fault-list"), /PMD camera: vanish, until it is ended/);
      await shot(page, "fault_injected");
      await page.locator("#fault-list button").click();
      await until("its end", async () => (await text(page, "events")).includes("pmd_lost ended"));
      assert.equal(await text(page, "fault-list"), "");
      await page.locator("#fault-device").selectOption("stereo");
      assert.ok(!(await page.locator("#fault-kind option").allInnerTexts()).some((kind) => kind.startsWith("dark")));
      // From the command line, counted in edges; the page tells it.
      const given = await run(join(bin, "stof"), ["fault", socket, "stereo:vanish:30"]);
      assert.equal(given.code, 0, given.text);
      await until("the pair is lost", async () => (await text(page, "events")).includes("stereo_lost began"));
      await until("the pair is back", async () => (await text(page, "events")).includes("stereo_lost ended"));
      // One of the page that ends by itself.
      await page.locator("#fault-edges").fill("20");
      await page.locator("#fault-give").click();
      await until("that it is in force", async () => (await text(page, "fault-said")).startsWith("The fault is in force"));
      await until("that it has ended", async () => (await text(page, "fault-said")) === "The fault has ended.");
      // The sensor goes, and is back.
      const choices = () => page.locator("#fault-form option").allInnerTexts();
      const before = await choices();
      assert.ok(before.length > 6, `${before}`);
      await sensor.stop();
      await until("that it is absent", async () => /no emulated sensor listens/.test(await text(page, "fault-said")));
      assert.deepEqual(await choices(), before);
      assert.ok(await page.locator("#fault-give").isDisabled());
      await shot(page, "fault_absent");
      const again = await startSensor(bin, sensor.port, [...flags, "--fault-socket", socket]);
      await until("that it is back", async () => (await text(page, "fault-said")) === "");
      assert.ok(await page.locator("#fault-give").isEnabled());
      await page.setViewportSize(phone);
      await fits(page, phone);
      await shot(page, "phone_fault");
      await page.context().close();
      await view.stop();
      await again.stop();
    },

    async "a recording is made, opens, and a seek shows the frame of that time"() {
      const to = join(folder, "recordings");
      mkdirSync(to);
      const sensor = await startSensor(bin, 0, flags);
      const view = await startView(bin, sensor.port, ["--record-to", to]);
      const live1 = await open(view.address);
      await live(live1);
      await live1.locator("#record").click();
      await until("some frames", async () => Number((await text(live1, "record-said")).match(/, (\d+) frames/)?.[1] ?? 0) >= 20);
      assert.equal(await live1.locator("#record").getAttribute("aria-pressed"), "true");
      await shot(live1, "recording");
      await live1.locator("#record").click();
      await until("the end", async () => (await text(live1, "record-said")).startsWith("Recorded "));
      await shot(live1, "recorded");
      await live1.context().close();
      await view.stop();
      await sensor.stop();
      const [name] = readdirSync(to);
      assert.match(name, /^stof_\d{8}_\d{6}\.mcap$/);
      const file = join(to, name);
      const info = await run(join(bin, "stof"), ["info", file, "--json"]);
      assert.equal(info.code, 0, info.text);
      const frames = JSON.parse(info.text).frames;
      assert.ok(frames >= 20, info.text);

      const replay = await startView(bin, file);
      const page = await open(replay.address);
      await live(page);
      const place = () => page.messages.filter((message) => message.type === "playback").at(-1);
      await until("the seek bar", async () => page.locator("#player").isVisible());
      assert.ok(await page.locator("#record").isHidden() && await page.locator("#settings").isHidden());
      assert.ok(place().seekable && place().length_ms >= 3000, JSON.stringify(place()));
      await page.locator("#play").click();
      await until("it stands", () => !place().playing);
      const seek = async (ms) => {
        await page.locator("#seek").evaluate((bar, to) => { bar.value = String(to); bar.dispatchEvent(new Event("input")); }, ms);
        await until(`the frame of ${ms} ms`, () => Math.abs(place().at_ms - ms) <= 250 + 200 && page.newest);
        await new Promise((done) => setTimeout(done, 400));
        return page.newest.frame;
      };
      assert.equal(await text(page, "pause"), "Freeze"); // this page's picture; the other button is the recording's
      assert.equal(await text(page, "play"), "Play");
      // Health is that of the place: a recording begins with the one that came before its first frame.
      const first = await seek(0);
      const up = async () => Number(/, up (\d+) s/.exec(await text(page, "health"))?.[1] ?? NaN);
      await until("the health of before", async () => !Number.isNaN(await up()));
      const begun = await up();
      assert.equal(await text(page, "state"), "Playback, paused");
      assert.equal(await page.locator("#state").getAttribute("data-level"), "play"); // not that of a live sensor
      await shot(page, "replay_begin");
      const later = await seek(2000);
      await until("the health of then", async () => await up() > begun);
      await until("what is active", async () => (await text(page, "active")).includes("unpaired"));
      assert.ok(place().at_ms >= 2000, `${place().at_ms}`);
      // Five a second, but for those that a busy machine lost.
      assert.ok(later > first && later - first <= 11, `${first}, ${later}`);
      assert.equal(await seek(0), first);
      assert.match(await text(page, "player-time"), /^0:00\.\d of 0:0\d\.\d$/);
      // It stands: nothing else comes.
      await new Promise((done) => setTimeout(done, 1000));
      assert.equal(page.newest.frame, first);
      await shot(page, "replay_halted");
      // Keys: on the page itself, and on the bar.
      await page.locator("body").press("End");
      await until("the end", () => place().at_ms === place().length_ms);
      await page.locator("#seek").press("Home");
      await until("the begin", () => place().at_ms < 250);
      await page.evaluate(() => document.activeElement.blur());
      await page.locator("body").press(" ");
      await until("it plays", () => place().playing && place().at_ms > 600);
      await page.setViewportSize(phone);
      await fits(page, phone);
      await shot(page, "phone_replay");
      await page.context().close();
      await replay.stop();
      // Cut, it has no index: no end, nothing to jump by, and a clock that begins with it.
      const cut = join(folder, "cut.mcap");
      writeFileSync(cut, readFileSync(file).subarray(0, -100));
      const plain = await startView(bin, cut);
      const short = await open(plain.address, wide, "dark");
      await live(short);
      await until("the player", async () => /^0:0\d\.\d$/.test(await text(short, "player-time")));
      assert.ok(await short.locator("#seek").isHidden() && await short.locator("#back").isHidden());
      assert.match(await text(short, "player-note"), /no index.*stof recover makes one\. It was recorded /);
      await shot(short, "replay_cut_dark");
      await short.context().close();
      await plain.stop();
    },

    async "a silence in a recording is played as one, and told in a line of its own on a phone"() {
      const sensor = await startSensor(bin, 0, flags);
      const file = join(folder, "silence.mcap");
      const made = start(join(bin, "stof"), ["record", `127.0.0.1:${sensor.port}`, file, "--timeout", "30"]);
      const wait = (ms) => new Promise((done) => setTimeout(done, ms));
      await until("a recording", () => existsSync(file) && readFileSync(file).length > 100_000);
      await wait(2000);
      sensor.child.kill("SIGSTOP");
      await wait(5000);
      sensor.child.kill("SIGCONT");
      await wait(4000);
      made.child.kill("SIGINT");
      assert.equal(await made.ended, 0, made.text);
      await sensor.stop();
      const view = await startView(bin, file);
      for (const [size, theme, name] of [[wide, "light", "replay_silence"], [{ width: 390, height: 844 }, "light", "phone_replay_silence"],
        [{ width: 390, height: 844 }, "dark", "phone_replay_silence_dark"], [wide, "dark", "replay_silence_dark"]]) {
        const page = await open(view.address, size, theme);
        await live(page);
        await until("the silence", async () => /^Old picture: the recording has nothing here for [45]\.\d s$/.test(await text(page, "state")));
        const opacity = () => page.locator("#stage").evaluate((stage) => getComputedStyle(stage).opacity);
        assert.equal(await opacity(), "0.45");
        const at = (await page.messages.filter((message) => message.type === "playback").at(-1)).at_ms;
        await until("the bar goes on", () => page.messages.filter((message) => message.type === "playback").at(-1).at_ms > at + 300);
        assert.match(await text(page, "events"), /the sensor sends again[^]*the sensor is silent, its last frame/);
        const box = (id) => page.locator(`#${id}`).boundingBox();
        if (size.width < 480) {
          const [state, button, sensorBox] = [await box("state"), await box("theme"), await box("sensor")];
          assert.ok(state.width > size.width - 40, JSON.stringify(state)); // a row of its own
          assert.ok(Math.abs(button.y + button.height / 2 - sensorBox.y - sensorBox.height / 2) < 12, JSON.stringify([button, sensorBox]));
        }
        // What lies beside the picture has no colour of what has no depth.
        const beside = await page.locator("#stage").evaluate((stage) => getComputedStyle(stage).backgroundColor);
        assert.ok(!["rgb(38, 40, 44)", "rgb(52, 54, 58)"].includes(beside), beside);
        assert.match(await text(page, "counts"), /Since the start: lost 0 frames; incomplete \d+; packets missing /);
        await fits(page, size);
        await shot(page, name);
        await until("frames again", async () => (await text(page, "state")).startsWith("Playback"));
        assert.equal(await opacity(), "1");
        await page.context().close();
      }
      await view.stop();
    },
  };
}
