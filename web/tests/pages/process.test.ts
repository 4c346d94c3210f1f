/** Steps on meshes: a hole mended, a place pulled at; each with its command line, each undone. */
import { expect, type Page, test } from '@playwright/test';
import { picture } from './page';

/** A sheet of n × n squares over 100 × 100, a little curved, without the middle one where it is torn. */
function sheet(n: number, torn: boolean): string {
  const lines = [];
  for (let i = 0; i <= n; ++i)
    for (let j = 0; j <= n; ++j) {
      const [x, y] = [(100 * i) / n, (100 * j) / n];
      lines.push(`v ${x} ${y} ${8 * Math.sin(x / 30) * Math.cos(y / 25)}`);
    }
  for (let i = 0; i < n; ++i)
    for (let j = 0; j < n; ++j) {
      if (torn && i === Math.floor(n / 2) && j === Math.floor(n / 2)) continue;
      const a = i * (n + 1) + j + 1;
      lines.push(`f ${a} ${a + n + 1} ${a + n + 2}`, `f ${a} ${a + n + 2} ${a + 1}`);
    }
  return lines.join('\n');
}

test.setTimeout(120_000);

async function open(page: Page, name: string, text: string): Promise<void> {
  await page.goto('/');
  await expect.poll(() => page.evaluate(() => globalThis.batten?.store.started.value)).toBe(true);
  await page.evaluate(([name, text]) => globalThis.batten?.openFiles([[name, new Blob([text])]]), [name, text] as const);
  await page.keyboard.press('Control+4');
}

const selected = (page: Page) =>
  page.evaluate(() => {
    const store = globalThis.batten?.store;
    const object = store?.selectedObject.value;
    const drawn = object && store?.drawn.value.get(object.id);
    const z = [...(drawn?.positions ?? [])].filter((_, i) => i % 3 === 2).map((one) => one + (drawn?.origin[2] ?? 0));
    return {
      kind: object?.request?.kind,
      borders: drawn?.mesh?.n_borders,
      top: Math.max(...z),
      motion: (object?.request?.moved as { translation: number[]; angle: number }[] | undefined)?.[0],
    };
  });

test('a torn mesh is mended, with what was done and the same command line', async ({ page }) => {
  await open(page, 'sheet.obj', sheet(20, true));
  await page.getByLabel('Do', { exact: true }).selectOption('repair');
  await page.getByLabel('Holes').selectOption('small');
  await page.getByRole('spinbutton', { name: 'Edges' }).fill('6');
  await page.getByRole('spinbutton', { name: 'Edges' }).press('Enter');
  await expect(page.getByLabel('The same on the command line')).toHaveValue('batten repair sheet.ply -o sheet-repair.ply --fill-holes 6');
  await page.getByRole('button', { name: 'Repair', exact: true }).click();
  await expect.poll(() => selected(page)).toMatchObject({ kind: 'repair', borders: 1 });
  await expect(page.getByRole('heading', { name: 'Done' })).toBeVisible();
  await page.keyboard.press('Control+z');
  await expect.poll(() => page.evaluate(() => globalThis.batten?.store.objects.value.length)).toBe(1);
});

test('a number that is being typed stays when another value arrives, and Escape takes it back', async ({ page }) => {
  await open(page, 'sheet.obj', sheet(5, true));
  await page.getByLabel('Do', { exact: true }).selectOption('repair');
  await page.getByLabel('Holes').selectOption('small');
  const field = page.getByRole('spinbutton', { name: 'Edges' });
  const slider = page.getByRole('slider', { name: 'Edges' });
  // Its places are logarithms. The panel is drawn again, as when a step ends.
  const slide = (place: string) =>
    slider.evaluate((one: HTMLInputElement, to) => {
      one.value = to;
      one.dispatchEvent(new Event('input', { bubbles: true }));
    }, place);
  await slide('1.6');
  await expect(field).toHaveValue('40');
  await field.click({ clickCount: 3 });
  await page.keyboard.type('12');
  await slide('1.7');
  await expect(page.getByLabel('The same on the command line')).toHaveValue(/--fill-holes 50$/);
  await expect(field).toHaveValue('12');
  await page.keyboard.press('Escape');
  await expect(field).toHaveValue('50');
  await field.click({ clickCount: 3 });
  await page.keyboard.type('7');
  await page.keyboard.press('Enter');
  await expect(page.getByLabel('The same on the command line')).toHaveValue(/--fill-holes 7$/);
  await field.click({ clickCount: 3 });
  await page.keyboard.press('Delete');
  await page.keyboard.press('Enter');
  await expect(field).toHaveValue('7');
});

