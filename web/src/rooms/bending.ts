/** A mesh pulled at: a place is held, dragged with a preview, and what comes of it is a step that undo takes back. */
import { signal } from '@preact/signals';
import { type Mesh, Plane, type Vector2, Vector3 } from 'three';
import type { App } from '../app';
import type { RequestOptions } from '../document/types';
import { register } from '../ui/commands';
import { Gumball, type Grip } from '../view/gumball';
import { dots, INK, moveSheet, sheet, together } from '../view/overlays';
import type { PointerTool, View } from '../view/scene';

type Place = [number, number, number];
export type Along = 'view' | 'normal' | 'x' | 'y' | 'z';

export interface Held {
  /** The mesh that it belongs to, as it was. */
  object: string;
  place: Place;
  normal: Place;
  moved: Uint32Array;
  fixed: Uint32Array;
  unit: string;
}

export interface Motion {
  translation: Place;
  /** Degrees about the normal where it was taken hold of. */
  angle: number;
}

const REST: Motion = { translation: [0, 0, 0], angle: 0 };

export class Bending implements PointerTool {
  readonly cursor = 'grab';
  readonly tool = signal<'pull' | 'look'>('pull');
  /** Of the part that moves as one, and of what moves along, in per cent of the diameter. */
  readonly radius = signal(6);
  readonly reach = signal(35);
  readonly energy = signal('total');
  readonly detail = signal('gauss-newton');
  readonly along = signal<Along>('view');
  readonly held = signal<Held | null>(null);
  readonly motion = signal<Motion>(REST);
  /** What is wrong with the place that was tried, in words. */
  readonly problem = signal<string | null>(null);
  /** The step that the held place has become, once it has moved. */
  readonly result = signal<string | null>(null);
  private mesh: Mesh | null = null;
  private drag: { pointer: number; plane: Plane; from: Vector3; before: Motion; grip: { grip: Grip; ball: Gumball; from: Vector2 } | null } | null = null;
  private pulling = false;
  private isCommitting = false;
  private hasMore = false;
  private wanted: Motion | null = null;
  private grabbing: Promise<void> | null = null;

  constructor(private app: App) {
    const here = () => app.room.value === 'process' && app.store.selectedObject.value?.kind === 'mesh';
    register(
      {
        id: 'hold-middle',
        title: 'Deform: take hold of what is in the middle of the view',
        keys: 'Shift+D',
        when: here,
        run: () => this.holdMiddle(),
      },
      { id: 'let-go', title: 'Deform: let go', keys: 'Shift+L', when: () => this.held.value !== null, run: () => this.letGo() },
    );
  }

  private get view(): View | null {
    return this.app.view;
  }

  /** What is held is let go where another object is selected, or the step was undone. */
  follow(): void {
    const held = this.held.peek();
    const result = this.result.peek();
    const { objects, selected } = this.app.store;
    if (!held || this.isCommitting) return;
    const entry = objects.value.find((one) => one.id === result);
    if (result && !entry) {
      this.result.value = null;
      this.motion.value = REST;
      this.showMarks();
    } else if (entry) {
      const moved = (entry.request?.moved as { translation: Place; angle: number }[] | undefined)?.[0];
      if (moved && !this.drag && !this.pulling) this.motion.value = { translation: moved.translation, angle: (moved.angle * 180) / Math.PI };
    }
    if (selected.value !== held.object && selected.value !== this.result.peek()) this.letGo();
  }

  letGo(): void {
    this.held.value = null;
    this.result.value = null;
    this.motion.value = REST;
    this.drag = null;
    this.endPreview();
    this.view?.overlay('handle', null);
  }

  async holdMiddle(): Promise<void> {
    const { view } = this;
    if (!view) return;
    const found = view.pickSurface(view.element.clientWidth / 2, view.element.clientHeight / 2);
    if (found) await this.hold(found.object, found.point, found.normal);
    else this.problem.value = 'There is no mesh in the middle of the view; turn the view so that the place to be held lies there.';
  }

  /** Takes hold of a place of a mesh. */
  async hold(object: string, point: Vector3, normal: Vector3): Promise<void> {
    const { store } = this.app;
    const { view } = this;
    const entry = store.objects.value.find((one) => one.id === object);
    const size = store.drawn.value.get(object)?.mesh?.diameter;
    if (!view || !entry || !size) return;
    this.letGo();
    const at = view.toModel(point);
    try {
      const { arrays } = await store.query({
        op: 'grab',
        object,
        at,
        radius: (this.radius.value / 100) * size,
        reach: (Math.max(this.reach.value, 1.05 * this.radius.value) / 100) * size,
        energy: this.energy.value,
      });
      if (store.selected.peek() !== object) store.selected.value = object;
      this.base = {
        positions: arrays.positions as Float32Array,
        normals: arrays.normals as Float32Array,
        triangles: arrays.triangles as Uint32Array,
        origin: store.drawn.value.get(object)?.origin ?? [0, 0, 0],
      };
      this.held.value = {
        object,
        place: at,
        normal: normal.toArray() as Place,
        moved: arrays.moved as Uint32Array,
        fixed: arrays.fixed as Uint32Array,
        unit: entry.unit,
      };
      this.problem.value = null;
      this.showMarks();
    } catch (error) {
      this.problem.value = error instanceof Error ? error.message : String(error);
    }
  }
  private base: { positions: Float32Array; normals: Float32Array; triangles: Uint32Array; origin: readonly number[] } | null = null;

