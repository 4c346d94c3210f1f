import { render } from 'preact';
import { Engine } from '../../engine/engine';
import { Store } from '../document/store';
import '../style.css';
import './phone.css';
import { PhonePage } from './page';
import { Recorder } from './recorder';

const engine = new Engine(() => new Worker(new URL('../../engine/worker.ts', import.meta.url), { type: 'module' }));
const store = new Store(engine);
const recorder = new Recorder(localStorage);

const place = document.getElementById('app');
if (place) {
  // The readings are kept by the recorder; the engine's project can always be made of them again.
  const started = store.start(false).catch((error: unknown) => store.tell('error', `The engine could not be started: ${String(error)}.`));
  place.replaceChildren();
  render(<PhonePage store={store} recorder={recorder} started={started} />, place);
}
Object.assign(globalThis, { battenPhone: { store, recorder } });

if ('serviceWorker' in navigator && import.meta.env.PROD) void navigator.serviceWorker.register('./sw.js').catch(() => {});
