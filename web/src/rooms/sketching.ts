/** What the sketch room does with strokes: edits of the model, refusals kept until they are answered. */
import { signal } from '@preact/signals';
import { EngineError } from '../../engine/engine';
import type { App } from '../app';
import type { Edit, ObjectEntry } from '../document/types';
import type { Axis, Ground, Stroke } from '../view/drawing';

/** What a first sketch is about as large as, in its unit. */
const FIRST_SIZE = 100;

/** The model and its surface that the selection belongs to. */
export function modelOf(objects: ObjectEntry[], selected: string | null) {
  const find = (id: string | undefined) => objects.find((one) => one.id === id);
  const picked = find(selected ?? undefined);
  const model = picked?.kind === 'model' ? picked : find(picked?.source);
  if (model?.kind !== 'model') return null;
  const surface = objects.find((one) => one.source === model.id && one.request?.kind === 'model-surface') ?? null;
  return { model, surface };
}

export class Sketching {
  readonly tool = signal<'draw' | 'look'>('draw');
  readonly ground = signal<Ground>('plane');
  readonly axis = signal<Axis>('z');
  readonly offset = signal(0);
  readonly into = signal<'auto' | 'face' | 'opening'>('auto');
  readonly sharp = signal(false);
  readonly purpose = signal<'insert' | 'hole'>('insert');
  /** The number of the curve that was clicked on. */
  readonly curve = signal<number | null>(null);
  readonly refusal = signal<{ message: string; remedy?: string; edit: Edit } | null>(null);

  constructor(private app: App) {}

  private get model() {
    return modelOf(this.app.store.objects.value, this.app.store.selected.value);
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

  async draw(stroke: Stroke): Promise<void> {
    const points = stroke.points.map((point) => point.map((x) => Number(x.toPrecision(8))));
    if (points.length < 2) {
      this.app.view?.setStroke(null);
      return;
    }
    const edit: Edit = { op: this.purpose.value, points };
    if (this.sharp.value) edit.sharpness = 1;
    if (this.into.value !== 'auto' && this.purpose.value === 'insert') edit.into = this.into.value;
    await this.edit(edit);
    this.purpose.value = 'insert';
  }

  /** The refused stroke once more, with the side that is meant. */
  async again(into: 'face' | 'opening'): Promise<void> {
    const refused = this.refusal.value;
    if (refused) await this.edit({ ...refused.edit, into });
  }

  forget(): void {
    this.refusal.value = null;
    this.app.view?.setStroke(null);
  }

  async remove(): Promise<void> {
    if (this.curve.value !== null) await this.edit({ op: 'delete', curve: `c${this.curve.value}` });
    this.curve.value = null;
  }

  async edit(edit: Edit): Promise<void> {
    const found = this.model;
    if (!found) return;
    const { store, view } = this.app;
    try {
      await store.send({ ...edit, object: found.model.id });
      this.refusal.value = null;
      view?.setStroke(null);
    } catch (error) {
      if (!(error instanceof EngineError)) throw error;
      this.refusal.value = { message: error.message, ...(error.remedy ? { remedy: error.remedy } : {}), edit };
      const points = edit.points as [number, number, number][] | undefined;
      view?.setStroke(points ?? null, true);
      return;
    }
    // The curves at once, the surface when it is made; where it cannot be made they stand alone.
    const target = found.surface ?? found.model;
    if (!(await store.show(target.id))) {
      store.dropDrawn(target.id);
      await store.show(found.model.id);
    }
  }
}
