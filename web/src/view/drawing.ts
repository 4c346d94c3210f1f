/**
 * Strokes in space from a mouse, a finger or a pen: where a stroke begins and ends near curves it lies in the plane
 * through both places that faces the viewer most; else on the surface under it, or on the chosen plane.
 */
import { Plane, Vector3 } from 'three';
import { highlight, stroke as strokeLine } from './overlays';
import type { PointerTool, View } from './scene';

export type Ground = 'plane' | 'surface';
export type Axis = 'x' | 'y' | 'z';

/** How near a curve an end has to be to be meant for it, in pixels: a finger is wider than a cursor. */
const REACH = { mouse: 14, pen: 14, touch: 26 };
/** Samples nearer than this to the one before say nothing. */
const LEAST_STEP = 1.5;

export interface Stroke {
  /** In the coordinates of the model. */
  points: [number, number, number][];
}

interface Sample {
  x: number;
  y: number;
}

export class Drawing implements PointerTool {
  readonly cursor = 'crosshair';
  ground: Ground = 'plane';
  axis: Axis = 'z';
  offset = 0;
  onStroke: (stroke: Stroke) => void = () => {};
  /** What a click without a stroke meets. */
  onPick: (curve: { object: string; curve: number; index: number } | null) => void = () => {};
  /** What a stroke is as far as it was drawn, and null when there is none any more. */
  onPreview: (stroke: Stroke | null) => void = () => {};
  /** Strokes that are no curves yet and can be met all the same. */
  loose: { name: string; points: Vector3[] }[] = [];
  private samples: Sample[] = [];
  private pointer: number | null = null;
  private reach = REACH.mouse;

  constructor(private view: View) {}

  /** Whether a pointer draws. Buttons other than the first, shift, and a second finger steer the view. */
  down(event: PointerEvent): boolean {
    if (this.pointer !== null && event.pointerId !== this.pointer) {
      this.cancel();
      return false;
    }
    if (event.button !== 0 || event.shiftKey || !event.isPrimary) return false;
    this.pointer = event.pointerId;
    this.reach = REACH[event.pointerType as keyof typeof REACH] ?? REACH.mouse;
    this.samples = [this.view.place(event)];
    return true;
  }

  move(event: PointerEvent): void {
    if (event.pointerId !== this.pointer) {
      if (event.pointerType === 'mouse' && event.buttons === 0) {
        const place = this.view.place(event);
        highlight(this.view, this.nearest(place.x, place.y, REACH.mouse)?.point ?? null);
      }
      return;
    }
    for (const one of event.getCoalescedEvents?.().length ? event.getCoalescedEvents() : [event]) {
      const place = this.view.place(one);
      const last = this.samples[this.samples.length - 1];
      if (!last || Math.hypot(place.x - last.x, place.y - last.y) >= LEAST_STEP) this.samples.push(place);
    }
    const stroke = this.inSpace();
    strokeLine(this.view, stroke.points);
    this.onPreview(stroke);
  }

  up(event: PointerEvent): void {
    if (event.pointerId !== this.pointer) return;
    const { samples } = this;
    const first = samples[0];
    const isClick = samples.every((one) => first && Math.hypot(one.x - first.x, one.y - first.y) < 5);
    const stroke = this.inSpace();
    this.pointer = null;
    this.samples = [];
    if (isClick && first) {
      strokeLine(this.view, null);
      this.onPreview(null);
      const found = this.view.nearestCurve(first.x, first.y, this.reach);
      this.onPick(found);
    } else {
      this.onStroke(stroke);
    }
  }

  isDrawing(): boolean {
    return this.pointer !== null;
  }

  cancel(): void {
    if (this.pointer !== null) {
      strokeLine(this.view, null);
      this.onPreview(null);
    }
    this.pointer = null;
    this.samples = [];
    highlight(this.view, null);
  }

  /** The curve or loose stroke that passes nearest to a pixel. */
  private nearest(x: number, y: number, within: number): { point: Vector3; distance: number } | null {
    let best: { point: Vector3; distance: number } | null = this.view.nearestCurve(x, y, within);
    for (const { points } of this.loose)
      for (const point of points) {
        const at = this.view.onScreen(point);
        const distance = Math.hypot(at.x - x, at.y - y);
        if (distance < (best?.distance ?? within)) best = { point, distance };
      }
    return best;
  }

  /** The samples as a stroke in the coordinates of the model. */
  private inSpace(): Stroke {
    const { view, samples } = this;
    const [first, last] = [samples[0], samples[samples.length - 1]];
    if (!first || !last) return { points: [] };
    const from = this.nearest(first.x, first.y, this.reach);
    const to = samples.length > 2 ? this.nearest(last.x, last.y, this.reach) : null;
    let points: Vector3[];
    if (from && to && from.point.distanceTo(to.point) > 1e-9 * view.size()) {
      points = this.onPlane(this.planeThrough(from.point, to.point));
      // The ends are those of the curves, not of the hand.
      if (points.length > 1) points = [from.point, ...points.slice(1, -1), to.point];
    } else if (this.ground === 'surface') {
      points = samples.flatMap((one) => view.pick(one.x, one.y) ?? []);
    } else {
      points = this.onPlane(this.groundPlane());
    }
    return { points: points.map((point) => view.toModel(point)) };
  }

  /** Through two places, as square to the line of sight as it can be. */
  private planeThrough(a: Vector3, b: Vector3): Plane {
    const along = b.clone().sub(a).normalize();
    const sight = this.view.camera.camera.getWorldDirection(new Vector3());
    const normal = sight.clone().addScaledVector(along, -sight.dot(along));
    // Looked at along the line between the places every plane through it is a line: take the upright one.
    if (normal.length() < 0.05) normal.crossVectors(along, new Vector3(0, 0, 1));
    return new Plane().setFromNormalAndCoplanarPoint(normal.normalize(), a);
  }

  groundPlane(): Plane {
    const normal = new Vector3(Number(this.axis === 'x'), Number(this.axis === 'y'), Number(this.axis === 'z'));
    const [x, y, z] = this.view.middle();
    return new Plane().setFromNormalAndCoplanarPoint(normal, new Vector3(-x, -y, -z).addScaledVector(normal, this.offset));
  }

  private onPlane(plane: Plane): Vector3[] {
    const points: Vector3[] = [];
    for (const one of this.samples) {
      const point = this.view.ray(one.x, one.y).intersectPlane(plane, new Vector3());
      if (point && point.distanceTo(this.view.camera.target) < 50 * this.view.size()) points.push(point);
    }
    return points;
  }
}
