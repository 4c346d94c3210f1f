import { describe, expect, it } from 'vitest';
import { formatEntry, parseJournal } from '../../engine/journal';

const bytes = (...list: number[]) => new Uint8Array(list).buffer;

function joined(...parts: Uint8Array[]): Uint8Array {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

describe('the journal', () => {
  const open = { message: { op: 'open', name: 'ä.ply' }, bytes: bytes(1, 2, 3) };
  const edit = { message: { op: 'edit', edit: { op: 'undo' } } };

  it('gives back what was written', () => {
    const { entries, end } = parseJournal(joined(formatEntry(open), formatEntry(edit)));
    expect(entries.map((one) => one.message)).toEqual([open.message, edit.message]);
    expect([...new Uint8Array(entries[0]?.bytes ?? new ArrayBuffer(0))]).toEqual([1, 2, 3]);
    expect(entries[1]?.bytes).toBeUndefined();
    expect(end).toBe(formatEntry(open).length + formatEntry(edit).length);
  });

  it('drops a record that was torn, wherever it was', () => {
    const whole = joined(formatEntry(open), formatEntry(edit));
    const first = formatEntry(open).length;
    for (let n = 0; n < whole.length; ++n) {
      const { entries, end } = parseJournal(whole.slice(0, n));
      expect(entries.length).toBe(n < first ? 0 : 1);
      expect(end).toBe(n < first ? 0 : first);
    }
  });
});
