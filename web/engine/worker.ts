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
  engine = null; // what it throws it throws once
  return {
    ok: false,
    kind: 'gone',
    message: isMemory ? 'the memory that the browser gives a page is not enough for this' : `the engine failed: ${text}`,
  };
}

function handle(message: Message, bytes: ArrayBuffer | undefined, id: number): Answer {
  if (!engine) return { ok: false, kind: 'gone', message: 'the engine has not started' };
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

/** Keeps what was done. @returns whether it is kept. */
function keep({ message, bytes }: { message: Message; bytes?: ArrayBuffer }, replaced: boolean): boolean {
  if (!journal) return false;
  if (replaced || message.op === 'new') journal.clear();
  return message.op === 'new' || journal.append(bytes ? { message, bytes } : { message });
}

async function serve(request: Request): Promise<void> {
  let answer: Answer;
  try {
    if (request.kind === 'start') {
      answer = await start(request.keep);
    } else if (request.kind === 'rest') {
      journal = (await Journal.open())?.journal ?? null;
      answer = { ok: true, json: { ok: true, kept: journal !== null }, arrays: {} };
    } else if (request.kind === 'keep') {
      answer = { ok: true, json: { ok: true, kept: keep(request, request.replaced) }, arrays: {} };
    } else if (request.message.op === 'new' && module) {
      engine?.delete();
      engine = new module.Engine();
      answer = { ok: true, json: { ok: true, kept: keep(request, true) }, arrays: {} };
    } else {
      answer = handle(request.message, request.bytes, request.id);
      if (answer.ok && isEdit(request.message)) answer.json.kept = keep(request, answer.json.replaced === true);
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
