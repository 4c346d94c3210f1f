/**
 * The camera of a CAD user: turns about the point under the cursor, zooms to it, pans, six views and fit. One finger
 * turns, two pan and pinch. The horizon stays level.
 */
import { MathUtils, Matrix4, PerspectiveCamera, Vector2, Vector3 } from 'three';

export type NamedView = 'front' | 'back' | 'left' | 'right' | 'top' | 'bottom' | 'home';

// As `batten render` looks at things when it is not told.
const HOME = { azimuth: MathUtils.degToRad(-55), elevation: MathUtils.degToRad(28) };
const VIEWS: Record<NamedView, { azimuth: number; elevation: number }> = {
  home: HOME,
  front: { azimuth: -Math.PI / 2, elevation: 0 },
  back: { azimuth: Math.PI / 2, elevation: 0 },
  right: { azimuth: 0, elevation: 0 },
  left: { azimuth: Math.PI, elevation: 0 },
  top: { azimuth: -Math.PI / 2, elevation: Math.PI / 2 },
  bottom: { azimuth: -Math.PI / 2, elevation: -Math.PI / 2 },
};

const TURN_PER_PIXEL = 0.008;
const ZOOM_PER_LINE = 0.0015;

export class ViewCamera {
  readonly camera = new PerspectiveCamera(30, 1, 0.01, 100);
  azimuth = HOME.azimuth;
  elevation = HOME.elevation;
  readonly target = new Vector3();
  distance = 3;
  /** Asked first about every pointer that goes down; true: it is not for the camera. */
  intercept: (event: PointerEvent) => boolean = () => false;
  private radius = 1;

  /** @param pick the point of the scene under a pixel, or null. @param changed is called to draw again. */
  constructor(
    private element: HTMLElement,
    private pick: (x: number, y: number) => Vector3 | null,
    private changed: () => void,
  ) {
    this.listen();
    this.apply();
  }

  /** Shows a ball whole. */
  fit(centre: Vector3, radius: number): void {
    this.target.copy(centre);
    this.radius = Math.max(radius, 1e-12);
    const half = MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    this.distance = (1.02 * this.radius) / Math.sin(narrow);
    this.apply();
  }

  look(view: NamedView): void {
    ({ azimuth: this.azimuth, elevation: this.elevation } = VIEWS[view]);
    this.apply();
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  /** Turns about a point, which stays where it is on the screen. */
  turn(dx: number, dy: number, about: Vector3 = this.target): void {
    const before = this.frame();
    this.azimuth -= dx * TURN_PER_PIXEL;
    this.elevation = MathUtils.clamp(this.elevation + dy * TURN_PER_PIXEL, -Math.PI / 2, Math.PI / 2);
    const local = about.clone().sub(this.target).applyMatrix4(before.transpose());
    this.target.copy(about).sub(local.applyMatrix4(this.frame()));
    this.apply();
  }

  pan(dx: number, dy: number): void {
    const perPixel = (2 * this.distance * Math.tan(MathUtils.degToRad(this.camera.fov / 2))) / this.element.clientHeight;
    this.target.add(new Vector3(-dx * perPixel, dy * perPixel, 0).applyMatrix4(this.frame()));
    this.apply();
  }

  /** @param factor below 1 goes nearer. The point stays where it is on the screen. */
  zoom(factor: number, to: Vector3 = this.target): void {
    const bounded = MathUtils.clamp(this.distance * factor, 1e-3 * this.radius, 1e3 * this.radius);
    const used = bounded / this.distance;
    this.target.lerp(to, 1 - used);
    this.distance = bounded;
    this.apply();
  }

  /** Columns: right, up, towards the viewer; z is up in the world. */
  private frame(): Matrix4 {
    const { azimuth: a, elevation: e } = this;
    const back = new Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    const right = new Vector3(-Math.sin(a), Math.cos(a), 0);
    return new Matrix4().makeBasis(right, back.clone().cross(right), back);
  }

  private apply(): void {
    const frame = this.frame();
    const back = new Vector3().setFromMatrixColumn(frame, 2);
    this.camera.position.copy(this.target).addScaledVector(back, this.distance);
    this.camera.quaternion.setFromRotationMatrix(frame);
    this.camera.near = Math.max(this.distance - 6 * this.radius, 1e-3 * this.distance);
    this.camera.far = this.distance + 6 * this.radius;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.changed();
  }

  private listen(): void {
    const pointers = new Map<number, Vector2>();
    let about: Vector3 | null = null;
    const at = (event: PointerEvent | WheelEvent) => {
      const box = this.element.getBoundingClientRect();
      return new Vector2(event.clientX - box.left, event.clientY - box.top);
    };
    this.element.addEventListener('contextmenu', (event) => event.preventDefault());
    this.element.addEventListener('pointerdown', (event) => {
      this.element.setPointerCapture(event.pointerId);
      if (this.intercept(event)) return;
      const place = at(event);
      pointers.set(event.pointerId, place);
      about = pointers.size === 1 ? (this.pick(place.x, place.y) ?? this.target.clone()) : null;
    });
    this.element.addEventListener('pointermove', (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const place = at(event);
      const others = [...pointers.entries()].filter(([id]) => id !== event.pointerId).map(([, point]) => point);
      pointers.set(event.pointerId, place);
      const other = others[0];
      if (other) {
        // Two fingers: half of what each moves pans, and what they move apart zooms.
        this.pan((place.x - before.x) / 2, (place.y - before.y) / 2);
        const apart = place.distanceTo(other);
        if (apart > 1) this.zoom(before.distanceTo(other) / apart);
      } else if (event.buttons & 6 || event.shiftKey) {
        // The middle button turns for those who come from CAD, unless shift pans; the right one pans.
        if (event.buttons & 4 && !event.shiftKey) this.turn(place.x - before.x, place.y - before.y, about ?? this.target);
        else this.pan(place.x - before.x, place.y - before.y);
      } else {
        this.turn(place.x - before.x, place.y - before.y, about ?? this.target);
      }
    });
    const release = (event: PointerEvent) => {
      pointers.delete(event.pointerId);
      about = null;
    };
    this.element.addEventListener('pointerup', release);
    this.element.addEventListener('pointercancel', release);
    this.element.addEventListener(
      'wheel',
      (event) => {
        event.preventDefault();
        const lines = event.deltaMode === 1 ? event.deltaY * 16 : event.deltaY;
        const place = at(event);
        this.zoom(Math.exp(lines * ZOOM_PER_LINE), this.pick(place.x, place.y) ?? this.target);
      },
      { passive: false },
    );
    this.element.addEventListener('keydown', (event) => {
      const step = 12;
      const moves: Record<string, [number, number]> = {
        ArrowLeft: [-step, 0],
        ArrowRight: [step, 0],
        ArrowUp: [0, -step],
        ArrowDown: [0, step],
      };
      const move = moves[event.key];
      if (move && !event.ctrlKey && !event.altKey && !event.metaKey) {
        event.preventDefault();
        if (event.shiftKey) this.pan(move[0], move[1]);
        else this.turn(move[0], move[1]);
      } else if (event.key === '+' || event.key === '=') this.zoom(0.9);
      else if (event.key === '-') this.zoom(1 / 0.9);
    });
  }
}
