import { SensorEvent, Status } from "./messages";

const levels = ["good", "minor", "major", "major"];
const mostShown = 100;

export function levelOf(severity: number): string {
  return levels[severity] ?? "major";
}

function element(name: string, text: string): HTMLElement {
  const made = document.createElement(name);
  made.textContent = text;
  return made;
}

// Of another day (of a recording) with its date.
function timeText(ms: number): string {
  const time = new Date(ms);
  return time.toDateString() === new Date().toDateString() ? time.toLocaleTimeString() : time.toLocaleString();
}

// The newest first, with the time when `stof view` heard of it, or recorded it.
export function showEvent(list: HTMLElement, event: SensorEvent): void {
  const item = document.createElement("li");
  item.dataset.level = event.active ? levelOf(event.severity) : "good";
  item.append(element("span", event.text.replace(/^(event|link): /, "")), element("time", timeText(event.time_ms)));
  list.prepend(item);
  while (list.children.length > mostShown) list.lastElementChild!.remove();
}

// silence: why it is old; "": it is not. unknown: what is said where nothing is known.
export function showHealth(line: HTMLElement, list: HTMLElement, health: Status["health"], silence: string, unknown: string): void {
  if (!health) {
    line.textContent = unknown;
    line.dataset.level = list.dataset.key = "";
    list.replaceChildren();
    return;
  }
  const old = silence !== "";
  list.hidden = old;
  const text = health.text.replace(/^health: /, "").replace(/, active:[^;]*/, "");
  line.textContent = old ? `Unknown: ${silence}. The last that the sensor said: ${text}` : text;
  line.dataset.level = old ? "wait" : levelOf(health.severity);
  const key = JSON.stringify(health.active);
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(
    ...health.active.map((one) => {
      const item = document.createElement("li");
      item.dataset.level = levelOf(one.severity);
      item.append(element("b", one.name.replace(/_/g, " ")), element("span", one.text));
      return item;
    }),
  );
}
