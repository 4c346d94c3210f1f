/** Everybody can use it: nothing serious or critical for axe in any room, in both themes. */
import AxeBuilder from '@axe-core/playwright';
import { expect, test } from '@playwright/test';
import { openSample } from './page';

for (const colorScheme of ['light', 'dark'] as const)
  test(`no serious fault for axe, ${colorScheme}`, async ({ browser }) => {
    const context = await browser.newContext({ colorScheme });
    const page = await context.newPage();
    await page.goto('/');
    const check = async (where: string) => {
      const { violations } = await new AxeBuilder({ page }).analyze();
      const bad = violations.filter((one) => one.impact === 'serious' || one.impact === 'critical');
      expect(bad.map((one) => `${where}: ${one.id} ${one.nodes.map((node) => node.target).join(' ')}`)).toEqual([]);
    };
    await check('welcome');
    await openSample(page);
    await check('reconstruct');
    await page.keyboard.press('Control+2');
    await check('sketch');
    await page.keyboard.press('Control+3');
    for (const key of ['Shift+C', 'Shift+X', 'Shift+T']) await page.keyboard.press(key);
    await expect(page.getByText('area inside')).toBeVisible();
    await check('inspect');
    await page.keyboard.press('Control+4');
    await page.getByLabel('Do', { exact: true }).selectOption('deform');
    await check('process');
    await page.keyboard.press('Control+5');
    await expect(page.getByText(/batten studio FOLDER/)).toBeVisible();
    await check('capture');
    await page.keyboard.press('Control+k');
    await check('palette');
    await page.keyboard.press('Escape');
    await page.keyboard.press('?');
    await check('keys');
    await context.close();
  });
