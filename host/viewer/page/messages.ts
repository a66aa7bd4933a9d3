// What `stof view` tells the page (docs/VIEWER.md).

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
  lost: number; // frames, those that came too late among them
  late: number;
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

// condition: null where the link is meant: the sensor is silent, has started again, sends again.
export interface SensorEvent { text: string; condition: number | null; severity: number; active: boolean; count: number; time_ms: number }

// Whether this page may have something done, and the ticket that each request carries.
export interface Rights { may: boolean; why: string; why_not_pair: string; ticket: string; page: number }

// The page's connection that began what takes a while.
export type BegunBy = { page: number; place: string } | null;

export type Plane = "depth" | "width" | "source" | "left";

export interface Answer { done: boolean; text: string }

export interface SettingsMessage {
  problem: string;
  schema: string;
  active: string;
  saved: string;
  defaults: string;
  role: string;
  doubt: string;
}

export interface FaultsMessage { devices: { device: string; now: string; edges: number; kinds: string[] }[]; problem: string }

export interface RecordingMessage {
  possible: boolean; on: boolean; writing: boolean; file: string; bytes: number; frames: number; dropped: number; seconds: number; problem: string;
}

export interface PlaybackMessage { playing: boolean; seekable: boolean; at_ms: number; length_ms: number; began_ms: number }

export interface PairingMessage { offer: string; step: string; by: BegunBy; role: string; given: string; ours: string; text: string }

export interface UpdateMessage {
  folder: string; files: { name: string; bytes: number }[];
  step: string; by: BegunBy; file: string; sent: number; total: number; text: string;
  running: string; other: string; state: string; problem: string;
}

// One exposure as the calibration judged it; corners and sizes in px of the camera's picture.
export interface CalibrationLook {
  verdict: string; size: [number, number]; left: [number, number][]; right: [number, number][]; views: number;
  wants: { name: string; ask: string; have: number; need: number }[];
  cells: { size: [number, number]; left: number[]; right: number[] };
  left_png?: string; right_png?: string;
}
export interface CalibrationResult {
  file: string; views: string[]; corner_sigma_px: number; baseline_m: number; warnings: string[];
  held_out: null | { views: string[]; reprojection_px: number; row_px: number; largest_row_px: number; scale_error: number };
}
export interface CalibrationMessage {
  step: string; by: BegunBy; text: string; wrong: boolean; folder: string; kept: number; look: CalibrationLook | null; result: CalibrationResult | null; problem: string;
}
