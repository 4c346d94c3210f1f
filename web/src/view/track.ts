/** The way of a device while it is captured: written on in place, however many points come in a second. */
import { BufferAttribute, BufferGeometry, Group, type InterleavedBufferAttribute, Points, PointsMaterial, Vector3 } from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { INK } from './overlays';
import type { View } from './scene';

/** Of a point as the server sends it: number of its curve, x, y, z, 1 at a node. */
export const TRACK_COLUMNS = 5;

/** How much more than all is shown, so that the view is not fitted anew with every point. */
const MARGIN = 1.3;

/** Both ends of the pieces between points of one curve; the first of the points from `first` on goes on from the one before. */
export function piecesOf(points: Float32Array, first: number): Float32Array {
  const n = points.length / TRACK_COLUMNS;
  const ends: number[] = [];
  for (let i = Math.max(1, first); i < n; ++i) {
    const [before, here] = [TRACK_COLUMNS * (i - 1), TRACK_COLUMNS * i];
    if (points[before] !== points[here]) continue;
    ends.push(...points.subarray(before + 1, before + 4), ...points.subarray(here + 1, here + 4));
  }
  return new Float32Array(ends);
}

export class Track {
  private points = new Float32Array(0);
  private n = 0;
  private nPieces = 0;
  private tip: [number, number, number] = [0, 0, 0];
  private lines: LineSegments2 | null = null;
  private nodes: Points | null = null;
  private tipDot: Points | null = null;
  private readonly ink = new LineMaterial({ color: INK.drawn, linewidth: 2 });
  private readonly nodeInk = new PointsMaterial({ color: INK.first, size: 7, sizeAttenuation: false, depthTest: false });
  private readonly tipInk = new PointsMaterial({ color: INK.accepted, size: 11, sizeAttenuation: false, depthTest: false });
  /** The ball that the view was fitted to; its radius. */
  private middle = new Vector3();
  private fitted = 0;

  /** What is there up to `first` stays. @param tip where the device is now */
  write(view: View | null, first: number, rows: Float32Array, tip: [number, number, number]): void {
    const n = first + rows.length / TRACK_COLUMNS;
    const isNew = first < this.n;
    if (TRACK_COLUMNS * n > this.points.length) {
      const longer = new Float32Array(2 * TRACK_COLUMNS * n);
      longer.set(this.points.subarray(0, TRACK_COLUMNS * first));
      this.points = longer;
    }
    this.points.set(rows, TRACK_COLUMNS * first);
    this.tip = tip;
    const before = this.n;
    this.n = n;
    if (view && this.lines && !isNew) this.goOn(view, before);
    else if (view) this.show(view);
  }

  /** Draws all of it; again after it was hidden, or where points were moved. */
  show(view: View): void {
    const pieces = piecesOf(this.points.subarray(0, TRACK_COLUMNS * this.n), 0);
    this.nPieces = pieces.length / 6;
    const room = new Float32Array(Math.max(6 * 512, 2 * pieces.length)); // so that it can go on in place
    room.set(pieces);
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(room);
    geometry.instanceCount = this.nPieces;
    this.lines = new LineSegments2(geometry, this.ink);
    this.lines.frustumCulled = false; // its bounds are not kept up to date
    this.nodes = dotsOf(this.nodePlaces(), this.nodeInk);
    this.tipDot = dotsOf(new Float32Array(this.tip), this.tipInk);
    const group = new Group();
    group.position.copy(view.fromModel([0, 0, 0]));
    group.add(this.lines, this.nodes, this.tipDot);
    view.overlay('track', group);
    this.fitted = 0;
    this.fit(view);
  }

  hide(view: View): void {
    this.lines = null;
    view.overlay('track', null);
  }

  private goOn(view: View, first: number): void {
    const pieces = piecesOf(this.points.subarray(0, TRACK_COLUMNS * this.n), first);
    const data = (this.lines?.geometry.getAttribute('instanceStart') as InterleavedBufferAttribute).data;
    if (6 * this.nPieces + pieces.length > data.array.length) {
      this.show(view);
      return;
    }
    if (pieces.length > 0) {
      (data.array as Float32Array).set(pieces, 6 * this.nPieces);
      data.addUpdateRange(6 * this.nPieces, pieces.length);
      data.needsUpdate = true;
      this.nPieces += pieces.length / 6;
      if (this.lines) this.lines.geometry.instanceCount = this.nPieces;
    }
    for (let i = first; i < this.n; ++i)
      if (this.points[TRACK_COLUMNS * i + 4] && this.nodes) {
        this.nodes.geometry.dispose();
        this.nodes.geometry = geometryOf(this.nodePlaces());
        break;
      }
    const at = this.tipDot?.geometry.getAttribute('position') as BufferAttribute;
    at.setXYZ(0, ...this.tip);
    at.needsUpdate = true;
    if (pieces.length > 0) this.fit(view);
    view.draw();
  }

  private nodePlaces(): Float32Array {
    const places: number[] = [];
    for (let i = 0; i < this.n; ++i)
      if (this.points[TRACK_COLUMNS * i + 4]) places.push(...this.points.subarray(TRACK_COLUMNS * i + 1, TRACK_COLUMNS * i + 4));
    return new Float32Array(places);
  }

  /** Goes back as far as is needed to see all of it. */
  private fit(view: View): void {
    const low = new Vector3(Infinity, Infinity, Infinity);
    const high = new Vector3(-Infinity, -Infinity, -Infinity);
    const point = new Vector3();
    for (let i = 0; i < this.n; ++i) {
      point.fromArray(this.points, TRACK_COLUMNS * i + 1);
      low.min(point);
      high.max(point);
    }
    const radius = this.n > 0 ? low.distanceTo(high) / 2 : 0;
    const middle = low.add(high).multiplyScalar(0.5);
    if (radius === 0 || radius + middle.distanceTo(this.middle) <= this.fitted) return;
    this.fitted = MARGIN * radius;
    this.middle.copy(middle);
    view.camera.fit(view.fromModel(middle.toArray()), this.fitted);
  }
}

function geometryOf(places: Float32Array): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(places, 3));
  return geometry;
}

function dotsOf(places: Float32Array, material: PointsMaterial): Points {
  const made = new Points(geometryOf(places), material);
  made.frustumCulled = false;
  made.renderOrder = 2; // after what they shine through
  return made;
}
