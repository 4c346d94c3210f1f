import { afterEach, describe, expect, it, vi } from 'vitest';
import { type Entry, formatEntry, Journal, parseJournal } from '../../engine/journal';

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

/** A disk that a kill stops between any two bytes. */
class Disk {
  bytes: number[] = [];
  steps = 0;
  killAfter = Infinity;
  room = Infinity;

  private step(): void {
    if (++this.steps > this.killAfter) throw new Error('killed');
  }
  /** What the journal asks of the browser's file. */
  storage() {
    const handle = {
      getSize: () => this.bytes.length,
      read: (into: Uint8Array) => into.set(this.bytes),
      truncate: (size: number) => {
        this.step();
        this.bytes.length = size;
      },
      write: (data: Uint8Array, { at }: { at: number }) => {
        const fits = data.slice(0, Math.max(0, this.room - at));
        fits.forEach((byte, i) => {
          this.step();
          this.bytes[at + i] = byte;
        });
        return fits.length;
      },
      flush: () => this.step(),
    };
    return { getDirectory: async () => ({ getFileHandle: async () => ({ createSyncAccessHandle: async () => handle }) }) };
  }
  async journal() {
    vi.stubGlobal('navigator', { storage: this.storage() });
    const opened = await Journal.open();
    if (!opened) throw new Error('no journal');
    return opened;
  }
}

describe('a page that is killed', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('loses at most the edit in flight, at 1,000 moments', async () => {
    let seed = 7;
    const below = (n: number) => {
      seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
      return Math.floor((seed / 2 ** 32) * n);
    };
    let drag = 0;
    const entries: Entry[] = Array.from({ length: 30 }, (_, k) => {
      if (below(3) === 0) ++drag;
      const message = { op: 'edit', edit: { op: 'request', value: below(1000) }, drag: below(2) ? drag : 0, k };
      return below(4) === 0 ? { message, bytes: bytes(...Array.from({ length: below(40) }, () => below(256))) } : { message };
    });
    /** What is there after the first n: of a drag the last. */
    const kept = (n: number) =>
      entries.slice(0, n).reduce<number[]>((list, { message }, k) => {
        const before = entries[k - 1]?.message;
        return [...(k > 0 && message.drag !== 0 && before?.drag === message.drag ? list.slice(0, -1) : list), k];
      }, []);
    const whole = new Disk();
    const { journal } = await whole.journal();
    for (const entry of entries) journal.append(entry);
    let n_lost = 0;
    for (let kill = 0; kill < 1000; ++kill) {
      const disk = new Disk();
      disk.killAfter = 1 + below(whole.steps);
      let n = 0;
      try {
        const { journal } = await disk.journal();
        for (; n < entries.length; ++n) journal.append(entries[n] as Entry);
      } catch {
        // as it was left
      }
      disk.killAfter = Infinity;
      const again = await disk.journal();
      const found = again.entries.map((one) => one.message.k);
      // Without the edit in flight, with it, or without the drag that it was to go on with.
      const before = kept(n);
      const goesOn = kept(n + 1).length === before.length;
      expect([before, kept(n + 1), ...(goesOn ? [before.slice(0, -1)] : [])]).toContainEqual(found);
      n_lost += found.length < kept(n + 1).length ? 1 : 0;
      again.journal.append({ message: { op: 'edit', k: -1 } });
      expect(parseJournal(new Uint8Array(disk.bytes)).entries.map((one) => one.message.k)).toEqual([...found, -1]);
    }
    expect(n_lost).toBeGreaterThan(100); // kills hit what was being written
  });
});

describe('a disk that is full', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('leaves whole records, and no gap between them', async () => {
    const disk = new Disk();
    const { journal } = await disk.journal();
    const entry = (k: number, size = 0) => ({ message: { op: 'edit', k }, ...(size ? { bytes: new ArrayBuffer(size) } : {}) });
    expect(journal.append(entry(1))).toBe(true);
    disk.room = disk.bytes.length + 100;
    expect(journal.append(entry(2, 500))).toBe(false);
    expect(journal.append(entry(3))).toBe(false); // it would fit, and would be played without what was before
    expect(parseJournal(new Uint8Array(disk.bytes)).entries.map((one) => one.message.k)).toEqual([1]);
    journal.clear();
    expect(journal.append(entry(4))).toBe(true);
  });
});
