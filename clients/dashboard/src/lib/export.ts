/** Results as files: what is on the screen, without another solve. */

import { encode } from 'scatterd';
import type { Scene } from './scene';

export function save(name: string, data: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(data);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export function asDocument(result: unknown, format: 'json' | 'cbor'): Blob {
  return new Blob([encode(result, format) as BlobPart], { type: `application/${format}` });
}

/** Fields at one time by name; those of the scene that have been made, or can be made here. */
export async function columnsOf(scene: Scene, step: number, wanted: string[]): Promise<Map<string, Float64Array>> {
  const columns = new Map<string, Float64Array>();
  for (const field of scene.fields) {
    if (wanted.includes(field.id)) columns.set(field.id, await field.values(step));
  }
  return columns;
}

export function asCsv(scene: Scene, columns: Map<string, Float64Array>): Blob {
  const { points, dim, count } = scene;
  const parts = [[...'xyz'.slice(0, dim), ...columns.keys()].join(',') + '\n'];
  const values = [...columns.values()];
  for (let p = 0; p < count; p++) {
    const row = [...points.subarray(p * dim, (p + 1) * dim), ...values.map((column) => column[p]!)];
    parts.push(`${row.join(',')}\n`);
  }
  return new Blob(parts, { type: 'text/csv' });
}

/** VTK PolyData in XML: arrays appended raw, each after its length as a 64-bit integer. */
export function asVtp(scene: Scene, columns: Map<string, Float64Array>): Blob {
  const { points, dim, count } = scene;
  const places = new Float64Array(3 * count);
  for (let p = 0; p < count; p++) places.set(points.subarray(p * dim, (p + 1) * dim), 3 * p);
  const arrays: [string, string, ArrayBufferView][] = [
    ['Points', 'type="Float64" NumberOfComponents="3"', places],
    ['connectivity', 'type="Int32"', Int32Array.from({ length: count }, (_, p) => p)],
    ['offsets', 'type="Int32"', Int32Array.from({ length: count }, (_, p) => p + 1)],
    ...[...columns].map(([name, values]): [string, string, ArrayBufferView] => [name, 'type="Float64"', values]),
  ];
  let offset = 0;
  const tags = arrays.map(([name, kind, data]) => {
    const tag = `<DataArray Name="${name}" ${kind} format="appended" offset="${offset}"/>`;
    offset += 8 + data.byteLength;
    return tag;
  });
  const head = `<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PolyData><Piece NumberOfPoints="${count}" NumberOfVerts="${count}" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0">
<Points>${tags[0]}</Points>
<Verts>${tags[1]}${tags[2]}</Verts>
<PointData>${tags.slice(3).join('\n')}</PointData>
</Piece></PolyData>
<AppendedData encoding="raw">_`;
  const data = arrays.flatMap(([, , array]) => [BigUint64Array.of(BigInt(array.byteLength)), array] as BlobPart[]);
  return new Blob([head, ...data, '</AppendedData></VTKFile>\n'], { type: 'application/vnd.vtk.vtp+xml' });
}
