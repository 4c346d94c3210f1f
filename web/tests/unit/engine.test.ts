/** The engine in node, held against what the native program gave for the same files. */
import { readdirSync, readFileSync } from 'node:fs';
import load, { type NativeEngine } from 'batten-engine';
import { beforeAll, describe, expect, it } from 'vitest';

const root = new URL('../../..', import.meta.url);
const file = (path: string) => new Uint8Array(readFileSync(new URL(path, root)));

let makeEngine: () => NativeEngine;
/** Bytes that the engine has of the machine: they never become fewer, and not more where all is given back. */
let memory: () => number;
beforeAll(async () => {
  const module = await load({ wasmBinary: file('build/web/engine/batten_engine.wasm') });
  makeEngine = () => new module.Engine();
  memory = () => module.HEAPU8.length;
});

function ask(engine: NativeEngine, message: object, bytes?: Uint8Array, progress?: (stage: string, fraction: number) => boolean) {
  const { text, arrays } = engine.handle(JSON.stringify(message), bytes ?? '', progress ?? null);
  return { json: JSON.parse(text), arrays };
}

const derive = (source: string, kind: string) => ({
  op: 'edit',
  edit: { op: 'derive', object: 'o0', name: kind, source, request: { kind } },
});

/** A binary PLY of double positions as the native program writes it. */
function plyVertices(bytes: Uint8Array): { n: number; m: number; positions: Float64Array } {
  const end = new TextDecoder('latin1').decode(bytes.subarray(0, 2000)).indexOf('end_header\n') + 11;
  const header = new TextDecoder().decode(bytes.subarray(0, end));
  const n = Number(/element vertex (\d+)/.exec(header)?.[1]);
  const m = Number(/element face (\d+)/.exec(header)?.[1]);
  const sizes: Record<string, number> = { double: 8, float: 4, int: 4, uchar: 1 };
  const properties = [...header.slice(0, header.indexOf('element face')).matchAll(/property (\w+) (\w+)/g)];
  const size = properties.reduce((sum, one) => sum + (sizes[one[1] ?? ''] ?? 0), 0);
  const view = new DataView(bytes.buffer, bytes.byteOffset + end);
  const positions = new Float64Array(3 * n);
  for (let i = 0; i < n; ++i) for (let k = 0; k < 3; ++k) positions[3 * i + k] = view.getFloat64(i * size + 8 * k, true);
  return { n, m, positions };
}

