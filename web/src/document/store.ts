/**
 * The project as the page knows it. All that changes it goes through `edit` and `open`; what the engine says of it
 * afterwards stands in signals that the panels read. Knows nothing of the view.
 */
import { batch, computed, signal } from '@preact/signals';
import { type AnyEngine, EngineError, type KeepingEngine, type Listener } from '../../engine/engine';
import { SocketEngine } from '../../engine/socket';
import { isEdit, type Message, type Success } from '../../engine/messages';
import type { Continuity, Drawn, Edit, ObjectEntry, RequestOptions, Values } from './types';

export interface Notice {
  id: number;
  level: 'error' | 'warning' | 'info';
  text: string;
  remedy?: string;
}

export interface Work {
  what: string;
  stage: string;
  fraction: number;
}

/** Of previews while a slider moves: enough triangles to judge a shape by. */
const LIVE_EDGE_LENGTH = 0.02;
const CHECK_AFTER_MS = 1200;

export class Store {
  readonly objects = signal<ObjectEntry[]>([]);
  readonly outdated = signal<ReadonlySet<string>>(new Set());
  readonly canUndo = signal(false);
  readonly canRedo = signal(false);
  readonly log = signal<string[]>([]);
  readonly selected = signal<string | null>(null);
  readonly hidden = signal<ReadonlySet<string>>(new Set());
  readonly drawn = signal<ReadonlyMap<string, Drawn>>(new Map());
  readonly values = signal<Values | null>(null);
  readonly continuity = signal<Continuity | null>(null);
  readonly work = signal<Work | null>(null);
  readonly notices = signal<Notice[]>([]);
  readonly kept = signal(false);
  readonly started = signal(false);
  /** How long the last update took, from the request to what can be drawn. */
  readonly lastUpdate = signal<{ ms: number; coarse: boolean } | null>(null);

  readonly selectedObject = computed(() => this.objects.value.find((one) => one.id === this.selected.value) ?? null);

  private drag = 0;
  private noticeId = 0;
  private dragging = false;
  private sliding = false;
  private check: ReturnType<typeof setTimeout> | undefined;
  private waiting: { target: string; request: RequestOptions; show: string | null; rest: boolean; drag: number } | null = null;
  private shows = 0;

  readonly engineName = signal('');

  private current: AnyEngine;
  private recovering = false;

  /** @param own the page's engine; it keeps what is done, whichever engine does it. */
  constructor(private own: KeepingEngine) {
    this.current = own;
    this.engineName.value = own.name;
  }

  get engine(): AnyEngine {
    return this.current;
  }

  /** The project goes over to another engine, whole with its history. */
  async moveTo(other: AnyEngine): Promise<void> {
    const { arrays } = await this.say({ op: 'save' });
    const project = (arrays.file as Uint8Array<ArrayBuffer>).slice().buffer;
    await other.start(false);
    if (this.objects.value.length > 0) await other.ask({ op: 'open', name: 'project.batten' }, project);
    const selected = this.selected.value;
    // The journal goes on with the project whole; what is before that stays, should the page be killed here.
    this.noteKept(await this.own.rest());
    if (this.objects.value.length > 0) this.noteKept(await this.own.keep({ op: 'open', name: 'project.batten' }, project, false));
    this.current = other;
    this.engineName.value = other.name;
    this.forget();
    await this.refresh();
    this.selected.value = this.objects.value.some((one) => one.id === selected) ? selected : null;
    await this.showAll();
  }

  /** @param show what the journal brought back; not after a stop, which would begin again what was stopped. */
  async start(keep: boolean, show = true): Promise<void> {
    this.current = this.own;
    this.engineName.value = this.own.name;
    const { json } = await this.own.start(keep);
    this.kept.value = json.kept === true;
    await this.refresh();
    if (show && Number(json.played) > 0) {
      const surfaces = this.objects.value;
      const last = surfaces[surfaces.length - 1];
      if (last) this.selected.value = last.id;
      await this.showAll();
    }
    if (Number(json.failed) > 0)
      this.tell('warning', `${json.failed} of the edits kept by this browser could not be made again.`);
    this.started.value = true;
  }

