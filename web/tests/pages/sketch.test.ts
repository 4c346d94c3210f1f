/** A surface from nothing by a mouse: closed after four strokes; refusals in words; undo; a hole's worth of tools. */
import { expect, type Page, test } from '@playwright/test';
import { picture } from './page';

type Place = [number, number];

/** Where a point of the model is on the screen. */
const onScreen = (page: Page, points: number[][]): Promise<Place[]> =>
  page.evaluate((list) => {
    const view = globalThis.batten?.view;
    if (!view) return [];
    const box = view.element.getBoundingClientRect();
    const [x, y, z] = view.middle();
    return list.map((point) => {
      const at = view.camera.target
        .clone()
        .set((point[0] ?? 0) - x, (point[1] ?? 0) - y, (point[2] ?? 0) - z)
        .project(view.camera.camera);
      return [box.x + ((at.x + 1) / 2) * box.width, box.y + ((1 - at.y) / 2) * box.height] as [number, number];
    });
  }, points);

/** The mouse goes down, over the places and, unless it is to stay down, up. What lies between comes at once: software draws every frame. */
async function draw(page: Page, points: number[][], up = true): Promise<void> {
  const places = await onScreen(page, points);
  const [first, last] = [places[0], places[places.length - 1]];
  if (!first || !last) throw new Error('no points');
  await page.mouse.move(...first);
  await page.mouse.down();
  await page.evaluate((list) => {
    for (const [clientX, clientY] of list)
      globalThis.batten?.view?.element.dispatchEvent(
        new PointerEvent('pointermove', { clientX, clientY, pointerId: 1, pointerType: 'mouse', isPrimary: true, buttons: 1, bubbles: true }),
      );
  }, places);
  await page.mouse.move(...last);
  if (up) await page.mouse.up();
}

const circle = (r: number, n = 40) =>
  Array.from({ length: n + 1 }, (_, i) => [r * Math.cos((2 * Math.PI * i) / n), r * Math.sin((2 * Math.PI * i) / n), 0]);
const arc = (a: Place, b: Place, height: number, n = 24) =>
  Array.from({ length: n + 1 }, (_, i) => {
    const t = (Math.PI * i) / n;
    const [c, s] = [Math.cos(t), Math.sin(t)];
    return [(a[0] + b[0]) / 2 + ((a[0] - b[0]) / 2) * c, (a[1] + b[1]) / 2 + ((a[1] - b[1]) / 2) * c, height * s];
  });

/** What the surface of the sketch has come to. */
const state = (page: Page) =>
  page.evaluate(() => {
    const store = globalThis.batten?.store;
    const surface = store?.objects.value.find((one) => one.request?.kind === 'model-surface');
    const drawn = surface && store?.drawn.value.get(surface.id);
    return {
      curves: new Set(drawn?.curves.map((one) => one.curve)).size,
      closed: drawn?.mesh?.closed ?? false,
      flaws: drawn?.flaws.length ?? 0,
      up_to_date: drawn?.version === surface?.version,
    };
  });

async function begin(page: Page): Promise<void> {
  await page.goto('/');
  await page.keyboard.press('Control+2');
  await page.getByRole('button', { name: 'New sketch' }).click();
  await expect(page.getByText('Draw a closed outline')).toBeVisible({ timeout: 30_000 });
}

test('a closed surface in four strokes, and every one undone', async ({ page }) => {
  await begin(page);
  const strokes = [circle(60), arc([60, 0], [-60, 0], 45), arc([0, 60], [0, -60], 45)];
  for (const [i, stroke] of strokes.entries()) {
    await draw(page, stroke);
    await expect.poll(() => state(page)).toEqual({ curves: i + 1, closed: false, flaws: 0, up_to_date: true });
  }
  await picture(page, 'studio-sketch');
  // From below.
  await page.evaluate(() => {
    const view = globalThis.batten?.view;
    if (!view) return;
    view.camera.elevation = -0.5;
    view.fit();
  });
  await draw(page, arc([60, 0], [-60, 0], -30));
  await expect.poll(() => state(page)).toEqual({ curves: 4, closed: true, flaws: 0, up_to_date: true });
  for (let curves = 3; curves >= 1; --curves) {
    await page.keyboard.press('Control+z');
    await expect.poll(() => state(page)).toMatchObject({ curves, up_to_date: true });
  }
});

test('a stroke that cannot be is refused in words, and another can follow', async ({ page }) => {
  await begin(page);
  await draw(page, circle(60));
  await expect.poll(() => state(page)).toMatchObject({ curves: 1 });
  await draw(page, [[10, 0, 0], [20, 5, 0], [30, 8, 0], [34, 9, 0]]);
  await expect(page.getByRole('alert')).toBeVisible();
  expect((await page.getByRole('alert').innerText()).length).toBeGreaterThan(40);
  await page.getByRole('button', { name: 'Forget it' }).click();
  await draw(page, arc([60, 0], [-60, 0], 45));
  await expect.poll(() => state(page)).toMatchObject({ curves: 2 });
});