  /** Another size of the same place. Not while something has come of it already. */
  async again(): Promise<void> {
    const held = this.held.value;
    if (!held || this.result.value || !this.view) return;
    await this.hold(held.object, this.view.fromModel(held.place), new Vector3(...held.normal));
  }

  // ---- pointers -----------------------------------------------------------------------------------------------------

  down(event: PointerEvent): boolean {
    const { view } = this;
    if (!view || this.drag || event.button !== 0 || event.shiftKey || !event.isPrimary) return false;
    const place = view.place(event);
    const held = this.held.value;
    if (held) {
      const isTouch = event.pointerType === 'touch';
      const ball = this.gumball(held);
      const grip = ball.gripAt(view, place, isTouch ? 24 : 10);
      if (grip || view.onScreen(ball.centre).distanceTo(place) < (isTouch ? 40 : 24)) {
        this.begin(event, undefined, grip ? { grip, ball, from: place } : null);
        return true;
      }
    }
    const found = view.pickSurface(place.x, place.y);
    if (!found) return false; // beside the mesh the view is turned
    this.grabbing = this.hold(found.object, found.point, found.normal).then(() => {
      this.grabbing = null;
    });
    this.begin(event, found.point);
    return true;
  }

  private begin(event: PointerEvent, at?: Vector3, grip: NonNullable<Bending['drag']>['grip'] = null): void {
    const { view } = this;
    if (!view) return;
    const held = this.held.value;
    const from = at ?? (held ? this.handleAt(held) : new Vector3());
    const sight = view.camera.camera.getWorldDirection(new Vector3());
    const plane = new Plane().setFromNormalAndCoplanarPoint(sight, from);
    this.drag = { pointer: event.pointerId, plane, from: from.clone(), before: at ? REST : this.motion.value, grip };
  }

  move(event: PointerEvent): void {
    const { view, drag } = this;
    if (!view || !drag || event.pointerId !== drag.pointer) return;
    const place = view.place(event);
    const held = this.held.value;
    if (!held) return;
    let way: Vector3 | null;
    if (drag.grip) {
      const { grip, ball, from } = drag.grip;
      const amount = ball.moved(view, grip, from, place);
      if (grip.kind === 'turn') return this.pull({ ...drag.before, angle: Math.round(drag.before.angle + (amount * 180) / Math.PI) });
      way = grip.axis.clone().multiplyScalar(amount);
    } else {
      way = view.ray(place.x, place.y).intersectPlane(drag.plane, new Vector3())?.sub(drag.from) ?? null;
      const along = this.direction(held);
      if (way && along) way.copy(along.multiplyScalar(way.dot(along)));
    }
    if (!way) return;
    const translation = drag.before.translation.map((x, i) => Number((x + way.getComponent(i)).toPrecision(6))) as Place;
    this.pull({ ...this.motion.value, translation });
  }

  up(event: PointerEvent): void {
    if (!this.drag || event.pointerId !== this.drag.pointer) return;
    const { before } = this.drag;
    this.drag = null;
    const finish = () => {
      const { translation, angle } = this.motion.value;
      if (angle !== before.angle || translation.some((x, i) => x !== before.translation[i])) void this.commit();
    };
    if (this.grabbing) void this.grabbing.then(finish);
    else finish();
  }

  cancel(): void {
    if (!this.drag) return;
    this.motion.value = this.drag.before;
    this.drag = null;
    this.endPreview();
    this.showMarks();
  }

  /** The direction that a drag is bound to; null: the plane that faces the viewer. */
  private direction(held: Held): Vector3 | null {
    const { value: along } = this.along;
    if (along === 'view') return null;
    if (along === 'normal') return new Vector3(...held.normal);
    return new Vector3(Number(along === 'x'), Number(along === 'y'), Number(along === 'z'));
  }
  /** As large as the handle asks, and never lost on a small one. */
  private gumball(held: Held): Gumball {
    const size = this.view?.size() ?? 1;
    return new Gumball(this.handleAt(held), new Vector3(...held.normal).normalize(), Math.max(0.16, (4 * this.radius.value) / 100) * size);
  }
  private handleAt(held: Held): Vector3 {
    return (this.view?.fromModel(held.place) ?? new Vector3()).add(new Vector3(...this.motion.value.translation));
  }

