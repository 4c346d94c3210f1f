/** The one view: draws what it is given, when something has changed. Knows no room and no engine. */
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DynamicDrawUsage,
  Group,
  Mesh,
  Points,
  PointsMaterial,
  type Object3D,
  type Ray,
  Raycaster,
  Scene,
  type ShaderMaterial,
  Sphere,
  type Texture,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { CurveVerdict, Drawn, Values } from '../document/types';
import { type NamedView, ViewCamera } from './camera';
import { colourTexture, type Shading, setShading, surfaceMaterial } from './materials';

const CURVE = 0x1c4a86;
const BORDER = 0xc25a1c;
const SHARP = 0x2b2f36;
const FAILS = 0xd2342e;
const PASSES = 0x2e8b57;
/** Pixels. */
const LINE_WIDTH = 2;

interface Shown {
  drawn: Drawn;
  group: Group;
  mesh: Mesh<BufferGeometry, ShaderMaterial> | null;
  lines: LineSegments2 | null;
  nodes: Points | null;
  isWire: boolean;
}

export interface Look {
  shading: Shading;
  stripes: number;
  flat: boolean;
  curves: boolean;
  nodes: boolean;
}

/** What a pointer does while it is down, where it does not steer the view. */
export interface PointerTool {
  cursor: string;
  /** Whether the pointer is this tool's. */
  down(event: PointerEvent): boolean;
  move(event: PointerEvent): void;
  up(event: PointerEvent): void;
  cancel(): void;
}

/** Two objects side by side in one picture: what is left of a line, a share of the width, shows one, what is right the other. */
export interface Divider {
  left: string;
  right: string;
  at: number;
}

export class View {
  readonly renderer: WebGLRenderer;
  readonly camera: ViewCamera;
  private scene = new Scene();
  private shown = new Map<string, Shown>();
  private origin: [number, number, number] | null = null;
  private pinned: Points | null = null;
  private overlays = new Map<string, Object3D>();
  private veiled = new Set<string>();
  /** What pointers do beside steering the view. */
  private tool: PointerTool | null = null;
  /** Called after every picture, for what is drawn over it. */
  readonly onDrawn = new Set<() => void>();
  divider: Divider | null = null;
  private emptySize = 1;
  private asked = false;
  private look: Look = { shading: 'shaded', stripes: 28, flat: false, curves: true, nodes: true };
  private values: Values | null = null;
  private textures: { sequential: Texture; diverging: Texture } | null = null;

  constructor(readonly element: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    // Focus belongs to the element around it, which has a name.
    this.renderer.domElement.setAttribute('aria-hidden', 'true');
    element.append(this.renderer.domElement);
    this.camera = new ViewCamera(element, (x, y) => this.pick(x, y), () => this.draw());
    this.camera.intercept = (event) => this.tool?.down(event) ?? false;
    element.addEventListener('pointermove', (event) => this.tool?.move(event));
    element.addEventListener('pointerup', (event) => this.tool?.up(event));
    element.addEventListener('pointercancel', () => this.tool?.cancel());
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
  }

  setColours(sequential: Float32Array, diverging: Float32Array): void {
    this.textures = { sequential: colourTexture(sequential), diverging: colourTexture(diverging) };
    this.draw();
  }

  /** Shows these objects and no others. */
  setObjects(list: Drawn[]): void {
    const wanted = new Set(list.map((one) => one.id));
    for (const [id, old] of this.shown)
      if (!wanted.has(id)) {
        this.dispose(old);
        this.shown.delete(id);
      }
    const first = this.shown.size === 0;
    for (const drawn of list) {
      const old = this.shown.get(drawn.id);
      if (old?.drawn === drawn) continue;
      // The first object says where the middle is; all others stand where they are beside it.
      this.origin ??= drawn.origin;
      if (old && this.update(old, drawn)) continue;
      if (old) this.dispose(old);
      this.shown.set(drawn.id, this.build(drawn));
    }
    if (this.shown.size === 0 && list.length === 0) this.origin = null;
    this.applyLook();
    if (first && this.shown.size > 0) this.fit();
    this.draw();
  }

  setLook(look: Look): void {
    this.look = look;
    this.applyLook();
    this.draw();
  }

