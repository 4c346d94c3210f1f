import { PerspectiveCamera, Raycaster, Vector2, Vector3 } from 'three';
import { expect, it } from 'vitest';
import { Gumball } from '../../src/view/gumball';
import type { View } from '../../src/view/scene';

/** What a gumball asks of the view: 800 × 600 pixels, seen from above at an angle. */
function viewFrom(x: number, y: number, z: number): View {
  const camera = new PerspectiveCamera(30, 800 / 600, 0.1, 100);
  camera.up.set(0, 0, 1);
  camera.position.set(x, y, z);
  camera.lookAt(0, 0, 0);
  camera.updateMatrixWorld();
  return {
    camera: { camera },
    onScreen: (point: Vector3) => {
      const at = point.clone().project(camera);
      return new Vector2(((at.x + 1) / 2) * 800, ((1 - at.y) / 2) * 600);
    },
    ray: (x: number, y: number) => {
      const caster = new Raycaster();
      caster.setFromCamera(new Vector2((2 * x) / 800 - 1, 1 - (2 * y) / 600), camera);
      return caster.ray;
    },
  } as unknown as View;
}

it('an arrow moves along its axis as far as the pointer, the ring turns by the angle', () => {
  const centre = new Vector3(0.2, -0.1, 0.3);
  const turn = new Vector3(0.3, 0.2, 0.9).normalize();
  for (const view of [viewFrom(4, -5, 3), viewFrom(-3, -4, 4), viewFrom(1, 6, 2)]) {
    const ball = new Gumball(centre, turn, 0.8);
    for (const axis of [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)]) {
      const tip = centre.clone().addScaledVector(axis, 0.8);
      const grip = ball.gripAt(view, view.onScreen(tip), 10);
      expect(grip).toMatchObject({ kind: 'move', axis });
      for (const way of [0.5, -1.1])
        expect(ball.moved(view, grip as NonNullable<typeof grip>, view.onScreen(tip), view.onScreen(tip.clone().addScaledVector(axis, way)))).toBeCloseTo(way, 9);
    }
    const spoke = new Vector3(1, 0, 0).cross(turn).normalize().multiplyScalar(0.64);
    // Where no arrow is nearer.
    const at = (angle: number) => centre.clone().add(spoke.clone().applyAxisAngle(turn, angle));
    const start = [0.4, 1.1, 2, 3.5, 4.4].find((angle) => ball.gripAt(view, view.onScreen(at(angle)), 10)?.kind === 'turn') ?? Number.NaN;
    const ring = ball.gripAt(view, view.onScreen(at(start)), 10);
    for (const angle of [0.7, -1.3])
      expect(ball.moved(view, ring as NonNullable<typeof ring>, view.onScreen(at(start)), view.onScreen(at(start + angle)))).toBeCloseTo(angle, 9);
  }
});

it('is not taken hold of beside it', () => {
  const view = viewFrom(4, -5, 3);
  const ball = new Gumball(new Vector3(), new Vector3(0, 0, 1), 0.5);
  expect(ball.gripAt(view, new Vector2(20, 20), 10)).toBeNull();
  expect(ball.gripAt(view, view.onScreen(new Vector3()), 6)).toBeNull(); // the middle moves freely
});
