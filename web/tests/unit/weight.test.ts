/** How much a first visit has to load. */
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';
import { describe, expect, it } from 'vitest';

const dist = new URL('../../dist/', import.meta.url);

describe.skipIf(!existsSync(dist))('the page that was built', () => {
  const packed = (pattern: RegExp) =>
    readdirSync(new URL('assets/', dist))
      .filter((name) => pattern.test(name))
      .reduce((sum, name) => sum + gzipSync(readFileSync(new URL(`assets/${name}`, dist))).length, 0) / 1000;

  // 170 kB are wanted at most; what has been won is kept.
  it('has at most 140 kB of JavaScript before the engine', () => {
    const page = readFileSync(new URL('index.html', dist), 'utf8');
    const scripts = [...page.matchAll(/assets\/([\w-]+\.js)/g)].map((match) => match[1] ?? '');
    expect(scripts.length).toBeGreaterThan(0);
    expect(scripts.reduce((sum, name) => sum + packed(new RegExp(`^${name}$`)), 0)).toBeLessThanOrEqual(140);
  });
  it('has an engine of at most 2,000 kB', () => {
    // All rooms in one module. 900 kB are wanted, by parts that are loaded when they are needed.
    expect(packed(/\.wasm$/)).toBeLessThanOrEqual(2000);
  });
});
