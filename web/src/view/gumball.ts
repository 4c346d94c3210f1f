/** Arrows to move something along and a ring to turn it by, at a place in the view: what users of CAD call a gumball. */
import { type LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { type Points, Vector2, Vector3 } from 'three';
import { dots, segments } from './overlays';
import type { View } from './scene';

export interface Grip {
  kind: 'move' | 'turn';
  /** Unit length: moved along, or turned about by the right hand. */
  axis: Vector3;
}

/** Red, green and blue for x, y and z, as everywhere. */
const COLOURS = [0xc8372d, 0x2e8b57, 0x2f62c9];
const RING = 0x8a5a00;
const N_RING = 64;
/** Arrows begin outside the handle itself, which moves freely. */
const BEGIN = 0.3;

export class Gumball {
  private readonly axes = [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)];

  /** @param turn the axis of the ring. @param size of arrows and ring. */
  constructor(
    readonly centre: Vector3,
    private turn: Vector3,
    private size: number,
  ) {}

  private ring(): Vector3[] {
    const first = new Vector3(Math.abs(this.turn.x) < 0.9 ? 1 : 0, Math.abs(this.turn.x) < 0.9 ? 0 : 1, 0).cross(this.turn).normalize();
    const second = this.turn.clone().cross(first);
    return Array.from({ length: N_RING + 1 }, (_, i) => {
      const t = (2 * Math.PI * i) / N_RING;
      return this.centre.clone().addScaledVector(first, 0.8 * this.size * Math.cos(t)).addScaledVector(second, 0.8 * this.size * Math.sin(t));
    });
  }

  /** What is drawn, in coordinates less `origin`. */
  parts(origin: Vector3): (LineSegments2 | Points)[] {
    const at = (point: Vector3) => point.clone().sub(origin).toArray();
    const tip = (axis: Vector3, t: number) => this.centre.clone().addScaledVector(axis, t * this.size);
    const ring = this.ring();
    return [
      ...this.axes.flatMap((axis, k) => {
        const color = COLOURS[k] ?? 0;
        return [
          segments(new Float32Array([...at(tip(axis, BEGIN)), ...at(tip(axis, 1))]), color, 3, false),
          dots([tip(axis, 1).sub(origin)], color, 9),
        ];
      }),
      segments(new Float32Array(ring.slice(1).flatMap((point, i) => [...at(ring[i] ?? point), ...at(point)])), RING, 3, false),
    ];
  }

  /** What is taken hold of at a pixel, within so many of them. */
  gripAt(view: View, place: Vector2, within: number): Grip | null {
    let best = within;
    let found: Grip | null = null;
    const near = (point: Vector3, grip: Grip) => {
      const distance = view.onScreen(point).distanceTo(place);
      if (distance < best) {
        best = distance;
        found = grip;
      }
    };
    for (const axis of this.axes)
      for (let t = BEGIN; t <= 1.001; t += 0.05) near(this.centre.clone().addScaledVector(axis, t * this.size), { kind: 'move', axis });
    for (const point of this.ring()) near(point, { kind: 'turn', axis: this.turn });
    return found;
  }

  /** How far along its axis, or by what angle in radians, a pointer has moved from one place to another. */
  moved(view: View, grip: Grip, from: Vector2, to: Vector2): number {
    const sight = view.camera.camera.getWorldDirection(new Vector3());
    // Along an arrow: in the plane through it that faces the viewer most.
    const normal = grip.kind === 'turn' ? grip.axis : sight.clone().addScaledVector(grip.axis, -sight.dot(grip.axis));
    const [a, b] = [from, to].map((pixel) => {
      const { origin, direction } = view.ray(pixel.x, pixel.y);
      const t = this.centre.clone().sub(origin).dot(normal) / (direction.dot(normal) || 1e-12);
      return origin.clone().addScaledVector(direction, t).sub(this.centre);
    }) as [Vector3, Vector3];
    if (grip.kind === 'move') return b.sub(a).dot(grip.axis);
    return Math.atan2(a.clone().cross(b).dot(grip.axis), a.dot(b));
  }
}
