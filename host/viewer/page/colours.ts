// Colours, all from the table that the server sends: the same as those of the PNG files.

export const unitsPerMetre = 4000; // depth and width are in quarter millimetres
const opaque = 0xff000000;

export type Rgb = [number, number, number];

export function rgb(text: string): Rgb {
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)) as Rgb;
}

// As ImageData holds it, read as little-endian words.
export function word([r, g, b]: Rgb): number {
  return (opaque | (b << 16) | (g << 8) | r) >>> 0;
}

// Distances on a logarithmic scale, near is warm. Beyond the ends is the colour of the end.
export class Scale {
  constructor(readonly table: Rgb[], readonly near: number, readonly far: number) {}

  position(metres: number): number {
    return Math.min(1, Math.max(0, Math.log(metres / this.near) / Math.log(this.far / this.near)));
  }

  at(position: number): Rgb {
    return this.table[Math.round(position * (this.table.length - 1))];
  }

  // The colour of each value of 16 bits, and its lightness.
  lookup(): { colour: Uint32Array; grey: Uint8Array } {
    const colour = new Uint32Array(65536);
    const grey = new Uint8Array(65536);
    for (let value = 1; value < 65536; ++value) {
      const [r, g, b] = this.at(this.position(value / unitsPerMetre));
      colour[value] = word([r, g, b]);
      grey[value] = (r * 54 + g * 183 + b * 19) >> 8;
    }
    return { colour, grey };
  }

  // Round values inside the scale, near first; as host/picture/colour_scale.cpp has them.
  ticks(): number[] {
    const all: number[] = [];
    for (let decade = 10 ** Math.floor(Math.log10(this.near)); decade <= this.far; decade *= 10) {
      for (const digit of [1, 1.5, 2, 3, 5, 7]) {
        const value = digit * decade;
        if (value >= this.near * (1 - 1e-9) && value <= this.far * (1 + 1e-9)) all.push(value);
      }
    }
    return all.length >= 3 ? all : linearTicks(this.near, this.far);
  }
}

function linearTicks(low: number, high: number): number[] {
  const raw = (high - low) / 8;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((one) => one >= raw * (1 - 1e-9))!;
  const all: number[] = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high * (1 + 1e-9); ++n) all.push(n * step);
  return all;
}

// Widths of intervals: from 2 mm to 1 m.
export const widthNear = 0.002;
export const widthFar = 1;
