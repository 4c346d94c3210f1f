/** What the sketch room does with strokes: edits of the model, previews of them, refusals kept until they are answered. */
import { signal } from '@preact/signals';
import { Matrix4, Vector3 } from 'three';
import { EngineError } from '../../engine/engine';
import type { App } from '../app';
import type { Edit, ObjectEntry } from '../document/types';
import { register } from '../ui/commands';
import { type Axis, Drawing, type Ground, type Stroke } from '../view/drawing';
import { dots, grid, INK, segments, stroke as strokeLine, together } from '../view/overlays';

/** Between two previews of a stroke. */
const TRY_PAUSE_MS = 120;
/** What a first sketch is about as large as, in its unit. */
const FIRST_SIZE = 100;

type Place = [number, number, number];

/** What the next stroke is for. Those of more than one stroke gather them first. */
export type Purpose = 'insert' | 'hole' | 'mirror' | 'glue' | 'skin' | 'align';

export interface Refusal {
  message: string;
  remedy?: string;
  edit: Edit;
  /** What a button can do about it. */
  remedies: { title: string; run: () => Promise<void> }[];
}

/** The model and its surface that the selection belongs to. */
export function modelOf(objects: ObjectEntry[], selected: string | null) {
  const find = (id: string | undefined) => objects.find((one) => one.id === id);
  const picked = find(selected ?? undefined);
  const model = picked?.kind === 'model' ? picked : find(picked?.source);
  if (model?.kind !== 'model') return null;
  const surface = objects.find((one) => one.source === model.id && one.request?.kind === 'model-surface') ?? null;
  return { model, surface };
}

const AXES: readonly Axis[] = ['x', 'y', 'z'];

/** The image of a stroke on the other side of a plane across an axis. */
export function mirrored(points: readonly Place[], axis: Axis, offset: number): Place[] {
  const k = AXES.indexOf(axis);
  return points.map((point) => point.map((x, i) => (i === k ? 2 * offset - x : x)) as Place);
}

/**
 * A stroke beside a plane of symmetry, with its image. A stroke that begins and ends in the plane becomes a closed curve with
 * it, one that only begins or ends there goes on in it; others have an image of their own. What crosses the plane stays as it is.
 */
export function completed(points: readonly Place[], axis: Axis, offset: number, near: number): { points: Place[]; closed?: boolean }[] {
  const k = AXES.indexOf(axis);
  const inPlane = (point: Place | undefined) => point !== undefined && Math.abs((point[k] ?? 0) - offset) <= near;
  const flat = (point: Place) => point.map((x, i) => (i === k ? offset : x)) as Place;
  if (points.every(inPlane)) return [{ points: points.map(flat) }];
  const sides = points.filter((point) => !inPlane(point)).map((point) => Math.sign((point[k] ?? 0) - offset));
  if (sides.includes(1) && sides.includes(-1)) return [{ points: [...points] }];
  const own = points.map((point) => [...point] as Place);
  const [starts, ends] = [inPlane(own[0]), inPlane(own[own.length - 1])];
  if (starts && own[0]) own[0] = flat(own[0]);
  if (ends && own.length > 0) own[own.length - 1] = flat(own[own.length - 1] as Place);
  const image = mirrored(own, axis, offset);
  if (starts && ends) return [{ points: [...own, ...image.reverse().slice(1, -1)], closed: true }];
  if (ends) return [{ points: [...own, ...image.reverse().slice(1)] }];
  if (starts) return [{ points: [...own.reverse(), ...image.slice(1)] }];
  return [{ points: own }, { points: image }];
}

