// The update panel: which release runs, and how an update goes. Files stay where `stof view` is: a page names one.
import { BegunBy } from "./connection";
import { Requests, find, make, put } from "./panels";

export interface UpdateMessage {
  folder: string; files: { name: string; bytes: number }[];
  step: string; by: BegunBy; file: string; sent: number; total: number; text: string;
  running: string; other: string; state: string; problem: string;
}

const askEveryMs = 3000; // while it is open
const steps = ["sending", "restarting", "trial", "confirmed"];
const places: Record<string, string> = { settled: "each start uses it", trial: "on trial: the next start uses the former one, unless this one is confirmed", restarting: "the sensor is about to restart", left: "each start uses it; the one in the other slot was tried and left" };

function sizeText(bytes: number): string {
  return bytes < 1e5 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

export class UpdatePanel {
  private state: UpdateMessage | null = null;
  private waits = false; // for an answer

  constructor(private requests: Requests) {
    find("update").addEventListener("toggle", () => this.ask());
    setInterval(() => this.ask(), askEveryMs);
    find("update-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const file = find<HTMLSelectElement>("update-file").value;
      if (file && window.confirm(`The sensor restarts with ${file}: it sends no frame for some seconds. A robot that needs it has to stand still. Go on?`)) void this.put(file);
    });
  }

  told(message: UpdateMessage): void {
    this.state = message;
    const key = JSON.stringify(message.files);
    const select = find<HTMLSelectElement>("update-file");
    if (select.dataset.key !== key) {
      select.dataset.key = key;
      const before = select.value;
      select.replaceChildren(...message.files.map((one) => make("option", `${one.name} (${sizeText(one.bytes)})`, { value: one.name })));
      if (message.files.some((one) => one.name === before)) select.value = before;
    }
    this.show();
  }

  // The rights have changed.
  connected(): void {
    this.waits = false;
    this.show();
    this.ask();
  }

  private busy(): boolean {
    return ["sending", "restarting", "trial"].includes(this.state?.step ?? "none");
  }

  private ask(): void {
    if (document.hidden || !find<HTMLDetailsElement>("update").open || this.waits || this.busy()) return;
    if (!this.requests.rights.may) {
      put("update-who", this.requests.rights.why);
      return;
    }
    if (!this.state) put("update-who", "The sensor is being asked.");
    this.waits = true;
    void this.requests.ask("release").then(() => { this.waits = false; });
  }

  private async put(file: string): Promise<void> {
    const answer = await this.requests.ask("update", { file });
    if (!answer.done) this.say(answer.text, true);
  }

  private say(text: string, wrong: boolean): void {
    put("update-said", text);
    find("update-said").dataset.level = wrong ? "major" : "good";
  }

  private show(): void {
    const state = this.state;
    if (!state) return;
    const busy = this.busy();
    find("update-form").hidden = !state.files.length || busy;
    find<HTMLButtonElement>("update-put").disabled = !this.requests.rights.may;
    put("update-from", !state.folder
      ? "To put a release on the sensor from here, start with its folder: stof view SENSOR --update-from DIR."
      : state.files.length ? `Releases of ${state.folder}, where stof view runs.` : `No release (*.update) is in ${state.folder}.`);
    find("update-from").hidden = busy;
    if (busy) {
      const who = this.requests.another(state.by);
      put("update-who", `${who ? `${who} puts ${state.file} on the sensor` : `${state.file} is being put on the sensor`}. Nobody ends an update that has begun.`);
    } else {
      put("update-who", state.problem || (state.running
        ? `Release ${state.running} runs: ${places[state.state] ?? state.state}.${state.other ? ` In the other slot: ${state.other}.` : ""}`
        : "The sensor runs from no image, so it takes no release."));
    }
    const bar = find<HTMLProgressElement>("update-bar");
    find("update-progress").hidden = state.step !== "sending";
    bar.max = Math.max(1, state.total);
    bar.value = state.sent;
    put("update-sent", state.total ? `${sizeText(state.sent)} of ${sizeText(state.total)}` : "the sensor is being asked");
    const at = steps.indexOf(state.step);
    find("update-steps").hidden = at < 0;
    for (const [place, item] of [...find("update-steps").children].entries()) {
      const done = place < at || state.step === "confirmed";
      (item as HTMLElement).dataset.state = done ? "done" : place === at ? "now" : "later";
      if (place === at && !done) item.setAttribute("aria-current", "step");
      else item.removeAttribute("aria-current");
    }
    if (state.step !== "none") this.say(state.text, state.step === "failed" || state.step === "left");
  }
}
