/** The window: rooms on the left, the view, the panel of the room, status below. */
import { useEffect, useRef } from 'preact/hooks';
import { type App, ROOMS } from '../app';
import type { Notice } from '../document/store';
import { ReconstructPanel } from '../rooms/reconstruct';
import { View } from '../view/scene';
import { milliseconds, short, shown as shownAs, SHOWN_UNITS, shownUnit } from './numbers';
import { lazy } from './lazy';
import { Tour } from './tour';

const Palette = lazy(() => import('./palette').then((part) => part.Palette));
const Pins = lazy(() => import('./pins').then((part) => part.Pins));
const Help = lazy(() => import('./help').then((part) => part.Help));
const SketchPanel = lazy(() => import('../rooms/sketch').then((room) => room.SketchPanel));
const InspectPanel = lazy(() => import('../rooms/inspect').then((room) => room.InspectPanel));
const CapturePanel = lazy(() => import('../rooms/capture').then((room) => room.CapturePanel));
const ProcessPanel = lazy(() => import('../rooms/process').then((room) => room.ProcessPanel));

const KIND_SIGNS: Record<string, string> = { scan: '∿', network: '#', mesh: '△', model: '✎', calibration: '◎', view: '◳' };

export function Shell({ app }: { app: App }) {
  const { store } = app;
  return (
    <div
      class="window"
      data-theme={app.theme.value}
      onDragOver={(event) => event.preventDefault()}
      onDrop={(event) => {
        event.preventDefault();
        void app.openFiles([...(event.dataTransfer?.files ?? [])].map((file) => [file.name, file] as const));
      }}
    >
      <Bar app={app} />
      <nav class="rooms" aria-label="Rooms">
        {ROOMS.map(([room, title], i) => (
          <button
            key={room}
            type="button"
            aria-current={app.room.value === room ? 'page' : undefined}
            title={`${title} (Ctrl+${i + 1})`}
            onClick={() => (app.room.value = room)}
          >
            {title}
          </button>
        ))}
      </nav>
      <main class="stage">
        <Canvas app={app} />
        {app.pins.value.length > 0 && <Pins app={app} />}
        <Legend app={app} />
        <Progress app={app} />
        <Tour app={app} />
        <Notices app={app} />
      </main>
      <aside class="panel" aria-label="Panel of the room">
        <Outline app={app} />
        {app.room.value === 'reconstruct' && <ReconstructPanel app={app} />}
        {app.room.value === 'sketch' && <SketchPanel app={app} />}
        {app.room.value === 'inspect' && <InspectPanel app={app} />}
        {app.room.value === 'process' && <ProcessPanel app={app} />}
        {app.room.value === 'capture' && <CapturePanel app={app} />}
      </aside>
      <Status app={app} />
      {app.palette.value && <Palette app={app} />}
      {app.help.value && <Help app={app} />}
      <div class="spoken" role="status" aria-live="polite">
        {store.work.value ? '' : (store.selectedObject.value?.name ?? '')}
      </div>
    </div>
  );
}

function Bar({ app }: { app: App }) {
  const { store } = app;
  const object = store.selectedObject.value;
  return (
    <header class="bar">
      <strong class="brand">Batten</strong>
      <button type="button" onClick={() => void app.chooseFiles()}>
        Open…
      </button>
      <button type="button" disabled={store.objects.value.length === 0} onClick={() => void app.saveProject()}>
        Save project
      </button>
      {object && object.formats.length > 0 && (
        <select
          aria-label="Save the selected object as"
          value=""
          onChange={(event) => {
            const format = event.currentTarget.value;
            event.currentTarget.value = '';
            if (format) void app.saveObject(format);
          }}
        >
          <option value="">Save as…</option>
          {app.formatsOf(object).map((format) => (
            <option key={format} value={format}>
              {format.toUpperCase()}
            </option>
          ))}
        </select>
      )}
      <button type="button" class="search" onClick={() => (app.palette.value = true)}>
        Find a command <kbd>Ctrl K</kbd>
      </button>
      <button type="button" aria-label="Undo" title="Undo (Ctrl+Z)" disabled={!store.canUndo.value} onClick={() => void store.undo()}>
        ↶
      </button>
      <button type="button" aria-label="Redo" title="Redo (Ctrl+Shift+Z)" disabled={!store.canRedo.value} onClick={() => void store.redo()}>
        ↷
      </button>
      <button type="button" aria-label="Keys and mouse" title="Keys and mouse (?)" onClick={() => (app.help.value = true)}>
        ?
      </button>
    </header>
  );
}

function Canvas({ app }: { app: App }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!place.current || app.view) return;
    try {
      app.attach(new View(place.current));
    } catch {
      app.store.tell('error', 'This browser draws no 3D pictures (WebGL2).', 'Turn on hardware acceleration, or take another browser.');
    }
  }, [app]);
  return <div ref={place} class="canvas" tabIndex={0} role="application" aria-label="3D view: arrows turn, shift and arrows move, plus and minus zoom" />;
}

