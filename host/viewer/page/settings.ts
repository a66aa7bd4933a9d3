// The settings panel, made from the sensor's own JSON Schema: it knows no setting.
import { SettingsMessage } from "./messages";
import { Requests, find, make, put } from "./panels";

interface Schema {
  type: string | string[];
  properties?: Record<string, Schema>;
  enum?: string[];
  minimum?: number;
  maximum?: number;
  minLength?: number;
  maxLength?: number;
  default?: Value;
  description?: string;
  "x-unit"?: string;
  "x-applies"?: string;
  "x-changed-by"?: string;
}

type Value = string | number | boolean;

const ranks = ["anybody", "tune", "admin"];
const rolesText: Record<string, string> = {
  admin: "Your key of this sensor changes everything.",
  tune: "Your key of this sensor (tune) changes what is not the installer's.",
  view: "Your key of this sensor (view) changes nothing.",
  anybody: "The sensor is not paired: without a key only the harmless settings can be changed, until the next start. stof pair gives a key.",
  none: "The sensor is paired, and there is no key of it here: nothing can be changed. stof pair gives a key.",
};

function parsed(text: string): Record<string, unknown> {
  try {
    return JSON.parse(text);
  } catch {
    return {};
  }
}

function valueAt(document: unknown, path: string): Value | undefined {
  let at = document as Record<string, unknown> | undefined;
  for (const name of path.split(".")) at = at?.[name] as Record<string, unknown> | undefined;
  return at as Value | undefined;
}

function shown(value: Value | undefined): string {
  return value === undefined ? "–" : value === "" ? "nothing" : String(value);
}

// One setting: its control, and what it is now.
class Field {
  readonly row = make("div", "", { className: "field" });
  private control: HTMLInputElement | HTMLSelectElement;
  private reset = make("button", "Default", { type: "button" });
  private note = make("span", "", { className: "quiet" });
  private kind: "choice" | "switch" | "number" | "text";
  active: Value | undefined;
  private standard: Value | undefined;
  private saved: Value | undefined;

  constructor(readonly path: string, private schema: Schema, private changed: () => void) {
    const id = `set-${path}`;
    const help = `${id}-help`;
    if (schema.enum) {
      this.kind = "choice";
      const select = make("select");
      for (const one of schema.enum) select.append(make("option", one, { value: one }));
      this.control = select;
    } else if (schema.type === "boolean") {
      this.kind = "switch";
      this.control = make("input", "", { type: "checkbox" });
    } else if (schema.type === "integer") {
      this.kind = "number";
      this.control = make("input", "", { type: "number", step: "1" });
      if (schema.minimum !== undefined) this.control.min = String(schema.minimum);
      if (schema.maximum !== undefined) this.control.max = String(schema.maximum);
    } else {
      this.kind = "text";
      this.control = make("input", "", { type: "text", spellcheck: false });
      this.control.maxLength = schema.maxLength ?? 63;
    }
    this.control.id = id;
    this.control.setAttribute("aria-describedby", help);
    this.control.addEventListener("input", () => { this.mark(); this.changed(); });
    this.reset.addEventListener("click", () => { this.show(this.standard); this.mark(); this.changed(); this.control.focus(); });
    this.reset.setAttribute("aria-label", `${path}: back to its default`);
    const later = schema["x-applies"] === "restart" ? " In force after the next start, where it is saved." : "";
    const text = `${schema.description ?? ""}${this.ends() && ` (${this.ends()})`}.${later}`;
    const name = make("label", path.split(".").pop(), { htmlFor: id });
    const line = make("div", "", { className: "control" });
    line.append(this.control, this.reset);
    const about = make("p", text, { id: help, className: "quiet" });
    this.row.append(name, line, about, this.note);
  }

  // "500 to 16380 mm"; "": it has none.
  private ends(): string {
    const { minimum, maximum, "x-unit": unit } = this.schema;
    return [minimum === undefined ? "" : `${minimum} to ${maximum}`, unit ?? ""].filter((part) => part).join(" ");
  }

  private read(): Value {
    if (this.kind === "switch") return (this.control as HTMLInputElement).checked;
    if (this.kind === "number" && this.control.value !== "") return Number(this.control.value);
    return this.control.value;
  }

  private show(value: Value | undefined): void {
    if (this.kind === "switch") (this.control as HTMLInputElement).checked = value === true;
    else this.control.value = value === undefined ? "" : String(value);
  }

  // What the user has changed stays; all else is as the sensor has it.
  take(active: Value | undefined, saved: Value | undefined, standard: Value | undefined, rank: number): void {
    const edited = this.change() !== undefined;
    [this.active, this.saved, this.standard] = [active, saved, standard];
    if (!edited) this.show(active);
    const may = rank >= ranks.indexOf(this.schema["x-changed-by"] ?? "admin");
    this.control.disabled = !may;
    this.reset.hidden = !may;
    this.mark();
  }

  drop(): void {
    this.show(this.active);
    this.mark();
  }

  // What shall be set; undefined: nothing. Throws where it cannot be.
  change(): Value | undefined {
    if (this.active === undefined) return undefined;
    const value = this.read();
    return value === this.active || (this.kind === "text" && String(this.active) === value) ? undefined : value;
  }

