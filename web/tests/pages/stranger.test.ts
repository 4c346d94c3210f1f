/** The way of somebody who has never seen it: sample scan, stripes, a slider, a file; then undo, and a window that was closed. */
import { readFileSync } from 'node:fs';
import { expect, test } from '@playwright/test';
import { openSample, picture, stripes, triangles } from './page';

test('sample scan, stripes, a slider, a file, undo, and back after the window was closed', async ({ page }) => {
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(error.message));
  // Shaders that do not compile are told there and nowhere else.
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  await openSample(page);
  await expect(page.getByText(/^All|kept in this browser/).first()).toBeVisible();
  const fine = await triangles(page);
  await picture(page, 'studio-reconstruct');

  await page.keyboard.press('Control+3');
  await page.getByLabel('Shading').selectOption('isophotes');
  expect(await stripes(page)).toBeGreaterThan(5);
  await page.getByRole('button', { name: 'Check all curves' }).click();
  await expect(page.getByText(/smooth curves (pass|fail)/)).toBeVisible({ timeout: 30_000 });
  await picture(page, 'studio-inspect');

  await page.keyboard.press('Control+1');
  const step = page.getByRole('spinbutton', { name: 'Step h, %' });
  await step.fill('3');
  await step.press('Enter');
  const isAnother = (n: number) => n > 1_000 && n !== fine;
  await expect.poll(async () => isAnother(await triangles(page)), { timeout: 60_000 }).toBe(true);
  const coarse = await triangles(page);

  const download = page.waitForEvent('download');
  await page.getByLabel('Save the selected object as').selectOption('ply');
  const file = readFileSync(await (await download).path());
  expect(file.subarray(0, 3).toString()).toBe('ply');
  expect(file.subarray(0, 2000).toString('latin1')).toContain(`element face ${coarse}\n`);

  await page.keyboard.press('Control+z');
  await expect.poll(() => triangles(page), { timeout: 60_000 }).toBe(fine);

  await page.reload();
  await expect.poll(() => triangles(page), { timeout: 60_000 }).toBe(fine);
  expect(errors).toEqual([]);
});

test('a step that takes too long is stopped, and nothing else is lost', async ({ page }) => {
  await openSample(page);
  const fine = await triangles(page);
  await page.keyboard.press('Control+4');
  await page.getByLabel('Do', { exact: true }).selectOption('remesh');
  await page.getByRole('button', { name: 'New triangles' }).click();
  await page.getByRole('button', { name: 'Stop', exact: true }).click();
  await expect(page.getByText('Stopped.')).toBeVisible();
  await expect.poll(() => page.evaluate(() => globalThis.batten?.store.objects.value.length)).toBe(3);
  await page.getByRole('button', { name: 'sample surface', exact: false }).first().click();
  await expect.poll(() => triangles(page)).toBe(fine);
});

test('a tour of five steps, once', async ({ page }) => {
  await openSample(page);
  const tour = page.getByRole('region', { name: /^Tour/ });
  await expect(tour).toBeVisible();
  for (let step = 1; step <= 4; ++step) {
    if (step === 3) {
      await tour.getByRole('button', { name: 'Show reflection lines' }).click();
      expect(await page.evaluate(() => globalThis.batten?.look.value.shading)).toBe('reflection-lines');
    }
    if (step === 4) {
      await tour.getByRole('button', { name: 'Check all curves' }).click();
      await expect(page.getByText(/smooth curves (pass|fail)/)).toBeVisible({ timeout: 30_000 });
    }
    await tour.getByRole('button', { name: /^Next/ }).click();
  }
  await tour.getByRole('button', { name: 'Begin' }).click();
  await expect(tour).toBeHidden();
});

test('a file that is none is refused in words, and nothing is lost', async ({ page }) => {
  await page.goto('/');
  await expect.poll(() => page.evaluate(() => globalThis.batten?.store.started.value)).toBe(true);
  await page.evaluate(() => globalThis.batten?.openFiles([['broken.ply', new Blob(['ply\nformat nonsense'])]]));
  await expect(page.getByRole('alert')).toContainText('broken.ply');
  await page.evaluate(() => globalThis.batten?.openFiles([['notes.xyz', new Blob(['hello'])]]));
  await expect(page.getByRole('alert').last()).toContainText('notes.xyz');
  expect(await page.evaluate(() => globalThis.batten?.store.objects.value.length)).toBe(0);
});

test('a second window says that it keeps nothing, and the first goes on', async ({ page, context }) => {
  await openSample(page);
  const fine = await triangles(page);
  const second = await context.newPage();
  await second.goto('/');
  await expect(second.getByText('not kept: save the project')).toBeVisible();
  await second.close();
  await page.reload();
  await expect.poll(() => triangles(page), { timeout: 60_000 }).toBe(fine);
});

test('works without a network after one visit', async ({ page, context }) => {
  await openSample(page);
  await page.evaluate(() => navigator.serviceWorker.ready);
  await context.setOffline(true);
  await page.reload();
  await expect.poll(() => triangles(page), { timeout: 60_000 }).toBeGreaterThan(10_000);
});

test('every command can be reached by the keyboard', async ({ page }) => {
  await openSample(page);
  await page.keyboard.press('Control+k');
  await page.getByLabel('Words of a command').fill('reflection');
  await page.keyboard.press('Enter');
  expect(await page.evaluate(() => globalThis.batten?.look.value.shading)).toBe('reflection-lines');
  expect(await stripes(page)).toBeGreaterThan(3);
});

for (const [width, height] of [[360, 640], [768, 1024], [1280, 800], [2560, 1440]] as const)
  test(`nothing is cut off at ${width} × ${height}`, async ({ page }) => {
    await page.setViewportSize({ width, height });
    await page.goto('/');
    await expect(page.getByRole('button', { name: 'Open the sample scan' })).toBeVisible();
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    expect(wide).toBeLessThanOrEqual(0);
    for (const button of await page.getByRole('button').all()) {
      const box = await button.boundingBox();
      if (box) expect(box.x + box.width).toBeLessThanOrEqual(width);
    }
  });
