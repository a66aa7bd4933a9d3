// Guided calibration: which board to hold, where views are still missing, and the result. `stof view` runs it (docs/VIEWER.md).
import { Requests, find, make, put } from "./panels";
import { CalibrationLook, CalibrationMessage, CalibrationResult } from "./messages";

const askEveryMs = 3000; // while it is open
const running = ["begin", "subscribing", "reading", "missing", "looking", "calibrating"];
const kinds: Record<string, { across: string; down: string; size: string; columns: number; rows: number; mm: number; help: string }> = {
  charuco: { across: "Inner corners across", down: "Inner corners down", size: "Square", columns: 12, rows: 9, mm: 40, help: "The best choice: a view counts where a camera sees a part of the board, so it reaches the corners of both pictures." },
  chess: { across: "Inner corners across", down: "Inner corners down", size: "Square", columns: 9, rows: 6, mm: 24, help: "A view counts where both cameras see all of the board." },
  aprilgrid: { across: "Tags across", down: "Tags down", size: "Tag", columns: 6, rows: 6, mm: 88, help: "Kalibr's board, 0.3 of a tag between tags: a view counts where a camera sees a part of the board." },
};
const eyes = ["left", "right"] as const;
const gap = 0.3; // between tags, of a tag's side

const papers: [string, number, number][] = [["a4", 210, 297], ["a3", 297, 420], ["a2", 420, 594], ["a1", 594, 841], ["a0", 841, 1189]];

// The smallest that takes the board with its white and its ruler, as stof calib target judges.
function paperFor(kind: string, columns: number, rows: number, mm: number): string {
  const length = (count: number) => mm * (kind === "aprilgrid" ? count + (count + 1) * gap : count + 1);
  const [width, height] = [length(columns), length(rows)];
  const white = 2 * Math.max(mm / 2, 5);
  const ruler = 14;
  return papers.find(([, short, long]) => {
    const [w, h] = width > height ? [long, short] : [short, long];
    return width + white <= w && height + white + ruler <= h;
  })?.[0] ?? "a0";
}

// What each want asks for, in short, and how the board is held for it.
const wantNames: Record<string, string> = {
  near: "near", far: "far", "left-away": "left side away", "right-away": "right side away", "top-away": "top away", "bottom-away": "bottom away", more: "views in all",
};

export class CalibrationPanel {
  private state: CalibrationMessage | null = null;
  private pictures = new Map<string, HTMLImageElement>();
  private taken = 0;