  // ---- edits ----------------------------------------------------------------------------------------------------

  /** A file becomes an object, or, where it is a project, the project. @returns the id of the object. */
  async open(name: string, bytes: ArrayBuffer): Promise<string | null> {
    return this.guard(`open ${name}`, async () => {
      const { json } = await this.ask(`reading ${name}`, { op: 'open', name }, bytes);
      for (const text of (json.warnings as string[]) ?? []) this.tell('warning', `${name}: ${text}`);
      if (json.replaced === true) this.forget();
      await this.refresh();
      const id = (json.object as string | undefined) ?? this.objects.value[this.objects.value.length - 1]?.id ?? null;
      this.selected.value = id;
      return id;
    });
  }

  /** A scan opened is meant to become a surface: adds its network and that one's surface. */
  async reconstruct(scan: string): Promise<string | null> {
    const name = this.objects.value.find((one) => one.id === scan)?.name ?? 'scan';
    const network = await this.derive(scan, `${name} network`, { kind: 'network' });
    return network && this.derive(network, `${name} surface`, { kind: 'surface' });
  }

  async derive(source: string, name: string, request: RequestOptions): Promise<string | null> {
    return this.guard(name, async () => {
      const { json } = await this.ask(name, {
        op: 'edit',
        edit: { op: 'derive', object: 'o0', name, source, request },
      });
      await this.refresh();
      this.selected.value = json.object as string;
      return json.object as string;
    });
  }

  /** @param drag the same number for all positions of one drag, which are one edit; 0 for others. */
  async edit(edit: Edit, drag = 0): Promise<boolean> {
    const done = await this.guard(edit.op, async () => {
      await this.say({ op: 'edit', edit, drag });
      await this.refresh();
      return true;
    });
    return done === true;
  }

  /** An edit whose refusal the caller shows. @throws EngineError */
  async send(edit: Edit, drag = 0): Promise<void> {
    await this.say({ op: 'edit', edit, drag });
    await this.refresh();
  }

  /** What changes nothing, for the tools of rooms: their previews and measures. @throws EngineError */
  query(message: Message): Promise<Success> {
    return this.say(message);
  }

  async undo(): Promise<void> {
    if (this.canUndo.value && (await this.edit({ op: 'undo' }))) await this.showAll();
  }
  async redo(): Promise<void> {
    if (this.canRedo.value && (await this.edit({ op: 'redo' }))) await this.showAll();
  }

  async clear(): Promise<void> {
    await this.say({ op: 'new' });
    this.forget();
    await this.refresh();
  }

  // ---- what is shown ----------------------------------------------------------------------------------------------

  /** Brings the pictures of all objects that can be seen up to date, sources first. */
  async showAll(): Promise<void> {
    const run = ++this.shows;
    for (const object of this.objects.value) {
      if (run !== this.shows) return;
      if (!this.hidden.value.has(object.id) && this.isShown(object)) await this.showOrSource(object);
    }
  }

  /** What cannot be made anew is not shown as it was: what it is made of stands in its place. */
  private async showOrSource(object: ObjectEntry): Promise<void> {
    const source = object.request?.kind === 'model-surface' ? object.source : undefined;
    // Nothing was drawn yet, or everything undone: no surface, and no fault.
    const isEmpty = source !== undefined && (await this.show(source))?.curves.length === 0;
    if (!isEmpty && (await this.show(object.id))) return;
    this.dropDrawn(object.id);
    if (object.source) await this.show(object.source);
  }

