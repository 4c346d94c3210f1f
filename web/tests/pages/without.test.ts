/** A browser that keeps nothing, cannot work offline, has no file dialogs of its own, shares no memory and draws no 3D. */
import { expect, test } from '@playwright/test';
import { triangles } from './page';

test('works without storage, service worker, file access and WebGL2, and says what it cannot do', async ({ page }) => {
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(error.message));
  await page.addInitScript(() => {
    const take = (object: object, name: string) => Object.defineProperty(object, name, { value: undefined, configurable: true });
    take(StorageManager.prototype, 'getDirectory');
    take(Navigator.prototype, 'serviceWorker');
    Reflect.deleteProperty(Navigator.prototype, 'serviceWorker');
    take(globalThis, 'showOpenFilePicker');
    take(globalThis, 'showSaveFilePicker');
    take(globalThis, 'SharedArrayBuffer');
    Object.defineProperty(globalThis, 'localStorage', {
      get: () => {
        throw new Error('denied');
      },
    });
    const getContext = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string, ...rest: unknown[]) {
      return kind.startsWith('webgl') ? null : Reflect.apply(getContext, this, [kind, ...rest]);
    } as typeof getContext;
  });
  // The journal is the worker's: what it would open is taken away there too.
  await page.route(/assets\/worker-.*\.js$/, async (route) => {
    const answer = await route.fetch();
    await route.fulfill({ response: answer, body: `delete StorageManager.prototype.getDirectory;\n${await answer.text()}` });
  });
  await page.goto('/');
  await expect(page.getByText('This browser draws no 3D pictures (WebGL2).')).toBeVisible();
  await page.getByRole('button', { name: 'Open the sample scan' }).click();
  await expect.poll(() => triangles(page), { timeout: 60_000 }).toBeGreaterThan(10_000);
  await expect(page.getByText('not kept: save the project')).toBeVisible();
  for (const room of ['Sketch', 'Inspect', 'Process', 'Capture', 'Reconstruct']) {
    await page.getByRole('button', { name: room, exact: true }).click();
    await expect(page.getByRole('complementary')).not.toHaveText('');
  }
  // Figures are there without a picture, and files go out as downloads.
  await page.getByRole('button', { name: 'Inspect', exact: true }).click();
  await page.getByRole('button', { name: 'Check all curves' }).click();
  await expect(page.getByText(/smooth curves (pass|fail)/)).toBeVisible({ timeout: 30_000 });
  const download = page.waitForEvent('download');
  await page.getByLabel('Save the selected object as').selectOption('ply');
  await download;
  // Without the server STEP says where it comes from.
  await page.getByLabel('Save the selected object as').selectOption('step');
  await expect(page.getByText('batten studio', { exact: false })).toBeVisible();
  expect(errors).toEqual([]);
});
