/** The worker that holds the engine: one message after the other, in the order in which they come. */
import load, { type EngineModule, type NativeEngine } from 'batten-engine';
import wasm from 'batten-engine-wasm?url';
import { type Entry, Journal } from './journal';
import { type Answer, type Failure, isEdit, type Message, type Reply, type Request } from './messages';

const PROGRESS_EVERY_MS = 40;

let module: EngineModule | null = null;
let engine: NativeEngine | null = null;
let journal: Journal | null = null;

function post(reply: Reply, transfer: Transferable[] = []): void {
  self.postMessage(reply, { transfer });
}

function fault(error: unknown): Failure {
  const text = error instanceof Error ? error.message : String(error);
  const isMemory = /memory|OOM|abort/i.test(text);
  return {
    ok: false,
    kind: isMemory ? 'memory' : 'fault',
    message: isMemory ? 'the memory that the browser gives a page is not enough for this' : `the engine failed: ${text}`,
  };
}

function handle(message: Message, bytes: ArrayBuffer | undefined, id: number): Answer {
  if (!engine) return { ok: false, kind: 'fault', message: 'the engine has not started' };
  let told = 0;
  const progress = (stage: string, fraction: number): boolean => {
    const now = performance.now();
    if (now - told > PROGRESS_EVERY_MS) {
      told = now;
      post({ kind: 'progress', id, stage, fraction });
    }
    return true;
  };
  const result = engine.handle(JSON.stringify(message), bytes ? new Uint8Array(bytes) : '', progress);
  const json = JSON.parse(result.text) as Record<string, unknown>;
  return json.ok === true ? { ok: true, json, arrays: result.arrays } : (json as unknown as Failure);
}

async function start(keep: boolean): Promise<Answer> {
  module = await load({ locateFile: () => wasm });
  engine = new module.Engine();
  let entries: Entry[] = [];
  if (keep) {
    const opened = await Journal.open();
    if (opened) ({ journal, entries } = opened);
  }
  let played = 0;
  for (const entry of entries) if (handle(entry.message, entry.bytes, 0).ok) ++played;
  return {
    ok: true,
    json: { ok: true, kept: journal !== null, played, failed: entries.length - played },
    arrays: {},
  };
}

async function serve(request: Request): Promise<void> {
  let answer: Answer;
  try {
    if (request.kind === 'start') {
      answer = await start(request.keep);
    } else if (request.message.op === 'new' && module) {
      engine?.delete();
      engine = new module.Engine();
      journal?.clear();
      answer = { ok: true, json: { ok: true }, arrays: {} };
    } else {
      answer = handle(request.message, request.bytes, request.id);
      if (answer.ok && isEdit(request.message)) {
        if (answer.json.replaced === true) journal?.clear();
        journal?.append(request.bytes ? { message: request.message, bytes: request.bytes } : { message: request.message });
      }
    }
  } catch (error) {
    answer = fault(error);
  }
  post({ kind: 'done', id: request.id, answer }, answer.ok ? Object.values(answer.arrays).map((array) => array.buffer) : []);
}

// One after the other: what comes while the engine starts waits until the journal is there too.
let last: Promise<void> = Promise.resolve();
self.onmessage = (event: MessageEvent<Request>) => {
  last = last.then(() => serve(event.data));
};