  setValues(values: Values | null): void {
    this.values = values;
    this.applyLook();
    this.draw();
  }

  /** Colours the curves of an object by what was measured along them. */
  setVerdicts(id: string | null, curves: CurveVerdict[]): void {
    for (const [key, shown] of this.shown) {
      if (!shown.lines) continue;
      shown.lines.geometry.setColors(
        lineColours(shown.drawn, (c) => {
          const verdict = key === id ? curves[c]?.verdict : undefined;
          return verdict === 'fail' ? FAILS : verdict === 'pass' ? PASSES : null;
        }),
      );
    }
    this.draw();
  }

  /** Marks a place of an object, in its drawn coordinates; null takes the mark away. */
  setPin(id: string, at: [number, number, number] | null): void {
    if (this.pinned) {
      this.scene.remove(this.pinned);
      this.pinned.geometry.dispose();
      this.pinned = null;
    }
    const shown = this.shown.get(id);
    if (at && shown) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(new Float32Array(at), 3));
      this.pinned = new Points(geometry, new PointsMaterial({ color: FAILS, size: 14, sizeAttenuation: false, depthTest: false }));
      this.pinned.position.copy(shown.group.position);
      this.scene.add(this.pinned);
      this.camera.target.set(...at).add(shown.group.position);
      this.camera.zoom(1);
    }
    this.draw();
  }

  // ---- drawing on it ----------------------------------------------------------------------------------------------

  /** The tool that has the pointers from now on; null: the view alone. */
  setTool(tool: PointerTool | null): void {
    if (this.tool === tool) return;
    this.tool?.cancel();
    this.tool = tool;
    this.element.style.cursor = tool?.cursor ?? '';
  }

  /** Something drawn beside the objects, by its name, in coordinates less middle(); null takes it away. */
  overlay(name: string, object: Object3D | null): void {
    const old = this.overlays.get(name);
    if (!old && !object) return;
    if (old) {
      this.scene.remove(old);
      old.traverse((one) => {
        (one as Partial<Mesh>).geometry?.dispose(); // not the material: its program would be compiled again for the next
      });
      this.overlays.delete(name);
    }
    if (object) {
      this.overlays.set(name, object);
      this.scene.add(object);
    }
    this.draw();
  }

  /** Objects that are there and not drawn, while something stands in their place. */
  veil(ids: readonly string[]): void {
    this.veiled = new Set(ids);
    for (const [id, { group }] of this.shown) group.visible = !this.veiled.has(id);
    this.draw();
  }

  setDivider(divider: Divider | null): void {
    this.divider = divider;
    this.draw();
  }
  /** The object that a divider hides at a pixel. */
  private hiddenAt(x: number): string | null {
    if (!this.divider) return null;
    return x < this.divider.at * this.element.clientWidth ? this.divider.right : this.divider.left;
  }

  /** Where a point less middle() is seen, in pixels. */
  onScreen(point: Vector3): Vector2 {
    const at = point.clone().project(this.camera.camera);
    return new Vector2(((at.x + 1) / 2) * this.element.clientWidth, ((1 - at.y) / 2) * this.element.clientHeight);
  }

  /** Where a pointer is, in pixels of the view. */
  place(event: { clientX: number; clientY: number }): Vector2 {
    const box = this.element.getBoundingClientRect();
    return new Vector2(event.clientX - box.left, event.clientY - box.top);
  }

  ray(x: number, y: number): Ray {
    const caster = new Raycaster();
    caster.setFromCamera(
      new Vector2((2 * x) / this.element.clientWidth - 1, 1 - (2 * y) / this.element.clientHeight),
      this.camera.camera,
    );
    return caster.ray;
  }

  /** What the view subtracts from coordinates of models. */
  middle(): [number, number, number] {
    return this.origin ?? [0, 0, 0];
  }
  toModel(point: Vector3): [number, number, number] {
    const [x, y, z] = this.middle();
    return [point.x + x, point.y + y, point.z + z];
  }
  fromModel(point: readonly number[]): Vector3 {
    const [x, y, z] = this.middle();
    return new Vector3((point[0] ?? 0) - x, (point[1] ?? 0) - y, (point[2] ?? 0) - z);
  }
  /** Of what is shown: the radius of the ball around it. */
  size(): number {
    return this.shown.size > 0 ? this.bounds().radius || 1 : this.emptySize;
  }
  /** How much is seen while nothing is there. */
  setEmptySize(size: number): void {
    this.emptySize = size;
    if (this.shown.size === 0) this.fit();
  }

  /** The curve that passes nearest to a pixel, within a distance in pixels; its nearest place there. */
  nearestCurve(
    x: number,
    y: number,
    within: number,
  ): { object: string; curve: number; index: number; name: string; point: Vector3; distance: number } | null {
    let best = within;
    let found: ReturnType<View['nearestCurve']> = null;
    const { clientWidth: width, clientHeight: height } = this.element;
    const at = new Vector3();
    for (const [object, { drawn, group }] of this.shown) {
      if (!drawn.network) continue;
      const { positions, vertices } = drawn.network;
      drawn.curves.forEach((curve, index) => {
        let before: { x: number; y: number; point: Vector3 } | null = null;
        for (let i = curve.first; i < curve.first + curve.n; ++i) {
          const v = vertices[i] ?? 0;
          const point = new Vector3(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]).add(group.position);
          at.copy(point).project(this.camera.camera);
          const here = { x: ((at.x + 1) / 2) * width, y: ((1 - at.y) / 2) * height, point };
          if (before) {
            const dx = here.x - before.x;
            const dy = here.y - before.y;
            const t = Math.min(1, Math.max(0, ((x - before.x) * dx + (y - before.y) * dy) / (dx * dx + dy * dy || 1)));
            const distance = Math.hypot(before.x + t * dx - x, before.y + t * dy - y);
            if (distance < best) {
              best = distance;
              found = { object, curve: curve.curve ?? -1, index, name: curve.name, point: before.point.clone().lerp(point, t), distance };
            }
          }
          before = here;
        }
      });
    }
    return found;
  }

  fit(): void {
    const ball = this.bounds();
    this.camera.fit(ball.center, ball.radius || 1);
  }

  lookFrom(view: NamedView): void {
    this.camera.look(view);
    this.fit();
  }

  /** The picture as it is seen, as a PNG. */
  picture(): Promise<Blob | null> {
    this.renderNow();
    return new Promise((resolve) => this.renderer.domElement.toBlob(resolve, 'image/png'));
  }

  // ---- inside -----------------------------------------------------------------------------------------------------

  private build(drawn: Drawn): Shown {
    const group = new Group();
    const origin = this.origin ?? drawn.origin;
    group.position.set(drawn.origin[0] - origin[0], drawn.origin[1] - origin[1], drawn.origin[2] - origin[2]);
    const shown: Shown = { drawn, group, mesh: null, lines: null, nodes: null, isWire: false };
    if (drawn.positions && drawn.triangles && drawn.normals) {
      shown.mesh = new Mesh(surfaceGeometry(drawn), surfaceMaterial());
      group.add(shown.mesh);
    }
    if (drawn.network) {
      const lines = new LineSegmentsGeometry();
      lines.setPositions(linePositions(drawn));
      lines.setColors(lineColours(drawn));
      shown.lines = new LineSegments2(lines, new LineMaterial({ vertexColors: true, linewidth: LINE_WIDTH }));
      group.add(shown.lines);
      const nodes = new BufferGeometry();
      nodes.setAttribute('position', new BufferAttribute(nodePositions(drawn), 3));
      shown.nodes = new Points(nodes, new PointsMaterial({ color: SHARP, size: 5, sizeAttenuation: false }));
      group.add(shown.nodes);
    }
    group.visible = !this.veiled.has(drawn.id);
    this.scene.add(group);
    return shown;
  }

  /** New positions for the same triangles, in place. @returns false where it has to be built anew. */
  private update(shown: Shown, drawn: Drawn): boolean {
    const before = shown.drawn;
    if (!shown.mesh || shown.isWire || !drawn.positions || !drawn.normals) return false;
    if (drawn.triangles !== before.triangles) return false;
    if (before.positions?.length !== drawn.positions.length || !shown.lines || !drawn.network) return false;
    if (before.network?.vertices.length !== drawn.network.vertices.length) return false;
    const set = (geometry: BufferGeometry, name: string, array: Float32Array) => {
      const attribute = geometry.getAttribute(name) as BufferAttribute;
      attribute.array = array; // handed over: nobody writes into what the engine has sent
      attribute.needsUpdate = true;
    };
    set(shown.mesh.geometry, 'position', drawn.positions);
    set(shown.mesh.geometry, 'normal', drawn.normals);
    shown.lines.geometry.setPositions(linePositions(drawn));
    if (shown.nodes) set(shown.nodes.geometry, 'position', nodePositions(drawn));
    shown.mesh.geometry.boundingSphere = null;
    const origin = this.origin ?? drawn.origin;
    shown.group.position.set(drawn.origin[0] - origin[0], drawn.origin[1] - origin[1], drawn.origin[2] - origin[2]);
    shown.drawn = drawn;
    return true;
  }

  private applyLook(): void {
    for (const [id, shown] of this.shown) {
      if (shown.lines) shown.lines.visible = this.look.curves;
      if (shown.nodes) shown.nodes.visible = this.look.curves && this.look.nodes;
      if (!shown.mesh) continue;
      const uniforms = shown.mesh.material.uniforms;
      const values = this.values?.object === id ? this.values : null;
      const fits = values && shown.drawn.positions && 3 * values.values.length === shown.drawn.positions.length;
      const shading = this.look.shading === 'values' && !fits ? 'shaded' : this.look.shading;
      setShading(shown.mesh.material, shading);
      this.setWire(shown, shading === 'wireframe');
      const set = (name: string, value: unknown) => {
        const uniform = uniforms[name];
        if (uniform) uniform.value = value;
      };
      set('stripes', this.look.stripes);
      set('flatShaded', this.look.flat);
      if (values && fits) {
        shown.mesh.geometry.setAttribute('value', new BufferAttribute(values.values, 1));
        set('low', values.low);
        set('high', values.high);
        set('colours', values.low < 0 ? this.textures?.diverging : this.textures?.sequential);
      }
    }
  }

  /** Lines of triangles are drawn by corners, which asks for vertices of their own for every triangle. */
  private setWire(shown: Shown, isWire: boolean): void {
    if (!shown.mesh || shown.isWire === isWire) return;
    const indexed = surfaceGeometry(shown.drawn);
    shown.mesh.geometry.dispose();
    shown.mesh.geometry = isWire ? withCorners(indexed) : indexed;
    shown.isWire = isWire;
  }

  private bounds(): Sphere {
    const box = { low: new Vector3(Infinity, Infinity, Infinity), high: new Vector3(-Infinity, -Infinity, -Infinity) };
    const point = new Vector3();
    for (const { drawn, group } of this.shown.values())
      for (const list of [drawn.positions, drawn.network?.positions]) {
        if (!list) continue;
        for (let i = 0; i + 2 < list.length; i += 3) {
          point.set(list[i] ?? 0, list[i + 1] ?? 0, list[i + 2] ?? 0).add(group.position);
          if (!Number.isFinite(point.x + point.y + point.z)) continue;
          box.low.min(point);
          box.high.max(point);
        }
      }
    if (!(box.low.x <= box.high.x)) return new Sphere(new Vector3(), this.emptySize);
    return new Sphere(box.low.clone().add(box.high).multiplyScalar(0.5), box.low.distanceTo(box.high) / 2);
  }

  /** The place of a surface under a pixel. */
  pick(x: number, y: number): Vector3 | null {
    return this.pickSurface(x, y)?.point ?? null;
  }
  /** The same with the object and the normal of the triangle there. */
  pickSurface(x: number, y: number): { object: string; point: Vector3; normal: Vector3 } | null {
    const hidden = this.hiddenAt(x);
    const seen = [...this.shown].filter(([id, shown]) => shown.mesh && shown.group.visible && id !== hidden);
    if (seen.length === 0) return null;
    const caster = new Raycaster();
    caster.ray.copy(this.ray(x, y));
    const hit = caster.intersectObjects(seen.flatMap(([, { mesh }]) => mesh ?? []), false)[0];
    const object = seen.find(([, { mesh }]) => mesh === hit?.object)?.[0];
    return hit?.face && object ? { object, point: hit.point, normal: hit.face.normal } : null;
  }

  private dispose(shown: Shown): void {
    this.scene.remove(shown.group);
    shown.mesh?.geometry.dispose();
    shown.mesh?.material.dispose();
    for (const one of [shown.lines, shown.nodes]) {
      one?.geometry.dispose();
      (one?.material as { dispose(): void } | undefined)?.dispose();
    }
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.resize(width, height);
  }

  /** Asks for a picture. */
  draw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.renderNow();
    });
  }

  private renderNow(): void {
    const up = new Vector3(0, 0, 1).transformDirection(this.camera.camera.matrixWorldInverse);
    for (const shown of this.shown.values()) {
      const uniform = shown.mesh?.material.uniforms.up;
      if (uniform) uniform.value = up;
    }
    for (const overlay of this.overlays.values())
      overlay.traverse((one) => {
        const uniform = ((one as Partial<Mesh>).material as Partial<ShaderMaterial> | undefined)?.uniforms?.up;
        if (uniform) uniform.value = up;
      });
    if (this.divider) this.renderSides(this.divider);
    else this.renderer.render(this.scene, this.camera.camera);
    for (const told of this.onDrawn) told();
  }

  private renderSides({ left, right, at }: Divider): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    const sides = [
      { from: 0, to: Math.round(at * width), hidden: right },
      { from: Math.round(at * width), to: width, hidden: left },
    ];
    this.renderer.setScissorTest(true);
    for (const { from, to, hidden } of sides) {
      const group = this.shown.get(hidden)?.group;
      const wasVisible = group?.visible ?? false;
      if (group) group.visible = false;
      this.renderer.setScissor(from, 0, to - from, height);
      this.renderer.render(this.scene, this.camera.camera);
      if (group) group.visible = wasVisible;
    }
    this.renderer.setScissorTest(false);
  }
}

