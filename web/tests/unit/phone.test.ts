import { describe, expect, it } from 'vitest';
import { angleBetween, frameOf, pathOf, rateOf, type Reading } from '../../src/phone/orientation';
import { betweenNodes, emptyScan, isClosed, nextNode, type PhoneCurve, problemOf, rawnetOf } from '../../src/phone/scan';

const near = (a: readonly number[], b: readonly number[]) => a.forEach((x, i) => expect(x).toBeCloseTo(b[i] ?? Number.NaN, 12));

describe('the frame of a telephone', () => {
  // W3C Device Orientation, section 4.1: flat on a table the screen faces up, and the top edge points north at alpha 0.
  it('is that of the standard', () => {
    near(frameOf(0, 0, 0).tangent, [0, 1, 0]);
    near(frameOf(0, 0, 0).normal, [0, 0, 1]);
    near(frameOf(90, 0, 0).tangent, [-1, 0, 0]); // turned to the left: west
    near(frameOf(0, 90, 0).tangent, [0, 0, 1]); // upright
    near(frameOf(0, 90, 0).normal, [0, -1, 0]);
    near(frameOf(0, 0, 90).normal, [1, 0, 0]); // rolled to the right
  });
  it('turns by the angle that it was turned by', () => {
    expect(angleBetween(frameOf(10, 20, 30), frameOf(10, 20, 30))).toBeCloseTo(0, 6);
    expect(angleBetween(frameOf(0, 0, 0), frameOf(37, 0, 0))).toBeCloseTo((37 * Math.PI) / 180, 12);
    expect(angleBetween(frameOf(0, 0, 0), frameOf(0, -50, 0))).toBeCloseTo((50 * Math.PI) / 180, 12);
  });
});

it('the rate of events is measured with its jitter', () => {
  expect(rateOf([0, 10, 20])).toBeNull();
  expect(rateOf([0, 10, 20, 30, 40, 50])).toEqual({ rate: 100, jitter: 0 });
  expect(rateOf([0, 5, 20, 25, 40])?.jitter).toBeCloseTo(5, 12);
});

it('a circle at even speed comes back', () => {
  const n = 200;
  const readings: Reading[] = Array.from({ length: n + 1 }, (_, i) => {
    const t = (2 * Math.PI * i) / n;
    return { time: t, tangent: [-Math.sin(t), Math.cos(t), 0], normal: [Math.cos(t), Math.sin(t), 0] };
  });
  const path = pathOf(readings);
  near(path[n] ?? [], [0, 0, 0]);
  expect(path[n / 2]?.[0]).toBeCloseTo(-2, 3); // the diameter of a unit circle away
});

const curve = (nodes: [number, number][], n = 30): PhoneCurve => ({
  name: 'rim',
  boundary: true,
  length: null,
  nodes: nodes.map(([reading, number]) => ({ reading, number })),
  readings: Array.from({ length: n }, (_, i) => ({ time: 0.1 * i, tangent: [1, 0, 0], normal: [0, 0, 1] })),
});

describe('a scan from a telephone', () => {
  it('is written as rawnet: from the first node to the last, scaled to the length', () => {
    const scan = { unit: 'mm', curves: [{ ...curve([[5, 0], [25, 1]]), length: 40 }] };
    const lines = rawnetOf(scan).split('\n').filter((line) => !line.startsWith('#'));
    expect(lines.slice(0, 7)).toEqual(['1', '1', '0', '2', '1 21', '0 1', '21']);
    expect(lines[7]).toBe('0 1 0 0 0 0 1');
    expect(lines[27]).toBe('40 1 0 0 0 0 1');
  });
  it('takes the speed of measured curves for the others', () => {
    const scan = { unit: 'mm', curves: [{ ...curve([[0, 0], [20, 1]]), length: 40 }, curve([[0, 0], [10, 1]])] };
    expect(rawnetOf(scan).split('\n').filter(Boolean).at(-1)).toBe('20 1 0 0 0 0 1');
  });
  it('knows its nodes', () => {
    const closed = curve([[0, 0], [10, 3], [29, 0]]);
    expect(isClosed(closed)).toBe(true);
    expect(isClosed(curve([[0, 0], [29, 1]]))).toBe(false);
    expect(nextNode({ unit: 'mm', curves: [closed] })).toBe(4);
    expect(nextNode(emptyScan())).toBe(0);
    expect(betweenNodes(curve([[5, 0], [25, 1]])).readings.length).toBe(21);
  });
  it('says what is missing', () => {
    const scan = (...curves: PhoneCurve[]) => problemOf({ unit: 'mm', curves });
    expect(scan()).toMatch(/Two curves/);
    expect(scan(curve([[0, 0]]), curve([[0, 0], [20, 1]]))).toMatch(/fewer than two nodes/);
    expect(scan(curve([[0, 0], [5, 1]]), curve([[0, 0], [20, 1]]))).toMatch(/only 6 readings/);
    expect(scan(curve([[0, 0], [20, 1]]), curve([[0, 2], [20, 3]]))).toMatch(/share a node/);
    expect(scan(curve([[0, 0], [20, 1]]), curve([[0, 0], [20, 1]]))).toBeNull();
  });
});
