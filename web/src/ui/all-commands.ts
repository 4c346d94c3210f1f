/** The commands of rooms that are loaded when they are opened: whoever lists or finds commands loads them all. */
import type { App } from '../app';
import { bendingOf } from '../rooms/bending';
import { probingOf } from '../rooms/probing';
import { sketchingOf } from '../rooms/sketching';

export function registerAll(app: App): void {
  sketchingOf(app);
  bendingOf(app);
  probingOf(app);
}
