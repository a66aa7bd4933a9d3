import { CloudView } from "./cloud_view";
import { Rgb, Scale, rgb, widthFar, widthNear } from "./colours";
import { CalibrationPanel } from "./calibration";
import { Connection } from "./connection";
import { Base, DepthView, Overlay, depthRange } from "./depth_view";
import { levelOf, showEvent, showHealth } from "./events";
import { FaultPanel } from "./faults";
import { Frame, Hello, PairingMessage, Plane, Rights, SensorEvent, Status } from "./messages";
import { PairingPanel } from "./pairing";
import { Requests, find, put } from "./panels";
import { Plot } from "./plots";
import { Probe } from "./probe";
import { Player, RecordButton } from "./recorder";
import { SettingsPanel } from "./settings";
import { UpdatePanel } from "./update";

function chosen(name: string): string {
  return document.querySelector<HTMLInputElement>(`input[name="${name}"]:checked`)!.value;
}

// A number with three digits.
function short(value: number): string {
  return String(Number(value.toPrecision(3)));
}

// Why a field takes no distance; "": it does.
function rangeError(field: HTMLInputElement): string {
  if (field.value === "") return "give a distance in metres";
  return Number(field.value) > 0 ? "" : "has to be more than 0 m";
}

function frames(count: number): string {
  return `${count} ${count === 1 ? "frame" : "frames"}`;
}

const readEveryMs = 100; // faster than that nobody reads

class Page {
  private map = find<HTMLCanvasElement>("map");
  private cloudCanvas = find<HTMLCanvasElement>("cloud");
  private near = find<HTMLInputElement>("near");
  private far = find<HTMLInputElement>("far");
  private rate = new Plot(find("rate"), 10);
  private latency = new Plot(find("latency"), 10);
  private loss = new Plot(find("loss"), 1);
  private probe = new Probe(this.map, find("mark"), (byKey) => this.probed(byKey));
  private depthView: DepthView | null = null;
  private cloudView: CloudView | null = null;
  private connection: Connection;
  private table: Rgb[] = [];
  private sources: { name: string; colour: string }[] = [];
  private scale: Scale | null = null;

  private frame: Frame | null = null; // the newest, or the one that stands while paused
  private fresh = false; // it is not drawn yet
  private paused = false;
  private more = 0; // frames that are still taken while paused
  private choseAt = 0;
  private drawing = 0;
  private received = 0;
  private drawn = 0;
  private latencies: number[] = [];
  private status: Status | null = null;
  private counted = { at: 0, toldMs: 0, frames: 0, bad: 0, received: 0, drawn: 0 };
  private isConnected = false;
  private wasConnected = false;
  private refused = false; // the first connection was
  private saying = 0;
  private aspect = "";
  private recording = false;
  private readAt = 0;
  private requests = new Requests(() => this.connection);
  private settings = new SettingsPanel(this.requests);
  private faults = new FaultPanel(this.requests);
  private recorder = new RecordButton(this.requests);
  private player = new Player(this.requests);
  private pairing = new PairingPanel(this.requests);
  private pairingStep = "none";
  private update = new UpdatePanel(this.requests);
  private calibration = new CalibrationPanel(this.requests);

