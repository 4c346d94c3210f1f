import type { App } from '../app';
export function probingOf(_app: App): void {}
