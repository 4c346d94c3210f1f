/** What the page and its worker say to each other. Lengths are in the unit of the object, angles in radians. */
import type { EngineArray } from 'batten-engine';

/** A message of the engine (docs/engine.md): "op" and what belongs to it. */
export interface Message {
  op: string;
  [field: string]: unknown;
}

/** To the worker. Every request gets exactly one `done`, unless the worker is ended before. */
export type Request =
  | { kind: 'start'; id: number; keep: boolean } // keep: write the journal, and play what is in it
  | { kind: 'ask'; id: number; message: Message; bytes?: ArrayBuffer }; // transferred: the sender loses it

/** From the worker. */
export type Reply =
  | { kind: 'progress'; id: number; stage: string; fraction: number } // 0 to 1 of the stage
  | { kind: 'done'; id: number; answer: Answer };

/** What went wrong, in words, with the remedy where there is one. */
export interface Failure {
  ok: false;
  kind: 'error' | 'refused' | 'cancelled' | 'memory' | 'fault';
  message: string;
  remedy?: string;
}

export interface Success {
  ok: true;
  json: Record<string, unknown>;
  arrays: Record<string, EngineArray>;
}

export type Answer = Success | Failure;

/** Whether a message changes the project, so that it belongs into the journal. */
export function isEdit(message: Message): boolean {
  return message.op === 'open' || message.op === 'edit';
}
