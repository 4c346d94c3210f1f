/** Captures by `batten studio`: a device of the server followed live, its keys, recordings replayed and made into scans. */
import { effect, signal } from '@preact/signals';
import { SocketEngine } from '../../engine/socket';
import type { App } from '../app';
import type { ServerFile } from '../document/server';
import { keysOf, register } from '../ui/commands';
import { Track } from '../view/track';

export interface SourceEntry {
  source: string;
  what: string;
}

/** The live view; lengths in metres. */
export interface CaptureState {
  seconds: number;
  /** "open", "lost REASON", "back", "end". */
  device: string;
  curves: number;
  drawing: boolean;
  paused: boolean;
  digits: string;
  nodes: number;
  distance_m: number;
  position: [number, number, number];
  placed: boolean;
  drift_m: number | null;
  drift_way_m: number;
  drift_node: number;
  rate_hz: number;
  jitter_s: number;
  readings: number;
  refused: number;
  missing: number;
  gaps: number;
}

export interface CaptureNews {
  /** The number of the capture. */
  id: number;
  doing: 'nothing' | 'record' | 'replay' | 'convert';
  name: string;
  file: number;
  source: string;
  first: number;
  state: CaptureState | null;
  /** When the oldest reading among what is new was taken, milliseconds since 1970; null where time runs otherwise. */
  sampled_ms: number | null;
  report: { figures: Record<string, unknown> & { curves: number; end: string; decoded?: { readings: number; refused: number; missing: number } }; warnings: string[] } | null;
  problem: string | null;
}

