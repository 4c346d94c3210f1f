/** Devices behind `batten studio`: recorded, followed, replayed, made into a scan and its surface. */
import { type ChildProcess, spawn } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { existsSync, mkdtempSync, readdirSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { expect, type Page, test } from '@playwright/test';
import { picture, triangles } from './page';

const root = new URL('../../../', import.meta.url).pathname;
const program = process.env.BATTEN_PROGRAM ?? join(root, 'build/release/bin/batten');

/** A number of a section of the panel, by its name. */
async function figure(page: Page, section: string, name: string): Promise<number> {
  const part = page.locator('details').filter({ has: page.locator('summary').getByText(section, { exact: true }) });
  const text = await part.locator('dl.figures div').filter({ has: page.getByText(name, { exact: true }) }).locator('dd').innerText();
  return Number.parseFloat(text.replace(/,/g, ''));
}
/** A port for datagrams that nobody has. */
function freePort(): Promise<number> {
  return new Promise((resolve) => {
    const socket = createSocket('udp4').bind(0, '127.0.0.1', () => {
      const { port } = socket.address();
      socket.close(() => resolve(port));
    });
  });
}
const RESULT = 'What came of it';

test('without the server the room says what it needs', async ({ page }) => {
  await page.goto('/');
  await page.keyboard.press('Control+5');
  await expect(page.getByText(/batten studio FOLDER/)).toBeVisible();
});

test.describe('with the server', () => {
  test.skip(!existsSync(program), 'the program is not built: ./test program web');

  let server: ChildProcess;
  let folder: string;
  let url: string;
  test.beforeEach(async () => {
    folder = mkdtempSync(join(tmpdir(), 'batten-capture-'));
    server = spawn(program, ['studio', folder, '--no-browser', '--json', '--port', '0', '--page', join(root, 'web/dist')]);
    for await (const line of createInterface({ input: server.stdout as NodeJS.ReadableStream })) {
      url = (JSON.parse(line) as { url: string }).url;
      break;
    }
  });
  test.afterEach(() => {
    server.kill('SIGTERM');
  });

  test('a simulated device with wrong packets becomes a surface, and is replayed', async ({ page }) => {
    await page.goto(url);
    await page.getByRole('button', { name: 'Capture', exact: true }).click();
    await expect(page.locator('#capture-source optgroup').first()).toHaveAttribute('label', 'Simulated devices');
    await page.getByLabel('From').selectOption('simulator:bumpycube');
    await page.getByLabel('Faults').selectOption('flip=0.05%');
    await page.getByLabel('Speed').selectOption('max');
    await expect(page.getByLabel('Source')).toHaveValue('simulator:bumpycube?flip=0.05%&speed=max');
    await page.getByRole('button', { name: 'Start recording' }).click();
    await expect(page.getByText(RESULT)).toBeVisible({ timeout: 120_000 });
    expect(readdirSync(folder)).toEqual(['recording.blog']);
    const readings = await figure(page, RESULT, 'readings');
    expect(await figure(page, RESULT, 'wrong, left out')).toBeGreaterThan(50);
    await picture(page, 'studio-capture');

    await page.getByLabel('Replay', { exact: true }).selectOption('16');
    await page.getByRole('button', { name: 'Replay recording.blog' }).click();
    await expect(page.getByText(RESULT)).toBeHidden();
    await expect(page.getByText(RESULT)).toBeVisible({ timeout: 120_000 });
    expect(await figure(page, RESULT, 'readings')).toBe(readings);

    await page.getByRole('button', { name: 'Make the scan and its surface' }).click();
    await expect.poll(() => triangles(page), { timeout: 120_000 }).toBeGreaterThan(5_000);
    expect(await page.evaluate(() => globalThis.batten?.room.value)).toBe('reconstruct');
    await expect(page.getByText('yes', { exact: true })).toBeVisible(); // closed, as the cube is
    expect(await page.evaluate(() => globalThis.batten?.store.objects.value.map((one) => one.kind))).toEqual(['scan', 'network', 'mesh']);
  });

  test('a device is followed through being unplugged, by keys of page and keyboard, and when the page is loaded again', async ({ page }) => {
    await page.goto(url);
    await page.getByRole('button', { name: 'Capture', exact: true }).click();
    await page.getByLabel('Source').fill('simulator:bumpycube?unplug=6:1');
    await page.getByRole('button', { name: 'Start recording' }).click();
    await expect(page.getByText(/It is opened anew/)).toBeVisible({ timeout: 30_000 });
    await expect(page.getByText('answers again')).toBeVisible({ timeout: 30_000 });
    const text = await page.locator('dl.figures div').filter({ hasText: 'to the picture' }).locator('dd').innerText();
    console.log(`reading to picture: ${text}`); // 30 ms are wanted; machines that test are busy
    expect(Number.parseFloat(text)).toBeLessThan(200);
    await page.keyboard.press('Control+Enter');
    await expect(page.getByText(RESULT)).toBeVisible();

    // A source from which nothing comes, so that all keys are ours.
    await page.getByLabel('Source').fill(`udp:${await freePort()}`);
    await page.getByRole('button', { name: 'Start recording' }).click();
    await page.getByRole('button', { name: 'New curve on its border' }).click();
    await expect.poll(() => figure(page, 'recording 2.blog', 'curve')).toBe(1);
    await page.getByRole('heading', { name: 'Capture' }).click(); // nothing has the focus
    await page.keyboard.press('4');
    await page.keyboard.press('2');
    await expect(page.getByLabel('Number being typed')).toHaveText('node 42_');
    await page.keyboard.press('Enter');
    await expect.poll(() => figure(page, 'recording 2.blog', 'nodes')).toBe(1);
    expect(await page.evaluate(() => globalThis.batten?.room.value)).toBe('capture');
    // The page loaded again finds it.
    await page.reload();
    await page.keyboard.press('Control+5');
    await expect.poll(() => figure(page, 'recording 2.blog', 'nodes')).toBe(1);
    await page.keyboard.press('Backspace');
    await expect.poll(() => figure(page, 'recording 2.blog', 'nodes')).toBe(0);
    await page.getByRole('button', { name: 'Stop recording' }).click();
    await expect(page.getByText(RESULT)).toBeVisible();
    expect(readdirSync(folder)).toEqual(['recording 2.blog', 'recording.blog']);
  });
});