/** Fewer pixels are drawn faster. */
const SMALL = { width: 800, height: 480 };
const offset = async (page: Page, value: number) => {
  const field = page.getByRole('spinbutton', { name: 'Offset, mm' });
  await field.fill(String(value));
  await field.press('Enter');
};
const ring = (r: number, z: number, n = 32) => circle(r, n).map(([x, y]) => [x ?? 0, y ?? 0, z]);
const straight = (a: number[], b: number[], n = 8) => Array.from({ length: n + 1 }, (_, i) => a.map((x, k) => x + ((b[k] ?? 0) - x) * (i / n)));

/** As on a machine that is busy: what waits for a frame comes late, and events come before it. */
const lateFrames = (page: Page) =>
  page.addInitScript(() => {
    const [frame, timeout] = [requestAnimationFrame.bind(globalThis), window.setTimeout.bind(window)];
    globalThis.requestAnimationFrame = (callback) => timeout(() => frame(callback), 250);
    // Preact waits so long for a frame before it runs effects without one.
    globalThis.setTimeout = ((callback: () => void, ms?: number) => timeout(callback, ms === 35 ? 400 : ms)) as typeof setTimeout;
  });

test('a tube glued between two outlines, and one skinned over profiles, on a busy machine', async ({ page }) => {
  await lateFrames(page);
  await page.setViewportSize(SMALL);
  await begin(page);
  await draw(page, ring(40, 0));
  await expect.poll(() => state(page)).toMatchObject({ curves: 1, up_to_date: true });
  await offset(page, 60);
  await draw(page, ring(40, 60));
  await expect.poll(() => state(page)).toMatchObject({ curves: 2, up_to_date: true });
  await page.keyboard.press('g');
  await expect(page.getByText('one side of the tube')).toBeVisible();
  await draw(page, straight([40, 0, 0], [40, 0, 60]));
  await expect(page.getByText('Draw the second stroke')).toBeVisible();
  await draw(page, straight([-40, 0, 0], [-40, 0, 60]));
  await expect.poll(() => state(page)).toEqual({ curves: 4, closed: true, flaws: 0, up_to_date: true });

  await page.getByRole('button', { name: 'Find a command' }).click();
  await page.getByLabel('Words of a command').fill('new sketch');
  await page.keyboard.press('Enter');
  await expect(page.getByText('Draw a closed outline')).toBeVisible();
  await page.keyboard.press('k');
  await offset(page, 0);
  await draw(page, ring(40, 0));
  await expect(page.getByText('1 drawn')).toBeVisible();
  await offset(page, 70);
  await draw(page, ring(25, 70));
  await page.getByRole('button', { name: 'Now the spines' }).click();
  await draw(page, straight([40, 0, 0], [25, 0, 70]));
  await expect(page.getByText('the second spine')).toBeVisible();
  await draw(page, straight([-40, 0, 0], [-25, 0, 70]));
  await expect.poll(() => page.evaluate(() => {
    const store = globalThis.batten?.store;
    const drawn = store?.drawn.value.get(store.selected.value ?? '');
    return [new Set(drawn?.curves.map((one) => one.curve)).size, drawn?.mesh?.n_borders];
  })).toEqual([4, 2]);
});

test('a stroke says what it would meet before it ends; symmetry completes it; a remedy is carried out', async ({ page }) => {
  await page.setViewportSize(SMALL);
  await begin(page);
  // An arc is no outline; a button makes it one.
  await draw(page, ring(60, 0).slice(0, 25));
  await page.getByRole('alert').getByRole('button', { name: 'Close it' }).click();
  await expect.poll(() => state(page)).toMatchObject({ curves: 1, up_to_date: true });
  await page.keyboard.press('Control+z');
  await page.getByLabel('Symmetry').selectOption('x');
  const half = Array.from({ length: 31 }, (_, i) => [60 * Math.sin((Math.PI * i) / 30), -60 * Math.cos((Math.PI * i) / 30), 0]);
  await draw(page, half);
  await expect.poll(() => state(page)).toMatchObject({ curves: 1, up_to_date: true });
  const reach = await page.evaluate(() => {
    const drawn = [...(globalThis.batten?.store.drawn.value.values() ?? [])].at(-1);
    const x = [...(drawn?.network?.positions ?? [])].filter((_, i) => i % 3 === 0).map((one) => one + (drawn?.origin[0] ?? 0));
    return [Math.min(...x), Math.max(...x)];
  });
  expect(reach[0]).toBeCloseTo(-(reach[1] ?? 0), 1);
  expect(reach[1]).toBeGreaterThan(55);

  await page.getByLabel('Symmetry').selectOption('off');
  await draw(page, arc([60, 0], [-60, 0], 45), false);
  await expect(page.getByText(/^Meets c0; 1 face more/)).toBeVisible();
  await page.mouse.up();
  await expect.poll(() => state(page)).toMatchObject({ curves: 2, up_to_date: true });
});
