import { Frame } from "./messages";
import { unitsPerMetre } from "./colours";

// Which pixel the user looks at, and what is known of it.
export class Probe {
  at: [number, number] | null = null;

  constructor(private canvas: HTMLCanvasElement, private mark: HTMLElement, private changed: (byKey: boolean) => void) {
    canvas.addEventListener("pointermove", (event) => this.point(event));
    canvas.addEventListener("pointerdown", (event) => this.point(event));
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse" && document.activeElement !== canvas) this.set(null, false);
    });
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  // The picture within its canvas, which is letterboxed.
  private box(): { left: number; top: number; scale: number } {
    const outer = this.canvas.getBoundingClientRect();
    const scale = Math.min(outer.width / this.canvas.width, outer.height / this.canvas.height);
    return {
      left: (outer.width - this.canvas.width * scale) / 2,
      top: (outer.height - this.canvas.height * scale) / 2,
      scale,
    };
  }

  private point(event: PointerEvent): void {
    const outer = this.canvas.getBoundingClientRect();
    const { left, top, scale } = this.box();
    const x = Math.floor((event.clientX - outer.left - left) / scale);
    const y = Math.floor((event.clientY - outer.top - top) / scale);
    const inside = x >= 0 && y >= 0 && x < this.canvas.width && y < this.canvas.height;
    this.set(inside ? [x, y] : null, false);
  }

  private key(event: KeyboardEvent): void {
    const steps: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const step = steps[event.key];
    if (event.key === "Escape") this.set(null, true);
    if (!step) return;
    event.preventDefault();
    const { width, height } = this.canvas;
    const [x, y] = this.at ?? [width >> 1, height >> 1];
    const far = event.shiftKey ? 10 : 1;
    this.set([Math.min(width - 1, Math.max(0, x + step[0] * far)), Math.min(height - 1, Math.max(0, y + step[1] * far))], true);
  }

  private set(at: [number, number] | null, byKey: boolean): void {
    this.at = at;
    this.place();
    this.changed(byKey);
  }

  // Where the mark stands, after the picture's size has changed, too.
  place(): void {
    this.mark.hidden = !this.at;
    if (!this.at) return;
    const { left, top, scale } = this.box();
    this.mark.style.left = `${left + (this.at[0] + 0.5) * scale}px`;
    this.mark.style.top = `${top + (this.at[1] + 0.5) * scale}px`;
  }

  read(frame: Frame | null, sources: string[]): { pixel: string; depth: string; width: string; source: string } {
    const nothing = { pixel: "–", depth: "–", width: "–", source: "–" };
    if (!this.at || !frame || this.at[0] >= frame.width || this.at[1] >= frame.height) return nothing;
    const place = this.at[1] * frame.width + this.at[0];
    const depth = frame.depth ? frame.depth[place] : 0;
    const name = frame.source ? sources[frame.source[place]] ?? "unknown" : "not sent";
    return {
      pixel: `${this.at[0]}, ${this.at[1]}`,
      depth: depth ? `${(depth / unitsPerMetre).toFixed(3)} m` : "none",
      width: !depth ? "–" : frame.intervalWidth ? `± ${((frame.intervalWidth[place] / unitsPerMetre) * 500).toFixed(1)} mm` : "not sent",
      source: name,
    };
  }
}
