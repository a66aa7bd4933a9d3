// The WebSocket to `stof view` (docs/VIEWER.md): frames are asked for one by one, and a connection that ends is made again.

import { FaultsMessage } from "./faults";
import { PairingMessage } from "./pairing";
import { PlaybackMessage, RecordingMessage } from "./recorder";
import { SettingsMessage } from "./settings";
import { UpdateMessage } from "./update";

export interface Calibration { fx: number; fy: number; cx: number; cy: number; max_range_m: number }

export interface Frame {
  frame: number;
  session: number;
  packets: number;
  missing_packets: number;
  latency_ms: number | null;
  calibration: Calibration | null;
  sensors?: number;
  compute_ms?: number;
  width: number;
  height: number;
  depth: Uint16Array | null; // quarter millimetres, 0: none
  intervalWidth: Uint16Array | null;
  source: Uint8Array | null;
  left: Uint8Array | null;
  leftWidth: number;
  leftHeight: number;
}

export interface Hello {
  sensor: string;
  recording: boolean;
  near_m: number;
  far_m: number;
  colours: string[];
  sources: { name: string; colour: string }[];
}

export interface Condition { name: string; text: string; severity: number }

export interface Status {
  at_ms: number; // of the program's clock
  frames: number;
  incomplete: number;
  lost: number;
  dropped: number;
  packets_missing: number;
  recovered: number;
  socket_drops: number;
  link: string[];
  waiting: string;
  health: null | {
    text: string; severity: number; reaction: number; uptime_s: number; rate_hz: number; latency_ms: number; subscribers: number;
    active: Condition[];
  };
}

export interface SensorEvent { text: string; condition: number; severity: number; active: boolean; count: number; time_ms: number }

// Whether this page may have something done, and the ticket that each request carries.
export interface Rights { may: boolean; why: string; why_not_pair: string; ticket: string; page: number }

// The page's connection that began what takes a while.
export type BegunBy = { page: number; place: string } | null;

export interface Listener {
  hello(hello: Hello): void;
  status(status: Status): void;
  event(event: SensorEvent): void;
  frame(frame: Frame): void;
  connected(is: boolean): void;
  rights(rights: Rights): void;
  answer(id: number, answer: { done: boolean; text: string }): void;
  settings(message: SettingsMessage): void;
  faults(message: FaultsMessage): void;
  recording(message: RecordingMessage): void;
  playback(message: PlaybackMessage): void;
  pairing(message: PairingMessage): void;
  update(message: UpdateMessage): void;
}

export type Plane = "depth" | "width" | "source" | "left";

const subprotocol = "stof.view.v1";
const retryMs = 1000;

export function parseFrame(data: ArrayBuffer): Frame {
  const size = new DataView(data).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, size)));
  const [width, height] = head.size;
  const [leftWidth, leftHeight] = head.left_size;
  let at = 4 + size;
  const has = (plane: Plane) => head.planes.includes(plane);
  const words = (plane: Plane) => {
    if (!has(plane)) return null;
    const pixels = new Uint16Array(data, at, width * height);
    at += pixels.byteLength;
    return pixels;
  };
  const bytes = (plane: Plane, count: number) => {
    if (!has(plane)) return null;
    const pixels = new Uint8Array(data, at, count);
    at += pixels.byteLength;
    return pixels;
  };
  const depth = words("depth");
  const intervalWidth = words("width");
  const source = bytes("source", width * height);
  const left = bytes("left", leftWidth * leftHeight);
  return { ...head, width, height, leftWidth, leftHeight, depth, intervalWidth, source, left };
}

export class Connection {
  private socket: WebSocket | null = null;
  private retry = 0;
  private resting = false;

  constructor(private listener: Listener, private planes: () => Plane[]) {
    this.open();
  }

  // Asks for that many more frames.
  ask(frames: number): void {
    if (this.socket?.readyState === WebSocket.OPEN) {
      const show = this.resting ? [] : this.planes();
      this.socket.send(JSON.stringify({ show, frames: this.resting ? 0 : frames, quiet: this.resting }));
    }
  }

  // False: there is no connection.
  send(request: object): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(request));
    return true;
  }

  // A page that nobody sees asks for nothing but events.
  rest(is: boolean): void {
    if (this.resting === is) return;
    this.resting = is;
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.ask(2);
    } else if (!is) {
      this.open();
    }
  }

  private open(): void {
    clearTimeout(this.retry);
    if (this.socket && this.socket.readyState !== WebSocket.CLOSED) return;
    const address = new URL(location.href);
    address.protocol = "ws:";
    address.hash = "";
    const socket = new WebSocket(address, subprotocol);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.listener.connected(true);
      this.ask(2);
    };
    socket.onclose = () => {
      this.listener.connected(false);
      if (!this.resting) this.retry = window.setTimeout(() => this.open(), retryMs);
    };
    socket.onmessage = (message) => {
      if (message.data instanceof ArrayBuffer) {
        this.listener.frame(parseFrame(message.data));
        return;
      }
      const said = JSON.parse(message.data);
      if (said.type === "hello") this.listener.hello(said);
      if (said.type === "status") this.listener.status(said);
      if (said.type === "event") this.listener.event(said);
      if (said.type === "rights") this.listener.rights(said);
      if (said.type === "answer") this.listener.answer(said.id, said);
      if (said.type === "settings") this.listener.settings(said);
      if (said.type === "faults") this.listener.faults(said);
      if (said.type === "recording") this.listener.recording(said);
      if (said.type === "playback") this.listener.playback(said);
      if (said.type === "pairing") this.listener.pairing(said);
      if (said.type === "update") this.listener.update(said);
    };
  }
}
