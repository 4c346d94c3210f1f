import { afterEach, expect, it, vi } from 'vitest';
import { Recorder } from '../../src/phone/recorder';

/** What the page keeps when it is killed: all that the storage holds at that moment. */
class Kept implements Partial<Storage> {
  text: string | null = null;
  getItem = () => this.text;
  setItem = (_: string, text: string) => {
    this.text = text;
  };
  removeItem = () => {
    this.text = null;
  };
}

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('a page that is killed at 1,000 moments loses at most a second of readings, and no curve', async () => {
  vi.useFakeTimers({ toFake: ['performance', 'setTimeout'] });
  vi.stubGlobal('window', new EventTarget());
  vi.stubGlobal('DeviceOrientationEvent', class {});
  vi.stubGlobal('navigator', {});
  const kept = new Kept();
  const recorder = new Recorder(kept as unknown as Storage);
  await recorder.listen();
  const all = (one: Recorder) => [...one.scan.value.curves, ...(one.current.value ? [one.current.value] : [])];
  let mostLost = 0;
  for (let tick = 0; tick < 6000; ++tick) {
    const inCurve = tick % 1500;
    if (inCurve === 100) recorder.begin(false);
    if (inCurve === 400 || inCurve === 1300) recorder.pressNode(null);
    if (inCurve === 430 || inCurve === 1320) recorder.releaseNode();
    if (inCurve === 1330) recorder.undoNode();
    if (inCurve === 1400) recorder.finish();
    vi.advanceTimersByTime(1000 / 60);
    const event = Object.assign(new Event('deviceorientation'), { alpha: (tick / 5) % 360, beta: 30 * Math.sin(tick / 90), gamma: 10 });
    Object.defineProperty(event, 'timeStamp', { value: performance.now() });
    globalThis.window.dispatchEvent(event);
    if (tick % 6 !== 0) continue;
    // Killed here; another page begins with what was kept.
    const storage = new Kept();
    storage.text = kept.text;
    const found = all(new Recorder(storage as unknown as Storage));
    const drawn = all(recorder).filter((curve) => curve.readings.length > 1);
    const current = recorder.current.value;
    // A curve that is a moment old may be in that second.
    const isYoung = current !== null && (current.readings.at(-1)?.time ?? 0) <= 1;
    expect(found.length).toBeGreaterThanOrEqual(drawn.length - (isYoung ? 1 : 0));
    found.forEach((curve, c) => {
      const before = drawn[c];
      const lost = (before?.readings.at(-1)?.time ?? 0) - (curve.readings.at(-1)?.time ?? 0);
      mostLost = Math.max(mostLost, lost);
      expect(curve.nodes).toEqual(before?.nodes);
      if (before !== current) expect(lost).toBe(0);
    });
  }
  expect(recorder.scan.value.curves.length).toBe(4);
  expect(mostLost).toBeGreaterThan(0.5); // something was in flight
  expect(mostLost).toBeLessThanOrEqual(1.02);
});