  constructor() {
    this.connection = new Connection({
      hello: (hello) => this.hello(hello),
      status: (status) => this.told(status),
      event: (event) => this.happened(event),
      frame: (frame) => this.arrived(frame),
      connected: (is) => this.connected(is),
      rights: (rights) => this.mayDo(rights),
      answer: (id, answer) => this.requests.answered(id, answer),
      settings: (message) => this.settings.told(message),
      faults: (message) => this.faults.told(message),
      recording: (message) => this.recorder.told(message),
      playback: (message) => this.player.told(message),
      pairing: (message) => this.paired(message),
      update: (message) => this.update.told(message),
      calibration: (message) => this.calibration.told(message),
    }, () => this.planes());
    for (const input of document.querySelectorAll<HTMLInputElement>("input[type=radio]")) {
      input.addEventListener("change", () => this.choose());
    }
    for (const input of [this.near, this.far]) input.addEventListener("change", () => this.setRange());
    find("pause").addEventListener("click", () => this.pause(!this.paused));
    document.addEventListener("visibilitychange", () => this.connection.rest(document.hidden));
    new ResizeObserver(() => { this.probe.place(); this.showLegend(); this.redraw(); }).observe(find("stage"));
    themeButton(() => { this.plot(); });
    setInterval(() => { if (!document.hidden) this.showState(); }, 500);
    this.connection.rest(document.hidden);
  }

  private hello(hello: Hello): void {
    const name = hello.sensor.replace(/^UDP /, "");
    find("sensor").textContent = name;
    document.title = `stof ${name}`;
    this.recording = hello.recording;
    find("pause").title = `The picture of this page stands; the ${hello.recording ? "recording" : "sensor"} goes on.`;
    find("settings").hidden = find("calibration").hidden = find("update").hidden = hello.recording;
    this.table = hello.colours.map(rgb);
    this.sources = hello.sources;
    if (!this.scale) {
      this.near.value = String(hello.near_m);
      this.far.value = String(hello.far_m);
      this.setScale(new Scale(this.table, hello.near_m, hello.far_m));
    }
    find("events").replaceChildren(); // all of them come again
    find("sources").replaceChildren(...hello.sources.slice(1).map((source) => {
      const item = document.createElement("li");
      const chip = document.createElement("i");
      chip.style.background = source.colour;
      item.append(chip, source.name === "pmd" ? "PMD" : source.name === "conflict" ? "conflict: no depth" : source.name);
      return item;
    }));
  }

  private planes(): Plane[] {
    if (this.paused) return this.more ? ["depth", "width", "source", "left"] : [];
    const base = chosen("base");
    const overlay = chosen("overlay");
    const planes: Plane[] = ["depth"];
    if (overlay === "width" || this.probe.at) planes.push("width");
    if (overlay === "source" || this.probe.at) planes.push("source");
    if (base === "left") planes.push("left");
    return planes;
  }

  private connected(is: boolean): void {
    this.isConnected = is;
    if (!is) {
      this.requests.ended();
      this.refused = true;
    }
    if (is) {
      this.wasConnected = true;
      this.counted.at = 0;
      this.status = null;
    }
    this.showState();
  }

  private mayDo(rights: Rights): void {
    this.requests.rights = rights;
    for (const id of ["record", "fault-give"]) find<HTMLButtonElement>(id).disabled = !rights.may;
    put("may-not", rights.why);
    find("may-not").hidden = rights.may;
    this.settings.connected();
    this.pairing.connected();
    this.update.connected();
    this.calibration.connected();
  }

  private paired(message: PairingMessage): void {
    this.pairing.told(message);
    if (message.step === "paired" && this.pairingStep !== "paired") this.settings.ask(true); // what the new key may
    this.pairingStep = message.step;
  }

  private arrived(frame: Frame): void {
    ++this.received;
    if (this.paused && !this.more) return;
    this.more = frame.source || frame.intervalWidth ? 0 : Math.max(0, this.more - 1);
    if (this.fresh) this.connection.ask(1); // the one before is never drawn
    this.frame = frame;
    this.fresh = true;
    if (frame.latency_ms !== null) this.latencies.push(frame.latency_ms);
    if (!this.drawing) this.drawing = requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    this.drawing = 0;
    if (!this.fresh) return;
    this.fresh = false;
    this.autoRange();
    this.redraw();
    ++this.drawn;
    this.connection.ask(this.paused && !this.more ? 0 : 1);
  }