  valid(): boolean {
    return this.control.disabled || this.control.checkValidity();
  }
  // What is wrong with it, also beside it.
  report(): string {
    this.control.reportValidity();
    return `${this.path}: ${this.control.validationMessage}`;
  }

  private mark(): void {
    const change = this.change();
    this.control.setCustomValidity(this.kind === "number" && this.control.value === "" ? `give a number, ${this.ends()}` : "");
    this.row.classList.toggle("changed", change !== undefined);
    this.reset.disabled = String(this.read()) === String(this.standard);
    this.note.textContent = change !== undefined
      ? `now ${shown(this.active)}`
      : this.saved !== undefined && this.saved !== this.active ? `not saved: the next start begins with ${shown(this.saved)}` : "";
  }
}

export class SettingsPanel {
  private fields: Field[] = [];
  private schema = "";
  private asked = false;

  constructor(private requests: Requests) {
    find("settings").addEventListener("toggle", () => this.ask());
    find("settings-apply").addEventListener("click", () => this.apply());
    find("settings-drop").addEventListener("click", () => { for (const field of this.fields) field.drop(); this.count(); });
    find("settings-save").addEventListener("click", () => this.save());
    find("settings-search").addEventListener("input", () => this.filter());
  }

  // Nothing is asked of the sensor until somebody opens the panel.
  ask(again = false): void {
    if (!find<HTMLDetailsElement>("settings").open) {
      this.asked = false;
      return;
    }
    if (!this.requests.rights.may) {
      put("settings-who", this.requests.rights.why);
      return;
    }
    if (this.asked && !again) return;
    this.asked = true;
    if (!this.fields.length) put("settings-who", "The sensor is being asked.");
    void this.requests.ask("settings").then((answer) => { if (!answer.done) this.say(answer.text, true); });
  }

  // The connection began anew, or ended.
  connected(): void {
    this.asked = false;
    this.ask();
    this.count();
  }

  told(message: SettingsMessage): void {
    if (message.problem) {
      put("settings-who", message.problem);
      this.count();
      return;
    }
    if (message.schema !== this.schema) {
      this.schema = message.schema;
      this.build(parsed(message.schema) as unknown as Schema);
    }
    const [active, saved, defaults] = [parsed(message.active), parsed(message.saved), parsed(message.defaults)];
    const rank = message.doubt ? -1 : ranks.indexOf(message.role);
    for (const field of this.fields) field.take(valueAt(active, field.path), valueAt(saved, field.path), valueAt(defaults, field.path), rank);
    put("settings-who", message.doubt || rolesText[message.role] || "");
    find("settings-save").hidden = rank < ranks.indexOf("tune");
    this.count();
  }

  private build(schema: Schema): void {
    this.fields = [];
    const place = find("settings-fields");
    place.replaceChildren();
    const group = (name: string, members: [string, Schema][], path: string) => {
      const single = members.filter(([, one]) => one.type !== "object");
      if (single.length) {
        const box = make("fieldset", "", { className: "group" });
        box.append(make("legend", name));
        for (const [member, one] of single) {
          const field = new Field(path ? `${path}.${member}` : member, one, () => this.count());
          this.fields.push(field);
          box.append(field.row);
        }
        place.append(box);
      }
      for (const [member, one] of members) {
        const longer = path ? `${path}.${member}` : member;
        if (one.type === "object") group(longer, Object.entries(one.properties ?? {}), longer);
      }
    };
    group("general", Object.entries(schema.properties ?? {}), "");
    this.filter();
  }

  private filter(): void {
    const wanted = find<HTMLInputElement>("settings-search").value.trim().toLowerCase();
    for (const field of this.fields) {
      field.row.hidden = wanted !== "" && !`${field.path} ${field.row.textContent}`.toLowerCase().includes(wanted);
    }
    for (const box of find("settings-fields").children) (box as HTMLElement).hidden = !box.querySelector(".field:not([hidden])");
  }

  private changes(): Record<string, Value> {
    const all: Record<string, Value> = {};
    for (const field of this.fields) {
      const value = field.change();
      if (value !== undefined) all[field.path] = value;
    }
    return all;
  }

  private count(): void {
    const changes = Object.keys(this.changes()).length;
    const may = this.requests.rights.may && this.fields.length > 0;
    find<HTMLButtonElement>("settings-apply").disabled = !may || changes === 0;
    find<HTMLButtonElement>("settings-drop").disabled = changes === 0;
    find<HTMLButtonElement>("settings-save").disabled = !may || changes > 0;
    find("settings-apply").textContent = changes ? `Apply ${changes} change${changes > 1 ? "s" : ""}` : "Apply";
  }

  private say(text: string, wrong: boolean): void {
    put("settings-said", text);
    find("settings-said").dataset.level = wrong ? "major" : "good";
  }

  private async apply(): Promise<void> {
    const wrong = this.fields.find((field) => !field.valid());
    if (wrong) {
      this.say(wrong.report(), true);
      return;
    }
    this.say("", false);
    const answer = await this.requests.ask("set", { settings: this.changes() });
    this.say(answer.text, !answer.done);
    this.count();
  }

  private async save(): Promise<void> {
    this.say("", false);
    const answer = await this.requests.ask("save");
    this.say(answer.text, !answer.done);
  }
}
