import { Frame } from "./messages";
import { Rgb, Scale, unitsPerMetre, widthFar, widthNear, word } from "./colours";
import type { Overlay } from "./depth_view";

// One point for each block of pixels: its nearest, so that no obstacle is left out. What has no depth has no point.
const vertexShader = `#version 300 es
precision highp float;
precision highp int;
precision highp usampler2D;
uniform usampler2D points;  // depth, and which pixel of the block
uniform sampler2D colours;
uniform ivec2 grid;
uniform int block;
uniform vec4 lens;  // fx, fy, cx, cy
uniform mat4 camera;
uniform float size;
out vec3 colour;
void main() {
  ivec2 cell = ivec2(gl_VertexID % grid.x, gl_VertexID / grid.x);
  uvec2 point = texelFetch(points, cell, 0).rg;
  if (point.r == 0u) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = 1.0;
    return;
  }
  int within = int(point.g);
  vec2 pixel = vec2(cell * block + ivec2(within % block, within / block));
  float z = float(point.r) / ${unitsPerMetre}.0;
  gl_Position = camera * vec4((pixel - lens.zw) / lens.xy * z, z, 1.0);
  gl_PointSize = max(1.0, size * z / gl_Position.w);
  colour = texelFetch(colours, cell, 0).rgb;
}`;
const fragmentShader = `#version 300 es
precision mediump float;
in vec3 colour;
out vec4 drawn;
void main() { drawn = vec4(colour, 1.0); }`;

const firstPoints = 19_200; // 30 frames a second also where the processor draws
const largestBlock = 8;
const slowMs = 50; // 15 clouds a second, and time for the rest
const fastMs = 25;
const longestMs = 2000;

export class CloudView {
  block = 0; // pixels on a side; 0: not chosen yet
  private gl: WebGL2RenderingContext | null;
  private program: WebGLProgram | null = null;
  private textures: WebGLTexture[] = [];
  private yaw = 0;
  private pitch = 0;
  private zoom = 1;
  private target = 0; // metres before the camera, what it turns about
  private pointers = new Map<number, [number, number]>();
  private fence: WebGLSync | null = null;
  private begunAt = 0;
  private took = 0; // to draw, a running mean, ms
  private fast = 0; // frames that could be finer
  private last: { frame: Frame; overlay: Overlay; full: boolean } | null = null;