  private redraw(): void {
    const frame = this.frame;
    if (!frame || !this.depthView || document.hidden) return;
    const base = chosen("base");
    const overlay = chosen("overlay") as Overlay;
    const aspect = `${frame.width} / ${frame.height}`;
    if (aspect !== this.aspect) find("stage").style.setProperty("--aspect", (this.aspect = aspect));
    if (base === "cloud") {
      this.cloudView?.draw(frame, overlay, this.paused);
    } else {
      this.depthView.draw(frame, base as Base, overlay);
      this.probe.place();
    }
    const now = performance.now();
    if (now - this.readAt >= readEveryMs || this.paused) {
      this.readAt = now;
      this.showProbe();
    }
    this.note(this.absence(frame, base, overlay));
  }

  // Why there is nothing to see.
  private absence(frame: Frame, base: string, overlay: Overlay): string {
    const absent = (what: string, name: string) => this.recording
      ? `The recording holds no ${what}.`
      : `The sensor sends no ${what}: stof config ${this.sensorName()} set streams.${name}=rvl`;
    if (base === "left" && frame.leftWidth === 0) return absent("left picture", "grey_left");
    if (base !== "left" && frame.width === 0) return absent("depth", "depth");
    if (performance.now() - this.choseAt < 1000) return ""; // it may not have been asked for
    if (overlay === "source" && !frame.source) return absent("sources", "source");
    if (overlay === "width" && !frame.intervalWidth) return absent("widths", "width");
    if (base === "cloud" && !this.cloudView?.available()) return "This browser has no WebGL 2: the cloud cannot be drawn.";
    if (base === "cloud" && !frame.calibration) return "The cloud waits for the sensor's calibration, which it tells once a second.";
    return "";
  }

  private sensorName(): string {
    return find("sensor").textContent!.replace(/:7560$/, "");
  }

  private note(text: string): void {
    put("note", text);
    find("note").hidden = text === "";
  }

  private choose(): void {
    this.choseAt = performance.now();
    const cloud = chosen("base") === "cloud";
    this.map.hidden = cloud;
    this.cloudCanvas.hidden = !cloud;
    find("mark").hidden = cloud || !this.probe.at;
    if (cloud && !this.cloudView && this.scale) {
      this.cloudView = new CloudView(this.cloudCanvas, this.scale, this.sources.map((one) => rgb(one.colour)), () => {});
    }
    this.map.setAttribute("aria-label", chosen("base") === "left" ? "Left picture" : "Depth map");
    find("sources").hidden = chosen("overlay") !== "source";
    const auto = chosen("scale") === "auto";
    this.near.disabled = this.far.disabled = auto;
    if (!auto) this.setRange();
    this.showLegend();
    this.connection.ask(0); // which planes, from the next frame on
    this.redraw();
  }

  private setRange(): void {
    const [near, far] = [Number(this.near.value), Number(this.far.value)];
    const [wrongNear, wrongFar] = [rangeError(this.near), rangeError(this.far)];
    this.near.setCustomValidity(wrongNear || (wrongFar || near < far ? "" : "has to be below the other end"));
    this.far.setCustomValidity(wrongFar);
    const asked = [this.near, this.far].find((end) => end.validity.customError);
    if (asked) {
      asked.reportValidity();
      return;
    }
    if (this.table.length) this.setScale(new Scale(this.table, near, far));
  }

  private autoRange(): void {
    if (chosen("scale") !== "auto" || !this.frame?.depth || !this.scale) return;
    const range = depthRange(this.frame.depth);
    const far = (a: number, b: number) => Math.abs(Math.log(a / b)) > 0.08;
    if (!range || !(far(range[0], this.scale.near) || far(range[1], this.scale.far))) return;
    this.near.value = range[0].toFixed(1);
    this.far.value = range[1].toFixed(1);
    this.setScale(new Scale(this.table, range[0], range[1]));
  }