describe('the engine', () => {
  it('makes a surface of the sample scan, follows sliders and undoes', () => {
    const engine = makeEngine();
    expect(ask(engine, { op: 'open', name: 'sample.rawnet' }, file('data/sample.rawnet')).json.object).toBe('o1');
    expect(ask(engine, derive('o1', 'network')).json).toMatchObject({ ok: true, object: 'o2' });
    expect(ask(engine, derive('o2', 'surface')).json).toMatchObject({ ok: true, object: 'o3' });
    const shown = ask(engine, { op: 'show', object: 'o3' });
    expect(shown.json.mesh).toMatchObject({ closed: true, genus: 0 });
    expect(shown.json.flaws).toEqual([]);
    expect(shown.arrays.triangles?.length).toBe(3 * shown.json.mesh.n_triangles);
    const request = (lambda: number) => ({
      op: 'edit',
      drag: 1,
      edit: { op: 'request', object: 'o2', request: { kind: 'network', weights: 'given', lambda, mu: 1 } },
    });
    expect(ask(engine, request(0.1)).json.ok).toBe(true);
    expect(ask(engine, { op: 'follow', object: 'o3', moving: true }).json.rebuilt).toBe(true);
    expect(ask(engine, request(0.2)).json.ok).toBe(true);
    const moved = ask(engine, { op: 'follow', object: 'o3', moving: true });
    expect(moved.json.rebuilt).toBe(false);
    expect(moved.arrays.triangles).toBeUndefined();
    expect(ask(engine, { op: 'edit', edit: { op: 'undo' } }).json.ok).toBe(true);
    expect(ask(engine, { op: 'document' }).json.objects[1].request.weights).toBe('auto');
    engine.delete();
  }, 120_000);

  const native = process.env.BATTEN_NATIVE_SURFACES;
  const program = (name: string) => plyVertices(new Uint8Array(readFileSync(`${native}/${name}.ply`)));

  /** The largest difference of coordinates as a share of the largest coordinate. */
  function difference(a: Float64Array, b: Float64Array): number {
    expect(a.length).toBe(b.length);
    let largest = 0;
    let size = 0;
    for (let i = 0; i < a.length; ++i) {
      largest = Math.max(largest, Math.abs((a[i] ?? 0) - (b[i] ?? Number.NaN)));
      size = Math.max(size, Math.abs(a[i] ?? 0));
    }
    return largest / size;
  }

  function expectTheSurface(engine: NativeEngine, object: string, name: string): void {
    const page = plyVertices(ask(engine, { op: 'save', object, format: 'ply' }).arrays.file as Uint8Array);
    const expected = program(name);
    expect(page.n).toBeGreaterThan(1000);
    expect(page.m).toBe(expected.m);
    expect(difference(expected.positions, page.positions)).toBeLessThan(1e-9);
  }

  it.skipIf(!native)('gives the surface of the native program for the sample scan, to 1e-9 of the size', () => {
    const engine = makeEngine();
    ask(engine, { op: 'open', name: 'sample.rawnet' }, file('data/sample.rawnet'));
    ask(engine, derive('o1', 'network'));
    ask(engine, derive('o2', 'surface'));
    expectTheSurface(engine, 'o3', 'sample');
    engine.delete();
  }, 120_000);

  const sessions = readdirSync(new URL('examples/sessions', root)).filter((name) => name.endsWith('.jsonl'));
  it.skipIf(!native).each(sessions)('gives the surface of the native program for the session %s, to 1e-9 of the size', (name) => {
    const engine = makeEngine();
    expect(ask(engine, { op: 'open', name }, file(`examples/sessions/${name}`)).json).toMatchObject({ ok: true, replaced: true });
    const model = ask(engine, { op: 'document' }).json.objects.find((one: { kind: string }) => one.kind === 'model').id;
    const surface = ask(engine, derive(model, 'model-surface')).json.object;
    expectTheSurface(engine, surface, name.replace('.jsonl', ''));
    engine.delete();
  }, 120_000);

  it('answers what goes wrong in words', () => {
    const engine = makeEngine();
    expect(ask(engine, { op: 'open', name: 'a.ply' }, new TextEncoder().encode('ply\nnonsense')).json.ok).toBe(false);
    expect(ask(engine, { op: 'show', object: 'o9' }).json.message).toBe("there is no object 'o9'");
    engine.delete();
  });

  it('tells progress and stops where it is asked to', () => {
    const engine = makeEngine();
    ask(engine, { op: 'open', name: 'sample.rawnet' }, file('data/sample.rawnet'));
    ask(engine, derive('o1', 'network'));
    let told = 0;
    const stopped = ask(engine, { op: 'show', object: 'o2' }, undefined, () => ++told < 3);
    expect(told).toBe(3);
    expect(stopped.json).toMatchObject({ ok: false, kind: 'cancelled' });
    engine.delete();
  });

  it('takes no more memory when models of 60,000 triangles were opened and closed again and again', () => {
    // A sheet of 174 × 174 squares, as a binary PLY.
    const n = 175;
    const m = 2 * (n - 1) ** 2;
    const header = new TextEncoder().encode(
      `ply\nformat binary_little_endian 1.0\nelement vertex ${n * n}\nproperty float x\nproperty float y\nproperty float z\n` +
        `element face ${m}\nproperty list uchar int vertex_indices\nend_header\n`,
    );
    const bytes = new Uint8Array(header.length + 12 * n * n + 13 * m);
    bytes.set(header);
    const view = new DataView(bytes.buffer);
    let at = header.length;
    for (let i = 0; i < n * n; ++i, at += 12) {
      view.setFloat32(at, i % n, true);
      view.setFloat32(at + 4, Math.floor(i / n), true);
    }
    for (let i = 0; i + 1 < n; ++i)
      for (let j = 0; j + 1 < n; ++j) {
        const a = n * i + j;
        for (const triangle of [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]) {
          view.setUint8(at, 3);
          triangle.forEach((v, k) => view.setInt32(at + 1 + 4 * k, v, true));
          at += 13;
        }
      }
    expect(m).toBeGreaterThan(60_000);
    const open = (show: boolean) => {
      const engine = makeEngine();
      expect(ask(engine, { op: 'open', name: 'sheet.ply' }, bytes).json.ok).toBe(true);
      if (show) expect(ask(engine, { op: 'show', object: 'o1' }).json.mesh.n_triangles).toBe(m);
      engine.delete();
    };
    for (let i = 0; i < 3; ++i) open(true);
    const before = memory();
    for (let i = 0; i < 12; ++i) open(i % 4 === 0);
    expect(memory()).toBe(before);
  }, 120_000);
});
