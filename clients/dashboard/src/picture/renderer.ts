/** Points drawn by WebGL 2. regl and what is built on it (regl-scatterplot) make code at run time,
 *  which the Content-Security-Policy of this page forbids; deck.gl is larger than the page may be.
 *
 *  A picture is drawn once into a texture somewhat larger than the canvas, and the canvas shows that
 *  texture: moving about costs one rectangle per frame, however many points there are and however
 *  slow the machine draws them. When the view rests, the texture is drawn anew.
 *
 *  In the plane, points are drawn as cones seen from the tip: where two overlap the nearer one wins,
 *  so that the picture is the Voronoi diagram of the cloud, without gaps. */

import { axesOf, type Camera, type Size } from './camera';

export interface Look {
  range: [number, number];
  /** Radius of a point (length). */
  radius: number;
  /** Cells of the plane, else discs. */
  cells: boolean;
  /** Part of the depth of a cloud in space that is hidden, from the viewer's side. */
  opened: number;
}

const margin = 1.4; // texture over canvas

/** Few points are quads, many are GL points: these cannot be as large as one likes on every card, but
 *  a million of them costs a thousandth of what a million quads cost without a card. */
const quadsUpTo = 20_000;

/** Both kinds from the same text; `#define QUADS` comes before it. */
const pointVertex = `
#ifdef QUADS
layout(location = 0) in vec2 corner;
#else
const vec2 corner = vec2(0.0);
#endif
layout(location = 1) in vec3 place;
layout(location = 2) in float value;
uniform vec3 centre;
uniform mat3 turn;
uniform vec2 scale;
uniform vec2 radius;
uniform float depth;
uniform vec2 range;
uniform float pixels;
uniform float nearest;
out vec2 at;
flat out vec2 spot;
flat out float shade;
void main() {
  vec3 p = turn * (place - centre);
  gl_Position = vec4(p.xy * scale + corner * radius, p.z > nearest ? 2.0 : -p.z * depth, 1.0);
  gl_PointSize = 2.0 * pixels;
  at = corner;
  spot = place.xy;
  shade = value > 1e30 ? -1.0 : clamp((value - range.x) * range.y, 0.0, 1.0);
}`;

const pointFragment = `
precision highp float;
in vec2 at;
flat in vec2 spot;
flat in float shade;
uniform sampler2D colours;
uniform bool cells;
uniform bool solid;
uniform float world;
uniform vec4 box;
out vec4 colour;
void main() {
#ifdef QUADS
  vec2 from = at;
#else
  vec2 from = vec2(2.0, -2.0) * gl_PointCoord + vec2(-1.0, 1.0);
#endif
  float d = length(from);
  if (d > 1.0) discard;
  vec2 here = spot + from * world;
  if (cells && (any(lessThan(here, box.xy)) || any(greaterThan(here, box.zw)))) discard;
  gl_FragDepth = cells ? 0.999 * d : gl_FragCoord.z;
  vec3 paint = shade < 0.0 ? vec3(0.5) : texture(colours, vec2((shade * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (solid) paint *= 0.7 + 0.3 * sqrt(1.0 - d * d);
  colour = vec4(paint, 1.0);
}`;

const showVertex = `
layout(location = 0) in vec2 corner;
uniform vec4 map;
out vec2 uv;
void main() {
  gl_Position = vec4(corner, 0.0, 1.0);
  uv = corner * map.xy + map.zw;
}`;

const showFragment = `
precision highp float;
in vec2 uv;
uniform sampler2D image;
out vec4 colour;
void main() {
  bool inside = all(greaterThanEqual(uv, vec2(0.0))) && all(lessThanEqual(uv, vec2(1.0)));
  colour = inside ? texture(image, uv) : vec4(0.0);
}`;

interface Program {
  program: WebGLProgram;
  at: (name: string) => WebGLUniformLocation | null;
}

export class Renderer {
  private readonly gl: WebGL2RenderingContext;
  private readonly quads: Program;
  private readonly dots: Program;
  private readonly show: Program;
  private readonly places: WebGLBuffer;
  private readonly values: WebGLBuffer;
  private readonly colours: WebGLTexture;
  private readonly target: WebGLFramebuffer;
  private readonly image: WebGLTexture;
  private readonly depth: WebGLRenderbuffer;
  private origin: [number, number, number] = [0, 0, 0];
  private unit = 1;
  private dim = 2;
  private box: [number, number, number, number] = [0, 0, 1, 1];
  private drawn: { camera: Camera; size: Size } | undefined;
  private order: Uint32Array | undefined;
  count = 0;
  /** Milliseconds that the last full drawing took. */
  cost = 0;