  private setScale(scale: Scale): void {
    this.scale = scale;
    if (this.depthView) {
      this.depthView.setScale(scale);
    } else {
      this.depthView = new DepthView(this.map, scale, this.sources.map((one) => rgb(one.colour)));
    }
    this.cloudView?.setScale(scale);
    this.showLegend();
    this.redraw();
  }

  // Of what is drawn in colours: depths, or widths.
  private showLegend(): void {
    if (!this.scale) return;
    const widths = chosen("overlay") === "width";
    // A width is read as a half to each side, as the probe tells it.
    const scale = widths ? new Scale([...this.table].reverse(), widthNear / 2, widthFar / 2) : this.scale;
    const legend = find("legend");
    legend.hidden = chosen("overlay") === "source" || (chosen("base") === "left" && !widths);
    const flat = window.matchMedia("(max-width: 480px)").matches;
    const bar = find<HTMLCanvasElement>("bar");
    const length = 256;
    bar.width = flat ? length : 1;
    bar.height = flat ? 1 : length;
    const context = bar.getContext("2d")!;
    for (let at = 0; at < length; ++at) {
      const [r, g, b] = scale.at(at / (length - 1));
      context.fillStyle = `rgb(${r} ${g} ${b})`;
      context.fillRect(flat ? at : 0, flat ? 0 : at, 1, 1);
    }
    const text = (metres: number) => (widths ? `± ${short(metres * 1000)} mm` : `${short(metres)} m`);
    const least = !flat ? 0.045 : widths ? 0.2 : 0.11; // between ticks, which have room for their text
    let last = -1;
    find("ticks").replaceChildren(...scale.ticks().flatMap((value) => {
      const place = scale.position(value);
      if (place - last < least && last >= 0) return [];
      last = place;
      const tick = document.createElement("span");
      tick.textContent = text(value);
      tick.style.setProperty(flat ? "left" : "top", `${100 * Math.min(0.985, Math.max(0.015, place))}%`);
      return [tick];
    }));
    legend.setAttribute("aria-label", `${widths ? "Width of the interval" : "Distance"}: from ${text(scale.near)} to ${text(scale.far)}`);
  }

  private probed(byKey: boolean): void {
    this.showProbe();
    this.connection.ask(0);
    if (!byKey) return;
    clearTimeout(this.saying); // for who listens: where the pointer came to rest
    this.saying = window.setTimeout(() => {
      const read = this.probe.read(this.frame, this.sources.map((one) => one.name));
      find("said").textContent = `Pixel ${read.pixel}: depth ${read.depth}, width ${read.width}, source ${read.source}`;
    }, 400);
  }

  private showProbe(): void {
    const read = this.probe.read(this.frame, this.sources.map((one) => one.name));
    put("probe-pixel", read.pixel);
    put("probe-depth", read.depth);
    put("probe-width", read.width);
    put("probe-source", read.source === "pmd" ? "PMD" : read.source);
  }

  private pause(is: boolean): void {
    this.paused = is;
    const button = find("pause");
    button.setAttribute("aria-pressed", String(is));
    this.more = is ? 3 : 0; // until one has all that it can be asked for while it stands
    this.connection.ask(2);
    this.redraw();
    this.showState();
  }

