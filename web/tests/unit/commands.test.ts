import { describe, expect, it } from 'vitest';
import { register, search } from '../../src/ui/commands';
import { degrees, length, milliseconds, short } from '../../src/ui/numbers';

describe('commands', () => {
  it('are found by all their words in any order, those that can be run first', () => {
    register(
      { id: 'a', title: 'Save a picture', when: () => false, run: () => {} },
      { id: 'b', title: 'Save the project', run: () => {} },
      { id: 'c', title: 'Open a file', run: () => {} },
    );
    expect(search('save').map((one) => one.id)).toEqual(['b', 'a']);
    expect(search('PICTURE save').map((one) => one.id)).toEqual(['a']);
    expect(search('nothing')).toEqual([]);
  });
  it('refuse one key for two', () => {
    register({ id: 'd', title: 'D', keys: 'Q', run: () => {} });
    expect(() => register({ id: 'e', title: 'E', keys: 'Q', run: () => {} })).toThrow(/same keys Q/);
  });
});

describe('numbers', () => {
  it('are as people read them', () => {
    expect(short(60572)).toBe('60,572');
    expect(short(0.0123456)).toBe('0.01235');
    expect(short(Number.NaN)).toBe('–');
    expect(length(2.5, 'mm')).toBe('2.5 mm');
    expect(degrees(Math.PI / 360)).toBe('0.5°');
    expect(milliseconds(38.4)).toBe('38 ms');
    expect(milliseconds(1240)).toBe('1.24 s');
  });
});
