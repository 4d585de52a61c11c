/** The picture of a scene: canvases, camera and hands. It draws when something has changed, once per
 *  frame at most. */

import { PointGrid } from '../lib/grid';
import { rangeOf, type Scene } from '../lib/scene';
import { fitted, panned, project, unproject, zoomed, type Camera, type Size } from './camera';
import { drawArrows, drawAxes, drawBox, drawCut, drawProbe, inkOf, type Cut } from './overlay';
import { Renderer, type Look } from './renderer';
import { Tracers } from './tracers';

export interface Probe {
  point: number;
  place: number[];
}

export interface Handlers {
  probe: (probe: Probe | undefined) => void;
  cut: (cut: Cut) => void;
  /** The viewpoint, once it rests; undefined if all is in view. */
  camera: (camera: Camera | undefined) => void;
}

export type Tool = 'move' | 'cut';

const rest = 160; // milliseconds without a move after which all is drawn anew

export class PictureView {
  tool: Tool = 'move';
  private readonly renderer: Renderer;
  private readonly context: CanvasRenderingContext2D;
  private readonly watcher: ResizeObserver;
  private readonly pointers = new Map<number, { x: number; y: number }>();
  private scene: Scene | undefined;
  private grid: PointGrid | undefined;
  private spacing = 1;
  private camera: Camera = { centre: [0, 0, 0], zoom: 1, yaw: 0, pitch: 0 };
  private size: Size = { width: 1, height: 1 };
  private look: Look = { range: [0, 1], radius: 1, cells: true, opened: 0 };
  private pointSize = 1;
  private arrows: { vectors: Float64Array; strongest: number } | undefined;
  private tracers: Tracers | undefined;
  private cut: Cut | undefined;
  private probed: Probe | undefined;
  private grip: 0 | 1 | undefined;
  private frame = 0;
  private moved = -Infinity;
  private before = 0;
  private fits = true;
  private turned = false;

  constructor(
    private readonly host: HTMLElement,
    canvas: HTMLCanvasElement,
    private readonly overlay: HTMLCanvasElement,
    private readonly handlers: Handlers,
  ) {
    this.renderer = new Renderer(canvas);
    this.context = overlay.getContext('2d')!;
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(host);
    this.listen();
  }

  // ---- What is shown ----

  setScene(scene: Scene, camera?: Camera): void {
    this.scene = scene;
    const { points, dim, lower, upper } = scene;
    this.renderer.setPoints(points, dim, lower, upper);
    const at = (k: number): Float64Array => Float64Array.from({ length: scene.count }, (_, p) => (k < dim ? points[p * dim + k]! : 0));
    this.grid = dim === 2 ? new PointGrid(at(0), at(1), lower, upper) : undefined;
    this.spacing = this.grid?.spacing() ?? spacingOf(scene);
    this.arrows = this.tracers = this.probed = undefined;
    this.fits = !camera;
    if (camera) this.camera = { ...camera, zoom: camera.zoom * devicePixelRatio };
    this.resize();
  }

  setValues(values: ArrayLike<number>): void {
    this.renderer.setValues(values);
    this.ask();
  }

  setColours(table: Uint8Array, range: [number, number]): void {
    this.renderer.setColours(table);
    this.look = { ...this.look, range };
    this.ask();
  }

  setShape(cells: boolean, pointSize: number): void {
    this.pointSize = pointSize;
    this.look = { ...this.look, cells };
    this.renderer.invalidate();
    this.ask();
  }

  /** In space: hides the part of the cloud nearest to the viewer, up to all of it (1). */
  setOpening(opened: number): void {
    this.look = { ...this.look, opened };
    this.renderer.invalidate();
    this.ask();
  }

  setArrows(vectors: Float64Array | undefined): void {
    this.arrows = vectors && { vectors, strongest: strongest(vectors) || 1 };
    this.ask();
  }

