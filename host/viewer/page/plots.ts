// Curves of the last minute.

const shownMs = 60_000;

export class Plot {
  private points: { at: number; value: number | null }[] = [];

  constructor(private canvas: HTMLCanvasElement, private least: number) {}

  add(at: number, value: number | null): void {
    this.points.push({ at, value });
    while (this.points[0].at < at - shownMs) this.points.shift();
  }

  total(): number {
    return this.points.reduce((sum, point) => sum + (point.value ?? 0), 0);
  }

  // From 0 to the next round number above all values.
  draw(now: number): void {
    const box = this.canvas.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(box.width * ratio);
    const height = Math.round(box.height * ratio);
    if (!width || !height) return;
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    const context = this.canvas.getContext("2d")!;
    const style = getComputedStyle(this.canvas);
    const values = this.points.map((point) => point.value ?? 0);
    const top = roundUp(Math.max(this.least, ...values));
    context.clearRect(0, 0, width, height);
    const font = 11 * ratio;
    context.font = `${font}px system-ui, sans-serif`;
    const room = context.measureText("00000").width;
    const place = (point: { at: number; value: number | null }) => [
      width - ((now - point.at) / shownMs) * (width - room),
      height - ratio - ((point.value ?? 0) / top) * (height - font),
    ];
    context.fillStyle = style.getPropertyValue("--quiet");
    context.strokeStyle = style.getPropertyValue("--line");
    context.lineWidth = ratio;
    for (const value of [0, top]) {
      const y = height - ratio - (value / top) * (height - font);
      context.beginPath();
      context.moveTo(room, y);
      context.lineTo(width, y);
      context.stroke();
      context.textBaseline = value ? "top" : "bottom";
      context.fillText(String(value), 0, value ? y - font / 3 : height);
    }
    context.strokeStyle = style.getPropertyValue("--plot");
    context.lineWidth = 1.5 * ratio;
    context.lineJoin = "round";
    context.beginPath();
    let drawing = false;
    for (const point of this.points) {
      const [x, y] = place(point);
      if (point.value === null || x < room) {
        drawing = false;
      } else if (drawing) {
        context.lineTo(x, y);
      } else {
        context.moveTo(x, y);
        drawing = true;
      }
    }
    context.stroke();
  }
}

function roundUp(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((factor) => factor * power).find((one) => one >= value * (1 - 1e-9))!;
}