  private told(status: Status): void {
    const now = performance.now();
    const bad = status.lost + status.incomplete;
    const before = this.counted;
    this.status = status;
    if (before.at && now > before.at && status.at_ms > before.toldMs) {
      const seconds = (now - before.at) / 1000;
      const rate = Math.max(0, status.frames - before.frames) / ((status.at_ms - before.toldMs) / 1000);
      const received = (this.received - before.received) / seconds;
      const drawn = (this.drawn - before.drawn) / seconds;
      const lost = Math.max(0, bad - before.bad);
      const latency = this.latencies.length ? this.latencies.reduce((a, b) => a + b) / this.latencies.length : null;
      this.rate.add(now, rate);
      this.latency.add(now, latency);
      this.loss.add(now, lost);
      find("rate-now").textContent = `${rate.toFixed(1)} /s`;
      find("latency-now").textContent = latency === null ? "–" : `${latency.toFixed(1)} ms`;
      find("loss-now").textContent = frames(this.loss.total());
      const sensor = status.health ? `sensor ${status.health.rate_hz.toFixed(1)}, ` : "";
      find("counts").textContent =
        `Frames a second: ${sensor}program ${rate.toFixed(1)}, page ${received.toFixed(1)}, drawn ${drawn.toFixed(1)}. ` +
        `Since the start: lost ${frames(status.lost)}${status.late ? `, ${status.late} of them came too late` : ""}; ` +
        `incomplete ${status.incomplete}; packets missing ${status.packets_missing}, recovered ${status.recovered}.` +
        (chosen("base") === "cloud" && this.cloudView && !this.paused ? ` Cloud: nearest of ${this.cloudView.block}x${this.cloudView.block} px.` : "");
    }
    this.counted = { at: now, toldMs: status.at_ms, frames: status.frames, bad, received: this.received, drawn: this.drawn };
    this.latencies = [];
    showHealth(find("health"), find("active"), status.health,
      !this.silent() ? "" : this.recording ? "the recording has nothing here" : "the sensor says nothing",
      this.recording ? "Not known: the recording does not hold what the sensor said of itself here." : "Nothing is known yet.");
    this.plot();
    this.showState();
  }

  private plot(): void {
    const now = performance.now();
    this.rate.draw(now);
    this.latency.draw(now);
    this.loss.draw(now);
  }

  private happened(event: SensorEvent): void {
    showEvent(find("events"), event);
    if (event.text.includes("settings_changed")) this.settings.ask(true); // by whomever
  }

  // One line, for eyes and ears: said again only where it changes.
  private showState(): void {
    const [text, level] = this.stateText();
    put("state", text);
    find("state").dataset.level = level;
    find("stage").style.opacity = this.isConnected && !this.silent() ? "1" : "0.45";
  }

  private silent(): boolean {
    return this.status !== null && this.status.waiting !== "";
  }

  private stateText(): [string, string] {
    if (!this.isConnected) {
      return this.wasConnected
        ? ["stof view has ended or cannot be reached: this page comes back by itself", "major"]
        : this.refused ? ["Not connected: stof view has ended, or all its places are taken: close another page of it", "major"] : ["connecting", "wait"];
    }
    if (this.silent()) return [`Old picture: ${this.status!.waiting}`, this.recording ? "wait" : "major"];
    if (this.paused) return ["Frozen picture", "wait"];
    const health = this.status?.health;
    if (health && health.severity > 0) {
      const trouble = health.active.filter((one) => one.severity > 0).map((one) => one.name.replace(/_/g, " ")).join(", ") || "trouble";
      return [this.recording ? `Playback: ${trouble}` : trouble, levelOf(health.severity)];
    }
    if (this.recording) return [this.player.plays() ? "Playback" : "Playback, paused", "play"];
    return this.frame ? ["Live", "good"] : ["waiting for the first frame", "wait"];
  }
}

function themeButton(changed: () => void): void {
  const button = find("theme");
  const names = ["system", "light", "dark"];
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  let now = "system";
  try {
    now = localStorage.getItem("stof-theme") ?? now;
  } catch {
    // without storage it is not remembered
  }
  const show = () => {
    document.documentElement.dataset.theme = now !== "system" ? now : dark.matches ? "dark" : "light";
    button.textContent = `Theme: ${now}`;
  };
  if (!names.includes(now)) now = "system";
  dark.addEventListener("change", () => { show(); changed(); });
  button.addEventListener("click", () => {
    now = names[(names.indexOf(now) + 1) % names.length];
    try {
      localStorage.setItem("stof-theme", now);
    } catch {
      // see above
    }
    show();
    changed();
  });
  show();
}

new Page();
