import { describe, expect, it } from 'vitest';
import { EngineError, type KeepingEngine } from '../../engine/engine';
import type { Message, Success } from '../../engine/messages';
import { Store } from '../../src/document/store';

/** An engine that knows names of objects, and what it was told to keep. */
class Fake implements KeepingEngine {
  readonly name = 'fake';
  journal: Message[] = [];
  asked: Message[] = [];
  starts = 0;
  isGone = false;
  isFull = false;

  private ok(json: Record<string, unknown> = {}): Success {
    return { ok: true, json: { ok: true, ...json }, arrays: {} };
  }
  async start(): Promise<Success> {
    ++this.starts;
    this.isGone = false;
    return this.ok({ kept: true, played: 0, failed: 0 });
  }
  async rest(): Promise<Success> {
    return this.ok({ kept: true });
  }
  async keep(message: Message): Promise<Success> {
    this.journal.push(message);
    return this.ok({ kept: !this.isFull });
  }
  async ask(message: Message): Promise<Success> {
    if (this.isGone) throw new EngineError('the server is gone', 'gone');
    this.asked.push(message);
    if (message.op === 'document')
      return this.ok({ objects: [{ id: 'o1', name: 'sheet', kind: 'mesh', version: 1 }], outdated: [], can_undo: true, can_redo: false, log: [] });
    if (message.op === 'save') return { ...this.ok(), arrays: { file: new Uint8Array(3) } };
    return this.ok({ kept: !this.isFull });
  }
  end(): void {}
}

describe('the project', () => {
  it('is kept by the page whichever engine has it, and comes back when that is gone', async () => {
    const own = new Fake();
    const server = new Fake();
    const store = new Store(own);
    await store.start(true);
    await store.moveTo(server);
    await store.edit({ op: 'rename', object: 'o1', name: 'hull' });
    expect(server.asked.some((one) => one.op === 'edit')).toBe(true);
    expect(own.journal.map((one) => one.op)).toEqual(['open', 'edit']);
    server.isGone = true;
    expect(await store.edit({ op: 'undo' })).toBe(false);
    expect(store.engine).toBe(own);
    expect(own.starts).toBe(2);
    expect(own.journal.length).toBe(2); // not the edit in flight
    expect(store.notices.value.map((one) => one.text)).toEqual([
      'The engine was started again, in this page. The project is as it was before.',
      'the server is gone',
    ]);
    expect(await store.edit({ op: 'undo' })).toBe(true);
  });

  it('says once that there is no room to keep it', async () => {
    const own = new Fake();
    const store = new Store(own);
    await store.start(true);
    own.isFull = true;
    await store.edit({ op: 'undo' });
    await store.edit({ op: 'undo' });
    expect(store.kept.value).toBe(false);
    expect(store.notices.value.filter((one) => /no room/.test(one.text)).length).toBe(1);
    own.isFull = false;
    await store.clear(); // another project, which there is room for
    expect(store.kept.value).toBe(true);
    own.isFull = true;
    await store.edit({ op: 'undo' });
    expect(store.kept.value).toBe(false);
    own.isGone = true; // nothing to start again from: it must not begin empty
    await store.edit({ op: 'undo' });
    expect(own.starts).toBe(1);
  });
});
