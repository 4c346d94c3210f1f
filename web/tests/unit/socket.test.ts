import { describe, expect, it } from 'vitest';
import { arrayOf } from '../../engine/socket';

describe('binary frames of the server', () => {
  const frame = (bytes: number[]) => new Uint8Array([...new Array<number>(16).fill(0), ...bytes]).buffer;

  it('become arrays of their type, behind a head of 16 bytes', () => {
    expect([...arrayOf(frame([0, 0, 128, 63, 0, 0, 0, 64]), { name: 'p', type: 'float32', count: 2 })]).toEqual([1, 2]);
    expect([...arrayOf(frame([5, 0, 0, 0, 0, 1, 0, 0]), { name: 't', type: 'uint32', count: 2 })]).toEqual([5, 256]);
    expect([...arrayOf(frame([7, 8, 9]), { name: 'file', type: 'uint8', count: 3 })]).toEqual([7, 8, 9]);
  });
  it('that are shorter than they say are an error, not rubbish', () => {
    expect(() => arrayOf(frame([0, 0]), { name: 'p', type: 'float32', count: 2 })).toThrow();
  });
});
