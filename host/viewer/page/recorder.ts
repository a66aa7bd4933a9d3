// The record button, and the seek bar of a recording.
import { RecordingMessage, PlaybackMessage } from "./messages";
import { Requests, find, put } from "./panels";

// "1:02.3" of 62,300 ms.
function clock(ms: number): string {
  const minutes = Math.floor(ms / 60_000);
  return `${minutes}:${((ms % 60_000) / 1000).toFixed(1).padStart(4, "0")}`;
}

function size(bytes: number): string {
  return bytes < 1e9 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e9).toFixed(2)} GB`;
}

export class RecordButton {
  private on = false;

  constructor(private requests: Requests) {
    find("record").addEventListener("click", async () => {
      const answer = await this.requests.ask("record", { on: !this.on });
      if (!answer.done) this.say(answer.text, true);
    });
  }

  private say(text: string, wrong: boolean): void {
    put("record-said", text);
    find("record-said").dataset.level = wrong ? "major" : "good";
    find("record-said").hidden = text === "";
  }

  told(message: RecordingMessage): void {
    const button = find<HTMLButtonElement>("record");
    button.hidden = !message.possible;
    this.on = message.on;
    put("record", message.on ? "Stop recording" : "Record");
    button.setAttribute("aria-pressed", String(message.on));
    if (message.writing) {
      put("record-said", `Writing ${message.file}`);
      find("record-said").dataset.level = "wait";
      find("record-said").hidden = false;
    } else if (message.problem) {
      this.say(`${message.file}: ${message.problem}`, true);
    } else if (message.file) {
      const lost = message.dropped ? `, ${message.dropped} ${message.dropped === 1 ? "frame" : "frames"} not: the disk is too slow` : "";
      this.say(`${message.on ? "Recording" : "Recorded"} ${message.file}: ${clock(1000 * message.seconds)}, ${message.frames} ${message.frames === 1 ? "frame" : "frames"}, ${size(message.bytes)}${lost}`, message.dropped > 0);
    }
  }
}

const seekEveryMs = 120; // while it is dragged

export class Player {
  private state: PlaybackMessage | null = null;
  private held = 0; // until then the bar is the user's
  private sought = 0;
  private later = 0;

  constructor(private requests: Requests) {
    const bar = find<HTMLInputElement>("seek");
    bar.addEventListener("input", () => this.seek(Number(bar.value)));
    find("play").addEventListener("click", () => this.play());
    for (const [id, ms] of [["back", -5000], ["forward", 5000]] as const) find(id).addEventListener("click", () => this.jump(ms));
    document.addEventListener("keydown", (event) => {
      const at = event.target as HTMLElement; // what has keys of its own keeps them
      const taken = at.closest("input, select, canvas, summary, ol") || (event.key === " " && at.closest("button"));
      if (!this.state || taken || event.ctrlKey || event.altKey || event.metaKey) return;
      const act: Record<string, () => void> = {
        " ": () => this.play(),
        ArrowLeft: () => this.jump(-5000),
        ArrowRight: () => this.jump(5000),
        Home: () => this.seek(0),
        End: () => this.seek(this.state!.length_ms),
      };
      if (!act[event.key]) return;
      event.preventDefault();
      act[event.key]();
    });
  }

  plays(): boolean {
    return this.state?.playing ?? true;
  }

  told(message: PlaybackMessage): void {
    this.state = message;
    find("player").hidden = false;
    put("play", message.playing ? "Pause" : "Play");
    find<HTMLInputElement>("seek").max = String(Math.max(1, message.length_ms));
    for (const id of ["seek", "back", "forward"]) {
      const control = find<HTMLInputElement | HTMLButtonElement>(id);
      control.hidden = !message.seekable; // nobody knows how long it is
      control.disabled = !this.requests.rights.may;
    }
    find<HTMLButtonElement>("play").disabled = !this.requests.rights.may;
    if (performance.now() > this.held) this.show(message.at_ms);
    const began = message.began_ms ? `recorded ${new Date(message.began_ms).toLocaleString()}` : "";
    const absent = "This file has no index, so there is nothing to jump by: stof recover makes one.";
    put("player-note", message.seekable ? began : `${absent}${began && ` It was ${began}.`}`);
  }

  private show(ms: number): void {
    const bar = find<HTMLInputElement>("seek");
    bar.value = String(ms);
    const text = `${clock(ms)} of ${clock(this.state?.length_ms ?? 0)}`;
    bar.setAttribute("aria-valuetext", text);
    put("player-time", this.state?.seekable ? text : clock(ms));
  }

  private play(): void {
    void this.requests.ask("play", { on: !this.state?.playing }).then((answer) => { if (!answer.done) put("player-note", answer.text); });
  }

  private jump(ms: number): void {
    const at = performance.now() < this.held ? Number(find<HTMLInputElement>("seek").value) : this.state?.at_ms ?? 0;
    this.seek(at + ms);
  }

  private seek(ms: number): void {
    if (!this.state?.seekable) return;
    const to = Math.round(Math.min(this.state.length_ms, Math.max(0, ms)));
    this.held = performance.now() + 600;
    this.show(to);
    clearTimeout(this.later);
    const wait = this.sought + seekEveryMs - performance.now();
    if (wait > 0) {
      this.later = window.setTimeout(() => this.seek(to), wait);
      return;
    }
    this.sought = performance.now();
    void this.requests.ask("seek", { to_ms: to }).then((answer) => { if (!answer.done) put("player-note", answer.text); });
  }
}
