/** Where one looks from: an orthographic view. In the plane it only moves and zooms. */

export interface Camera {
  /** The place in the middle of the picture. */
  centre: [number, number, number];
  /** Pixels per unit of length. */
  zoom: number;
  /** Turns about the vertical and the horizontal axis (radians); 0 in the plane. */
  yaw: number;
  pitch: number;
}

export interface Size {
  width: number;
  height: number;
}

export type Vector = [number, number, number];

/** Rows: to the right, up, towards the viewer. */
export function axesOf({ yaw, pitch }: Camera): [Vector, Vector, Vector] {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return [
    [cy, sy, 0],
    [-sy * sp, cy * sp, cp].map((value, k) => (pitch === 0 && yaw === 0 ? [0, 1, 0][k]! : value)) as Vector,
    [sy * cp, -cy * cp, sp].map((value, k) => (pitch === 0 && yaw === 0 ? [0, 0, 1][k]! : value)) as Vector,
  ];
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** From a place to a pixel. */
export function project(camera: Camera, size: Size, place: Vector): [number, number] {
  const [right, up] = axesOf(camera);
  const from = place.map((value, k) => value - camera.centre[k]!) as Vector;
  return [size.width / 2 + camera.zoom * dot(from, right), size.height / 2 - camera.zoom * dot(from, up)];
}

/** From a pixel to the place in the plane through the centre that one sees there. */
export function unproject(camera: Camera, size: Size, x: number, y: number): Vector {
  const [right, up] = axesOf(camera);
  const [a, b] = [(x - size.width / 2) / camera.zoom, (size.height / 2 - y) / camera.zoom];
  return camera.centre.map((value, k) => value + a * right[k]! + b * up[k]!) as Vector;
}

/** The camera that has all of a box in view. */
export function fitted(lower: number[], upper: number[], size: Size, margin: number): Camera {
  const at = (k: number): number => ((lower[k] ?? 0) + (upper[k] ?? 0)) / 2;
  const side = (k: number): number => (upper[k] ?? 0) - (lower[k] ?? 0);
  const flat = lower.length < 3;
  const [wide, high] = flat ? [side(0), side(1)] : Array(2).fill(Math.hypot(side(0), side(1), side(2)));
  const room = { width: Math.max(20, size.width - 2 * margin), height: Math.max(20, size.height - 2 * margin) };
  const zoom = Math.min(room.width / (wide || 1), room.height / (high || 1));
  return { centre: [at(0), at(1), at(2)], zoom, yaw: flat ? 0 : 0.6, pitch: flat ? 0 : 0.5 };
}

/** The camera moved by pixels. */
export function panned(camera: Camera, dx: number, dy: number): Camera {
  const [right, up] = axesOf(camera);
  const centre = camera.centre.map((value, k) => value - (dx * right[k]! - dy * up[k]!) / camera.zoom) as Vector;
  return { ...camera, centre };
}

/** The camera zoomed by a factor about a pixel, which keeps its place. */
export function zoomed(camera: Camera, size: Size, factor: number, x: number, y: number): Camera {
  const closer = { ...camera, zoom: camera.zoom * factor };
  const [before, after] = [unproject(camera, size, x, y), unproject(closer, size, x, y)];
  const centre = closer.centre.map((value, k) => value + before[k]! - after[k]!) as Vector;
  return { ...closer, centre };
}
