/** A scan that is being recorded, and its file. */
import type { Reading } from './orientation';

export interface PhoneCurve {
  name: string;
  boundary: boolean;
  readings: Reading[];
  /** Nodes: which reading, and their number in the scan. */
  nodes: { reading: number; number: number }[];
  /** Measured with a ruler, in the unit of the scan; null: estimated from closure. */
  length: number | null;
}

export interface PhoneScan {
  unit: string;
  curves: PhoneCurve[];
}

export const emptyScan = (): PhoneScan => ({ unit: 'mm', curves: [] });

/** The next number that no node has. */
export function nextNode(scan: PhoneScan): number {
  return 1 + Math.max(-1, ...scan.curves.flatMap((curve) => curve.nodes.map((node) => node.number)));
}

/** A curve that ends at the node where it began. */
export function isClosed(curve: PhoneCurve): boolean {
  return curve.nodes.length > 2 && curve.nodes[0]?.number === curve.nodes[curve.nodes.length - 1]?.number;
}

/** What was recorded between the first node and the last: before and after the hand only came and went. */
export function betweenNodes(curve: PhoneCurve): PhoneCurve {
  const from = curve.nodes[0]?.reading ?? 0;
  const to = curve.nodes[curve.nodes.length - 1]?.reading ?? curve.readings.length - 1;
  return {
    ...curve,
    readings: curve.readings.slice(from, to + 1),
    nodes: curve.nodes.map((node) => ({ ...node, reading: node.reading - from })),
  };
}

/** Whether the lengths are to be found from closure: some curve has none. */
export const needsLengths = (scan: PhoneScan): boolean => scan.curves.some((curve) => curve.length === null);

/** What keeps a scan from becoming a surface, in words, or nothing. */
export function problemOf(scan: PhoneScan): string | null {
  if (scan.curves.length < 2) return 'Two curves that cross are the least that a surface can be made of.';
  for (const curve of scan.curves) {
    if (curve.nodes.length < 2) return `${curve.name} has fewer than two nodes: press NODE wherever it meets another curve, and at its ends.`;
    const n = betweenNodes(curve).readings.length;
    if (n < 10) return `${curve.name} has only ${n} readings between its nodes; delete it and record it again.`;
  }
  const count = new Map<number, number>();
  for (const curve of scan.curves) for (const node of curve.nodes) count.set(node.number, (count.get(node.number) ?? 0) + 1);
  const alone = [...count].filter(([, n]) => n === 1).map(([number]) => number + 1);
  if (alone.length === count.size) return 'No two curves share a node: give the crossings the same numbers.';
  return null;
}

/**
 * The scan as a rawnet file (docs/files.md). Distances are seconds of motion, scaled to the length of the curve where it
 * was measured; else to the mean of those that were, or as they are.
 */
export function rawnetOf(recorded: PhoneScan): string {
  const scan = { ...recorded, curves: recorded.curves.map(betweenNodes) };
  const number = (x: number) => String(Number(x.toPrecision(9)));
  const known = scan.curves.filter((curve) => curve.length !== null);
  const seconds = (curve: PhoneCurve) => (curve.readings[curve.readings.length - 1]?.time ?? 1) - (curve.readings[0]?.time ?? 0);
  const speed =
    known.length > 0
      ? known.reduce((sum, curve) => sum + (curve.length ?? 0), 0) / known.reduce((sum, curve) => sum + seconds(curve), 0)
      : 1;
  const lines = ['# rawnet: recorded with a telephone', `# unit: ${scan.unit}`, '# tangents: at-sample', String(scan.curves.length)];
  for (const curve of scan.curves) {
    const scale = curve.length === null ? speed : curve.length / seconds(curve);
    const from = curve.readings[0]?.time ?? 0;
    lines.push(
      `# name: ${curve.name.replace(/[\r\n]+/g, ' ')}`,
      curve.boundary ? '1' : '0',
      isClosed(curve) ? '1' : '0',
      String(curve.nodes.length),
      curve.nodes.map((node) => node.reading + 1).join(' '),
      curve.nodes.map((node) => node.number).join(' '),
      String(curve.readings.length),
    );
    for (const { time, tangent, normal } of curve.readings)
      lines.push([scale * (time - from), ...tangent, ...normal].map(number).join(' '));
  }
  return `${lines.join('\n')}\n`;
}
