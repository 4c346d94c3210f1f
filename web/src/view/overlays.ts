/** What rooms draw beside the objects: strokes, marks, lines, a mesh while it is pulled at. Loaded with the rooms. */
import { BufferAttribute, BufferGeometry, Color, GridHelper, Group, Line, LineBasicMaterial, LineSegments, type Material, Mesh, Points, PointsMaterial, Vector3 } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { surfaceMaterial } from './materials';
import type { View } from './scene';

export const INK = { drawn: 0x6a3fb5, refused: 0xd2342e, accepted: 0x2e8b57, first: 0xc25a1c, second: 0x1c6fb0 };

type Place = readonly [number, number, number];

/** Materials are kept: one that is made anew has its program compiled again. */
const kept = new Map<string, Material>();
function keptMaterial<M extends Material>(name: string, make: () => M): M {
  const known = kept.get(name);
  if (known) return known as M;
  const made = make();
  kept.set(name, made);
  return made;
}

/** The stroke that is being drawn, or was refused, in coordinates of the model; null takes it away. */
export function stroke(view: View, points: readonly Place[] | null, refused = false, name = 'stroke'): void {
  if (!points || points.length < 2) {
    view.overlay(name, null);
    return;
  }
  const geometry = new BufferGeometry().setFromPoints(points.map((one) => view.fromModel(one)));
  const line = new Line(
    geometry,
    keptMaterial(`line ${refused}`, () => new LineBasicMaterial({ color: refused ? INK.refused : INK.drawn, depthTest: false })),
  );
  line.renderOrder = 1;
  view.overlay(name, line);
}

/** A place that a stroke would snap to. */
export function highlight(view: View, point: Vector3 | null): void {
  view.overlay('highlight', point ? dots([point], INK.drawn, 9) : null);
}

export function dots(points: readonly Vector3[], color: number, size: number, depthTest = false): Points {
  const geometry = new BufferGeometry().setFromPoints([...points]);
  const made = new Points(
    geometry,
    keptMaterial(`dots ${color} ${size} ${depthTest}`, () => new PointsMaterial({ color, size, sizeAttenuation: false, depthTest })),
  );
  made.renderOrder = depthTest ? 0 : 2; // after what they shine through
  return made;
}

/** A grid on the plane that strokes lie on; null takes it away. */
export function grid(view: View, plane: { axis: 'x' | 'y' | 'z'; offset: number } | null, name = 'grid', ink: [number, number] = [0x7f8894, 0xb4bac4]): void {
  if (!plane) {
    view.overlay(name, null);
    return;
  }
  const lines = new GridHelper(2.4 * view.size(), 12, ...ink);
  // A grid of three lies across y.
  if (plane.axis === 'z') lines.rotation.x = Math.PI / 2;
  if (plane.axis === 'x') lines.rotation.z = Math.PI / 2;
  lines.position.copy(view.fromModel([0, 0, 0]));
  lines.position[plane.axis] += plane.offset;
  view.overlay(name, lines);
}

/** Pieces of lines as wide as curves: both ends of each, and one colour or one per end. */
export function segments(ends: Float32Array, color: number | Float32Array, width = 2, depthTest = true): LineSegments2 {
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(ends);
  const isList = typeof color !== 'number';
  if (isList) geometry.setColors(color);
  const made = new LineSegments2(
    geometry,
    keptMaterial(
      `segments ${isList || color} ${width} ${depthTest}`,
      () => new LineMaterial({ ...(isList ? { vertexColors: true } : { color }), linewidth: width, depthTest }),
    ),
  );
  made.renderOrder = depthTest ? 0 : 2;
  return made;
}
/** The same, a pixel wide: for many. */
export function hairs(ends: Float32Array, colours: Float32Array): LineSegments {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(ends, 3));
  geometry.setAttribute('color', new BufferAttribute(colours, 3));
  return new LineSegments(geometry, keptMaterial('hairs', () => new LineBasicMaterial({ vertexColors: true })));
}

export function rgb(color: number): [number, number, number] {
  return new Color(color).toArray() as [number, number, number];
}

export function together(origin: Vector3, ...parts: (Points | Line | Mesh | LineSegments2)[]): Group {
  const group = new Group();
  group.position.copy(origin);
  group.add(...parts);
  return group;
}

/** A mesh that stands in the place of an object; its arrays are written anew by `moveSheet`. */
export function sheet(positions: Float32Array, normals: Float32Array, triangles: Uint32Array, origin: Vector3): Mesh {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(normals, 3));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  const mesh = new Mesh(geometry, surfaceMaterial());
  mesh.position.copy(origin);
  mesh.frustumCulled = false;
  return mesh;
}
export function moveSheet(mesh: Mesh, positions: Float32Array, normals: Float32Array): void {
  for (const [name, array] of [['position', positions], ['normal', normals]] as const) {
    const attribute = mesh.geometry.getAttribute(name) as BufferAttribute;
    attribute.array = array;
    attribute.needsUpdate = true;
  }
}
