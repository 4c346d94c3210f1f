/** From a phone's sensors to readings: frames on a curve (S 5.2.3). No page and no engine in here. */

/** One reading: where the phone pointed at a moment. Directions in the frame of the earth, unit. */
export interface Reading {
  /** Seconds of motion since the curve began: what is spent at nodes does not count. */
  time: number;
  tangent: [number, number, number];
  normal: [number, number, number];
}

const DEGREE = Math.PI / 180;

/**
 * The frame of a phone that slides along its upper edge with its back on the surface: the tangent is its y axis, the
 * outward normal its z axis. Angles in degrees as the browser gives them: the rotation from the phone to the earth is
 * Rz(alpha) Rx(beta) Ry(gamma) (W3C Device Orientation, 4.1).
 */
export function frameOf(alpha: number, beta: number, gamma: number): Pick<Reading, 'tangent' | 'normal'> {
  const [a, b, c] = [alpha * DEGREE, beta * DEGREE, gamma * DEGREE];
  const [sa, ca, sb, cb, sc, cc] = [Math.sin(a), Math.cos(a), Math.sin(b), Math.cos(b), Math.sin(c), Math.cos(c)];
  return {
    tangent: [-sa * cb, ca * cb, sb],
    normal: [ca * sc + sa * sb * cc, sa * sc - ca * sb * cc, cb * cc],
  };
}

/** The angle between two frames, in radians: that of the rotation from one to the other. */
export function angleBetween(a: Pick<Reading, 'tangent' | 'normal'>, b: Pick<Reading, 'tangent' | 'normal'>): number {
  const dot = (u: readonly number[], v: readonly number[]) => u.reduce((sum, x, i) => sum + x * (v[i] ?? 0), 0);
  const cross = (u: readonly number[], v: readonly number[]) => [0, 1, 2].map((i) => {
    const [j, k] = [(i + 1) % 3, (i + 2) % 3];
    return (u[j] ?? 0) * (v[k] ?? 0) - (u[k] ?? 0) * (v[j] ?? 0);
  });
  const trace = dot(a.tangent, b.tangent) + dot(a.normal, b.normal) + dot(cross(a.tangent, a.normal), cross(b.tangent, b.normal));
  return Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2)));
}

/** How regularly events come: their mean rate in Hz, and the standard deviation of the time between them in ms. */
export function rateOf(times: readonly number[]): { rate: number; jitter: number } | null {
  if (times.length < 5) return null;
  const steps = times.slice(1).map((time, i) => time - (times[i] ?? 0));
  const mean = steps.reduce((sum, step) => sum + step, 0) / steps.length;
  if (!(mean > 0)) return null;
  const variance = steps.reduce((sum, step) => sum + (step - mean) ** 2, 0) / steps.length;
  return { rate: 1000 / mean, jitter: Math.sqrt(variance) };
}

/** Where the readings lead at even speed, by the midpoints of their directions: the live picture. Starts at 0. */
export function pathOf(readings: readonly Reading[]): [number, number, number][] {
  const path: [number, number, number][] = [[0, 0, 0]];
  for (let i = 1; i < readings.length; ++i) {
    const [a, b, last] = [readings[i - 1], readings[i], path[i - 1]];
    if (!a || !b || !last) break;
    const h = (b.time - a.time) / 2;
    path.push([0, 1, 2].map((k) => (last[k] ?? 0) + h * ((a.tangent[k] ?? 0) + (b.tangent[k] ?? 0))) as [number, number, number]);
  }
  return path;
}
