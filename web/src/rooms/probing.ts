/** What the inspect room draws over an object: combs, principal directions, a section, a measured distance. */
import { signal } from '@preact/signals';
import type { App } from '../app';
import type { Edit } from '../document/types';
import { register } from '../ui/commands';
import { dots, hairs, INK, rgb, segments, stroke, together } from '../view/overlays';
import type { PointerTool } from '../view/scene';

type Place = [number, number, number];
export type Axis = 'x' | 'y' | 'z';

export interface SectionCurve {
  closed: boolean;
  length: number;
  area: number | null;
}
export interface Section {
  length: number;
  area: number;
  curves: SectionCurve[];
}
/** A picked place, in coordinates of the model. */
interface Picked {
  place: Place;
  normal: Place | null;
}

/** Moved less than this a pointer has clicked, in pixels. */
const CLICK = 4;
const REACH = 9;

export class Probing implements PointerTool {
  readonly cursor = 'crosshair';
  readonly combs = signal(false);
  /** Of the longest quill, in per cent of the size of what is seen. */
  readonly combLength = signal(12);
  readonly largest = signal<number | null>(null);
  readonly directions = signal(false);
  readonly cut = signal<{ axis: Axis; offset: number } | null>(null);
  readonly section = signal<Section | null>(null);
  readonly measuring = signal(false);
  readonly picked = signal<Picked[]>([]);
  private from: { x: number; y: number } | null = null;
  private run = 0;
  private cutting = false;
  private waiting: { id: string; axis: Axis; offset: number } | null = null;

  constructor(private app: App) {
    const here = () => app.room.value === 'inspect';
    const hasMesh = () => here() && app.store.selectedObject.value?.kind === 'mesh';
    register(
      { id: 'combs', title: 'Curvature combs along curves', keys: 'Shift+C', when: () => here() && this.hasCurves(), run: () => void (this.combs.value = !this.combs.value) },
      { id: 'directions', title: 'Principal directions', keys: 'Shift+P', when: hasMesh, run: () => void (this.directions.value = !this.directions.value) },
      { id: 'section', title: 'Section by a plane', keys: 'Shift+X', when: hasMesh, run: () => this.toggleCut() },
      { id: 'measure', title: 'Measure between two places', keys: 'Shift+T', when: here, run: () => this.setMeasuring(!this.measuring.value) },
      { id: 'measure-middle', title: 'Measure: take the place in the middle of the view', keys: 'Shift+J', when: () => here() && this.measuring.value, run: () => this.pickMiddle() },
    );
  }

  private hasCurves(): boolean {
    return (this.app.store.drawn.value.get(this.app.store.selected.value ?? '')?.curves.length ?? 0) > 0;
  }

  // ---- combs and directions -------------------------------------------------------------------------------------------

  /** Draws what is switched on for an object; nothing for null. */
  async show(id: string | null): Promise<void> {
    const { view, store } = this.app;
    const run = ++this.run;
    if (!view) return;
    if (!id || !this.combs.value) view.overlay('combs', null);
    if (!id || !this.directions.value) view.overlay('directions', null);
    if (!id || !this.cut.value) {
      view.overlay('section', null);
      this.section.value = null;
    }
    if (!id) return;
    try {
      if (this.combs.value && !this.hasCurves()) view.overlay('combs', null);
      else if (this.combs.value) {
        const { json, arrays } = await store.query({ op: 'combs', object: id });
        if (run !== this.run) return;
        this.drawCombs(json.origin as Place, json.combs as { first: number; n: number }[], arrays as Record<string, Float32Array>);
      }
      if (this.directions.value) {
        const { json, arrays } = await store.query({ op: 'directions', object: id });
        if (run !== this.run) return;
        this.drawDirections(json.origin as Place, arrays as Record<string, Float32Array>, store.drawn.value.get(id)?.mesh?.area ?? 0);
      }
    } catch (error) {
      store.tell('error', error instanceof Error ? error.message : String(error));
      this.combs.value = false;
    }
    if (this.cut.value) this.moveCut(id, this.cut.value.axis, this.cut.value.offset);
  }

