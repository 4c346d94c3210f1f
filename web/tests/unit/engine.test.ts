/** The engine in node, held against what the native program gave for the same files. */
import { readFileSync } from 'node:fs';
import load, { type NativeEngine } from 'batten-engine';
import { beforeAll, describe, expect, it } from 'vitest';

const root = new URL('../../..', import.meta.url);
const file = (path: string) => new Uint8Array(readFileSync(new URL(path, root)));

let makeEngine: () => NativeEngine;
beforeAll(async () => {
  const module = await load({ wasmBinary: file('build/web/engine/batten_engine.wasm') });
  makeEngine = () => new module.Engine();
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

  const native = process.env.BATTEN_NATIVE_SURFACE;
  it.skipIf(!native)('gives the network of the native program to 1e-9 of the size, and its surface', () => {
    const engine = makeEngine();
    ask(engine, { op: 'open', name: 'sample.rawnet' }, file('data/sample.rawnet'));
    ask(engine, derive('o1', 'network'));
    ask(engine, derive('o2', 'surface'));
    const page = plyVertices(ask(engine, { op: 'save', object: 'o3', format: 'ply' }).arrays.file as Uint8Array);
    const bytes = new Uint8Array(readFileSync(native ?? ''));
    const program = plyVertices(bytes);
    // The vertices of the curves come first.
    const onCurves = (ask(engine, { op: 'show', object: 'o2' }).arrays['network.positions']?.length ?? 0) / 3;
    expect(onCurves).toBeGreaterThan(1000);
    let largest = 0;
    let size = 0;
    for (let i = 0; i < 3 * onCurves; ++i) {
      largest = Math.max(largest, Math.abs((program.positions[i] ?? 0) - (page.positions[i] ?? Number.NaN)));
      size = Math.max(size, Math.abs(program.positions[i] ?? 0));
    }
    expect(largest / size).toBeLessThan(1e-9);
    // Inside patches triangles may lie otherwise: the last digit of a sine decides where a vertex goes. The surface is one.
    expect(Math.abs(page.m / program.m - 1)).toBeLessThan(0.01);
    expect(ask(engine, { op: 'open', name: 'native.ply' }, bytes).json.object).toBe('o4');
    const { max, rms } = ask(engine, { op: 'distances', object: 'o3', truth: 'o4' }).json;
    expect(max / size).toBeLessThan(5e-4);
    expect(rms / size).toBeLessThan(5e-5);
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
});
