/** Listens to the phone while a curve is drawn, and keeps what it hears. */
import { signal } from '@preact/signals';
import { angleBetween, frameOf, rateOf, type Reading } from './orientation';
import { emptyScan, nextNode, type PhoneCurve, type PhoneScan } from './scan';

/** Faster turning than this blurs a curve, radians per second. */
const TOO_FAST = 2.5;
/** A hand that moves turns faster than this, degrees per second, or pushes harder than that, metres per second squared. */
const REST_TURN = 2;
const REST_PUSH = 0.25;
/** It rests when neither was seen for so long, milliseconds. */
const REST_AFTER_MS = 100;
/** A reading every so many seconds is enough for a hand. */
const LEAST_STEP = 1 / 60;
const KEEP_EVERY_MS = 1000;
const KEY = 'batten-phone-scan';

export type SensorState = 'unknown' | 'asking' | 'refused' | 'silent' | 'ready';

export class Recorder {
  readonly scan = signal<PhoneScan>(emptyScan());
  readonly sensors = signal<SensorState>('unknown');
  readonly rate = signal<{ rate: number; jitter: number } | null>(null);
  readonly current = signal<PhoneCurve | null>(null);
  readonly atNode = signal(false);
  readonly tooFast = signal(false);
  /** The frame that was heard last, and the one before the curve began. */
  private frame: Pick<Reading, 'tangent' | 'normal'> | null = null;
  private feels = false;
  /** Up to when motion was counted, in ms. */
  private counted = 0;
  private lastMotion = Number.NEGATIVE_INFINITY;
  private times: number[] = [];
  /** Of the event before, in ms; what counts as motion lies between events while no node is held. */
  private before = 0;
  private moved = 0;
  private kept = 0;
  private wakeLock: { release(): Promise<void> } | null = null;

  constructor(private storage: Storage) {
    try {
      const text = storage.getItem(KEY);
      if (text) {
        const read = JSON.parse(text) as { scan: PhoneScan; current: PhoneCurve | null };
        // A curve that was being drawn when the page died is kept with what it had.
        const curves = read.current && read.current.readings.length > 1 ? [...read.scan.curves, read.current] : read.scan.curves;
        this.scan.value = { ...read.scan, curves };
      }
    } catch {
      storage.removeItem(KEY);
    }
  }

  /** Asks for the sensors, from a tap, and sees whether they speak. */
  async listen(): Promise<void> {
    this.sensors.value = 'asking';
    const request = (DeviceOrientationEvent as unknown as { requestPermission?: () => Promise<string> }).requestPermission;
    if (request) {
      try {
        if ((await request.call(DeviceOrientationEvent)) !== 'granted') {
          this.sensors.value = 'refused';
          return;
        }
      } catch {
        this.sensors.value = 'refused';
        return;
      }
    }
    window.addEventListener('deviceorientation', (event) => this.hear(event));
    window.addEventListener('devicemotion', (event) => this.feel(event));
    setTimeout(() => {
      if (this.sensors.value === 'asking') this.sensors.value = 'silent';
    }, 2500);
  }

  begin(boundary: boolean): void {
    const name = `curve ${this.scan.value.curves.length + 1}`;
    this.moved = 0;
    this.current.value = { name, boundary, readings: [], nodes: [], length: null };
    this.atNode.value = false;
    void this.keepAwake();
  }

  /** The hand rests at a crossing: the reading is a node, and time stands still until it is let go. */
  pressNode(number: number | null): void {
    const curve = this.current.value;
    if (!curve || !this.frame) return;
    this.atNode.value = true;
    if (curve.readings.length === 0) this.take(this.frame);
    const reading = curve.readings.length - 1;
    const last = curve.nodes[curve.nodes.length - 1];
    // The same place pressed twice is one node.
    const nodes = last?.reading === reading ? curve.nodes.slice(0, -1) : curve.nodes;
    const used = number ?? this.nextNumber();
    this.current.value = { ...curve, nodes: [...nodes, { reading, number: used }] };
    navigator.vibrate?.(30);
    this.keep(true);
  }
  releaseNode(): void {
    this.atNode.value = false;
  }

  nextNumber(): number {
    const current = this.current.value;
    return nextNode(current ? { ...this.scan.value, curves: [...this.scan.value.curves, current] } : this.scan.value);
  }

