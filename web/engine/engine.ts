/** The engine as the page sees it: ask and be answered, hear of progress, stop. */
import type { Answer, Message, Reply, Request, Success } from './messages';

export type Listener = (stage: string, fraction: number) => void;

/** An answer that is a failure, as an error: `message` is the engine's own sentence. */
export class EngineError extends Error {
  constructor(
    message: string,
    readonly kind: string,
    readonly remedy?: string,
  ) {
    super(message);
  }
}

/** Whoever carries out messages: a worker of the page, or a server. */
export interface AnyEngine {
  readonly name: string;
  start(keep: boolean): Promise<Success>;
  /** One message. `bytes` are handed over: the caller loses them. @throws EngineError */
  ask(message: Message, bytes?: ArrayBuffer, onProgress?: Listener): Promise<Success>;
  end(): void;
}

/** An engine that keeps what is done in the browser, also what another engine does. */
export interface KeepingEngine extends AnyEngine {
  keep(message: Message, bytes: ArrayBuffer | undefined, replaced: boolean): Promise<Success>;
  /** The project is with another: from here on it only keeps, and its memory is given back. */
  rest(): Promise<Success>;
}

interface Pending {
  resolve: (answer: Success) => void;
  reject: (error: EngineError) => void;
  onProgress?: Listener | undefined;
}

export class Engine implements KeepingEngine {
  readonly name = 'engine in this page';
  private worker: Worker | null = null;
  private pending = new Map<number, Pending>();
  private next = 1;

  constructor(private makeWorker: () => Worker) {}

  /** Starts, or starts again, with what the journal holds. */
  async start(keep: boolean): Promise<Success> {
    this.begin();
    return this.send((id) => ({ kind: 'start', id, keep }));
  }
  async rest(): Promise<Success> {
    this.begin();
    return this.send((id) => ({ kind: 'rest', id }));
  }

  private begin(): void {
    this.end();
    const worker = this.makeWorker();
    this.worker = worker;
    worker.onmessage = (event: MessageEvent<Reply>) => this.hear(event.data);
    worker.onerror = (event) => this.fail(new EngineError(event.message || 'the worker could not be started', 'gone'));
  }

  ask(message: Message, bytes?: ArrayBuffer, onProgress?: Listener): Promise<Success> {
    return this.send(
      (id) => (bytes ? { kind: 'ask', id, message, bytes } : { kind: 'ask', id, message }),
      bytes ? [bytes] : [],
      onProgress,
    );
  }

  keep(message: Message, bytes: ArrayBuffer | undefined, replaced: boolean): Promise<Success> {
    return this.send(
      (id) => (bytes ? { kind: 'keep', id, message, bytes, replaced } : { kind: 'keep', id, message, replaced }),
      bytes ? [bytes] : [],
    );
  }

  /** Ends the worker whatever it does; what was asked fails as cancelled. The project is in the journal. */
  end(): void {
    this.worker?.terminate();
    this.worker = null;
    this.fail(new EngineError('stopped', 'cancelled'));
  }

  private send(make: (id: number) => Request, transfer: Transferable[] = [], onProgress?: Listener): Promise<Success> {
    const id = this.next++;
    return new Promise((resolve, reject) => {
      if (!this.worker) {
        reject(new EngineError('the engine is not running', 'gone'));
        return;
      }
      this.pending.set(id, { resolve, reject, onProgress });
      this.worker.postMessage(make(id), transfer);
    });
  }

  private hear(reply: Reply): void {
    const pending = this.pending.get(reply.id);
    if (!pending) return;
    if (reply.kind === 'progress') {
      pending.onProgress?.(reply.stage, reply.fraction);
      return;
    }
    this.pending.delete(reply.id);
    const answer: Answer = reply.answer;
    if (answer.ok) pending.resolve(answer);
    else pending.reject(new EngineError(answer.message, answer.kind, answer.remedy));
  }

  private fail(error: EngineError): void {
    const all = [...this.pending.values()];
    this.pending.clear();
    for (const one of all) one.reject(error);
  }
}
