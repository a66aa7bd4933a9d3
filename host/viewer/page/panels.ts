// What the panels share: elements by id, and requests to `stof view` that are answered (docs/VIEWER.md).
import { BegunBy, Connection, Rights } from "./connection";

export function find<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

// What does not change costs no layout.
export function put(id: string, text: string): void {
  const element = find(id);
  if (element.textContent !== text) element.textContent = text;
}

export function make<K extends keyof HTMLElementTagNameMap>(name: K, text = "", members: Partial<HTMLElementTagNameMap[K]> = {}): HTMLElementTagNameMap[K] {
  const made = document.createElement(name);
  if (text) made.textContent = text;
  return Object.assign(made, members);
}

export interface Answer { done: boolean; text: string }

const nobody: Rights = { may: false, why: "not connected", why_not_pair: "not connected", ticket: "", page: 0 };

// One request after the other has its answer; a connection that ends refuses those that are open.
export class Requests {
  rights: Rights = { ...nobody };
  private open = new Map<number, (answer: Answer) => void>();
  private last = 0;

  constructor(private connection: () => Connection) {}

  ask(what: string, members: object = {}): Promise<Answer> {
    if (!this.rights.may) return Promise.resolve({ done: false, text: this.rights.why });
    const id = ++this.last;
    const sent = this.connection().send({ do: what, id, ticket: this.rights.ticket, ...members });
    if (!sent) return Promise.resolve({ done: false, text: "not connected" });
    return new Promise((done) => this.open.set(id, done));
  }

  // Whose it is that another page began; "" where this one did, or nobody.
  another(by: BegunBy): string {
    if (!by || by.page === this.rights.page) return "";
    return by.place === "this computer" ? "Another page of the computer where stof view runs" : by.place;
  }

  answered(id: number, answer: Answer): void {
    this.open.get(id)?.(answer);
    this.open.delete(id);
  }

  ended(): void {
    this.rights = { ...nobody };
    for (const done of this.open.values()) done({ done: false, text: "the connection ended before the answer" });
    this.open.clear();
  }
}