export class Sketching {
  readonly tool = signal<'draw' | 'look'>('draw');
  readonly ground = signal<Ground>('plane');
  readonly axis = signal<Axis>('z');
  readonly offset = signal(0);
  readonly into = signal<'auto' | 'face' | 'opening'>('auto');
  readonly sharp = signal(false);
  readonly purpose = signal<Purpose>('insert');
  /** The plane across which every stroke has an image, by the axis that it lies across. */
  readonly symmetry = signal<Axis | 'off'>('off');
  /** Strokes of a tool that takes several; `spines` is where those of skin begin. */
  readonly gathered = signal<Place[][]>([]);
  readonly spinesFrom = signal<number | null>(null);
  /** The number of the curve that was clicked on, and the index of its piece among what is drawn. */
  readonly curve = signal<number | null>(null);
  readonly piece = signal<number | null>(null);
  readonly refusal = signal<Refusal | null>(null);
  /** What the stroke that is being drawn would do, in words. */
  readonly preview = signal<{ text: string; fits: boolean } | null>(null);
  private drawing: Drawing | null = null;
  private trying = false;
  private wanted: Stroke | null = null;
  private drag = 1_000_000; // beside those of the store, which count from 1
  private waiting: { edit: Edit; drag: number; rest: boolean } | null = null;
  private sliding = false;

  constructor(private app: App) {
    this.registerCommands();
  }

  private get model() {
    return modelOf(this.app.store.objects.value, this.app.store.selected.value);
  }

  /** The pointers draw from now on, on this ground; null: they do not. */
  use(ground: { ground: Ground; axis: Axis; offset: number } | null): void {
    const { view } = this.app;
    if (!view) return;
    if (!ground) {
      view.setTool(null);
      grid(view, null);
      grid(view, null, 'symmetry');
      return;
    }
    if (!this.drawing) {
      this.drawing = new Drawing(view);
      this.drawing.onStroke = (stroke) => void this.draw(stroke);
      this.drawing.onPreview = (stroke) => this.tryLater(stroke);
      this.drawing.onPick = (found) => {
        this.curve.value = found && found.curve >= 0 ? found.curve : null;
        this.piece.value = found && found.curve >= 0 ? found.index : null;
      };
    }
    Object.assign(this.drawing, ground);
    this.drawing.loose = this.gathered.value.map((points, i) => ({ name: `stroke ${i + 1}`, points: points.map((one) => view.fromModel(one)) }));
    view.setTool(this.drawing);
    grid(view, ground.ground === 'plane' ? ground : null);
    const { value: symmetry } = this.symmetry;
    grid(view, symmetry === 'off' ? null : { axis: symmetry, offset: 0 }, 'symmetry', [0xc25a1c, 0xe0b798]);
  }

  /** An empty model with the surface that will grow on it. */
  async begin(): Promise<void> {
    const { store } = this.app;
    const name = `sketch ${1 + store.objects.value.filter((one) => one.kind === 'model').length}`;
    if (!(await store.edit({ op: 'add', object: 'o0', kind: 'model', name, unit: 'mm', content: {} }))) return;
    const model = store.objects.value[store.objects.value.length - 1];
    if (!model) return;
    await store.derive(model.id, `${name} surface`, { kind: 'model-surface', levels: 2 });
    this.curve.value = null;
    this.app.view?.setEmptySize(FIRST_SIZE);
    this.app.view?.lookFrom('home');
  }

  // ---- strokes ------------------------------------------------------------------------------------------------------

  /** Another tool; what was gathered for the one before is forgotten. */
  choose(purpose: Purpose): void {
    this.tool.value = 'draw';
    this.purpose.value = this.purpose.value === purpose ? 'insert' : purpose;
    this.dropGathered();
  }
  private dropGathered(): void {
    this.gathered.value = [];
    this.spinesFrom.value = null;
    this.showGathered();
  }
  private showGathered(): void {
    const { view } = this.app;
    if (!view) return;
    for (let i = 0; i < 24; ++i) strokeLine(view, this.gathered.value[i] ?? null, false, `gathered ${i}`);
  }