  constructor(private canvas: HTMLCanvasElement, private scale: Scale, private sources: Rgb[], private changed: () => void) {
    this.gl = canvas.getContext("webgl2", { antialias: false, alpha: false });
    this.start();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.start());
    this.listen();
  }

  available(): boolean {
    return this.program !== null;
  }

  setScale(scale: Scale): void {
    this.scale = scale;
  }

  private start(): void {
    const gl = this.gl;
    if (!gl) return;
    const program = gl.createProgram()!;
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      console.error(gl.getProgramInfoLog(program));
      return;
    }
    this.program = program;
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.149, 0.157, 0.173, 1);
    this.textures = [0, 1].map((unit) => {
      const texture = gl.createTexture()!;
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      return texture;
    });
    gl.uniform1i(gl.getUniformLocation(program, "points"), 0);
    gl.uniform1i(gl.getUniformLocation(program, "colours"), 1);
  }

  // Blocks follow the time that drawing takes; `full`: one point for each pixel.
  draw(frame: Frame, overlay: Overlay, full: boolean): void {
    this.last = { frame, overlay, full };
    const gl = this.gl;
    const { depth, calibration } = frame;
    if (!gl || !this.program || !depth || !calibration) return;
    const begunAt = performance.now();
    this.block ||= Math.max(1, Math.ceil(Math.sqrt((frame.width * frame.height) / firstPoints)));
    const block = full ? 1 : this.block;
    const columns = Math.floor(frame.width / block);
    const rows = Math.floor(frame.height / block);
    this.upload(gl, frame, overlay, block, columns, rows);
    const ratio = window.devicePixelRatio || 1;
    const box = this.canvas.getBoundingClientRect();
    // Twice the frame's width is enough, also for screens with many pixels.
    const shrink = Math.min(1, (2 * frame.width) / (box.width * ratio));
    const width = Math.max(1, Math.round(box.width * ratio * shrink));
    const height = Math.max(1, Math.round(box.height * ratio * shrink));
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const at = (name: string) => gl.getUniformLocation(this.program!, name);
    gl.uniform2i(at("grid"), columns, rows);
    gl.uniform1i(at("block"), block);
    gl.uniform4f(at("lens"), calibration.fx, calibration.fy, calibration.cx, calibration.cy);
    const pixelsPerPixel = Math.min(width / frame.width, height / frame.height);
    gl.uniform1f(at("size"), 1.3 * block * pixelsPerPixel);
    gl.uniformMatrix4fv(at("camera"), false, this.camera(frame, width, height));
    gl.drawArrays(gl.POINTS, 0, columns * rows);
    if (!full && !this.fence) {
      this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      this.begunAt = begunAt;
      gl.flush();
      requestAnimationFrame(() => this.judge());
    }
  }

  // Looks at every repaint whether the cloud is drawn: how long that took decides how fine the next one is.
  private judge(): void {
    const gl = this.gl;
    if (!gl || !this.fence) return;
    const took = performance.now() - this.begunAt;
    if (gl.getSyncParameter(this.fence, gl.SYNC_STATUS) !== gl.SIGNALED && took < longestMs) {
      requestAnimationFrame(() => this.judge());
      return;
    }
    gl.deleteSync(this.fence);
    this.fence = null;
    this.took = this.took ? 0.7 * this.took + 0.3 * took : took;
    if (this.took > slowMs && this.block < largestBlock) {
      ++this.block;
      this.took = 0;
    } else if (this.took < fastMs && this.block > 1 && ++this.fast > 30) {
      --this.block;
      this.fast = this.took = 0;
    }
  }

  private upload(gl: WebGL2RenderingContext, frame: Frame, overlay: Overlay, block: number, columns: number, rows: number): void {
    const depth = frame.depth!;
    const points = new Uint16Array(2 * columns * rows);
    const colours = new Uint32Array(columns * rows);
    const { colour } = this.lookup();
    const narrow = overlay === "width" ? this.widths() : null;
    for (let row = 0, cell = 0; row < rows; ++row) {
      for (let column = 0; column < columns; ++column, ++cell) {
        let best = 0;
        let within = 0;
        let place = 0;
        for (let dy = 0; dy < block; ++dy) {
          let at = (row * block + dy) * frame.width + column * block;
          for (let dx = 0; dx < block; ++dx, ++at) {
            const value = depth[at];
            if (value && (!best || value < best)) {
              best = value;
              within = dy * block + dx;
              place = at;
            }
          }
        }
        if (!best) continue;
        points[2 * cell] = best;
        points[2 * cell + 1] = within;
        colours[cell] =
          overlay === "source" && frame.source
            ? word(this.sources[frame.source[place]] ?? [255, 255, 255])
            : narrow && frame.intervalWidth
              ? narrow[Math.max(1, frame.intervalWidth[place])]
              : colour[best];
      }
    }
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[0]);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG16UI, columns, rows, 0, gl.RG_INTEGER, gl.UNSIGNED_SHORT, points);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[1]);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, columns, rows, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(colours.buffer));
  }

  private kept: { scale: Scale; lookup: { colour: Uint32Array } } | null = null;
  private lookup(): { colour: Uint32Array } {
    if (this.kept?.scale !== this.scale) this.kept = { scale: this.scale, lookup: this.scale.lookup() };
    return this.kept.lookup;
  }

  private keptWidths: Uint32Array | null = null;
  private widths(): Uint32Array {
    this.keptWidths ??= new Scale([...this.scale.table].reverse(), widthNear, widthFar).lookup().colour;
    return this.keptWidths;
  }

  // Columns of projection * turn * from the sensor's axes (x right, y down, z forward).
  private camera(frame: Frame, width: number, height: number): Float32Array {
    const { fx, fy } = frame.calibration!;
    if (!this.target) this.target = median(frame.depth!) || 3;
    // Where the picture is the broader one, its height fits.
    const wide = width / frame.width > height / frame.height;
    const sx = wide ? ((2 * fy) / frame.height) * (height / width) : (2 * fx) / frame.width;
    const sy = wide ? (2 * fy) / frame.height : ((2 * fx) / frame.width) * (width / height);
    const [cy, siny] = [Math.cos(this.yaw), Math.sin(this.yaw)];
    const [cp, sp] = [Math.cos(this.pitch), Math.sin(this.pitch)];
    const distance = this.target / this.zoom;
    // Rows of the turned axes: right, up, forward.
    const right = [cy, 0, siny];
    const forward = [-siny * cp, sp, cy * cp];
    const up = [-siny * sp, -cp, cy * sp];
    const dot = (row: number[]) => -row[2] * this.target;
    const [near, far] = [0.05, 100];
    const a = (far + near) / (far - near);
    const b = (-2 * far * near) / (far - near);
    const depthOf = dot(forward) + distance;
    const matrix = new Float32Array(16);
    for (let column = 0; column < 3; ++column) {
      matrix[4 * column] = sx * right[column];
      matrix[4 * column + 1] = sy * up[column];
      matrix[4 * column + 2] = a * forward[column];
      matrix[4 * column + 3] = forward[column];
    }
    matrix[12] = sx * dot(right);
    matrix[13] = sy * dot(up);
    matrix[14] = a * depthOf + b;
    matrix[15] = depthOf;
    return matrix;
  }

  private turn(dx: number, dy: number, zoom: number): void {
    this.yaw = Math.max(-1.5, Math.min(1.5, this.yaw + dx));
    this.pitch = Math.max(-1.5, Math.min(1.5, this.pitch + dy));
    this.zoom = Math.max(0.2, Math.min(8, this.zoom * zoom));
    if (this.last) this.draw(this.last.frame, this.last.overlay, this.last.full);
    this.changed();
  }

  private reset(): void {
    this.yaw = this.pitch = this.target = 0;
    this.zoom = 1;
    this.turn(0, 0, 1);
  }

  private listen(): void {
    const canvas = this.canvas;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = this.pointers.get(event.pointerId);
      if (!before) return;
      const now: [number, number] = [event.clientX, event.clientY];
      const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      this.pointers.set(event.pointerId, now);
      if (others.length) {
        const span = (at: [number, number]) => Math.hypot(at[0] - others[0][0], at[1] - others[0][1]) || 1;
        this.turn(0, 0, span(now) / span(before));
      } else {
        this.turn((now[0] - before[0]) * 0.006, (now[1] - before[1]) * 0.006, 1);
      }
    });
    for (const name of ["pointerup", "pointercancel"] as const) {
      canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.turn(0, 0, Math.exp(-event.deltaY * 0.0015));
    }, { passive: false });
    canvas.addEventListener("dblclick", () => this.reset());
    canvas.addEventListener("keydown", (event) => {
      const turns: Record<string, [number, number, number]> = {
        ArrowLeft: [-0.1, 0, 1], ArrowRight: [0.1, 0, 1], ArrowUp: [0, -0.1, 1], ArrowDown: [0, 0.1, 1],
        "+": [0, 0, 1.2], "=": [0, 0, 1.2], "-": [0, 0, 1 / 1.2],
      };
      if (event.key === "0") this.reset();
      const turn = turns[event.key];
      if (!turn) return;
      event.preventDefault();
      this.turn(...turn);
    });
  }
}

function median(depth: Uint16Array): number {
  const some: number[] = [];
  for (let at = 0; at < depth.length; at += 37) {
    if (depth[at]) some.push(depth[at]);
  }
  some.sort((a, b) => a - b);
  return (some[some.length >> 1] ?? 0) / unitsPerMetre;
}