  undoNode(): void {
    const curve = this.current.value;
    if (curve) this.current.value = { ...curve, nodes: curve.nodes.slice(0, -1) };
    this.keep(true); // or a page that is killed would bring it back
  }

  /** The curve is done. */
  finish(): void {
    const curve = this.current.value;
    this.current.value = null;
    this.atNode.value = false;
    if (curve && curve.readings.length > 1) this.scan.value = { ...this.scan.value, curves: [...this.scan.value.curves, curve] };
    this.keep(true);
    void this.wakeLock?.release();
    this.wakeLock = null;
  }

  change(index: number, patch: Partial<PhoneCurve>): void {
    this.scan.value = {
      ...this.scan.value,
      curves: this.scan.value.curves.map((curve, i) => (i === index ? { ...curve, ...patch } : curve)),
    };
    this.keep(true);
  }
  remove(index: number): void {
    this.scan.value = { ...this.scan.value, curves: this.scan.value.curves.filter((_, i) => i !== index) };
    this.keep(true);
  }
  setUnit(unit: string): void {
    this.scan.value = { ...this.scan.value, unit };
    this.keep(true);
  }
  clear(): void {
    this.scan.value = emptyScan();
    this.current.value = null;
    this.keep(true);
  }

  /** Before NODE is pressed and after it is let go the hand rests: that is no part of the way. */
  private feel(event: DeviceMotionEvent): void {
    const { acceleration, rotationRate } = event;
    if (!rotationRate || !acceleration || acceleration.x === null) return;
    const turn = Math.hypot(rotationRate.alpha ?? 0, rotationRate.beta ?? 0, rotationRate.gamma ?? 0);
    const push = Math.hypot(acceleration.x ?? 0, acceleration.y ?? 0, acceleration.z ?? 0);
    this.feels = true;
    if (turn > REST_TURN || push > REST_PUSH) this.lastMotion = event.timeStamp;
  }

  /** The seconds that the hand has moved since this was asked last. Without motion sensors it always moves. */
  private secondsMoved(now: number): number {
    const rests = this.feels && now - this.lastMotion > REST_AFTER_MS;
    // Up to the last motion that was felt: what follows is only counted when it was motion too.
    const end = !this.feels ? now : rests ? this.counted : Math.max(this.counted, this.lastMotion);
    const seconds = (end - this.counted) / 1000;
    this.counted = rests ? now : end;
    return seconds;
  }

  private hear(event: DeviceOrientationEvent): void {
    if (event.alpha === null || event.beta === null || event.gamma === null) return;
    this.sensors.value = 'ready';
    const now = event.timeStamp;
    this.times = [...this.times.slice(-60), now];
    this.rate.value = rateOf(this.times);
    const frame = frameOf(event.alpha, event.beta, event.gamma);
    const seconds = Math.max(0, (now - this.before) / 1000);
    if (this.frame && seconds > 0) this.tooFast.value = angleBetween(this.frame, frame) / seconds > TOO_FAST;
    const moved = this.secondsMoved(now);
    this.frame = frame;
    this.before = now;
    const curve = this.current.value;
    if (!curve || this.atNode.value) return;
    // A pause of the browser is no motion.
    if (curve.readings.length > 0) this.moved += Math.min(moved, 0.25);
    const last = curve.readings[curve.readings.length - 1];
    if (!last || this.moved - last.time >= LEAST_STEP) this.take(frame);
  }

  private take(frame: Pick<Reading, 'tangent' | 'normal'>): void {
    const curve = this.current.value;
    if (!curve) return;
    curve.readings.push({ time: this.moved, ...frame });
    this.current.value = { ...curve };
    this.keep(false);
  }

  private keep(now: boolean): void {
    if (!now && performance.now() - this.kept < KEEP_EVERY_MS) return;
    this.kept = performance.now();
    try {
      this.storage.setItem(KEY, JSON.stringify({ scan: this.scan.value, current: this.current.value }));
    } catch {
      // Full: what is in memory goes on; the page tells that it is not kept.
      this.isKept.value = false;
    }
  }
  readonly isKept = signal(true);

  private async keepAwake(): Promise<void> {
    try {
      const lock = (navigator as unknown as { wakeLock?: { request(kind: string): Promise<{ release(): Promise<void> }> } }).wakeLock;
      this.wakeLock = (await lock?.request('screen')) ?? null;
    } catch {
      // The screen may go dark; nothing else is lost.
    }
  }
}