  /** The edits that a stroke amounts to; none where more strokes have to come first. */
  private editsOf(points: Place[], gathered = this.gathered.value): Edit[] {
    const options: Record<string, unknown> = {};
    if (this.sharp.value) options.sharpness = 1;
    if (this.into.value !== 'auto' && this.purpose.value === 'insert') options.into = this.into.value;
    switch (this.purpose.value) {
      case 'insert':
      case 'hole': {
        const op = this.purpose.value;
        if (this.symmetry.value === 'off') return [{ op, points, ...options }];
        const near = 0.03 * (this.app.view?.size() ?? 1);
        return completed(points, this.symmetry.value, 0, near).map((one) => ({ op, ...one, ...options }));
      }
      case 'mirror':
        return [{ op: 'mirror', points, ...options }];
      case 'align':
        return this.curve.value === null ? [] : [{ op: 'align', reference: `c${this.curve.value}`, points }];
      case 'glue':
        return gathered.length < 1 ? [] : [{ op: 'glue', first: { points: gathered[0] }, second: { points }, ...options }];
      case 'skin': {
        const from = this.spinesFrom.value;
        if (from === null || gathered.length < from + 1) return [];
        const profiles = gathered.slice(0, from).map((one) => ({ points: one, closed: true }));
        return [{ op: 'skin', profiles, spines: [{ points: gathered[from] }, { points }], ...options }];
      }
    }
  }

  async draw(stroke: Stroke): Promise<void> {
    const { view } = this.app;
    this.tryLater(null);
    const points = rounded(stroke);
    if (points.length < 2) {
      if (view) strokeLine(view, null);
      return;
    }
    const edits = this.editsOf(points);
    if (edits.length === 0) {
      if (view) strokeLine(view, null);
      this.gathered.value = [...this.gathered.value, points];
      this.showGathered();
      return;
    }
    for (const edit of edits) if (!(await this.edit(edit))) return;
    if (this.purpose.value !== 'insert') {
      this.purpose.value = 'insert';
      this.dropGathered();
    }
  }

  // ---- before the pointer is up ---------------------------------------------------------------------------------------

  /** What a stroke would become is asked while it is drawn; the newest is what counts. */
  private tryLater(stroke: Stroke | null): void {
    this.wanted = stroke;
    if (!stroke) {
      this.preview.value = null;
      if (this.app.view) this.app.view.overlay('preview', null);
    } else if (!this.trying) void this.runTries();
  }

  private async runTries(): Promise<void> {
    const { store, view } = this.app;
    this.trying = true;
    while (this.wanted) {
      const points = rounded(this.wanted);
      this.wanted = null;
      const found = this.model;
      const edit = points.length > 2 && found ? this.editsOf(points)[0] : undefined;
      if (!edit || !found || !view) continue;
      try {
        const { json, arrays } = await store.query({ op: 'try', edit: { ...edit, object: found.model.id } });
        if (this.drawing?.isDrawing() !== true) break;
        if (json.accepted !== true) {
          this.preview.value = { text: String(json.reason), fits: false };
          view.overlay('preview', null);
          continue;
        }
        const meets = json.meets as { at: Place; curve: string }[];
        const names = [...new Set(meets.map((one) => one.curve))];
        const faces = json.faces as number;
        this.preview.value = {
          text: `${names.length > 0 ? `Meets ${names.join(', ')}` : 'Meets no curve'}${faces > 0 ? `; ${faces} face${faces > 1 ? 's' : ''} more` : ''}.`,
          fits: true,
        };
        const positions = arrays.positions as Float32Array;
        const pieces = json.pieces as { first: number; n: number }[];
        const ends = new Float32Array(pieces.reduce((sum, { n }) => sum + 6 * Math.max(0, n - 1), 0));
        let at = 0;
        for (const { first, n } of pieces)
          for (let i = first; i + 1 < first + n; ++i, at += 6) ends.set(positions.subarray(3 * i, 3 * i + 6), at);
        const marks = dots(meets.map((one) => new Vector3(...one.at)), INK.accepted, 10);
        view.overlay('preview', together(view.fromModel(json.origin as Place), segments(ends, INK.accepted, 3), marks));
      } catch {
        this.preview.value = null; // the stroke itself will say what is wrong
      }
      await new Promise((resolve) => setTimeout(resolve, TRY_PAUSE_MS)); // the hand needs no more, and the engine has other work
    }
    this.trying = false;
    if (!this.drawing?.isDrawing()) this.tryLater(null);
  }

