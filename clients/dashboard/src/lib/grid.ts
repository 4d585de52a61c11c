/** Nearest point of a cloud: points sorted into square cells (counting sort). Building is O(n); a
 *  search looks at rings of cells until no farther ring can hold a nearer point. */

export class PointGrid {
  private readonly start: Int32Array;
  private readonly order: Int32Array;
  private readonly columns: number;
  private readonly rows: number;
  private readonly cell: number;

  /** @param x coordinates, @param y coordinates, @param lower and @param upper the box around them */
  constructor(
    private readonly x: ArrayLike<number>,
    private readonly y: ArrayLike<number>,
    private readonly lower: readonly number[],
    upper: readonly number[],
  ) {
    const width = Math.max(upper[0]! - lower[0]!, 1e-300);
    const height = Math.max(upper[1]! - lower[1]!, 1e-300);
    const wanted = Math.max(1, x.length / 2);
    this.cell = Math.max(Math.sqrt((width * height) / wanted), Math.max(width, height) / wanted);
    this.columns = Math.floor(width / this.cell) + 1;
    this.rows = Math.floor(height / this.cell) + 1;
    [this.start, this.order] = this.sorted();
  }

  private sorted(): [Int32Array, Int32Array] {
    const start = new Int32Array(this.columns * this.rows + 1);
    const order = new Int32Array(this.x.length);
    const cells = new Int32Array(this.x.length);
    for (let p = 0; p < cells.length; p++) {
      cells[p] = this.column(this.x[p]!) + this.columns * this.row(this.y[p]!);
      start[cells[p]! + 1]!++;
    }
    for (let c = 1; c < start.length; c++) start[c]! += start[c - 1]!;
    const fill = start.slice();
    for (let p = 0; p < cells.length; p++) order[fill[cells[p]!]!++] = p;
    return [start, order];
  }

  private column(x: number): number {
    return clamp(Math.floor((x - this.lower[0]!) / this.cell), this.columns - 1);
  }

  private row(y: number): number {
    return clamp(Math.floor((y - this.lower[1]!) / this.cell), this.rows - 1);
  }

  /** Number of the point nearest to (x, y), -1 if none is within `reach`. */
  nearest(x: number, y: number, reach = Infinity): number {
    const [i, j] = [this.column(x), this.row(y)];
    let found = -1;
    let best = reach * reach;
    for (let ring = 0; ring <= Math.max(this.columns, this.rows); ring++) {
      const inner = (ring - 1) * this.cell;
      if (ring > 0 && inner * inner > best) break;
      for (let b = j - ring; b <= j + ring; b++) {
        if (b < 0 || b >= this.rows) continue;
        const step = b === j - ring || b === j + ring ? 1 : Math.max(1, 2 * ring);
        for (let a = i - ring; a <= i + ring; a += step) {
          if (a < 0 || a >= this.columns) continue;
          for (let k = this.start[a + this.columns * b]!; k < this.start[a + this.columns * b + 1]!; k++) {
            const p = this.order[k]!;
            const distance = (this.x[p]! - x) ** 2 + (this.y[p]! - y) ** 2;
            if (distance <= best && (distance < best || found < 0)) [best, found] = [distance, p];
          }
        }
      }
    }
    return found;
  }

  /** Median distance from a point to its nearest neighbour, over a sample of the points. */
  spacing(): number {
    const count = this.x.length;
    if (count < 2) return this.cell;
    const step = Math.max(1, Math.floor(count / 500));
    const found: number[] = [];
    for (let p = 0; p < count; p += step) found.push(this.toNeighbour(p));
    return found.sort((a, b) => a - b)[found.length >> 1]!;
  }

  private toNeighbour(p: number): number {
    const [x, y] = [this.x[p]!, this.y[p]!];
    let best = Infinity;
    for (let ring = 0; ring <= Math.max(this.columns, this.rows); ring++) {
      if (best <= (ring - 1) * this.cell) break;
      for (const q of this.ring(this.column(x), this.row(y), ring)) {
        if (q !== p) best = Math.min(best, Math.hypot(this.x[q]! - x, this.y[q]! - y));
      }
    }
    return best;
  }

  private *ring(i: number, j: number, ring: number): Generator<number> {
    for (let b = Math.max(0, j - ring); b <= Math.min(this.rows - 1, j + ring); b++) {
      for (let a = Math.max(0, i - ring); a <= Math.min(this.columns - 1, i + ring); a++) {
        if (Math.max(Math.abs(a - i), Math.abs(b - j)) !== ring) continue;
        const c = a + this.columns * b;
        for (let k = this.start[c]!; k < this.start[c + 1]!; k++) yield this.order[k]!;
      }
    }
  }
}

function clamp(k: number, most: number): number {
  return k < 0 ? 0 : k > most ? most : k;
}
