/** A part of the page that is loaded when it is first shown. */
import { type Signal, signal } from '@preact/signals';
import type { ComponentType } from 'preact';

export function lazy<Props extends object>(load: () => Promise<ComponentType<Props>>): ComponentType<Props> {
  const loaded: Signal<ComponentType<Props> | null> = signal(null);
  let asked = false;
  return function Lazy(props: Props) {
    if (!asked) {
      asked = true;
      void load().then((component) => (loaded.value = component));
    }
    const Component = loaded.value;
    return Component ? <Component {...props} /> : <p class="empty">…</p>;
  };
}
