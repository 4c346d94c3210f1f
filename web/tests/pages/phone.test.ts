/** A telephone slid over three great circles of a ball of 50 mm, with injected orientations: curves, surface, files; then killed. */
import { readFileSync } from 'node:fs';
import { expect, type Page, test } from '@playwright/test';
import { picture } from './page';

const RADIUS = 50;
const SECONDS_A_QUARTER = 0.8;
type Three = [number, number, number];

// Great circles by two of their directions, and the nodes met: the axes +x +y -x -y +z -z have the numbers 1 to 6.
const CIRCLES: { a: Three; b: Three; nodes: number[] }[] = [
  { a: [1, 0, 0], b: [0, 1, 0], nodes: [1, 2, 3, 4, 1] },
  { a: [1, 0, 0], b: [0, 0, 1], nodes: [1, 5, 3, 6, 1] },
  { a: [0, 1, 0], b: [0, 0, 1], nodes: [2, 5, 4, 6, 2] },
];

/** Begins to send orientations: those of a telephone at an angle of a circle, which `go` moves on at even speed. */
async function startSending(page: Page): Promise<void> {
  await page.evaluate(() => {
    const state = { a: [1, 0, 0], b: [0, 1, 0], angle: 0, goal: 0, speed: 0, last: performance.now() };
    Object.assign(globalThis, { sending: state });
    setInterval(() => {
      const now = performance.now();
      state.angle = Math.min(state.goal, state.angle + (state.speed * (now - state.last)) / 1000);
      state.last = now;
      const [c, s] = [Math.cos(state.angle), Math.sin(state.angle)];
      const n = [0, 1, 2].map((k) => c * (state.a[k] ?? 0) + s * (state.b[k] ?? 0));
      const t = [0, 1, 2].map((k) => -s * (state.a[k] ?? 0) + c * (state.b[k] ?? 0));
      const [tx = 0, ty = 0, tz = 0] = t;
      const [nx = 0, ny = 0, nz = 0] = n;
      // The inverse of Rz(alpha) Rx(beta) Ry(gamma); x is t × n. Looking straight up or down alpha is free.
      const beta = Math.asin(Math.max(-1, Math.min(1, tz)));
      const upright = Math.hypot(tx, ty) < 1e-9;
      const alpha = upright ? 0 : Math.atan2(-tx, ty);
      const xz = tx * ny - ty * nx;
      const gamma = upright ? Math.atan2(nx, tz > 0 ? -ny : ny) : Math.atan2(-xz, nz);
      const deg = 180 / Math.PI;
      const turn = state.angle < state.goal ? state.speed * deg : 0;
      const push = turn > 0 ? 0.5 : 0.01;
      dispatchEvent(
        new DeviceMotionEvent('devicemotion', {
          acceleration: { x: push, y: 0, z: 0 },
          rotationRate: { alpha: turn, beta: 0, gamma: 0 },
          interval: 15,
        }),
      );
      dispatchEvent(new DeviceOrientationEvent('deviceorientation', { alpha: alpha * deg, beta: beta * deg, gamma: gamma * deg }));
    }, 15);
  });
}
const place = (page: Page, a: Three, b: Three) =>
  page.evaluate(([a, b]) => Object.assign((globalThis as unknown as { sending: object }).sending, { a, b, angle: 0, goal: 0, speed: 0 }), [a, b]);
async function go(page: Page, quarter: number): Promise<void> {
  await page.evaluate(
    ([goal, speed]) => Object.assign((globalThis as unknown as { sending: object }).sending, { goal, speed, last: performance.now() }),
    [(quarter * Math.PI) / 2, Math.PI / 2 / SECONDS_A_QUARTER],
  );
}
const arrived = (page: Page) =>
  expect
    .poll(() => page.evaluate(() => { const { sending } = globalThis as unknown as { sending: { angle: number; goal: number } }; return sending.goal - sending.angle; }), { intervals: [20] })
    .toBe(0);

test('three circles become a ball of the right size, offline, and a killed page loses nothing', async ({ browser }) => {
  const context = await browser.newContext({ viewport: { width: 390, height: 760 }, hasTouch: true, isMobile: true, acceptDownloads: true });
  const page = await context.newPage();
  await page.goto('/phone.html');
  await page.evaluate(() => navigator.serviceWorker.ready);
  await context.setOffline(true);
  await page.reload();
  await page.getByRole('button', { name: 'Turn the sensors on' }).click();
  await startSending(page);
  await expect(page.getByText(/✓ sensors \d+ Hz/)).toBeVisible();

  for (const [c, { a, b, nodes }] of CIRCLES.entries()) {
    await place(page, a, b);
    await page.getByRole('button', { name: /New curve/ }).click();
    const met = new Set(CIRCLES.slice(0, c).flatMap((circle) => circle.nodes));
    for (const [i, node] of nodes.entries()) {
      if (i > 0) await arrived(page);
      const button = met.has(node) ? page.getByRole('button', { name: `● ${node}` }) : page.getByRole('button', { name: /^NODE/ });
      met.add(node);
      const box = await button.boundingBox();
      if (!box) throw new Error('no button');
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await page.mouse.down();
      await expect(page.getByText('At a node')).toBeVisible();
      if (c === 1 && i === 2) await picture(page, 'phone-record');
      // The hand rests until it lets go.
      await page.mouse.up();
      if (i < nodes.length - 1) await go(page, i + 1);
    }
    await page.getByRole('button', { name: 'Curve is done' }).click();
  }

  // Killed and opened again: everything is there.
  await page.reload();
  const lengths = page.getByRole('spinbutton');
  await expect(lengths).toHaveCount(3);
  for (let i = 0; i < 3; ++i) {
    await lengths.nth(i).fill(String(2 * Math.PI * RADIUS));
    await lengths.nth(i).press('Tab');
  }
  await page.getByRole('button', { name: 'Make the surface' }).click();
  await expect(page.getByText(/triangles, closed/)).toBeVisible({ timeout: 60_000 });
  await picture(page, 'phone-surface');
  const { diameter, radii } = await page.evaluate(() => {
    const { store } = (globalThis as unknown as { battenPhone: { store: import('../../src/document/store').Store } }).battenPhone;
    const drawn = [...store.drawn.value.values()].at(-1);
    const list = drawn?.positions ?? [];
    const radii: number[] = [];
    for (let i = 0; i < list.length; i += 3) radii.push(Math.hypot(list[i] ?? 0, list[i + 1] ?? 0, list[i + 2] ?? 0));
    return { diameter: drawn?.mesh?.diameter ?? 0, radii: [Math.min(...radii), Math.max(...radii)] };
  });
  // A timer is no even hand: the size within 3 %, and round within 8 %.
  expect(diameter / (2 * Math.sqrt(3) * RADIUS)).toBeGreaterThan(0.97);
  expect(diameter / (2 * Math.sqrt(3) * RADIUS)).toBeLessThan(1.03);
  expect((radii[0] ?? 0) / RADIUS).toBeGreaterThan(0.92);
  expect((radii[1] ?? 0) / RADIUS).toBeLessThan(1.08);

  const download = page.waitForEvent('download');
  await page.getByRole('button', { name: 'Save PLY' }).click();
  expect(readFileSync(await (await download).path()).subarray(0, 3).toString()).toBe('ply');
  await context.close();
});

test('says what is wrong where no sensor speaks', async ({ page }) => {
  await page.goto('/phone.html');
  await page.getByRole('button', { name: 'Turn the sensors on' }).click();
  await expect(page.getByRole('alert')).toContainText(/sensor/i, { timeout: 10_000 });
});