  /** Scans are no pictures, and a network is part of the picture of its surface. */
  isShown(object: ObjectEntry): boolean {
    if (object.kind === 'scan' || object.kind === 'calibration' || object.kind === 'view') return false;
    if (object.id === this.selected.value) return true;
    // What something else was made of makes room for what was made of it; models and meshes not before that is there.
    const made = this.objects.value.filter((other) => other.source === object.id);
    return object.kind === 'model' || object.kind === 'mesh' ? !made.some((other) => this.drawn.value.has(other.id)) : made.length === 0;
  }

  async show(id: string): Promise<Drawn | null> {
    const entry = this.objects.value.find((one) => one.id === id);
    if (!entry) return null;
    const known = this.drawn.value.get(id);
    if (known && known.version === entry.version && !known.coarse) return known;
    return this.guard(entry.name, async () => {
      const from = performance.now();
      const answer = await this.ask(entry.name, { op: 'show', object: id });
      this.lastUpdate.value = { ms: performance.now() - from, coarse: false };
      return this.keepDrawn(id, entry.version, null, answer);
    });
  }

  /**
   * A slider sets an option of a derived object. While it moves, the coarse surface `show` follows; positions that come
   * while the engine is at work make place for the last. At rest everything is brought up to date.
   */
  slide(target: string, request: RequestOptions, show: string | null, rest: boolean): void {
    if (this.drag === 0 || !this.dragging) {
      this.drag++;
      this.dragging = true;
    }
    this.waiting = { target, request, show, rest, drag: this.drag };
    if (rest) this.dragging = false;
    if (!this.sliding) void this.runSlides();
  }

  private async runSlides(): Promise<void> {
    this.sliding = true;
    while (this.waiting) {
      const { target, request, show, rest, drag } = this.waiting;
      this.waiting = null;
      try {
        await this.say({ op: 'edit', edit: { op: 'request', object: target, request }, drag });
        await this.refresh();
        if (show) await this.follow(show, rest);
        else if (rest) await this.showAll();
        if (show && rest) this.checkLater();
      } catch (error) {
        this.report(error, 'slider');
        await this.refresh();
      }
    }
    this.sliding = false;
  }

  /** What was moved at rest is built and checked when nobody has touched anything for a while. */
  private checkLater(): void {
    clearTimeout(this.check);
    this.check = setTimeout(() => {
      if (!this.sliding && !this.dragging) void this.showAll();
    }, CHECK_AFTER_MS);
  }

  /** The surface of a scan at once: coarse while something moves, as fine as is wanted when it rests. */
  private async follow(id: string, fine: boolean): Promise<void> {
    const entry = this.objects.value.find((one) => one.id === id);
    if (!entry) return;
    const from = performance.now();
    const answer = await this.say({
      op: 'follow',
      object: id,
      moving: !fine,
      fine,
      edge_length: LIVE_EDGE_LENGTH,
      triangles: this.drawn.value.get(id)?.coarse !== (fine ? 'fine' : 'coarse'),
    });
    this.keepDrawn(id, entry.version, fine ? 'fine' : 'coarse', answer);
    this.lastUpdate.value = { ms: performance.now() - from, coarse: !fine };
  }

  /** What could not be made anew is not shown as it was. */
  dropDrawn(id: string): void {
    this.drawn.value = new Map([...this.drawn.value].filter(([other]) => other !== id));
  }

  /** @returns whether there are such values; else what is missing is told. */
  computeValues(id: string, shading: string): Promise<boolean> {
    return this.keepValues(id, shading, shading, { op: 'values', object: id, shading });
  }

  computeDistances(id: string, truth: string): Promise<boolean> {
    return this.keepValues(id, 'error', 'distance', { op: 'distances', object: id, truth });
  }

  private async keepValues(id: string, shading: string, title: string, message: Message): Promise<boolean> {
    const drawn = this.drawn.value.get(id);
    const done = await this.guard(title, async () => {
      const { json, arrays } = await this.ask(title, message);
      if (this.drawn.value.get(id) !== drawn) return true; // made anew meanwhile: these belong to what was
      this.values.value = {
        object: id,
        shading,
        values: arrays.values as Float32Array<ArrayBuffer>,
        low: json.low as number,
        high: json.high as number,
        title: json.title as string,
        ...(json.mean === undefined ? {} : { figures: { mean: json.mean as number, rms: json.rms as number, max: json.max as number } }),
      };
      return true;
    });
    return done === true;
  }

