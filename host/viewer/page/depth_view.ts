import { Frame } from "./messages";
import { Rgb, Scale, widthFar, widthNear, word } from "./colours";

export type Base = "depth" | "left";
export type Overlay = "none" | "source" | "width";

// What has no depth is a checker, as in the PNG files: missing is never a colour of the scale.
const checker = [word([38, 40, 44]), word([52, 54, 58])];
const checkerShift = 3; // 8 px
const strength = 0.7; // of an overlay

// Draws frames as they are, pixel by pixel.
export class DepthView {
  private context: CanvasRenderingContext2D;
  private image: ImageData | null = null;
  private words = new Uint32Array(0);
  private depthLookup: { colour: Uint32Array; grey: Uint8Array };
  private widthLookup: { colour: Uint32Array; grey: Uint8Array };
  private sourceColours: Uint32Array;

  constructor(private canvas: HTMLCanvasElement, scale: Scale, sources: Rgb[]) {
    this.context = canvas.getContext("2d", { alpha: false })!;
    this.depthLookup = scale.lookup();
    this.widthLookup = new Scale([...scale.table].reverse(), widthNear, widthFar).lookup();
    this.sourceColours = Uint32Array.from({ length: 256 }, (_, at) => word(sources[at] ?? [255, 255, 255]));
  }

  setScale(scale: Scale): void {
    this.depthLookup = scale.lookup();
  }

  draw(frame: Frame, base: Base, overlay: Overlay): void {
    const { width, height } = frame;
    if (width === 0 || height === 0) return;
    if (!this.image || this.image.width !== width || this.image.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.image = this.context.createImageData(width, height);
      this.words = new Uint32Array(this.image.data.buffer);
    }
    const left = frame.leftWidth === width && frame.leftHeight === height ? frame.left : null;
    if (base === "left") {
      this.drawLeft(frame, left);
    } else {
      this.drawDepth(frame);
    }
    if (overlay !== "none") this.lay(frame, base, overlay, left);
    this.context.putImageData(this.image, 0, 0);
  }

  private drawDepth({ width, height, depth }: Frame): void {
    const words = this.words;
    const colour = this.depthLookup.colour;
    for (let y = 0, at = 0; y < height; ++y) {
      for (let x = 0; x < width; ++x, ++at) {
        const value = depth ? depth[at] : 0;
        words[at] = value ? colour[value] : checker[((x >> checkerShift) + (y >> checkerShift)) & 1];
      }
    }
  }

  private drawLeft({ width, height }: Frame, left: Uint8Array | null): void {
    const words = this.words;
    for (let at = 0; at < width * height; ++at) {
      const value = left ? left[at] : 0;
      words[at] = (0xff000000 | (value * 0x010101)) >>> 0;
    }
  }

  // The overlay's colour over the picture's lightness, so that shapes stay visible.
  private lay(frame: Frame, base: Base, overlay: Overlay, left: Uint8Array | null): void {
    const words = this.words;
    const grey = this.depthLookup.grey;
    const keep = 1 - strength;
    for (let at = 0; at < words.length; ++at) {
      let colour = 0;
      if (overlay === "source" && frame.source && frame.source[at]) colour = this.sourceColours[frame.source[at]];
      if (overlay === "width" && frame.intervalWidth && frame.depth?.[at]) {
        colour = this.widthLookup.colour[Math.max(1, frame.intervalWidth[at])];
      }
      if (!colour) continue;
      const light = (base === "left" ? (left ? left[at] : 0) : frame.depth ? grey[frame.depth[at]] : 0) * keep;
      const r = (colour & 255) * strength + light;
      const g = ((colour >> 8) & 255) * strength + light;
      const b = ((colour >> 16) & 255) * strength + light;
      words[at] = (0xff000000 | (b << 16) | (g << 8) | r) >>> 0;
    }
  }
}

// The distances between which all but 2 percent of the depths at each end lie, metres.
export function depthRange(depth: Uint16Array): [number, number] | null {
  const bins = new Uint32Array(1024);
  let count = 0;
  for (let at = 0; at < depth.length; at += 7) {
    if (depth[at]) {
      ++bins[depth[at] >> 6];
      ++count;
    }
  }
  if (count < 50) return null;
  const place = (share: number) => {
    let below = 0;
    for (let bin = 0; bin < bins.length; ++bin) {
      below += bins[bin];
      if (below >= share * count) return ((bin + 0.5) * 64) / 4000;
    }
    return 16.4;
  };
  const near = place(0.02);
  return [near, Math.max(place(0.98), near * 1.2)];
}
