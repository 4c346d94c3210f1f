/** The page behind `batten studio`: a folder's file opened, its surface written back, and nobody else let in. */
import { type ChildProcess, spawn } from 'node:child_process';
import { copyFileSync, existsSync, mkdtempSync, readFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { expect, test } from '@playwright/test';
import { triangles } from './page';

const root = new URL('../../../', import.meta.url).pathname;
const program = process.env.BATTEN_PROGRAM ?? join(root, 'build/release/bin/batten');

test.describe('with the server', () => {
  test.skip(!existsSync(program), 'the program is not built: ./test program web');

  let server: ChildProcess;
  let folder: string;
  let url: string;
  test.beforeAll(async () => {
    folder = mkdtempSync(join(tmpdir(), 'batten-studio-'));
    copyFileSync(join(root, 'data/sample.rawnet'), join(folder, 'hull.rawnet'));
    server = spawn(program, ['studio', folder, '--no-browser', '--json', '--port', '0', '--page', join(root, 'web/dist')]);
    const lines = createInterface({ input: server.stdout as NodeJS.ReadableStream });
    for await (const line of lines) {
      url = (JSON.parse(line) as { url: string }).url;
      break;
    }
  });
  test.afterAll(() => {
    server.kill('SIGTERM');
  });

  test('a file of the folder becomes a surface in the folder', async ({ page }) => {
    await page.goto(url);
    await page.getByRole('button', { name: 'hull.rawnet' }).click();
    await expect.poll(() => triangles(page), { timeout: 60_000 }).toBeGreaterThan(10_000);
    expect(page.url()).not.toContain('#'); // the secret is not left in the address
    await page.getByLabel('Save the selected object as').selectOption('ply');
    await expect(page.getByText(/hull surface\.ply is in the folder/)).toBeVisible();
    expect(readFileSync(join(folder, 'hull surface.ply')).subarray(0, 3).toString()).toBe('ply');
    // STEP by the native library, whichever engine holds the project; without Open Cascade it says how to get it.
    await page.getByLabel('Save the selected object as').selectOption('step');
    await expect(page.getByText(/hull surface\.step is in the folder|Open Cascade/)).toBeVisible({ timeout: 60_000 });
    const step = join(folder, 'hull surface.step');
    if (existsSync(step)) expect(readFileSync(step, 'latin1')).toContain('B_SPLINE_SURFACE');
    // The page again, without the secret: the cookie is enough.
    await page.reload();
    await expect.poll(() => triangles(page), { timeout: 60_000 }).toBeGreaterThan(10_000);
    expect(await page.evaluate(() => globalThis.batten?.folder.value?.files.length)).toBe(2); // STEP is written, not opened
  });

  test('the native engine takes the project over and gives the same', async ({ page }) => {
    // The secret of the address is spent: the cookie of this context was not. A server of its own, then.
    const own = spawn(program, ['studio', folder, '--no-browser', '--json', '--port', '0', '--page', join(root, 'web/dist')]);
    let address = '';
    for await (const line of createInterface({ input: own.stdout })) {
      address = (JSON.parse(line) as { url: string }).url;
      break;
    }
    try {
      await page.goto(address);
      await page.getByRole('button', { name: 'hull.rawnet' }).click();
      await expect.poll(() => triangles(page), { timeout: 60_000 }).toBeGreaterThan(10_000);
      const inPage = await triangles(page);
      await page.keyboard.press('Control+k');
      await page.getByLabel('Words of a command').fill('native');
      await page.keyboard.press('Enter');
      await expect(page.getByText('native engine', { exact: true })).toBeVisible({ timeout: 60_000 });
      await expect.poll(() => triangles(page), { timeout: 60_000 }).toBe(inPage);
      await page.keyboard.press('Control+z'); // the history came over
      await expect.poll(() => page.evaluate(() => globalThis.batten?.store.objects.value.length)).toBe(2);
      // The server is killed: the page goes on with what was done there, but for the edit in flight.
      own.kill('SIGKILL');
      await page.waitForTimeout(200);
      await page.keyboard.press('Control+Shift+z');
      await expect(page.getByText('The engine was started again, in this page.')).toBeVisible({ timeout: 60_000 });
      await expect(page.getByText('engine in this page', { exact: true })).toBeVisible();
      await expect.poll(() => page.evaluate(() => globalThis.batten?.store.objects.value.length)).toBe(2);
      await page.keyboard.press('Control+Shift+z');
      await expect.poll(() => page.evaluate(() => globalThis.batten?.store.objects.value.length)).toBe(3);
      await page.getByRole('button', { name: 'hull surface', exact: true }).click();
      await expect.poll(() => triangles(page), { timeout: 60_000 }).toBe(inPage);
    } finally {
      own.kill('SIGTERM');
    }
  });

  test('another browser has the page and no files', async ({ browser }) => {
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.goto(url.replace(/#.*/, ''));
    await expect(page.getByRole('button', { name: 'Open the sample scan' })).toBeVisible();
    await expect.poll(() => page.evaluate(() => globalThis.batten?.store.started.value)).toBe(true);
    expect(await page.evaluate(() => globalThis.batten?.folder.value)).toBeNull();
    await context.close();
  });
});
