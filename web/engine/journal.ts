/**
 * The journal of a page: every message that changed the project, with the bytes that came with it, in a file of the
 * origin's private file system. A page that is killed loses at most the message in flight. Records are appended whole:
 * 8 bytes with the lengths of text and bytes, then both; a torn record at the end is dropped.
 */
import type { Message } from './messages';

const FILE = 'journal';

export interface Entry {
  message: Message;
  bytes?: ArrayBuffer;
}

/** The whole records of a journal, and where the last of them ends. */
export function parseJournal(data: Uint8Array): { entries: Entry[]; end: number } {
  const entries: Entry[] = [];
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  let at = 0;
  while (at + 8 <= data.byteLength) {
    const nText = view.getUint32(at, true);
    const nBytes = view.getUint32(at + 4, true);
    const end = at + 8 + nText + nBytes;
    if (end > data.byteLength) break;
    let message: Message;
    try {
      message = JSON.parse(new TextDecoder().decode(data.subarray(at + 8, at + 8 + nText))) as Message;
    } catch {
      break;
    }
    const bytes = data.slice(at + 8 + nText, end);
    entries.push(nBytes > 0 ? { message, bytes: bytes.buffer } : { message });
    at = end;
  }
  return { entries, end: at };
}

/** One record. */
export function formatEntry(entry: Entry): Uint8Array {
  const text = new TextEncoder().encode(JSON.stringify(entry.message));
  const nBytes = entry.bytes?.byteLength ?? 0;
  const data = new Uint8Array(8 + text.length + nBytes);
  const view = new DataView(data.buffer);
  view.setUint32(0, text.length, true);
  view.setUint32(4, nBytes, true);
  data.set(text, 8);
  if (entry.bytes) data.set(new Uint8Array(entry.bytes), 8 + text.length);
  return data;
}

/** Whether two messages are of one drag of one thing, so that the later stands for both. */
function sameDrag(a: Message, b: Message): boolean {
  return typeof a.drag === 'number' && a.drag !== 0 && a.drag === b.drag;
}

/** A page that was just closed, or a worker that was ended, holds its file a moment longer. */
async function patiently<T>(open: () => Promise<T>): Promise<T> {
  for (let tries = 0; ; ++tries) {
    try {
      return await open();
    } catch (error) {
      if (tries === 8) throw error;
      await new Promise((resolve) => setTimeout(resolve, 250));
    }
  }
}

export class Journal {
  private isFull = false;
  private last: { message: Message; from: number } | null = null;

  private constructor(
    private handle: FileSystemSyncAccessHandle,
    private end: number,
  ) {}

  /** Null where the browser has no such files, or another page holds the journal. */
  static async open(): Promise<{ journal: Journal; entries: Entry[] } | null> {
    try {
      const root = await navigator.storage.getDirectory();
      const file = await root.getFileHandle(FILE, { create: true });
      const handle = await patiently(() => file.createSyncAccessHandle());
      const data = new Uint8Array(handle.getSize());
      handle.read(data, { at: 0 });
      const { entries, end } = parseJournal(data);
      handle.truncate(end);
      return { journal: new Journal(handle, end), entries };
    } catch {
      return null;
    }
  }

  /** @returns false where there is no room for it: the journal ends before it then, and takes no more. */
  append(entry: Entry): boolean {
    if (this.isFull) return false;
    let from = this.end;
    if (this.last && sameDrag(this.last.message, entry.message)) from = this.last.from;
    const data = formatEntry(entry);
    this.handle.truncate(from);
    try {
      // Some browsers throw where there is no room, others write what fits.
      this.isFull = this.handle.write(data, { at: from }) < data.byteLength;
    } catch {
      this.isFull = true;
    }
    if (this.isFull) this.handle.truncate(from);
    this.handle.flush();
    this.last = { message: entry.message, from };
    this.end = from + (this.isFull ? 0 : data.byteLength);
    return !this.isFull;
  }

  /** A project that begins anew needs nothing of what was before. */
  clear(): void {
    this.handle.truncate(0);
    this.handle.flush();
    this.end = 0;
    this.last = null;
    this.isFull = false;
  }
}