  // ---- edits --------------------------------------------------------------------------------------------------------

  forget(): void {
    this.refusal.value = null;
    if (this.app.view) strokeLine(this.app.view, null);
  }

  async remove(): Promise<void> {
    if (this.curve.value !== null) await this.edit({ op: 'delete', curve: `c${this.curve.value}` });
    this.curve.value = null;
  }

  /** The sharpness of the curve, or of its piece that was clicked on; the surface follows while it is dragged. */
  setSharpness(value: number, rest: boolean, ends: readonly [number, number] | null): void {
    if (this.curve.value === null) return;
    const edit: Edit = { op: 'sharpness', curve: `c${this.curve.value}`, value };
    if (ends) edit.between = ends.map((v) => `v${v}`);
    this.waiting = { edit, drag: this.drag, rest };
    if (rest) this.drag++;
    if (!this.sliding) void this.runSlides();
  }
  private async runSlides(): Promise<void> {
    this.sliding = true;
    while (this.waiting) {
      const { edit, drag } = this.waiting;
      this.waiting = null;
      await this.edit(edit, drag);
    }
    this.sliding = false;
  }

  /** Moves, turns (degrees about an axis) and scales the whole model, or mirrors it across the plane of an axis. */
  async transform(move: Place, turn: { axis: Axis; angle: number }, scale: number, mirror = false): Promise<void> {
    const along = new Vector3(Number(turn.axis === 'x'), Number(turn.axis === 'y'), Number(turn.axis === 'z'));
    const size = mirror ? new Vector3(1, 1, 1).addScaledVector(along, -2) : new Vector3(scale, scale, scale);
    const matrix = new Matrix4().makeTranslation(...move);
    if (!mirror) matrix.multiply(new Matrix4().makeRotationAxis(along, (turn.angle * Math.PI) / 180));
    matrix.scale(size);
    if (await this.edit({ op: 'transform', matrix: matrix.transpose().toArray() })) this.app.view?.fit(); // three counts by columns
  }

  /** @returns whether it was done; else its refusal is shown. */
  async edit(edit: Edit, drag = 0): Promise<boolean> {
    const found = this.model;
    if (!found) return false;
    const { store, view } = this.app;
    try {
      await store.send({ ...edit, object: found.model.id }, drag);
      this.forget();
    } catch (error) {
      if (!(error instanceof EngineError)) throw error;
      this.refusal.value = { message: error.message, ...(error.remedy ? { remedy: error.remedy } : {}), edit, remedies: this.remediesOf(edit, error) };
      const points = edit.points as Place[] | undefined;
      if (view) strokeLine(view, points ?? null, true);
      return false;
    }
    // The curves at once, the surface when it is made; where it cannot be made they stand alone.
    const target = found.surface ?? found.model;
    if (!(await store.show(target.id))) {
      store.dropDrawn(target.id);
      await store.show(found.model.id);
    }
    return true;
  }

  /** The remedies of a sentence that need no hand: each does it and draws the stroke again. */
  private remediesOf(edit: Edit, error: EngineError): Refusal['remedies'] {
    const text = `${error.message} ${error.remedy ?? ''}`;
    const list: Refusal['remedies'] = [];
    const again = (title: string, patch: object) => list.push({ title, run: async () => void (await this.edit({ ...edit, ...patch })) });
    const snap = /give a snap of ([\d.e+-]+) or (more|less)/.exec(error.remedy ?? '');
    const value = Number(snap?.[1]);
    if (snap && value > 0) again(`Again with a snap of ${value.toPrecision(3)}`, { snap: snap[2] === 'more' ? 1.02 * value : 0.98 * value });
    else if (/smaller snapping distance/.test(text)) again('Again with a smaller snap', { snap: 0.005 * (this.app.view?.size() ?? 1) });
    const deletion = /\bdelete c(\d+)/.exec(error.remedy ?? '');
    if (deletion)
      list.push({
        title: `Delete c${deletion[1]}, then again`,
        run: async () => void ((await this.edit({ op: 'delete', curve: `c${deletion[1]}` })) && (await this.edit(edit))),
      });
    if (edit.op === 'insert' && /closed curve|first boundary/.test(text) && edit.closed !== true) again('Close it', { closed: true });
    if (edit.op === 'glue' && /insert the stroke/.test(text)) again('Insert the first stroke', { op: 'insert', points: (edit.first as { points: Place[] }).points, first: undefined, second: undefined });
    if (edit.op === 'insert' && /opening|face/.test(text)) {
      if (edit.into !== 'opening') again('Into the opening', { into: 'opening' });
      if (edit.into !== 'face') again('Into the face', { into: 'face' });
    }
    return list;
  }

