import { describe, expect, it } from 'vitest';
import { handlesFile } from '../../src/rooms/bending';
import { stepOf } from '../../src/rooms/process';
import { completed } from '../../src/rooms/sketching';
import { length, shown, shownUnit } from '../../src/ui/numbers';

type Place = [number, number, number];

describe('symmetry', () => {
  const half: Place[] = [[0.01, 0, 0], [1, 1, 0], [1, 2, 0], [-0.01, 3, 0]];
  it('closes a stroke that begins and ends in the plane by its image, once through each end', () => {
    expect(completed(half, 'x', 0, 0.1)).toEqual([
      { points: [[0, 0, 0], [1, 1, 0], [1, 2, 0], [0, 3, 0], [-1, 2, 0], [-1, 1, 0]], closed: true },
    ]);
  });
  it('goes on through the plane where a stroke begins or ends in it', () => {
    expect(completed(half.slice(0, 2), 'x', 0, 0.1)).toEqual([{ points: [[1, 1, 0], [0, 0, 0], [-1, 1, 0]] }]);
    expect(completed(half.slice(2), 'x', 0, 0.1)).toEqual([{ points: [[1, 2, 0], [0, 3, 0], [-1, 2, 0]] }]);
  });
  it('leaves a stroke in the plane, or across it, alone, and gives others an image', () => {
    expect(completed([[0.05, 0, 1], [-0.05, 2, 1]], 'x', 0, 0.1)).toEqual([{ points: [[0, 0, 1], [0, 2, 1]] }]);
    expect(completed([[-1, 0, 0], [1, 0, 0]], 'x', 0, 0.1)).toEqual([{ points: [[-1, 0, 0], [1, 0, 0]] }]);
    expect(completed([[3, 0, 0], [4, 0, 0]], 'x', 2, 0.1)).toEqual([{ points: [[3, 0, 0], [4, 0, 0]] }, { points: [[1, 0, 0], [0, 0, 0]] }]);
  });
});

describe('steps', () => {
  const settings = {
    fairMethod: 'auto', keepBoundary: false, vertices: 100, adaptivity: 0.1, keepEdges: 30, remove: 50, scheme: 'linear', levels: 1,
    weld: 'auto', weldLength: 0.01, orient: false, holes: 'none', holeEdges: 50, energy: 'bend', detail: 'none',
  } as const;
  it('of repair have the command line that does the same', () => {
    expect(stepOf('repair', settings, 'a b').command).toBe('batten repair a-b.ply -o a-b-repair.ply');
    const all = stepOf('repair', { ...settings, weld: 'length', orient: true, holes: 'all' }, 'a');
    expect(all.command).toBe('batten repair a.ply -o a-repair.ply --weld 0.01% --orient --fill-holes all');
    expect(all.request).toEqual({ kind: 'repair', weld: true, weld_length: { value: 0.0001, kind: 'relative' }, orient: true, fill_holes: 2147483647 });
    expect(stepOf('repair', { ...settings, weld: 'off' }, 'a').request).toMatchObject({ weld: false, weld_length: null, fill_holes: 0 });
  });
  it('of deformation have their handles as a file of the command line', () => {
    const request = { kind: 'deform', fixed: [0, 1], moved: [{ vertices: [7], translation: [0, 0, 1], axis: [0, 0, 1], angle: Math.PI / 2, about: [1, 1, 1] }] };
    expect(JSON.parse(handlesFile(request))).toEqual({
      fixed: { vertices: [0, 1] },
      handles: [{ select: { vertices: [7] }, translate: [0, 0, 1], rotate_deg: [0, 0, 1, 90], about: [1, 1, 1] }],
    });
  });
});

describe('units', () => {
  it('change what is shown and not what is, where the unit of the numbers is known', () => {
    shownUnit.value = 'in';
    expect(length(25.4, 'mm')).toBe('1 in');
    expect(length(25.4 ** 2, 'mm', 2)).toBe('1 in²');
    expect(length(2, '')).toBe('2');
    expect(shown('furlong')).toEqual({ factor: 1, unit: 'furlong' });
    shownUnit.value = '';
    expect(length(2.5, 'mm')).toBe('2.5 mm');
  });
});
