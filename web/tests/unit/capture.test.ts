import { describe, expect, it } from 'vitest';
import { asksForWheel, sourceText } from '../../src/rooms/capture';
import { freeName, nodeKey } from '../../src/rooms/capturing';
import { piecesOf } from '../../src/view/track';

describe('the source of a capture', () => {
  it('is written as `batten capture` takes it', () => {
    expect(sourceText('simulator:torus', 'morphorider', '', '1')).toBe('simulator:torus');
    expect(sourceText('simulator:torus', 'line', 'flip=1%', 'max')).toBe('simulator:torus?device=line&flip=1%&speed=max');
    expect(sourceText('line:/dev/ttyUSB0', 'line', 'flip=1%', 'max')).toBe('line:/dev/ttyUSB0');
  });
  it('needs the length of the wheel where the device does not say it', () => {
    expect(['simulator:torus', 'simulator:torus?flip=1%', 'morphorider:/dev/ttyUSB0'].map(asksForWheel)).toEqual([true, true, true]);
    expect(['simulator:torus?device=line', 'line:/dev/ttyUSB0', 'udp:9000'].map(asksForWheel)).toEqual([false, false, false]);
  });
});

describe('keys of a capture', () => {
  it('are those of the numeric pad', () => {
    expect(['+', '-', '0', '9', '.', '/', '*', 'Enter', 'Backspace'].map(nodeKey)).toEqual(['+', '-', '0', '9', '.', '/', '*', 'enter', 'backspace']);
    expect(['q', 'F5', ' ', 'Escape', '12', ''].map(nodeKey)).toEqual([null, null, null, null, null, null]);
  });
  it('leave names of recordings alone that there are', () => {
    expect(freeName([])).toBe('recording.blog');
    expect(freeName(['recording.blog', 'recording 2.blog', 'hull.blog'])).toBe('recording 3.blog');
  });
});

describe('the track of a capture', () => {
  const points = new Float32Array([1, 0, 0, 0, 1, 1, 1, 0, 0, 0, 2, 5, 5, 5, 0, 2, 6, 5, 5, 0]);
  it('is drawn by pieces between points of one curve', () => {
    expect([...piecesOf(points, 0)]).toEqual([0, 0, 0, 1, 0, 0, 5, 5, 5, 6, 5, 5]);
  });
  it('goes on from the point before what is new', () => {
    expect([...piecesOf(points, 3)]).toEqual([5, 5, 5, 6, 5, 5]);
    expect([...piecesOf(points, 2)]).toEqual([5, 5, 5, 6, 5, 5]); // another curve begins
    expect([...piecesOf(points, 4)]).toEqual([]);
  });
});
