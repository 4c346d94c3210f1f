import { render } from 'preact';
import { Engine } from '../engine/engine';
import { App } from './app';
import { Store } from './document/store';
import './style.css';
import { press } from './ui/commands';
import { Shell } from './ui/shell';

const engine = new Engine(() => new Worker(new URL('../engine/worker.ts', import.meta.url), { type: 'module' }));
const store = new Store(engine);
const app = new App(store);

const place = document.getElementById('app');
if (place) {
  place.replaceChildren();
  render(<Shell app={app} />, place);
}
window.addEventListener('keydown', (event) => press(event));
// For tests and for the curious.
Object.assign(globalThis, { batten: app });

if ('serviceWorker' in navigator && import.meta.env.PROD)
  void navigator.serviceWorker.register('./sw.js').catch(() => store.tell('info', 'This browser cannot keep the page for use without a network.'));
