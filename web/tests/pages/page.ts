/** What the tests of pages share. */
import { expect, type Page } from '@playwright/test';
import type { App } from '../../src/app';

declare global {
  var batten: App | undefined;
}

/** Triangles of the checked surface of the selected object; 0 while there is a preview or none. */
export const triangles = (page: Page): Promise<number> =>
  page.evaluate(() => {
    const store = globalThis.batten?.store; // not there while the page loads
    const id = store?.selected.value;
    return (id ? store?.drawn.value.get(id)?.mesh?.n_triangles : 0) ?? 0;
  });

export async function openSample(page: Page): Promise<void> {
  if (page.url() === 'about:blank') await page.goto('/');
  await page.getByRole('button', { name: 'Open the sample scan' }).click();
  await expect.poll(() => triangles(page), { timeout: 60_000 }).toBeGreaterThan(10_000);
}

/** How often the grey value along the middle row of the picture turns from dark to light: the stripes that are seen. */
export async function stripes(page: Page): Promise<number> {
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  return page.evaluate(async () => {
    const blob = await globalThis.batten?.view?.picture();
    if (!blob) return -1;
    const image = await createImageBitmap(blob);
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    if (!context) return -1;
    context.drawImage(image, 0, 0);
    const row = context.getImageData(0, Math.floor(image.height / 2), image.width, 1).data;
    let count = 0;
    let light = false;
    for (let i = 0; i < row.length; i += 4) {
      const grey = (row[i + 3] ?? 0) < 128 ? -1 : (row[i] ?? 0) + (row[i + 1] ?? 0) + (row[i + 2] ?? 0);
      if (grey > 480 && !light) {
        ++count;
        light = true;
      } else if (grey >= 0 && grey < 250) light = false;
    }
    return count;
  });
}

/** Pictures of the documents are made by the tests that show the same: BATTEN_PICTURES=yes npm run pages. */
export async function picture(page: Page, name: string): Promise<void> {
  if (!process.env.BATTEN_PICTURES) return;
  const leave = page.getByRole('button', { name: 'Leave' });
  if (await leave.isVisible()) await leave.click();
  await page.waitForTimeout(1000); // drawn, not only asked for
  await page.screenshot({ path: new URL(`../../../docs/pictures/${name}.png`, import.meta.url).pathname });
}
