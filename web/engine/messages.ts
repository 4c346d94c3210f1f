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
  | { kind: 'rest'; id: number } // instead of start: no engine, only the journal
  | { kind: 'ask'; id: number; message: Message; bytes?: ArrayBuffer } // transferred: the sender loses it
  // Carried out by another engine: the journal alone takes it, after it forgot what was before where that was replaced.
  | { kind: 'keep'; id: number; message: Message; bytes?: ArrayBuffer; replaced: boolean };

/** From the worker. */
export type Reply =
  | { kind: 'progress'; id: number; stage: string; fraction: number } // 0 to 1 of the stage
  | { kind: 'done'; id: number; answer: Answer };

/** What went wrong, in words, with the remedy where there is one. */
export interface Failure {
  ok: false;
  kind: 'error' | 'refused' | 'cancelled' | 'memory' | 'fault' | 'gone'; // gone: it answers nothing any more
  message: string;
  remedy?: string;
}

export interface Success {
  ok: true;
  json: Record<string, unknown>;
  arrays: Record<string, EngineArray>;
}

export type Answer = Success | Failure;

/** Whether a message changes the project, so that the journal takes it. */
export function isEdit(message: Message): boolean {
  return message.op === 'open' || message.op === 'edit' || message.op === 'new';
}