/** A key of the page as the device's keys are called; null for others. */
export function nodeKey(key: string): string | null {
  if (/^[-+0-9./*]$/.test(key)) return key;
  return ({ Enter: 'enter', Backspace: 'backspace' } as Record<string, string>)[key] ?? null;
}

/** The first name of a recording that there is not yet. */
export function freeName(names: readonly string[]): string {
  for (let i = 1; ; ++i) {
    const name = i === 1 ? 'recording.blog' : `recording ${i}.blog`;
    if (!names.includes(name)) return name;
  }
}

/** Figures change in the panel so often; the picture follows every message. */
const BETWEEN_FIGURES_MS = 100;
const BETWEEN_ATTEMPTS_MS = 1000;
const KEPT_DELAYS = 1000;

export class Capturing {
  readonly isLinked = signal(false);
  readonly sources = signal<SourceEntry[]>([]);
  readonly recordings = signal<ServerFile[]>([]);
  readonly folder = signal<string | null>(null);
  readonly news = signal<CaptureNews | null>(null);
  /** From a reading to the picture being asked for, of the last thousand messages. */
  readonly delays = signal<{ median: number; most: number; largest: number } | null>(null);
  private readonly socket = new SocketEngine(`${location.origin.replace(/^http/, 'ws')}/capture`);
  private readonly track = new Track();
  private latest: CaptureNews | null = null;
  private kept: number[] = [];
  private timer: ReturnType<typeof setTimeout> | null = null;
  private isShown = false;

  constructor(private app: App) {
    const here = () => app.room.value === 'capture';
    const isBusy = () => (this.news.value?.doing ?? 'nothing') !== 'nothing';
    register(
      { id: 'capture-stop', title: 'Stop the capture', keys: 'Ctrl+Enter', when: isBusy, run: () => this.stop() },
      { id: 'capture-scan', title: 'Make a scan of what was captured', when: () => here() && !isBusy() && this.news.value?.report != null, run: () => this.openScan() },
    );
    // Before other commands: digits are views elsewhere, plus and minus zoom.
    window.addEventListener('keydown', (event) => this.hearKey(event), { capture: true });
    this.socket.onEvent = (json, arrays) => this.hear(json as unknown as CaptureNews, arrays.points as Float32Array);
    this.socket.onGone = () => {
      this.isLinked.value = false;
      setTimeout(() => void this.link(), BETWEEN_ATTEMPTS_MS);
    };
    effect(() => this.setShown(here()));
    void this.link();
  }

  private async link(): Promise<void> {
    try {
      await this.socket.start();
      this.isLinked.value = true;
      await this.look();
    } catch {
      // onGone tries again
    }
  }

  /** What there is now. */
  async look(): Promise<void> {
    await this.tellFaults(async () => {
      const { json } = await this.socket.ask({ op: 'sources' });
      this.sources.value = json.sources as SourceEntry[];
      this.recordings.value = json.recordings as ServerFile[];
      this.folder.value = json.folder as string | null;
    });
  }

  async record(options: { source: string; name: string; wheel_m?: number; nodes?: number; calibration?: string }): Promise<void> {
    await this.tellFaults(() => this.socket.ask({ op: 'record', ...options }));
  }

  async replay(file: ServerFile, speed: number): Promise<void> {
    await this.tellFaults(() => this.socket.ask({ op: 'replay', file: file.number, name: file.name, speed }));
  }

  async stop(): Promise<void> {
    await this.tellFaults(() => this.socket.ask({ op: 'stop' }));
  }

  async press(key: string): Promise<void> {
    await this.tellFaults(() => this.socket.ask({ op: 'key', key }));
  }

  /** A recording becomes a scan of the project, with its network and surface. */
  async openScan(file?: ServerFile): Promise<void> {
    const { news } = this;
    const wanted = file ?? (news.value ? { number: news.value.file, name: news.value.name, size: 0 } : null);
    if (!wanted) return;
    await this.tellFaults(async () => {
      const { json, arrays } = await this.socket.ask({ op: 'convert', file: wanted.number, name: wanted.name });
      for (const text of json.warnings as string[]) this.app.store.tell('warning', `${wanted.name}: ${text}`);
      const name = wanted.name.replace(/^.*\//, '').replace(/\.blog$/, '.rawnet');
      await this.app.openFiles([[name, new Blob([arrays.file as Uint8Array<ArrayBuffer>])] as const]);
    });
  }

  private async tellFaults(body: () => Promise<unknown>): Promise<void> {
    try {
      await body();
    } catch (error) {
      this.app.store.tell('error', error instanceof Error ? error.message : String(error));
    }
  }

  private hearKey(event: KeyboardEvent): void {
    const target = event.target as HTMLElement | null;
    if (this.app.room.value !== 'capture' || this.latest?.doing !== 'record') return;
    if (target?.matches?.('input, textarea, select, dialog *')) return;
    // Enter and space belong to a button that has the focus.
    if (event.key === 'Enter' && target?.matches?.('button, summary')) return;
    const key = keysOf(event).includes('Ctrl+') || event.altKey ? null : nodeKey(event.key);
    if (!key) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!event.repeat) void this.press(key);
  }

  private hear(news: CaptureNews, points: Float32Array): void {
    const before = this.latest;
    if (before?.id !== news.id) this.kept = [];
    this.latest = news;
    if (news.state) this.track.write(this.isShown ? this.app.view : null, news.first, points, news.state.position);
    if (news.state && this.isShown) this.veil();
    if (news.sampled_ms !== null) {
      this.kept.push(performance.timeOrigin + performance.now() - news.sampled_ms);
      if (this.kept.length > KEPT_DELAYS) this.kept.shift();
    }
    if (before?.doing !== news.doing || before.id !== news.id) this.publish();
    else this.timer ??= setTimeout(() => this.publish(), BETWEEN_FIGURES_MS);
  }

  private publish(): void {
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = null;
    const isOver = this.news.value?.doing === 'record' && this.latest?.doing === 'nothing';
    this.news.value = this.latest;
    const sorted = [...this.kept].sort((a, b) => a - b);
    const at = (share: number) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0;
    this.delays.value = sorted.length > 0 ? { median: at(0.5), most: at(0.95), largest: at(1) } : null;
    if (isOver) void this.look();
  }

  /** The device's way is in metres from its first node: other objects make room for it. */
  private veil(): void {
    this.app.view?.veil(this.app.store.objects.value.map((one) => one.id));
  }

  private setShown(on: boolean): void {
    const { view } = this.app;
    if (!view || on === this.isShown) return;
    this.isShown = on;
    if (on && this.latest?.state) {
      this.track.show(view);
      this.veil();
    } else if (!on) {
      this.track.hide(view);
      view.veil([]);
      view.fit();
    }
  }
}

let made: Capturing | null = null;
/** The one of the page. */
export function capturingOf(app: App): Capturing {
  made ??= new Capturing(app);
  return made;
}