  setMotion(vectors: Float64Array | undefined): void {
    const { scene, grid } = this;
    if (vectors && scene && grid) {
      const side = Math.max(scene.upper[0]! - scene.lower[0]!, scene.upper[1]! - scene.lower[1]!);
      const pace = side / 4 / (strongest(vectors) || 1);
      this.tracers = new Tracers(scene, vectors, grid, this.spacing, pace);
    } else {
      this.tracers = undefined;
    }
    this.ask();
  }

  setCut(cut: Cut | undefined): void {
    this.cut = cut;
    this.ask();
  }

  fit(): void {
    const { scene } = this;
    if (!scene) return;
    this.fits = true;
    this.lookFrom(fitted(scene.lower, scene.upper, this.size, 36 * devicePixelRatio));
  }

  /** Where one looks from, independent of the size of the window: zoom in pixels of the page. */
  private get viewpoint(): Camera | undefined {
    return this.fits ? undefined : { ...this.camera, zoom: this.camera.zoom / devicePixelRatio };
  }

  /** Everything drawn, as one picture. */
  snapshot(paper: string): HTMLCanvasElement {
    const copy = document.createElement('canvas');
    copy.width = this.size.width;
    copy.height = this.size.height;
    const context = copy.getContext('2d')!;
    context.fillStyle = paper;
    context.fillRect(0, 0, copy.width, copy.height);
    for (const layer of this.host.querySelectorAll('canvas')) context.drawImage(layer, 0, 0);
    return copy;
  }

  dispose(): void {
    cancelAnimationFrame(this.frame);
    this.watcher.disconnect();
    this.renderer.dispose();
  }

  // ---- Drawing ----

  redraw(): void {
    this.ask();
  }

  private ask(): void {
    if (!this.frame) this.frame = requestAnimationFrame((now) => this.draw(now));
  }

  private draw(now: number): void {
    this.frame = 0;
    const { scene, camera, size } = this;
    if (!scene || size.width < 2) return;
    const moving = now - this.moved < rest;
    const radius = this.pointSize * this.spacing * (this.look.cells && scene.dim < 3 ? 1.6 : 0.45);
    this.renderer.draw(camera, size, { ...this.look, radius }, moving);
    this.drawOver(scene, now);
    if (moving || this.tracers) this.ask();
    if (!moving && this.turned) this.tellCamera();
    this.before = now;
  }

  private tellCamera(): void {
    this.turned = false;
    this.handlers.camera(this.viewpoint);
  }

