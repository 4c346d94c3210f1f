import { defineConfig } from '@playwright/test';

// Another port where several work on one machine.
const port = process.env.BATTEN_PAGE_PORT ?? '4173';
const url = `http://127.0.0.1:${port}`;

// The distribution's Chromium; software rendering, which draws the same everywhere.
export default defineConfig({
  testDir: 'tests/pages',
  workers: 1,
  timeout: 180_000,
  expect: { timeout: 15_000 }, // machines that test are busy
  retries: 1, // so busy that a step takes minutes; what passes at the second try is listed as flaky
  reporter: [['list']],
  use: {
    baseURL: url,
    viewport: { width: 1280, height: 800 },
    launchOptions: {
      executablePath: process.env.BATTEN_CHROMIUM ?? '/usr/bin/chromium',
      args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
    },
    trace: 'retain-on-failure',
  },
  webServer: { command: `npx vite preview --host 127.0.0.1 --port ${port} --strictPort`, url, reuseExistingServer: true },
});