  private drawCombs(origin: Place, combs: { first: number; n: number }[], { roots, directions, curvature }: Record<string, Float32Array>): void {
    const { view } = this.app;
    if (!view || !roots || !directions || !curvature) return;
    const largest = curvature.reduce((most, one) => Math.max(most, Math.abs(one)), 0);
    this.largest.value = largest;
    const scale = largest > 0 ? ((this.combLength.value / 100) * view.size()) / largest : 0;
    const tip = (i: number, k: number) => (roots[3 * i + k] ?? 0) + scale * (curvature[i] ?? 0) * (directions[3 * i + k] ?? 0);
    const quills = new Float32Array(6 * curvature.length);
    const colours = new Float32Array(6 * curvature.length);
    const lines: number[] = [];
    for (let i = 0; i < curvature.length; ++i) {
      quills.set(roots.subarray(3 * i, 3 * i + 3), 6 * i);
      for (let k = 0; k < 3; ++k) quills[6 * i + 3 + k] = tip(i, k);
      const colour = rgb((curvature[i] ?? 0) < 0 ? INK.second : INK.first);
      colours.set([...colour, ...colour], 6 * i);
    }
    for (const { first, n } of combs)
      for (let i = first; i + 1 < first + n; ++i) for (const j of [i, i + 1]) for (let k = 0; k < 3; ++k) lines.push(tip(j, k));
    view.overlay('combs', together(view.fromModel(origin), hairs(quills, colours), segments(new Float32Array(lines), INK.drawn, 1.5)));
  }

  private drawDirections(origin: Place, { places, first, second }: Record<string, Float32Array>, area: number): void {
    const { view } = this.app;
    if (!view || !places || !first || !second) return;
    const n = places.length / 3;
    const half = 0.35 * Math.sqrt(area / Math.max(1, n));
    const ends = new Float32Array(12 * n);
    const colours = new Float32Array(12 * n);
    [first, second].forEach((along, which) => {
      const colour = rgb(which === 0 ? INK.first : INK.second);
      for (let i = 0; i < n; ++i)
        for (let k = 0; k < 3; ++k) {
          const at = 12 * i + 6 * which + k;
          const way = half * (along[3 * i + k] ?? 0);
          ends[at] = (places[3 * i + k] ?? 0) - way;
          ends[at + 3] = (places[3 * i + k] ?? 0) + way;
          colours[at] = colours[at + 3] = colour[k] ?? 0;
        }
    });
    view.overlay('directions', together(view.fromModel(origin), hairs(ends, colours)));
  }

  // ---- section ----------------------------------------------------------------------------------------------------------

  /** How far an object reaches along an axis, in coordinates of the model. */
  extent(id: string, axis: Axis): [number, number] {
    const drawn = this.app.store.drawn.value.get(id);
    const k = 'xyz'.indexOf(axis);
    let [low, high] = [Infinity, -Infinity];
    for (let i = k; i < (drawn?.positions?.length ?? 0); i += 3) {
      const x = (drawn?.positions?.[i] ?? 0) + (drawn?.origin[k] ?? 0);
      low = Math.min(low, x);
      high = Math.max(high, x);
    }
    return low <= high ? [low, high] : [0, 1];
  }

  /** A place on an axis as fine as a slider is, so that its number can be read. */
  readable(id: string, axis: Axis, offset: number): number {
    const [low, high] = this.extent(id, axis);
    const step = 10 ** Math.floor(Math.log10(Math.max(high - low, 1e-30) / 500));
    return Number((Math.round(offset / step) * step).toPrecision(6));
  }

  toggleCut(): void {
    const id = this.app.store.selected.value;
    if (this.cut.value || !id) this.cut.value = null;
    else {
      const [low, high] = this.extent(id, 'z');
      this.cut.value = { axis: 'z', offset: this.readable(id, 'z', (low + high) / 2) };
    }
  }

  moveCut(id: string, axis: Axis, offset: number): void {
    this.waiting = { id, axis, offset };
    if (!this.cutting) void this.runCuts();
  }