  // ---- preview and step -----------------------------------------------------------------------------------------------

  /** Shows the mesh with the handle moved so; of positions that come while the engine is at work the last counts. */
  pull(motion: Motion): void {
    this.motion.value = motion;
    this.wanted = motion;
    if (!this.pulling) void this.runPulls();
  }

  private async runPulls(): Promise<void> {
    const { store } = this.app;
    this.pulling = true;
    while (this.wanted) {
      const motion = this.wanted;
      this.wanted = null;
      const held = this.held.value;
      if (!held) break;
      try {
        const from = performance.now();
        const { arrays } = await store.query({ op: 'pull', ...this.motionOf(held, motion) });
        if (this.held.value !== held) break;
        this.showPreview(arrays.positions as Float32Array, arrays.normals as Float32Array);
        store.lastUpdate.value = { ms: performance.now() - from, coarse: true };
      } catch (error) {
        this.problem.value = error instanceof Error ? error.message : String(error);
      }
    }
    this.pulling = false;
  }

  private motionOf(held: Held, { translation, angle }: Motion) {
    return { translation, axis: held.normal, angle: (angle * Math.PI) / 180, about: held.place };
  }

  private showPreview(positions: Float32Array, normals: Float32Array): void {
    const { view, base } = this;
    if (!view || !base) return;
    if (this.mesh) moveSheet(this.mesh, positions, normals);
    else {
      this.mesh = sheet(positions, normals, base.triangles, view.fromModel(base.origin));
      view.overlay('bent', this.mesh);
      const hidden = [this.held.value?.object, this.result.value].filter((one): one is string => typeof one === 'string');
      view.veil(hidden);
    }
    base.positions = positions;
    this.showMarks();
  }
  private endPreview(): void {
    this.mesh = null;
    this.wanted = null;
    this.view?.overlay('bent', null);
    this.view?.veil([]);
  }

  /** The vertices that move as one, and the place to drag them by. */
  private showMarks(): void {
    const { view, base } = this;
    const held = this.held.value;
    if (!view || !held || !base) return;
    const points = [...held.moved].map((v) => new Vector3(...base.positions.subarray(3 * v, 3 * v + 3)));
    const origin = view.fromModel(base.origin);
    const ball = this.gumball(held);
    view.overlay('handle', together(origin, dots(points, INK.drawn, 4), ...ball.parts(origin), dots([ball.centre.clone().sub(origin)], INK.refused, 14)));
  }

  /** Numbers typed, or sliders moved: `rest` makes the step. */
  set(motion: Motion, rest: boolean): void {
    if (!this.held.value) return;
    this.pull(motion);
    if (rest) void this.commit();
  }

  /** The preview becomes a step, or changes the one that it became before. */
  async commit(): Promise<void> {
    const held = this.held.value;
    if (!held) return;
    this.hasMore = true;
    if (this.isCommitting) return; // what is being made is made again with it
    this.isCommitting = true;
    try {
      while (this.hasMore && this.held.value === held) {
        this.hasMore = false;
        await this.makeStep(held);
      }
    } finally {
      this.isCommitting = false;
    }
    this.follow();
  }

  private async makeStep(held: Held): Promise<void> {
    const { store } = this.app;
    const request = this.requestOf(held);
    const known = store.objects.value.find((one) => one.id === this.result.value);
    let id = known?.id ?? null;
    if (known) {
      if (!(await store.edit({ op: 'request', object: known.id, request }))) return;
    } else {
      const source = store.objects.value.find((one) => one.id === held.object);
      id = await store.derive(held.object, `${source?.name ?? 'mesh'} bent`, request);
      this.result.value = id;
    }
    if (!id) return;
    store.selected.value = id;
    if (!(await store.show(id)) && !known) {
      await store.edit({ op: 'undo' }); // nothing came of it; its sentence is told
      this.result.value = null;
    }
    await store.showAll();
    if (!this.drag) this.endPreview();
  }

  private requestOf(held: Held): RequestOptions {
    return {
      kind: 'deform',
      energy: this.energy.value,
      detail: this.detail.value,
      fixed: Array.from(held.fixed),
      moved: [{ vertices: Array.from(held.moved), ...this.motionOf(held, this.motion.value) }],
    };
  }
}

/** What a deformation is told by as a file of `batten deform --handles`. */
export function handlesFile(request: RequestOptions): string {
  const moved = request.moved as { vertices: number[]; translation: Place; axis: Place; angle: number; about: Place }[];
  return JSON.stringify({
    fixed: { vertices: request.fixed },
    handles: moved.map((one) => ({
      select: { vertices: one.vertices },
      translate: one.translation,
      rotate_deg: [...one.axis, (one.angle * 180) / Math.PI],
      about: one.about,
    })),
  });
}

let made: Bending | null = null;
/** The one of the page. */
export function bendingOf(app: App): Bending {
  made ??= new Bending(app);
  return made;
}