test('before and after stand beside each other, with a line between that is dragged and moved by keys', async ({ page }) => {
  await open(page, 'sheet.obj', sheet(11, true));
  await page.getByLabel('Do', { exact: true }).selectOption('repair');
  await page.getByLabel('Holes').selectOption('all');
  await page.getByRole('button', { name: 'Repair', exact: true }).click();
  await expect.poll(() => selected(page)).toMatchObject({ kind: 'repair' });
  await page.keyboard.press('3'); // from above: the hole is in the middle
  await page.getByLabel('Show', { exact: true }).selectOption('both');
  const line = page.getByRole('slider', { name: 'Line between before and after' });
  await expect(line).toHaveAttribute('aria-valuenow', '50');
  /** Whether something is drawn in the middle of the view, beside the line. */
  const middle = () =>
    page.evaluate(async () => {
      const blob = await globalThis.batten?.view?.picture();
      if (!blob) throw new Error('no picture');
      const image = await createImageBitmap(blob);
      const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
      context?.drawImage(image, 0, 0);
      return context?.getImageData(image.width / 2, image.height / 2, 1, 1).data[3] === 255;
    });
  await line.focus();
  for (let i = 0; i < 3; ++i) await page.keyboard.press('Shift+ArrowRight');
  await expect(line).toHaveAttribute('aria-valuenow', '80');
  expect(await middle()).toBe(false);
  const box = await page.getByRole('application').boundingBox();
  const grip = await line.boundingBox();
  if (!box || !grip) throw new Error('no view');
  await page.mouse.move(grip.x, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.45 * box.width, box.y + box.height / 2, { steps: 4 });
  await page.mouse.up();
  await expect(line).toHaveAttribute('aria-valuenow', '45');
  expect(await middle()).toBe(true);
  await page.keyboard.press('Control+3'); // another room shows what was made, whole
  await expect(line).toHaveCount(0);
});

test('a place is held and dragged: a preview, a step, moved by an arrow, changed by a number, undone', async ({ page }) => {
  await open(page, 'sheet.obj', sheet(30, false));
  await page.getByLabel('Do', { exact: true }).selectOption('deform');
  const rest = (await selected(page)).top;
  const box = await page.getByRole('application').boundingBox();
  if (!box) throw new Error('no view');
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await expect(page.getByText('vertices of the handle')).toBeVisible();
  for (let i = 1; i <= 8; ++i) await page.mouse.move(x, y - 12 * i);
  await page.mouse.up();
  await expect.poll(() => selected(page)).toMatchObject({ kind: 'deform' });
  await expect.poll(async () => (await selected(page)).top).toBeGreaterThan(rest + 5);
  await picture(page, 'studio-process');
  // By its arrow the place moves along z alone.
  const tip = await page.evaluate(() => {
    const { view, store } = globalThis.batten ?? {};
    const moved = (store?.selectedObject.value?.request?.moved as { translation: number[]; about: number[] }[] | undefined)?.[0];
    if (!view || !moved) return null;
    const centre = view.fromModel(moved.about.map((one, i) => one + (moved.translation[i] ?? 0)));
    return view.onScreen(centre.setZ(centre.z + 0.2 * view.size()));
  });
  if (!tip) throw new Error('nothing is held');
  const before = (await selected(page)).motion?.translation ?? [];
  await page.mouse.move(box.x + tip.x, box.y + tip.y);
  await page.mouse.down();
  for (let i = 1; i <= 4; ++i) await page.mouse.move(box.x + tip.x + 3 * i, box.y + tip.y - 8 * i);
  await page.mouse.up();
  await expect.poll(async () => (await selected(page)).motion?.translation[2]).toBeGreaterThan((before[2] ?? 0) + 2);
  expect((await selected(page)).motion?.translation.slice(0, 2)).toEqual(before.slice(0, 2));
  const z = page.getByRole('spinbutton', { name: /^Move z/ });
  // The step is made and told: a field is written anew until then.
  await expect.poll(() => page.evaluate(() => globalThis.batten?.store.work.value ?? null)).toBeNull();
  const told = (await selected(page)).motion?.translation[2] ?? 0;
  await expect.poll(async () => Number(await z.inputValue())).toBeCloseTo(told, 1);
  await z.fill('40');
  await z.press('Enter');
  await expect.poll(async () => (await selected(page)).motion?.translation[2]).toBe(40);
  await expect.poll(async () => (await selected(page)).top).toBeGreaterThan(30);
  await page.keyboard.press('Control+z');
  await expect.poll(async () => (await selected(page)).motion?.translation[2]).toBeLessThan(40);
  await page.keyboard.press('Control+z');
  await expect.poll(async () => (await selected(page)).motion?.translation).toEqual(before);
  await page.keyboard.press('Control+z');
  await expect.poll(() => page.evaluate(() => globalThis.batten?.store.objects.value.length)).toBe(1);
  // By the keyboard alone.
  await page.getByRole('application').focus();
  await page.keyboard.press('Shift+D');
  await expect(page.getByText('vertices of the handle')).toBeVisible();
});