  private ask(id: string, axis: Axis, offset: number, name?: string) {
    const normal = [Number(axis === 'x'), Number(axis === 'y'), Number(axis === 'z')];
    return this.app.store.query({ op: 'section', object: id, normal, offset, ...(name ? { name } : {}) });
  }

  private async runCuts(): Promise<void> {
    const { view, store } = this.app;
    this.cutting = true;
    while (this.waiting && view) {
      const { id, axis, offset } = this.waiting;
      this.waiting = null;
      try {
        const { json, arrays } = await this.ask(id, axis, offset);
        if (!this.cut.value) break;
        const curves = json.curves as (SectionCurve & { first: number; n: number })[];
        const positions = arrays.positions as Float32Array;
        const lines: number[] = [];
        for (const { first, n, closed } of curves)
          for (let i = 0; i < n - (closed ? 0 : 1); ++i)
            for (const j of [first + i, first + ((i + 1) % n)]) lines.push(...positions.subarray(3 * j, 3 * j + 3));
        view.overlay('section', together(view.fromModel(json.origin as Place), segments(new Float32Array(lines), INK.refused, 3)));
        this.section.value = { length: json.length as number, area: json.area as number, curves };
      } catch (error) {
        store.tell('error', error instanceof Error ? error.message : String(error));
      }
    }
    this.cutting = false;
  }

  /** The curves of the section become a network of the project. */
  async keepSection(id: string): Promise<void> {
    const cut = this.cut.value;
    const { store } = this.app;
    if (!cut) return;
    const name = `${store.objects.value.find((one) => one.id === id)?.name ?? 'mesh'} at ${cut.axis} ${Number(cut.offset.toPrecision(4))}`;
    try {
      const { json } = await this.ask(id, cut.axis, cut.offset, name);
      if (await store.edit(json.edit as Edit)) store.tell('info', `${name} is a network of the project now.`);
    } catch (error) {
      store.tell('error', error instanceof Error ? error.message : String(error));
    }
  }

  // ---- measure ----------------------------------------------------------------------------------------------------------

  setMeasuring(on: boolean): void {
    this.measuring.value = on;
    this.app.view?.setTool(on ? this : null);
    if (!on) {
      this.picked.value = [];
      this.showPicked();
    }
  }

  down(event: PointerEvent): boolean {
    this.from = event.button === 0 && event.isPrimary ? { x: event.clientX, y: event.clientY } : null;
    return false; // a drag turns the view as ever
  }
  move(): void {}
  up(event: PointerEvent): void {
    const { from } = this;
    const { view } = this.app;
    this.from = null;
    if (!view || !from || Math.hypot(event.clientX - from.x, event.clientY - from.y) > CLICK) return;
    const { x, y } = view.place(event);
    this.pickAt(x, y);
  }
  cancel(): void {
    this.from = null;
  }

  pickMiddle(): void {
    const { view } = this.app;
    if (view) this.pickAt(view.element.clientWidth / 2, view.element.clientHeight / 2);
  }

  private pickAt(x: number, y: number): void {
    const { view } = this.app;
    if (!view) return;
    const surface = view.pickSurface(x, y);
    const point = view.nearestCurve(x, y, REACH)?.point ?? surface?.point;
    if (!point) return;
    const before = this.picked.value.length === 1 ? this.picked.value : [];
    this.picked.value = [...before, { place: view.toModel(point), normal: surface ? (surface.normal.toArray() as Place) : null }];
    this.showPicked();
  }

  private showPicked(): void {
    const { view } = this.app;
    if (!view) return;
    const points = this.picked.value.map(({ place }) => view.fromModel(place));
    view.overlay('measure', points.length > 0 ? dots(points, INK.refused, 11) : null);
    stroke(view, this.picked.value.map(({ place }) => place), true, 'measured'); // also where the surface hides it
  }
}

let made: Probing | null = null;
/** The one of the page. */
export function probingOf(app: App): Probing {
  made ??= new Probing(app);
  return made;
}
