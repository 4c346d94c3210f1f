/** What the engine's answers hold. Lengths in the unit of the object, angles in radians. */

export type ObjectKind = 'scan' | 'network' | 'model' | 'mesh' | 'calibration' | 'view';

/** The options of a request by the names of docs/projects.md. */
export interface RequestOptions {
  kind: string;
  [option: string]: unknown;
}

export interface ObjectEntry {
  id: string;
  name: string;
  kind: ObjectKind;
  unit: string;
  /** Changes with everything that the object depends on. */
  version: number;
  /** The extensions that it can be saved as. */
  formats: string[];
  source?: string;
  request?: RequestOptions;
}

/** An edit as a line of a journal. */
export interface Edit {
  op: string;
  [field: string]: unknown;
}

export interface CurveEntry {
  name: string;
  boundary: boolean;
  sharp: boolean;
  closed: boolean;
  /** Its number and sharpness in a model. */
  curve?: number;
  sharpness?: number;
  /** The vertices at its ends in a model. */
  ends?: [number, number];
  /** Where its vertices stand in Drawn.network.vertices. */
  first: number;
  n: number;
}

export interface MeshFigures {
  n_vertices: number;
  n_triangles: number;
  closed: boolean;
  n_borders: number;
  n_components: number;
  genus: number | null;
  problems: string[];
  smallest_angle: number;
  mean_smallest_angle: number;
  largest_angle: number;
  /** The share of triangles with an angle below 20°. */
  slivers: number;
  mean_aspect: number;
  worst_aspect: number | null;
  /** The middle of the triangle of that. */
  worst: [number, number, number] | null;
  shortest_edge: number;
  mean_edge: number;
  longest_edge: number;
  /** The share of inner vertices with six edges. */
  regular: number;
  area: number;
  volume: number | null;
  diameter: number;
}

export interface ScanFigures {
  lambda: number;
  mu: number;
  weights_reason: string;
  step: number;
  size: number;
  n_readings: number;
  n_samples: number;
  outliers: number[];
  distrusted: number[];
  misfit_before: number;
  misfit: number;
}

/** An object as it is drawn; coordinates are less `origin`. */
export interface Drawn {
  id: string;
  version: number;
  /** A preview, by kept solvers and not checked: coarse while a slider moves, fine when it rests. */
  coarse: 'coarse' | 'fine' | null;
  origin: [number, number, number];
  positions?: Float32Array<ArrayBuffer>;
  normals?: Float32Array<ArrayBuffer>;
  triangles?: Uint32Array<ArrayBuffer>;
  network?: {
    positions: Float32Array<ArrayBuffer>;
    normals?: Float32Array<ArrayBuffer>;
    vertices: Uint32Array<ArrayBuffer>;
    nodes: Uint32Array<ArrayBuffer>;
  };
  curves: CurveEntry[];
  warnings: string[];
  flaws: string[];
  /** What was mended, a line for each kind. */
  done?: string[];
  mesh?: MeshFigures;
  report?: ScanFigures;
  live?: { lambda: number; mu: number; misfit: number };
  times?: { stage: string; seconds: number }[];
}

/** One value per drawn vertex, and the ends of its colour bar. */
export interface Values {
  object: string;
  shading: string;
  values: Float32Array<ArrayBuffer>;
  low: number;
  high: number;
  title: string;
  figures?: { mean: number; rms: number; max: number };
}

export interface CurveVerdict {
  name: string;
  verdict: 'pass' | 'fail' | 'sharp' | 'border';
  gap: number;
  normal_jump: number;
  mean_normal_jump: number;
  curvature_jump: number;
  distance: number;
  worst: [number, number, number];
}

export interface Continuity {
  object: string;
  tolerance: number;
  curves: CurveVerdict[];
  n_checked: number;
  n_failed: number;
}