  async computeContinuity(id: string, tolerance: number, curves?: string): Promise<void> {
    await this.guard('continuity', async () => {
      const message = { op: 'continuity', object: id, tolerance, ...(curves ? { curves } : {}) };
      const { json } = await this.ask('continuity', message);
      this.continuity.value = { object: id, tolerance, ...(json as unknown as Omit<Continuity, 'object' | 'tolerance'>) };
    });
  }

  /** The bytes of a file: of one object, or of the whole project. */
  async save(id: string | null, format: string): Promise<Uint8Array<ArrayBuffer> | null> {
    return this.guard('save', async () => {
      const { json, arrays } = await this.ask('save', id ? { op: 'save', object: id, format } : { op: 'save' });
      for (const text of (json.warnings as string[]) ?? []) this.tell('warning', text);
      return arrays.file as Uint8Array<ArrayBuffer>;
    });
  }

  /** Ends what the engine does. The project comes back from the journal, as it was before. */
  async cancel(): Promise<void> {
    if (this.engine instanceof SocketEngine) {
      this.engine.cancel();
      return;
    }
    if (!this.kept.value) {
      this.tell('warning', 'This browser keeps no journal, so that stopping would lose the project.', 'Wait for the end.');
      return;
    }
    await this.start(true, false);
    this.tell('info', 'Stopped. The project is as it was before.');
  }

  // ---- telling ----------------------------------------------------------------------------------------------------

  tell(level: Notice['level'], text: string, remedy?: string): void {
    const notice: Notice = { id: ++this.noticeId, level, text, ...(remedy ? { remedy } : {}) };
    this.notices.value = [...this.notices.value.filter((one) => one.text !== text), notice].slice(-30);
  }
  dismiss(id: number): void {
    this.notices.value = this.notices.value.filter((one) => one.id !== id);
  }

  // ---- inside -----------------------------------------------------------------------------------------------------

  private async ask(what: string, message: Message, bytes?: ArrayBuffer): Promise<Success> {
    this.work.value = { what, stage: '', fraction: 0 };
    try {
      return await this.say(message, bytes, (stage, fraction) => {
        this.work.value = { what, stage, fraction };
      });
    } finally {
      this.work.value = null;
    }
  }

  /** Asks the engine of the project. What it changed is kept by the page's own; where it is gone, that one takes over. */
  private async say(message: Message, bytes?: ArrayBuffer, onProgress?: Listener): Promise<Success> {
    const engine = this.current;
    try {
      const answer = await engine.ask(message, bytes, onProgress);
      if (isEdit(message))
        this.noteKept(engine === this.own ? answer : await this.own.keep(message, bytes, answer.json.replaced === true));
      return answer;
    } catch (error) {
      if (error instanceof EngineError && error.kind === 'gone' && engine === this.current) await this.recover();
      throw error;
    }
  }

  private noteKept({ json }: Success): void {
    const isKept = json.kept === true; // again, when a project begins anew where there was no room
    if (this.kept.value && !isKept)
      this.tell('warning', 'The browser has no room left: what is done from here on is not kept.', 'Save the project.');
    this.kept.value = isKept;
  }

  /** The project as the journal has it, in an engine that is started anew. */
  private async recover(): Promise<void> {
    if (this.recovering || !this.kept.value) return;
    this.recovering = true;
    const before = this.selected.value;
    try {
      this.forget();
      await this.start(true, false);
      this.selected.value = this.objects.value.some((one) => one.id === before) ? before : null;
      this.tell('warning', 'The engine was started again, in this page. The project is as it was before.');
      await this.showAll();
    } finally {
      this.recovering = false;
    }
  }