function Legend({ app }: { app: App }) {
  const values = app.store.values.value;
  const { shading } = app.look.value;
  if (!values || values.shading !== shading) return null;
  const diverging = values.low < 0;
  // Distances and deviations are lengths, curvatures are one over a length, or over its square.
  const { factor, unit } = shownAs(app.store.objects.value.find((one) => one.id === values.object)?.unit ?? '');
  const power = shading === 'mean-curvature' ? -1 : shading === 'gaussian-curvature' ? -2 : 1;
  const scale = factor ** power;
  return (
    <figure class="legend">
      <figcaption>
        {values.title}
        {unit && ` ${power < 0 ? `1/${unit}` : unit}${power === -2 ? '²' : ''}`}
      </figcaption>
      <span>{short(values.high * scale)}</span>
      <div class="ramp" style={{ background: diverging ? app.ramps.value.diverging : app.ramps.value.sequential }} />
      <span>{short(values.low * scale)}</span>
    </figure>
  );
}

function Progress({ app }: { app: App }) {
  const work = app.store.work.value;
  if (!work) return null;
  return (
    <div class="progress" role="progressbar" aria-label={work.what} aria-valuemin={0} aria-valuemax={100} aria-valuenow={Math.round(100 * work.fraction)}>
      <span>
        {work.what}
        {work.stage && `: ${work.stage}`}
      </span>
      <progress max={1} value={work.fraction} />
      <button type="button" onClick={() => void app.store.cancel()}>
        Stop
      </button>
    </div>
  );
}

function Notices({ app }: { app: App }) {
  const list = app.store.notices.value;
  if (list.length === 0) return null;
  return (
    <ol class="notices" aria-label="Messages">
      {list.map((notice: Notice) => (
        <li key={notice.id} class={notice.level} role={notice.level === 'error' ? 'alert' : undefined}>
          <div>
            {notice.text}
            {notice.remedy && <em> {notice.remedy}</em>}
          </div>
          <button type="button" aria-label="Dismiss" onClick={() => app.store.dismiss(notice.id)}>
            ×
          </button>
        </li>
      ))}
    </ol>
  );
}

function Outline({ app }: { app: App }) {
  const { store } = app;
  const objects = store.objects.value;
  if (objects.length === 0) return null;
  const depth = (id: string | undefined): number => {
    const source = objects.find((one) => one.id === id)?.source;
    return source ? 1 + depth(source) : 0;
  };
  return (
    <ul class="outline" aria-label="Objects">
      {objects.map((object) => (
        <li key={object.id} style={{ paddingLeft: `${depth(object.id)}em` }} class={store.selected.value === object.id ? 'selected' : ''}>
          <button
            type="button"
            class="name"
            aria-pressed={store.selected.value === object.id}
            title={object.kind}
            onClick={() => void app.select(object.id)}
            onDblClick={() => {
              const name = prompt('New name', object.name);
              if (name) void store.edit({ op: 'rename', object: object.id, name });
            }}
          >
            <span aria-hidden="true">{KIND_SIGNS[object.kind]}</span> {object.name}
          </button>
          <button
            type="button"
            class="eye"
            aria-label={`${store.hidden.value.has(object.id) ? 'Show' : 'Hide'} ${object.name}`}
            onClick={() => void app.toggleHidden(object.id)}
          >
            {store.hidden.value.has(object.id) ? '○' : '●'}
          </button>
        </li>
      ))}
    </ul>
  );
}

function Status({ app }: { app: App }) {
  const { store } = app;
  const object = store.selectedObject.value;
  const drawn = object ? store.drawn.value.get(object.id) : undefined;
  const last = store.lastUpdate.value;
  const triangles = drawn?.mesh?.n_triangles ?? (drawn?.triangles ? drawn.triangles.length / 3 : 0);
  return (
    <footer class="status">
      {object && (
        <label>
          numbers in{' '}
          <select class="unit-choice" value={object.unit} onChange={(event) => void app.setObjectUnit(object, event.currentTarget.value)}>
            {[...new Set(['', ...SHOWN_UNITS, object.unit])].map((unit) => (
              <option key={unit} value={unit}>
                {unit || 'no unit'}
              </option>
            ))}
          </select>
        </label>
      )}
      <label>
        shown in{' '}
        <select class="unit-choice" value={shownUnit.value} onChange={(event) => app.setUnit(event.currentTarget.value)}>
          {['', ...SHOWN_UNITS].map((unit) => (
            <option key={unit} value={unit}>
              {unit || 'its own unit'}
            </option>
          ))}
        </select>
      </label>
      {drawn && drawn.curves.length > 0 && <span>{new Set(drawn.curves.map((one, i) => one.curve ?? i)).size} curves</span>}
      {triangles > 0 && (
        <span>
          {short(triangles)} triangles{drawn?.coarse === 'coarse' ? ', preview' : drawn?.coarse ? ', not checked yet' : ''}
        </span>
      )}
      {last && <span>{milliseconds(last.ms)}</span>}
      <span>{store.started.value ? store.engineName.value : 'the engine starts…'}</span>
      {store.started.value && <span>{store.kept.value ? 'kept in this browser' : 'not kept: save the project'}</span>}
    </footer>
  );
}
