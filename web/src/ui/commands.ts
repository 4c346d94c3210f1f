/** One registry of commands feeds the palette, the keys, the list of keys and the tests. */
import { signal } from '@preact/signals';

export interface Command {
  id: string;
  title: string;
  /** As shown and as pressed: "Ctrl+Z", "1", "F". */
  keys?: string;
  /** Whether it can be run now; always, where it is missing. */
  when?: () => boolean;
  run: () => void | Promise<void>;
}

const registry = new Map<string, Command>();
export const commandsChanged = signal(0);

export function register(...commands: Command[]): void {
  for (const command of commands) {
    const clash = [...registry.values()].find((one) => one.keys && one.keys === command.keys && one.id !== command.id);
    if (clash) throw new Error(`${command.id} and ${clash.id} have the same keys ${command.keys}`);
    registry.set(command.id, command);
  }
  commandsChanged.value++;
}

export function commands(): Command[] {
  return [...registry.values()];
}

export function available(command: Command): boolean {
  return command.when?.() ?? true;
}

/** Commands whose title holds all the words, the best first. */
export function search(text: string): Command[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return commands()
    .filter((command) => words.every((word) => command.title.toLowerCase().includes(word)))
    .sort((a, b) => Number(available(b)) - Number(available(a)) || a.title.localeCompare(b.title));
}

/** What a key event is called in the registry. */
export function keysOf(event: KeyboardEvent): string {
  const key = event.key.length === 1 ? event.key.toUpperCase() : event.key;
  const withShift = event.shiftKey && (event.key.length > 1 || /[A-Z]/i.test(event.key));
  return `${event.ctrlKey || event.metaKey ? 'Ctrl+' : ''}${event.altKey ? 'Alt+' : ''}${withShift ? 'Shift+' : ''}${key}`;
}

/** Runs the command of a key. Where somebody writes, only those with Ctrl are meant. */
export function press(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement | null;
  const writes = target?.matches?.('input:not([type=range]):not([type=checkbox]):not([type=radio]), textarea, select, [contenteditable]');
  const keys = keysOf(event);
  if (writes && !keys.startsWith('Ctrl+')) return false;
  const command = commands().find((one) => one.keys === keys);
  if (!command || !available(command)) return false;
  event.preventDefault();
  void command.run();
  return true;
}
