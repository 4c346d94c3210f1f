/** The engine of `batten studio`, native, behind the same messages (docs/studio-server.md). */
import type { EngineArray } from 'batten-engine';
import { type AnyEngine, EngineError, type Listener } from './engine';
import type { Message, Success } from './messages';

/** Before the elements of an array: kind, id, count and type, 32 bits each. */
const HEAD_BYTES = 16;

interface Announced {
  name: string;
  type: 'float32' | 'uint32' | 'uint8';
  count: number;
}

interface Pending {
  resolve: (answer: Success) => void;
  reject: (error: EngineError) => void;
  onProgress?: Listener | undefined;
}

/** The elements of a binary frame. */
export function arrayOf(frame: ArrayBuffer, { type, count }: Announced): EngineArray {
  if (type === 'float32') return new Float32Array(frame, HEAD_BYTES, count);
  if (type === 'uint32') return new Uint32Array(frame, HEAD_BYTES, count);
  return new Uint8Array(frame, HEAD_BYTES, count);
}

export class SocketEngine implements AnyEngine {
  readonly name = 'native engine';
  /** What the server tells without being asked. */
  onEvent?: (json: Record<string, unknown>, arrays: Success['arrays']) => void;
  /** Called where the server closes the socket, or cannot be reached. */
  onGone?: () => void;
  private socket: WebSocket | null = null;
  private pending = new Map<number, Pending>();
  private next = 1;
  /** An answer whose arrays are still to come. */
  private coming: { id: number; json: Record<string, unknown>; left: Announced[]; arrays: Success['arrays'] } | null = null;

  constructor(private address: string) {}

  start(): Promise<Success> {
    this.end();
    return new Promise((resolve, reject) => {
      const socket = new WebSocket(this.address);
      socket.binaryType = 'arraybuffer';
      socket.onopen = () => resolve({ ok: true, json: { ok: true }, arrays: {} });
      socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.hear(event.data);
      socket.onclose = () => {
        const gone = new EngineError('the server is gone', 'gone');
        reject(gone);
        this.fail(gone);
        this.onGone?.();
      };
      this.socket = socket;
    });
  }

  ask(message: Message, bytes?: ArrayBuffer, onProgress?: Listener): Promise<Success> {
    const id = this.next++;
    return new Promise((resolve, reject) => {
      if (this.socket?.readyState !== WebSocket.OPEN) {
        reject(new EngineError('the server is gone', 'gone'));
        return;
      }
      this.pending.set(id, { resolve, reject, onProgress });
      this.socket.send(JSON.stringify(bytes ? { ...message, id, bytes: bytes.byteLength } : { ...message, id }));
      if (bytes) this.socket.send(bytes);
    });
  }

  /** Asks what runs to stop; it answers as cancelled, and the project is as before. */
  cancel(): void {
    for (const target of this.pending.keys()) this.socket?.send(JSON.stringify({ id: this.next++, op: 'cancel', target }));
  }

  end(): void {
    const { socket } = this;
    this.socket = null;
    if (socket) socket.onclose = null;
    socket?.close();
    this.fail(new EngineError('stopped', 'cancelled'));
  }

  private hear(data: string | ArrayBuffer): void {
    if (typeof data !== 'string') {
      const announced = this.coming?.left.shift();
      if (!this.coming || !announced) return;
      this.coming.arrays[announced.name] = arrayOf(data, announced);
      this.settle();
      return;
    }
    const json = JSON.parse(data) as Record<string, unknown>;
    const id = Number(json.id);
    if (json.event === 'progress') {
      this.pending.get(id)?.onProgress?.(String(json.stage), Number(json.fraction));
      return;
    }
    this.coming = { id, json, left: [...((json.arrays as Announced[] | undefined) ?? [])], arrays: {} };
    this.settle();
  }

  private settle(): void {
    if (!this.coming || this.coming.left.length > 0) return;
    const { id, json, arrays } = this.coming;
    this.coming = null;
    if (json.event) {
      this.onEvent?.(json, arrays);
      return;
    }
    const pending = this.pending.get(id);
    this.pending.delete(id);
    if (json.ok === true) pending?.resolve({ ok: true, json, arrays });
    else pending?.reject(new EngineError(String(json.message), String(json.kind), json.remedy as string | undefined));
  }

  private fail(error: EngineError): void {
    const all = [...this.pending.values()];
    this.pending.clear();
    for (const one of all) one.reject(error);
  }
}
