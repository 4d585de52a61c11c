/** Particles carried along by a steady velocity field, for the eye: they start anywhere in the cloud
 *  and are replaced when they leave it or grow old. */

import type { PointGrid } from '../lib/grid';
import type { Scene } from '../lib/scene';
import { project, type Camera, type Size } from './camera';

const wanted = 900;
const life = 3; // seconds
const tail = 9; // places kept

interface Tracer {
  x: number;
  y: number;
  age: number;
  trail: number[];
}

export class Tracers {
  private readonly all: Tracer[];

  constructor(
    private readonly scene: Scene,
    private readonly vectors: Float64Array,
    private readonly grid: PointGrid,
    private readonly reach: number,
    /** Lengths of the field covered by the fastest in a second. */
    private readonly pace: number,
  ) {
    this.all = Array.from({ length: wanted }, () => this.born(Math.random() * life));
  }

  private born(age: number): Tracer {
    const { points, count } = this.scene;
    const p = Math.floor(Math.random() * count);
    const jump = (): number => (Math.random() - 0.5) * this.reach;
    return { x: points[2 * p]! + jump(), y: points[2 * p + 1]! + jump(), age, trail: [] };
  }

  /** Moves all by `seconds`, by the midpoint rule. */
  step(seconds: number): void {
    this.all.forEach((tracer, k) => {
      const half = this.moved(tracer, tracer, seconds / 2);
      const next = half && this.moved(tracer, half, seconds);
      tracer.age += seconds;
      if (!next || tracer.age > life) {
        this.all[k] = this.born(0);
        return;
      }
      tracer.trail.push(tracer.x, tracer.y);
      if (tracer.trail.length > 2 * tail) tracer.trail.splice(0, 2);
      [tracer.x, tracer.y] = [next.x, next.y];
    });
  }

  private moved(from: { x: number; y: number }, at: { x: number; y: number }, seconds: number): { x: number; y: number } | undefined {
    const { lower, upper } = this.scene;
    const inside = at.x >= lower[0]! && at.x <= upper[0]! && at.y >= lower[1]! && at.y <= upper[1]!;
    const p = inside ? this.grid.nearest(at.x, at.y, this.reach) : -1;
    if (p < 0) return undefined;
    const way = seconds * this.pace;
    return { x: from.x + way * this.vectors[2 * p]!, y: from.y + way * this.vectors[2 * p + 1]! };
  }

  /** White within black, to be seen on every colour of a map. */
  draw(context: CanvasRenderingContext2D, camera: Camera, size: Size): void {
    context.lineCap = 'round';
    for (const [width, colour, alpha] of [[2.8, '#000', 0.35], [1.3, '#fff', 0.9]] as const) {
      context.lineWidth = width;
      context.strokeStyle = colour;
      context.globalAlpha = alpha;
      context.beginPath();
      for (const { x, y, trail } of this.all) {
        const places = [...trail, x, y];
        for (let k = 0; k < places.length; k += 2) {
          const spot = project(camera, size, [places[k]!, places[k + 1]!, 0]);
          if (k) context.lineTo(...spot);
          else context.moveTo(...spot);
        }
      }
      context.stroke();
    }
    context.globalAlpha = 1;
    context.lineWidth = 1;
  }
}
