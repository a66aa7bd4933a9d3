// The fault panel: there for an emulated sensor that takes faults.
import { FaultsMessage } from "./messages";
import { Requests, find, make, put } from "./panels";

const kindsText: Record<string, string> = {
  drop: "drop: frames are lost",
  delay: "delay: frames come late",
  repeat: "repeat: the last comes again",
  tear: "tear: half is old",
  corrupt: "corrupt: damaged",
  vanish: "vanish: unplugged",
  freeze: "freeze: old pixels",
  dark: "dark: no lamp",
  hang: "hang: frozen until opened again",
};
const devicesText: Record<string, string> = { trigger: "Trigger", stereo: "Stereo pair", pmd: "PMD camera" };

export class FaultPanel {
  private devices = "";
  private given = ""; // the device whose fault from here is in force
  private isAbsent = false; // the sensor does not answer

  constructor(private requests: Requests) {
    find("fault-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const edges = find<HTMLInputElement>("fault-edges").value; // empty: until it is ended, as of stof fault
      void this.give(find<HTMLSelectElement>("fault-device").value, find<HTMLSelectElement>("fault-kind").value, edges === "" ? 0 : Number(edges));
    });
    find("fault-device").addEventListener("change", () => this.kinds());
  }

  private known: FaultsMessage["devices"] = [];

  told(message: FaultsMessage): void {
    find("faults").hidden = false;
    if (message.problem) {
      this.say(message.problem, true);
    } else if (this.isAbsent) {
      this.say("", false);
    }
    this.isAbsent = message.problem !== "";
    find<HTMLButtonElement>("fault-give").disabled = this.isAbsent || !this.requests.rights.may;
    if (!this.isAbsent) this.show(message); // else the choices stay
    this.list(message);
  }

  private show(message: FaultsMessage): void {
    this.known = message.devices;
    if (this.given && message.devices.some((one) => one.device === this.given && one.now === "none")) {
      this.say("The fault has ended.", false);
      this.given = "";
    }
    const names = message.devices.map((one) => one.device).join();
    if (names !== this.devices) {
      this.devices = names;
      const select = find<HTMLSelectElement>("fault-device");
      select.replaceChildren(...message.devices.map((one) => make("option", devicesText[one.device] ?? one.device, { value: one.device })));
      if (message.devices.some((one) => one.device === "pmd")) select.value = "pmd";
      this.kinds();
    }
  }

  private list(message: FaultsMessage): void {
    const active = message.devices.filter((one) => one.now !== "none");
    const key = JSON.stringify(active);
    const list = find("fault-list");
    if (list.dataset.key === key) return;
    list.dataset.key = key;
    list.replaceChildren(...active.map((one) => {
      const item = make("li");
      const end = make("button", "End", { type: "button" });
      end.setAttribute("aria-label", `End ${one.now} of ${devicesText[one.device] ?? one.device}`);
      end.addEventListener("click", () => void this.give(one.device, "none", 0));
      item.append(make("span", `${devicesText[one.device] ?? one.device}: ${one.now}${one.edges ? `, ${one.edges} ${one.edges === 1 ? "edge" : "edges"} more` : ", until it is ended"}`), end);
      return item;
    }));
  }

  private kinds(): void {
    const device = find<HTMLSelectElement>("fault-device").value;
    const kinds = this.known.find((one) => one.device === device)?.kinds ?? [];
    const select = find<HTMLSelectElement>("fault-kind");
    const before = select.value;
    select.replaceChildren(...kinds.map((kind) => make("option", kindsText[kind] ?? kind, { value: kind })));
    select.value = kinds.includes(before) ? before : kinds.includes("vanish") ? "vanish" : kinds[0] ?? "";
  }

  private say(text: string, wrong: boolean): void {
    put("fault-said", text);
    find("fault-said").dataset.level = wrong ? "major" : "good";
  }

  private async give(device: string, kind: string, edges: number): Promise<void> {
    this.given = "";
    const answer = await this.requests.ask("fault", { device, kind, edges });
    this.given = answer.done && kind !== "none" ? device : "";
    this.say(answer.done ? (kind === "none" ? "The fault has ended." : "The fault is in force: its effect is under Health and Events.") : answer.text, !answer.done);
  }
}
