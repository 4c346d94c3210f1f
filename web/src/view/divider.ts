/** The line between two objects that are compared: dragged, or moved by arrow keys; shift makes steps of a tenth. */
import type { View } from './scene';

/** @returns what takes it away. */
export function addDivider(view: View, left: string, right: string): () => void {
  const bar = document.createElement('div');
  bar.className = 'divider';
  bar.tabIndex = 0;
  bar.setAttribute('role', 'slider');
  bar.setAttribute('aria-label', 'Line between before and after');
  bar.setAttribute('aria-valuemin', '0');
  bar.setAttribute('aria-valuemax', '100');
  for (const name of ['before', 'after']) {
    const label = document.createElement('span');
    label.textContent = name;
    bar.append(label);
  }
  const put = (at: number) => {
    const inside = Math.min(1, Math.max(0, at));
    view.setDivider({ left, right, at: inside });
    bar.style.left = `${100 * inside}%`;
    bar.setAttribute('aria-valuenow', `${Math.round(100 * inside)}`);
  };
  // The view around it turns on what is not taken here.
  bar.addEventListener('pointerdown', (event) => {
    event.stopPropagation();
    bar.setPointerCapture(event.pointerId);
  });
  bar.addEventListener('pointermove', (event) => {
    if (bar.hasPointerCapture(event.pointerId)) put(view.place(event).x / view.element.clientWidth);
  });
  bar.addEventListener('keydown', (event) => {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    event.stopPropagation();
    event.preventDefault();
    put((view.divider?.at ?? 0.5) + way * (event.shiftKey ? 0.1 : 0.01));
  });
  view.element.append(bar);
  put(view.divider?.at ?? 0.5);
  return () => {
    bar.remove();
    view.setDivider(null);
  };
}