  private drawOver(scene: Scene, now: number): void {
    const { context, grid } = this;
    const scale = devicePixelRatio;
    const size = { width: this.size.width / scale, height: this.size.height / scale };
    const camera = { ...this.camera, zoom: this.camera.zoom / scale };
    const ink = inkOf(this.host);
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, size.width, size.height);
    if (this.tracers) {
      this.tracers.step(Math.min(0.05, Math.max(0, now - this.before) / 1000));
      this.tracers.draw(context, camera, size);
    }
    if (this.arrows && grid) {
      drawArrows(context, camera, size, scene, grid, { ...this.arrows, reach: 1.5 * this.spacing }, ink);
    }
    if (scene.dim === 3) drawBox(context, camera, size, scene, ink);
    else drawAxes(context, camera, size, ink);
    if (this.cut) drawCut(context, camera, size, this.cut, ink);
    if (this.probed) drawProbe(context, project(camera, size, spot(this.probed.place)), ink);
  }

  private resize(): void {
    const box = this.host.getBoundingClientRect();
    const [width, height] = [box.width, box.height].map((side) => Math.max(1, Math.round(side * devicePixelRatio)));
    this.size = { width: width!, height: height! };
    for (const layer of this.host.querySelectorAll('canvas')) {
      if (layer.width !== width) layer.width = width!;
      if (layer.height !== height) layer.height = height!;
    }
    this.renderer.invalidate();
    if (this.fits) this.fit();
    this.ask();
  }

  private lookFrom(camera: Camera): void {
    this.camera = camera;
    this.moved = performance.now();
    this.turned = true;
    this.ask();
  }

  private steer(camera: Camera): void {
    this.fits = false;
    this.lookFrom(camera);
  }

  // ---- Hands ----

  private listen(): void {
    const { overlay } = this;
    overlay.addEventListener('pointerdown', (event) => this.press(event));
    overlay.addEventListener('pointermove', (event) => this.move(event));
    for (const name of ['pointerup', 'pointercancel'] as const) overlay.addEventListener(name, (event) => this.release(event));
    overlay.addEventListener('pointerleave', () => this.pointers.size === 0 && this.probe(undefined));
    overlay.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    overlay.addEventListener('dblclick', () => this.fit());
    overlay.addEventListener('keydown', (event) => this.key(event));
  }

  private at(event: MouseEvent): { x: number; y: number } {
    const box = this.overlay.getBoundingClientRect();
    return { x: (event.clientX - box.left) * devicePixelRatio, y: (event.clientY - box.top) * devicePixelRatio };
  }

  private press(event: PointerEvent): void {
    const spotted = this.at(event);
    this.overlay.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, spotted);
    if (this.tool !== 'cut' || this.scene?.dim !== 2) return;
    const [x, y] = unproject(this.camera, this.size, spotted.x, spotted.y);
    this.grip = this.gripAt(spotted);
    if (this.grip === undefined) {
      this.grip = 1;
      this.cut = { from: [x, y], to: [x, y] };
    }
  }

  /** The end of the cut under a pixel. */
  private gripAt({ x, y }: { x: number; y: number }): 0 | 1 | undefined {
    if (!this.cut) return undefined;
    const near = [this.cut.from, this.cut.to].findIndex((end) => {
      const [a, b] = project(this.camera, this.size, [...end, 0]);
      return Math.hypot(a - x, b - y) < 14 * devicePixelRatio;
    });
    return near < 0 ? undefined : (near as 0 | 1);
  }

  private move(event: PointerEvent): void {
    const now = this.at(event);
    const last = this.pointers.get(event.pointerId);
    if (!last) {
      this.probe(this.near(now.x, now.y));
      return;
    }
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    this.pointers.set(event.pointerId, now);
    if (this.grip !== undefined && this.cut) this.dragCut(now);
    else if (other) this.pinch(last, now, other);
    else if (this.scene?.dim === 3 && !event.shiftKey) this.turn(now.x - last.x, now.y - last.y);
    else this.steer(panned(this.camera, now.x - last.x, now.y - last.y));
  }

  private dragCut({ x, y }: { x: number; y: number }): void {
    const [a, b] = unproject(this.camera, this.size, x, y);
    this.cut = this.grip ? { from: this.cut!.from, to: [a, b] } : { from: [a, b], to: this.cut!.to };
    this.ask();
  }

  private pinch(last: { x: number; y: number }, now: { x: number; y: number }, other: { x: number; y: number }): void {
    const spread = (p: { x: number; y: number }): number => Math.hypot(p.x - other.x, p.y - other.y) || 1;
    const closer = zoomed(this.camera, this.size, spread(now) / spread(last), (now.x + other.x) / 2, (now.y + other.y) / 2);
    this.steer(panned(closer, (now.x - last.x) / 2, (now.y - last.y) / 2));
  }

  private turn(dx: number, dy: number): void {
    const { yaw, pitch } = this.camera;
    this.steer({ ...this.camera, yaw: yaw - dx / 150, pitch: Math.min(1.57, Math.max(-1.57, pitch + dy / 150)) });
  }

  private release(event: PointerEvent): void {
    this.pointers.delete(event.pointerId);
    if (this.grip !== undefined && this.cut) this.handlers.cut(this.cut);
    this.grip = undefined;
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const { x, y } = this.at(event);
    this.steer(zoomed(this.camera, this.size, Math.exp(-event.deltaY / 400), x, y));
  }

  /** Arrows move the picture, with Shift the place that is read off; + and - zoom, 0 fits. */
  private key(event: KeyboardEvent): void {
    const steps: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const step = steps[event.key];
    const middle = [this.size.width / 2, this.size.height / 2] as const;
    if (step && event.shiftKey) this.stepProbe(step);
    else if (step && this.scene?.dim === 3) this.turn(-20 * step[0], 20 * step[1]);
    else if (step) this.steer(panned(this.camera, -60 * step[0], 60 * step[1]));
    else if (event.key === '+' || event.key === '=') this.steer(zoomed(this.camera, this.size, 1.25, ...middle));
    else if (event.key === '-') this.steer(zoomed(this.camera, this.size, 0.8, ...middle));
    else if (event.key === '0') this.fit();
    else return;
    event.preventDefault();
  }

  private stepProbe([a, b]: [number, number]): void {
    const from = this.probed ? spot(this.probed.place) : this.camera.centre;
    const way = Math.max(this.spacing, 24 / this.camera.zoom);
    const [x, y] = project(this.camera, this.size, [from[0] + a * way, from[1] + b * way, from[2]]);
    this.probe(this.near(x, y, Infinity));
  }

  /** The point that one sees at a pixel. */
  private near(x: number, y: number, reach?: number): Probe | undefined {
    const { scene, grid, camera, size } = this;
    if (!scene) return undefined;
    if (!grid) return this.nearInSpace(scene, x, y);
    const [a, b] = unproject(camera, size, x, y);
    const point = grid.nearest(a, b, reach ?? Math.max(1.2 * this.spacing, 10 / camera.zoom));
    return point < 0 ? undefined : { point, place: placeOf(scene, point) };
  }

  private nearInSpace(scene: Scene, x: number, y: number): Probe | undefined {
    if (scene.count > 200_000) return undefined;
    let [found, best] = [-1, (8 * devicePixelRatio) ** 2];
    for (let p = 0; p < scene.count; p++) {
      const [a, b] = project(this.camera, this.size, spot(placeOf(scene, p)));
      const distance = (a - x) ** 2 + (b - y) ** 2;
      if (distance < best) [found, best] = [p, distance];
    }
    return found < 0 ? undefined : { point: found, place: placeOf(scene, found) };
  }

  private probe(probe: Probe | undefined): void {
    if (probe?.point === this.probed?.point) return;
    this.probed = probe;
    this.handlers.probe(probe);
    this.ask();
  }

  /** Values along the cut: those of the nearest points. */
  along(cut: Cut, values: ArrayLike<number>, samples = 400): { s: number[]; value: number[] } {
    const [s, value]: [number[], number[]] = [[], []];
    const length = Math.hypot(cut.to[0] - cut.from[0], cut.to[1] - cut.from[1]);
    let last = -1;
    for (let k = 0; k <= samples; k++) {
      const part = k / samples;
      const p = this.grid?.nearest(...mix(cut.from, cut.to, part), 1.5 * this.spacing) ?? -1;
      if (p < 0 || p === last) continue;
      last = p;
      s.push(part * length);
      value.push(values[p]!);
    }
    return { s, value };
  }
}

function mix(a: [number, number], b: [number, number], part: number): [number, number] {
  return [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])];
}

function placeOf({ points, dim }: Scene, p: number): number[] {
  return Array.from(points.subarray(p * dim, (p + 1) * dim));
}

function spot(place: number[]): [number, number, number] {
  return [place[0] ?? 0, place[1] ?? 0, place[2] ?? 0];
}

/** Of a cloud that fills its box evenly. */
function spacingOf({ lower, upper, count, dim }: Scene): number {
  const volume = lower.reduce((product, low, k) => product * Math.max(upper[k]! - low, 1e-300), 1);
  return (volume / Math.max(1, count)) ** (1 / dim);
}

function strongest(vectors: Float64Array): number {
  const squares = Float64Array.from({ length: vectors.length / 2 }, (_, p) => vectors[2 * p]! ** 2 + vectors[2 * p + 1]! ** 2);
  return Math.sqrt(rangeOf(squares)[1]);
}