  private registerCommands(): void {
    const { app } = this;
    const here = () => app.room.value === 'sketch' && this.model !== null;
    const hasCurve = () => here() && this.curve.value !== null;
    const tools: [Purpose, string, string, () => boolean][] = [
      ['hole', 'Cut a hole with the next stroke', 'O', here],
      ['mirror', 'Draw half a curve and mirror it', 'Shift+Y', here],
      ['glue', 'Glue two borders by a tube', 'G', here],
      ['skin', 'Skin: a tube through closed profiles', 'K', here],
      ['align', 'Align the model: draw where the curve is', 'A', hasCurve],
    ];
    register(
      { id: 'draw', title: 'Draw', keys: 'D', when: here, run: () => this.choose('insert') },
      { id: 'look', title: 'Turn the view instead of drawing', keys: 'V', when: here, run: () => void (this.tool.value = 'look') },
      { id: 'new-sketch', title: 'New sketch', run: () => { app.room.value = 'sketch'; return this.begin(); } },
      { id: 'delete-curve', title: 'Delete the curve', keys: 'X', when: hasCurve, run: () => this.remove() },
      { id: 'mirror-curve', title: 'Mirror the curve', keys: 'M', when: hasCurve, run: async () => void (await this.edit({ op: 'mirror', curve: `c${this.curve.value}` })) },
      {
        id: 'sharp-curve',
        title: 'Make the curve an edge, or smooth again',
        keys: 'E',
        when: hasCurve,
        run: () => this.setSharpness(this.curveEntry()?.sharp ? 0 : 1, true, null),
      },
      {
        id: 'symmetry',
        title: 'Symmetry: every stroke has an image',
        keys: 'Y',
        when: here,
        run: () => void (this.symmetry.value = this.symmetry.value === 'off' ? 'x' : 'off'),
      },
      { id: 'skin-spines', title: 'Skin: the profiles are drawn, now the spines', keys: 'Shift+K', when: () => this.canBeginSpines(), run: () => this.beginSpines() },
      ...tools.map(([purpose, title, keys, when]) => ({ id: `tool-${purpose}`, title, keys, when, run: () => this.choose(purpose) })),
    );
  }

  canBeginSpines(): boolean {
    return this.app.room.value === 'sketch' && this.purpose.value === 'skin' && this.spinesFrom.value === null && this.gathered.value.length >= 2;
  }
  beginSpines(): void {
    this.spinesFrom.value = this.gathered.value.length;
  }

  /** The curve that was clicked on, as it is drawn. */
  curveEntry() {
    const found = this.model;
    const { store } = this.app;
    const drawn = found && (store.drawn.value.get(found.surface?.id ?? found.model.id) ?? store.drawn.value.get(found.model.id));
    return drawn?.curves.find((one) => one.curve === this.curve.value) ?? null;
  }
}

function rounded(stroke: Stroke): Place[] {
  return stroke.points.map((point) => point.map((x) => Number(x.toPrecision(8))) as Place);
}

let made: Sketching | null = null;
/** The one of the page. */
export function sketchingOf(app: App): Sketching {
  made ??= new Sketching(app);
  return made;
}
