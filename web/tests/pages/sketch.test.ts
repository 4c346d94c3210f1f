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

async function draw(page: Page, points: number[][]): Promise<void> {
  const places = await onScreen(page, points);
  const [first, ...rest] = places;
  if (!first) throw new Error('no points');
  await page.mouse.move(...first);
  await page.mouse.down();
  for (const place of rest) await page.mouse.move(...place);
  await page.mouse.up();
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
  await expect(page.getByText('Draw a closed outline')).toBeVisible();
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
