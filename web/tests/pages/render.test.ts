/** The view draws what `batten render` draws: the same surface at the same pose, pixel by pixel. */
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { expect, type Page, test } from '@playwright/test';
import { openSample } from './page';

const root = new URL('../../../', import.meta.url).pathname;
const program = process.env.BATTEN_PROGRAM ?? join(root, 'build/release/bin/batten');
const MARGIN = 0.05; // of the narrower side, as render leaves around what it draws
const TANGENT = Math.tan((11 * Math.PI) / 180); // of half its angle of view

/** Puts the viewer where render puts him (render/camera.cpp), into a picture as large as the view. */
async function lookAsRenderDoes(page: Page): Promise<{ width: number; height: number }> {
  return page.evaluate(
    ([marginShare, tangent]) => {
      const { view, store } = globalThis.batten ?? {};
      const drawn = store?.drawn.value.get(store.selected.value ?? '');
      if (!view || !drawn?.positions) throw new Error('nothing is shown');
      const { clientWidth: width, clientHeight: height } = view.element;
      const camera = view.camera.camera;
      view.camera.look('home');
      const e = camera.matrixWorld.elements;
      const right = e.slice(0, 3);
      const up = e.slice(4, 7);
      const back = e.slice(8, 11);
      const offset = drawn.origin.map((x, i) => x - (view.middle()[i] ?? 0));
      const dot = (a: number[], b: number[]) => a.reduce((sum, x, i) => sum + x * (b[i] ?? 0), 0);
      const seen: number[][] = [];
      const low = [Infinity, Infinity, Infinity];
      const high = [-Infinity, -Infinity, -Infinity];
      for (let i = 0; i < drawn.positions.length; i += 3) {
        const p = [0, 1, 2].map((k) => (drawn.positions?.[i + k] ?? 0) + (offset[k] ?? 0));
        const q = [dot(p, right), dot(p, up), dot(p, back)];
        seen.push(q);
        q.forEach((x, k) => {
          low[k] = Math.min(low[k] ?? 0, x);
          high[k] = Math.max(high[k] ?? 0, x);
        });
      }
      const middle = low.map((x, k) => (x + (high[k] ?? 0)) / 2);
      const margin = marginShare * Math.min(width, height);
      const inner = [width - 2 * margin, height - 2 * margin] as const;
      const side = Math.min(...inner);
      let distance = 0.6 * Math.hypot(...low.map((x, k) => (high[k] ?? 0) - x));
      for (const q of seen) {
        q.forEach((x, k) => (q[k] = x - (middle[k] ?? 0)));
        const [x = 0, y = 0, z = 0] = q;
        distance = Math.max(distance, z + (Math.abs(x) * side) / (tangent * inner[0]), z + (Math.abs(y) * side) / (tangent * inner[1]));
      }
      const range = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] } as { x: [number, number]; y: [number, number] };
      for (const [x = 0, y = 0, z = 0] of seen) {
        const [u, v] = [x / (distance - z), y / (distance - z)];
        range.x = [Math.min(range.x[0], u), Math.max(range.x[1], u)];
        range.y = [Math.min(range.y[0], v), Math.max(range.y[1], v)];
      }
      const scale = Math.min(inner[0] / (range.x[1] - range.x[0]), inner[1] / (range.y[1] - range.y[0]));
      const centre = [width / 2 - (scale * (range.x[0] + range.x[1])) / 2, height / 2 + (scale * (range.y[0] + range.y[1])) / 2] as const;
      const target = [0, 1, 2].map((k) => (middle[0] ?? 0) * (right[k] ?? 0) + (middle[1] ?? 0) * (up[k] ?? 0) + (middle[2] ?? 0) * (back[k] ?? 0));
      view.camera.target.set(target[0] ?? 0, target[1] ?? 0, target[2] ?? 0);
      view.camera.distance = distance;
      view.camera.look('home');
      const projection = camera.projectionMatrix.elements;
      projection[0] = (2 * scale) / width;
      projection[5] = (2 * scale) / height;
      projection[8] = 1 - (2 * centre[0]) / width;
      projection[9] = (2 * centre[1]) / height - 1;
      camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
      return { width, height };
    },
    [MARGIN, TANGENT] as const,
  );
}

/** Shares of the pixels: that differ, and that show surface. */
async function difference(page: Page, png: Buffer): Promise<{ off: number; surface: number }> {
  return page.evaluate(async (text) => {
    const pixels = async (blob: Blob) => {
      const image = await createImageBitmap(blob);
      const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
      if (!context) throw new Error('no picture');
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, image.width, image.height);
    };
    const blob = await globalThis.batten?.view?.picture();
    if (!blob) throw new Error('no picture');
    const ours = await pixels(blob);
    const theirs = await pixels(new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]));
    if (ours.width !== theirs.width || ours.height !== theirs.height) throw new Error('pictures of two sizes');
    // On the background of the other, which is one colour along a row.
    for (let y = 0; y < ours.height; ++y)
      for (let x = 0; x < ours.width; ++x) {
        const at = 4 * (y * ours.width + x);
        const alpha = (ours.data[at + 3] ?? 0) / 255;
        for (let k = 0; k < 3; ++k)
          ours.data[at + k] = alpha * (ours.data[at + k] ?? 0) + (1 - alpha) * (theirs.data[4 * y * ours.width + k] ?? 0);
      }
    const TOLERANCE = 48; // edges of stripes are smoothed in two ways
    let off = 0;
    let surface = 0;
    for (let at = 0; at < ours.data.length; at += 4) {
      surface += (ours.data[at + 3] ?? 0) > 0 ? 1 : 0;
      off += [0, 1, 2].some((k) => Math.abs((ours.data[at + k] ?? 0) - (theirs.data[at + k] ?? 0)) > TOLERANCE) ? 1 : 0;
    }
    const all = ours.width * ours.height;
    return { off: off / all, surface: surface / all };
  }, png.toString('base64'));
}

test('a surface looks as in the pictures of the command line', async ({ page }) => {
  test.skip(!existsSync(program), 'the program is not built: ./test program web');
  test.setTimeout(120_000);
  await openSample(page);
  await page.keyboard.press('Control+3');
  const download = page.waitForEvent('download');
  await page.getByLabel('Save the selected object as').selectOption('ply');
  const folder = mkdtempSync(join(tmpdir(), 'batten-render-'));
  const mesh = join(folder, 'surface.ply');
  writeFileSync(mesh, readFileSync(await (await download).path()));
  await page.evaluate(() => globalThis.batten?.setLook({ curves: false }));
  for (const shading of ['shaded', 'isophotes', 'reflection-lines', 'normal-map'] as const) {
    await page.evaluate((shading) => globalThis.batten?.setLook({ shading }), shading);
    const { width, height } = await lookAsRenderDoes(page);
    const picture = join(folder, `${shading}.png`);
    execFileSync(program, ['render', mesh, '-o', picture, '--shading', shading, '--size', `${width}x${height}`]);
    const { off, surface } = await difference(page, readFileSync(picture));
    expect(surface, shading).toBeGreaterThan(0.2);
    expect(off, shading).toBeLessThanOrEqual(0.01);
  }
});