  private async guard<T>(what: string, body: () => Promise<T>): Promise<T | null> {
    try {
      return await body();
    } catch (error) {
      this.report(error, what);
      return null;
    }
  }

  private report(error: unknown, what: string): void {
    if (error instanceof EngineError) {
      if (error.kind !== 'cancelled') this.tell('error', error.message, error.remedy);
    } else {
      this.tell('error', `${what}: ${error instanceof Error ? error.message : String(error)}`);
    }
  }

  private keepDrawn(id: string, version: number, coarse: Drawn['coarse'], { json, arrays }: Success): Drawn {
    const before = this.drawn.value.get(id);
    const triangles = (arrays.triangles ?? before?.triangles) as Uint32Array<ArrayBuffer> | undefined;
    const vertex = arrays['network.vertices'] as Uint32Array<ArrayBuffer> | undefined;
    const drawn: Drawn = {
      id,
      version,
      coarse,
      origin: (json.origin as [number, number, number] | undefined) ?? [0, 0, 0],
      curves: (json.curves as Drawn['curves'] | undefined) ?? [],
      warnings: (json.warnings as string[] | undefined) ?? (coarse ? (before?.warnings ?? []) : []),
      flaws: (json.flaws as string[] | undefined) ?? [],
      ...(arrays.positions ? { positions: arrays.positions as Float32Array<ArrayBuffer> } : {}),
      ...(arrays.normals ? { normals: arrays.normals as Float32Array<ArrayBuffer> } : {}),
      ...(triangles ? { triangles } : {}),
      ...(arrays['network.positions'] && vertex
        ? {
            network: {
              positions: arrays['network.positions'] as Float32Array<ArrayBuffer>,
              vertices: vertex,
              nodes: arrays['network.nodes'] as Uint32Array<ArrayBuffer>,
              ...(arrays['network.normals'] ? { normals: arrays['network.normals'] as Float32Array<ArrayBuffer> } : {}),
            },
          }
        : {}),
      ...(json.mesh ? { mesh: json.mesh as NonNullable<Drawn['mesh']> } : {}),
      ...(json.done ? { done: json.done as string[] } : {}),
      ...(json.report ? { report: json.report as NonNullable<Drawn['report']> } : {}),
      ...(coarse
        ? { live: { lambda: json.lambda as number, mu: json.mu as number, misfit: json.misfit as number } }
        : {}),
      ...(json.times ? { times: json.times as NonNullable<Drawn['times']> } : {}),
    };
    const map = new Map(this.drawn.value);
    map.set(id, drawn);
    batch(() => {
      if (this.values.value?.object === id) this.values.value = null;
      if (this.continuity.value?.object === id && !coarse) this.continuity.value = null;
      this.drawn.value = map;
    });
    return drawn;
  }

  private forget(): void {
    batch(() => {
      this.drawn.value = new Map();
      this.selected.value = null;
      this.hidden.value = new Set();
      this.values.value = null;
      this.continuity.value = null;
    });
  }

  private async refresh(): Promise<void> {
    const { json } = await this.say({ op: 'document' });
    const objects = json.objects as ObjectEntry[];
    const there = new Set(objects.map((one) => one.id));
    batch(() => {
      // What was selected and is gone leaves the selection to what it was made of.
      let chosen = this.selected.value;
      while (chosen && !there.has(chosen)) chosen = this.objects.value.find((one) => one.id === chosen)?.source ?? null;
      this.objects.value = objects;
      this.outdated.value = new Set(json.outdated as string[]);
      this.canUndo.value = json.can_undo as boolean;
      this.canRedo.value = json.can_redo as boolean;
      this.log.value = json.log as string[];
      this.selected.value = chosen;
      if ([...this.drawn.value.keys()].some((id) => !there.has(id)))
        this.drawn.value = new Map([...this.drawn.value].filter(([id]) => there.has(id)));
    });
  }
}