function surfaceGeometry(drawn: Drawn): BufferGeometry {
  const geometry = new BufferGeometry();
  if (!drawn.positions || !drawn.normals || !drawn.triangles) return geometry;
  const position = new BufferAttribute(drawn.positions, 3);
  position.setUsage(DynamicDrawUsage);
  geometry.setAttribute('position', position);
  geometry.setAttribute('normal', new BufferAttribute(drawn.normals, 3));
  geometry.setIndex(new BufferAttribute(drawn.triangles, 1));
  return geometry;
}

/** The same triangles without an index, with the barycentric coordinates of their corners. */
function withCorners(geometry: BufferGeometry): BufferGeometry {
  const split = geometry.toNonIndexed();
  const n = split.getAttribute('position').count;
  const corners = new Float32Array(3 * n);
  for (let i = 0; i < n; ++i) corners[3 * i + (i % 3)] = 1;
  split.setAttribute('corner', new BufferAttribute(corners, 3));
  return split;
}

/** Both ends of every piece of every curve. */
function linePositions({ network, curves }: Drawn): Float32Array {
  if (!network) return new Float32Array();
  const pieces = curves.reduce((sum, curve) => sum + Math.max(0, curve.n - 1), 0);
  const result = new Float32Array(6 * pieces);
  let at = 0;
  for (const curve of curves)
    for (let i = curve.first; i + 1 < curve.first + curve.n; ++i)
      for (const end of [network.vertices[i] ?? 0, network.vertices[i + 1] ?? 0]) {
        result.set(network.positions.subarray(3 * end, 3 * end + 3), at);
        at += 3;
      }
  return result;
}

/** @param instead a colour for a curve by its index, or null. */
function lineColours({ curves }: Drawn, instead: (c: number) => number | null = () => null): Float32Array {
  const pieces = curves.reduce((sum, curve) => sum + Math.max(0, curve.n - 1), 0);
  const result = new Float32Array(6 * pieces);
  let at = 0;
  curves.forEach((curve, c) => {
    const colour = new Color(instead(c) ?? (curve.boundary ? BORDER : curve.sharp ? SHARP : CURVE)).toArray();
    for (let i = 0; i < 2 * (curve.n - 1); ++i, at += 3) result.set(colour, at);
  });
  return result;
}

function nodePositions({ network }: Drawn): Float32Array {
  if (!network) return new Float32Array();
  const result = new Float32Array(3 * network.nodes.length);
  network.nodes.forEach((node, i) => {
    result.set(network.positions.subarray(3 * node, 3 * node + 3), 3 * i);
  });
  return result;
}
