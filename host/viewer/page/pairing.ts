// Pairing: there while the user has no key of the sensor. Keys are made and kept by `stof view`, none comes here.
import { BegunBy } from "./connection";
import { Requests, find, put } from "./panels";

export interface PairingMessage { offer: string; step: string; by: BegunBy; role: string; given: string; ours: string; text: string }

const offers: Record<string, string> = {
  unpaired: "Nobody has paired this sensor: whoever reaches its network changes what is harmless, and nobody more. Once it is paired, a change takes a key.",
  no_key: "This sensor is paired, and you have no key of it: you see all and change nothing.",
};

const roles: Record<string, string> = { admin: "may change everything", tune: "may tune depth and streams", view: "may look" };

// "123 456" of six digits: as the sensor tells them.
function spaced(digits: string): string {
  return `${digits.slice(0, 3)} ${digits.slice(3)}`;
}

export class PairingPanel {
  private state: PairingMessage | null = null;
  private seen = false; // a pairing that this page saw

  constructor(private requests: Requests) {
    find("pair-way").addEventListener("change", () => this.show());
    find("pair-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const code = find<HTMLInputElement>("pair-code");
      const byCode = find<HTMLSelectElement>("pair-way").value === "code";
      if (byCode && !code.value.trim()) {
        this.say("Type the 32 digits of the label.", true);
        return;
      }
      void this.ask("pair", { code: byCode ? code.value.trim() : "", role: find<HTMLSelectElement>("pair-role").value });
      code.value = "";
    });
    find("pair-digits-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.ask("digits", { digits: find<HTMLInputElement>("pair-digits").value.trim() });
    });
    find("pair-end").addEventListener("click", () => void this.ask("end_pairing"));
  }

  told(message: PairingMessage): void {
    const before = this.state?.step;
    this.state = message;
    if (!["none", "paired"].includes(message.step)) this.seen = true;
    if (before !== message.step) {
      if (message.step === "digits") find<HTMLInputElement>("pair-digits").value = "";
      this.say(message.text, message.step === "failed");
    }
    this.show();
    const own = !this.requests.another(message.by);
    if (own && before !== message.step && message.step === "digits" && find("pairing").contains(document.activeElement)) find("pair-digits").focus();
  }

  // The rights have changed.
  connected(): void {
    if (!this.requests.rights.may) this.seen = false;
    this.show();
  }

  private underWay(): boolean {
    return ["begin", "digits", "accept"].includes(this.state?.step ?? "none");
  }

  private show(): void {
    const state = this.state;
    find("pairing").hidden = !state || !this.requests.rights.may || !(state.offer || this.seen);
    if (!state) return;
    const code = find<HTMLSelectElement>("pair-way").value === "code";
    const own = !this.requests.another(state.by) && !this.requests.rights.why_not_pair;
    find("pair-code-field").hidden = !code;
    find("pair-form").hidden = this.underWay() || state.step === "paired" || !!this.requests.rights.why_not_pair;
    find("pair-digits-form").hidden = state.step !== "digits" || !own;
    find("pair-end").hidden = !this.underWay() || !own;
    put("pair-asks", this.underWay() ? this.asks(state) : "");
    find("pair-asks").hidden = !this.underWay();
    put("pair-why", state.step === "paired" ? "" : offers[state.offer] ?? "");
    find("pair-why").hidden = state.step === "paired" || this.underWay() || !state.offer;
    put("pair-now", this.instruction(state, code));
    find("pair-now").hidden = find("pair-now").textContent === "";
  }

  // Who asks for what, and what confirming does.
  private asks(state: PairingMessage): string {
    const who = this.requests.another(state.by);
    const what = `role ${state.role}: a key that ${roles[state.role] ?? ""}`;
    return who
      ? `${who} asks for ${what}. Holding the sensor's button makes that key, for the user of stof view: hold it only if you know who asks. That page alone types the digits or gives up.`
      : `You ask for ${what}. stof view keeps it.`;
  }

  private instruction(state: PairingMessage, code: boolean): string {
    if (this.underWay() && this.requests.another(state.by)) return "";
    if (!this.underWay() && state.step !== "paired" && this.requests.rights.why_not_pair) return `From here nobody pairs: ${this.requests.rights.why_not_pair}.`;
    switch (state.step) {
      case "begin": return "The sensor is being asked.";
      case "digits": return "Now the sensor tells six digits, in its log and on its serial line. Type them here: they are compared with those of this side.";
      case "accept": return state.given === state.ours
        ? `Equal: ${spaced(state.given)} there and ${spaced(state.ours)} here. Now hold the sensor's button for 3 seconds, or type them where stof pair --window asks.`
        : "";
      case "paired": return "";
      default: return code
        ? "The code stands on the sensor's label: 32 digits, 0 to 9 and a to f."
        : "Press the sensor's button: for two minutes it can be paired. A sensor without one: stof pair --serial LINE --window, where its cable ends.";
    }
  }

  private say(text: string, wrong: boolean): void {
    put("pair-said", text);
    find("pair-said").dataset.level = wrong ? "major" : "good";
  }

  private async ask(what: string, members: object = {}): Promise<void> {
    this.say("", false);
    const answer = await this.requests.ask(what, members);
    if (!answer.done) this.say(answer.text, true);
  }
}