  constructor(private readonly canvas: HTMLCanvasElement) {
    const gl = canvas.getContext('webgl2', { antialias: false, alpha: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error('This browser has no WebGL 2, which the picture needs.');
    this.gl = gl;
    const versioned = (text: string, define = ''): string => `#version 300 es\n${define}${text}`;
    const quads = '#define QUADS\n';
    this.quads = this.link(versioned(pointVertex, quads), versioned(pointFragment, quads));
    this.dots = this.link(versioned(pointVertex), versioned(pointFragment));
    this.show = this.link(versioned(showVertex), versioned(showFragment));
    const corners = this.fill(gl.createBuffer(), Float32Array.of(-1, -1, 1, -1, -1, 1, 1, 1));
    this.attribute(corners, 0, 2);
    this.places = gl.createBuffer();
    this.attribute(this.places, 1, 3);
    this.values = gl.createBuffer();
    this.attribute(this.values, 2, 1);
    this.colours = this.texture();
    this.image = this.texture();
    this.target = gl.createFramebuffer();
    this.depth = gl.createRenderbuffer();
  }

  // ---- What is drawn ----

  /** Points [n][d] in a box; coordinates are kept relative to its middle, for precision. */
  setPoints(points: Float64Array, dim: number, lower: number[], upper: number[]): void {
    this.count = points.length / dim;
    this.dim = dim;
    this.origin = [0, 1, 2].map((k) => ((lower[k] ?? 0) + (upper[k] ?? 0)) / 2) as [number, number, number];
    this.unit = Math.max(...lower.map((low, k) => upper[k]! - low), 1e-300);
    this.order = dim === 3 ? shuffled(this.count) : undefined;
    const places = new Float32Array(3 * this.count);
    for (let p = 0; p < this.count; p++) {
      const from = (this.order?.[p] ?? p) * dim;
      for (let k = 0; k < dim; k++) places[3 * p + k] = (points[from + k]! - this.origin[k]!) / this.unit;
    }
    this.box = [0, 1].flatMap((end) => [0, 1].map((k) => this.inside((end ? upper : lower)[k] ?? 0, k))) as typeof this.box;
    this.fill(this.places, places);
    this.drawn = undefined;
  }

  private inside(value: number, k: number): number {
    return (value - this.origin[k]!) / this.unit;
  }

  setValues(values: ArrayLike<number>): void {
    const numbers = new Float32Array(this.count);
    for (let p = 0; p < this.count; p++) {
      const value = values[this.order?.[p] ?? p]!;
      numbers[p] = Number.isFinite(value) ? value : 3e38;
    }
    this.fill(this.values, numbers);
    this.drawn = undefined;
  }

  setColours(table: Uint8Array): void {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, table);
    this.drawn = undefined;
  }

  /** The next draw is a full one. */
  invalidate(): void {
    this.drawn = undefined;
  }

  // ---- Drawing ----

  /** Shows the points. While `moving`, what was drawn before may be shown in a new place. */
  draw(camera: Camera, size: Size, look: Look, moving: boolean): void {
    const slow = this.cost > 14;
    const turned = this.drawn && (this.drawn.camera.yaw !== camera.yaw || this.drawn.camera.pitch !== camera.pitch);
    const reusable = this.drawn && !turned && this.drawn.size.width === size.width && this.drawn.size.height === size.height;
    if (!(moving && slow && reusable)) this.drawFully(camera, size, look, moving && slow);
    this.present(camera, size);
  }

  private drawFully(camera: Camera, size: Size, look: Look, hurried: boolean): void {
    const wait = (): void => this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
    if (!hurried) wait(); // for what was asked of the card before
    const began = performance.now();
    const count = hurried && this.dim === 3 ? Math.ceil((this.count * 12) / this.cost) : this.count;
    this.drawImage(camera, size, look, Math.min(count, this.count));
    this.drawn = { camera, size };
    if (hurried) return;
    wait();
    this.cost = performance.now() - began;
    this.canvas.dataset.drawn = this.cost.toFixed(1);
    this.canvas.dataset.points = String(this.count);
  }

  private drawImage(camera: Camera, size: Size, look: Look, count: number): void {
    const { gl } = this;
    const [width, height] = [Math.ceil(size.width * margin), Math.ceil(size.height * margin)];
    this.resizeTarget(width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.viewport(0, 0, width, height);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const isQuads = this.count <= quadsUpTo;
    const program = isQuads ? this.quads : this.dots;
    gl.useProgram(program.program);
    this.setUniforms(program, camera, { width, height }, look);
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    this.advance(isQuads ? 1 : 0);
    if (isQuads) gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    else gl.drawArrays(gl.POINTS, 0, count);
  }

  /** Place and value of a point: once per instance (1), or per vertex (0). */
  private advance(divisor: number): void {
    for (const place of [1, 2]) this.gl.vertexAttribDivisor(place, divisor);
  }

  private setUniforms({ at }: Program, camera: Camera, { width, height }: Size, look: Look): void {
    const { gl, unit } = this;
    const pixels = camera.zoom * unit;
    const radius = Math.max(look.radius / unit, 0.75 / pixels);
    const [least, greatest] = look.range;
    const cells = look.cells && this.dim < 3;
    gl.uniform3fv(at('centre'), camera.centre.map((value, k) => this.inside(value, k)));
    gl.uniformMatrix3fv(at('turn'), true, axesOf(camera).flat());
    gl.uniform2f(at('scale'), (2 * pixels) / width, (2 * pixels) / height);
    gl.uniform2f(at('radius'), (2 * pixels * radius) / width, (2 * pixels * radius) / height);
    gl.uniform1f(at('world'), radius);
    gl.uniform1f(at('pixels'), pixels * radius);
    gl.uniform1f(at('depth'), 0.3);
    gl.uniform1f(at('nearest'), this.dim === 3 ? 0.9 - 1.8 * look.opened : 1e9);
    gl.uniform2f(at('range'), least, greatest > least ? 1 / (greatest - least) : 0);
    gl.uniform1i(at('cells'), +cells);
    gl.uniform1i(at('solid'), +(this.dim === 3));
    const slack = 0.5 / pixels;
    gl.uniform4f(at('box'), this.box[0] - slack, this.box[1] - slack, this.box[2] + slack, this.box[3] + slack);
  }

  /** The texture on the canvas, moved from the view it was drawn for to the present one. */
  private present(camera: Camera, size: Size): void {
    const { gl } = this;
    if (!this.drawn) return;
    const before = this.drawn.camera;
    const ratio = before.zoom / camera.zoom;
    const [right, up] = axesOf(camera);
    const offset = (axis: number[]): number =>
      axis.reduce((sum, part, k) => sum + part * (camera.centre[k]! - before.centre[k]!), 0) * before.zoom;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, size.width, size.height);
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(this.show.program);
    gl.bindTexture(gl.TEXTURE_2D, this.image);
    const [width, height] = [Math.ceil(size.width * margin), Math.ceil(size.height * margin)];
    gl.uniform4f(this.show.at('map'), (ratio * size.width) / (2 * width), (ratio * size.height) / (2 * height),
      0.5 + offset(right) / width, 0.5 + offset(up) / height);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }

  dispose(): void {
    this.gl.getExtension('WEBGL_lose_context')?.loseContext();
  }

  // ---- WebGL ----

  private resizeTarget(width: number, height: number): void {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.image);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.image, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depth);
  }

  private link(vertex: string, fragment: string): Program {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
      const shader = gl.createShader(type)!;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error(`The graphics card refuses the picture: ${gl.getProgramInfoLog(program)}`);
    }
    const places = new Map<string, WebGLUniformLocation | null>();
    const at = (name: string): WebGLUniformLocation | null => {
      if (!places.has(name)) places.set(name, gl.getUniformLocation(program, name));
      return places.get(name) ?? null;
    };
    return { program, at };
  }

  private fill(buffer: WebGLBuffer, data: Float32Array): WebGLBuffer {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }

  private attribute(buffer: WebGLBuffer, place: number, size: number): void {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, 0, 0);
  }

  private texture(): WebGLTexture {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return texture;
  }
}

/** 0 to n - 1 in an order that looks random, so that the first few are a fair sample. */
function shuffled(n: number): Uint32Array {
  const order = Uint32Array.from({ length: n }, (_, k) => k);
  let state = 1;
  for (let k = n - 1; k > 0; k--) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    const other = state % (k + 1);
    [order[k], order[other]] = [order[other]!, order[k]!];
  }
  return order;
}