  constructor(private requests: Requests) {
    find("calibration").addEventListener("toggle", () => this.ask());
    setInterval(() => { if (!document.hidden && !this.busy()) this.ask(); }, askEveryMs);
    find("cal-kind").addEventListener("change", () => this.choose());
    for (const id of ["cal-columns", "cal-rows", "cal-size"]) find(id).addEventListener("input", () => this.sketch());
    find("cal-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.begin(false);
    });
    find("cal-go-on").addEventListener("click", () => void this.begin(true));
    find("cal-end").addEventListener("click", () => void this.want("end_calibration"));
    find("cal-install").addEventListener("click", () => {
      if (window.confirm("The sensor computes with this calibration from the next frame on and at each start, until another one is installed (stof calib install --factory goes back). Install it?")) void this.want("install");
    });
    this.choose();
  }

  told(message: CalibrationMessage): void {
    const before = this.state;
    this.state = message;
    if (message.look && before?.look && message.look.views > before.look.views) this.flash();
    if (message.look) this.draw(message.look);
    this.show();
  }

  // The rights have changed.
  connected(): void {
    this.show();
    this.ask();
  }

  private ask(): void {
    if (!find<HTMLDetailsElement>("calibration").open) return;
    if (!this.requests.rights.may) {
      this.say(this.requests.rights.why, true);
      return;
    }
    void this.want("calibration");
  }

  private busy(): boolean {
    return [...running, "installing"].includes(this.state?.step ?? "none");
  }

  private async want(what: string, members: object = {}): Promise<boolean> {
    const answer = await this.requests.ask(what, members);
    if (!answer.done) this.say(answer.text, true);
    return answer.done;
  }

  private async begin(goesOn: boolean): Promise<void> {
    if (!find<HTMLFormElement>("cal-form").reportValidity()) return;
    await this.want("calibrate", { board: this.board(), goes_on: goesOn });
  }

  // As --board of stof calib stereo.
  private board(): string {
    const kind = find<HTMLSelectElement>("cal-kind").value;
    const number = (id: string) => Number(find<HTMLInputElement>(id).value);
    const size = Number((number("cal-size") / 1000).toFixed(6));
    const places = `${number("cal-columns")}x${number("cal-rows")}:${size}`;
    return kind === "chess" ? places : kind === "charuco" ? `charuco:${places}` : `aprilgrid:${places}:${gap}`;
  }

  private choose(): void {
    const kind = kinds[find<HTMLSelectElement>("cal-kind").value];
    put("cal-columns-name", kind.across);
    put("cal-rows-name", kind.down);
    put("cal-size-name", `${kind.size} as measured, mm`);
    for (const [id, value] of [["cal-columns", kind.columns], ["cal-rows", kind.rows], ["cal-size", kind.mm]] as const) find<HTMLInputElement>(id).value = String(value);
    this.sketch();
  }

  // The board, so that nobody holds another one. Markers are only hinted at.
  private sketch(): void {
    const name = find<HTMLSelectElement>("cal-kind").value;
    const kind = kinds[name];
    const number = (id: string) => Number(find<HTMLInputElement>(id).value);
    const paper = paperFor(name, number("cal-columns"), number("cal-rows"), number("cal-size"));
    put("cal-help", `${kind.help} Print it at 100 percent, glue it onto something flat and stiff, and measure ${name === "aprilgrid" ? "a tag" : "along ten squares"}: stof calib target --board ${this.board()} --paper ${paper} --out board.pdf`);
    const count = (id: string) => Math.min(40, Math.max(1, Math.floor(Number(find<HTMLInputElement>(id).value)) || 1));
    const more = name === "aprilgrid" ? 0 : 1; // squares beyond the inner corners
    const [columns, rows] = [count("cal-columns") + more, count("cal-rows") + more];
    const canvas = find<HTMLCanvasElement>("cal-sketch");
    const cell = Math.max(4, Math.floor(Math.min(220 / columns, 150 / rows)));
    canvas.width = cell * (columns + 1);
    canvas.height = cell * (rows + 1);
    const pen = canvas.getContext("2d")!;
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, canvas.width, canvas.height);
    pen.fillStyle = "#000";
    for (let y = 0; y < rows; ++y) {
      for (let x = 0; x < columns; ++x) {
        const black = name === "aprilgrid" || (x + y) % 2 === 0;
        const inset = name === "aprilgrid" ? 0.12 : black ? 0 : name === "charuco" ? 0.2 : 1;
        if (inset < 1) pen.fillRect(cell * (x + 0.5 + inset), cell * (y + 0.5 + inset), cell * (1 - 2 * inset), cell * (1 - 2 * inset));
        if (inset > 0 && inset < 1) { // a marker's bits
          pen.fillStyle = "#fff";
          const bit = cell * (1 - 2 * inset) / 4;
          for (const [u, v] of [[1, 1], [2, (x * 3 + y) % 2 ? 2 : 1]]) pen.fillRect(cell * (x + 0.5 + inset) + bit * u, cell * (y + 0.5 + inset) + bit * v, bit, bit);
          pen.fillStyle = "#000";
        }
      }
    }
    canvas.setAttribute("aria-label", `A sketch of the board: ${columns} by ${rows} ${name === "aprilgrid" ? "tags" : "squares"}`);
  }

  private say(text: string, wrong: boolean): void {
    put("cal-said", text);
    find("cal-said").dataset.level = wrong ? "major" : "good";
  }

  private flash(): void {
    find("cal-live").dataset.taken = "yes";
    clearTimeout(this.taken);
    this.taken = window.setTimeout(() => delete find("cal-live").dataset.taken, 900);
  }

  private show(): void {
    const state = this.state;
    if (!state) return;
    const busy = running.includes(state.step);
    const other = this.requests.another(state.by);
    find("cal-absent").hidden = !state.problem;
    put("cal-absent", state.problem);
    find("cal-begin").hidden = Boolean(state.problem) || busy || state.step === "installing";
    find<HTMLButtonElement>("cal-start").disabled = !this.requests.rights.may;
    const goOn = find<HTMLButtonElement>("cal-go-on");
    goOn.hidden = !state.kept;
    goOn.disabled = !this.requests.rights.may;
    put("cal-go-on", `Go on with ${state.kept} ${state.kept === 1 ? "view" : "views"} of before`);
    find("cal-end").hidden = !busy || other !== "";
    find("cal-live").hidden = !busy || !state.look;
    put("cal-other", `${other} ${busy ? "began this calibration: only that page ends it" : "made this calibration: only that page installs it, as long as it is open"}.`);
    find("cal-other").hidden = !other || !(busy || state.step === "calibrated");
    const wrong = state.step === "failed" || state.wrong;
    // What is said of each exposure changes too often for who listens.
    const looking = state.step === "looking";
    put("cal-now", looking ? state.text : "");
    find("cal-now").dataset.level = state.look?.verdict === "taken" || state.look?.verdict === "known" ? "good" : "wait";
    if (!looking && state.step !== "none") this.say(state.text, wrong);
    if (looking && state.look) this.say(`${state.look.views} ${state.look.views === 1 ? "view" : "views"} taken.`, false);
    find("cal-result").hidden = !state.result || busy;
    if (state.result) this.showResult(state.result, state.step);
  }

  private draw(look: CalibrationLook): void {
    for (const eye of eyes) {
      const png = eye === "left" ? look.left_png : look.right_png;
      if (!png) continue;
      const picture = new Image();
      picture.onload = () => {
        this.pictures.set(eye, picture);
        if (this.state?.look === look) this.drawEye(eye, look, picture);
      };
      picture.src = `data:image/png;base64,${png}`;
    }
    const list = find("cal-wants");
    const corners = look.wants.filter((want) => want.name.startsWith("corner "));
    const rest = look.wants.filter((want) => !want.name.startsWith("corner "));
    const reached = corners.filter((want) => want.have >= want.need).length;
    const items = [...rest.map((want) => ({ name: wantNames[want.name] ?? want.name, ask: want.ask, have: want.have, need: want.need })),
      { name: "corners of both pictures", ask: corners.filter((want) => want.have < want.need).map((want) => want.ask).join("; "), have: reached, need: corners.length }];
    const key = JSON.stringify(items);
    if (list.dataset.key === key) return;
    list.dataset.key = key;
    list.replaceChildren(...items.map((one) => {
      const done = one.have >= one.need;
      const item = make("li", `${one.name}: ${Math.min(one.have, one.need)} of ${one.need}`);
      item.dataset.state = done ? "done" : "now";
      if (!done && one.ask) item.append(make("span", one.ask.replace(/^[a-z]+: /, ""), { className: "quiet" }));
      return item;
    }));
  }

  // The picture, the found corners over it; below, where views are missing: what is veiled has no corner yet.
  private drawEye(eye: "left" | "right", look: CalibrationLook, picture: HTMLImageElement): void {
    const canvas = find<HTMLCanvasElement>(`cal-${eye}`);
    const [width, height] = [640, Math.round((640 * look.size[1]) / look.size[0])];
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const pen = canvas.getContext("2d")!;
    pen.drawImage(picture, 0, 0, width, height);
    const [columns, rows] = look.cells.size;
    const counts = look.cells[eye];
    const [w, h] = [width / columns, height / rows];
    let empty = 0;
    for (let at = 0; at < counts.length; ++at) {
      if (counts[at]) continue;
      ++empty;
      const [x, y] = [(at % columns) * w, Math.floor(at / columns) * h];
      pen.fillStyle = "rgb(240 150 0 / .34)";
      pen.fillRect(x + 1, y + 1, w - 2, h - 2);
    }
    // Corners of the picture that some view has to reach: 0 to 3 of the left one, 4 to 7 of the right one.
    look.wants.filter((want) => want.name.startsWith("corner ")).forEach((want, place) => {
      if ((place < 4 ? "left" : "right") !== eye || want.have >= want.need) return;
      pen.strokeStyle = "#ff9f1a";
      pen.lineWidth = 5;
      pen.setLineDash([14, 8]);
      pen.strokeRect(place % 2 ? width * 0.75 : 3, place % 4 > 1 ? height * 0.75 : 3, width / 4 - 3, height / 4 - 3);
      pen.setLineDash([]);
    });
    const scale = width / look.size[0];
    pen.lineWidth = 2;
    for (const [u, v] of look[eye]) {
      pen.beginPath();
      pen.arc((u + 0.5) * scale, (v + 0.5) * scale, 5, 0, 2 * Math.PI);
      pen.strokeStyle = "#000";
      pen.stroke();
      pen.beginPath();
      pen.arc((u + 0.5) * scale, (v + 0.5) * scale, 3.5, 0, 2 * Math.PI);
      pen.strokeStyle = look.verdict === "taken" ? "#3dff8b" : "#fff12e";
      pen.stroke();
    }
    canvas.setAttribute("aria-label", `${eye === "left" ? "Left" : "Right"} camera: ${look[eye].length} corners found; ${empty} of ${counts.length} fields have none of any view`);
  }

  private showResult(result: CalibrationResult, step: string): void {
    const held = result.held_out;
    const rows: [string, string][] = [
      ["Views", `${result.views.length} to fit${held ? `, ${held.views.length} to judge by` : ""}`],
      ["Reprojection error", `${result.corner_sigma_px.toFixed(3)} px${held ? `; of the views to judge by ${held.reprojection_px.toFixed(3)} px` : ""}`],
      ...(held ? [["Rows apart", `${held.row_px.toFixed(3)} px (good: 0.3 or less)`], ["Squares", `${(100 * held.scale_error).toFixed(2)} percent off (good: 0.5 or less)`]] as [string, string][] : []),
      ["Baseline", `${(1000 * result.baseline_m).toFixed(1)} mm`],
      ["File", result.file],
    ];
    find("cal-figures").replaceChildren(...rows.map(([name, value]) => {
      const row = make("div");
      row.append(make("dt", name), make("dd", value));
      return row;
    }));
    put("cal-verdict", result.warnings.length ? "Not all is well:" : "Nothing speaks against this calibration.");
    find("cal-verdict").dataset.level = result.warnings.length ? "minor" : "good";
    find("cal-warnings").replaceChildren(...result.warnings.map((warning) => make("li", warning)));
    const install = find<HTMLButtonElement>("cal-install");
    install.hidden = !this.requests.rights.may || this.requests.another(this.state!.by) !== "" || step === "installed";
    install.disabled = step === "installing";
  }
}
