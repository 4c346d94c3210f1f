/** A telephone as the device (S 5.2.3): sensors, curves with their nodes, the surface, files. For one thumb. */
import { useSignal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { download, fileName } from '../document/files';
import type { Store } from '../document/store';
import { NumberInput } from '../ui/controls';
import { milliseconds, short } from '../ui/numbers';
import { View } from '../view/scene';
import { pathOf } from './orientation';
import type { Recorder } from './recorder';
import { isClosed, needsLengths, type PhoneCurve, problemOf, rawnetOf } from './scan';

type Step = 'record' | 'surface';
/** Edges and steps that a telephone draws at ease, parts of the diameter. */
const PHONE_STEP = 0.025;

export function PhonePage({ store, recorder, started }: { store: Store; recorder: Recorder; started: Promise<unknown> }) {
  const step = useSignal<Step>('record');
  const surface = useSignal<string | null>(null);
  const scan = recorder.scan.value;
  const problem = problemOf(scan);
  const make = async () => {
    step.value = 'surface';
    await started;
    if (store.objects.value.length > 0) await store.clear();
    const bytes = new TextEncoder().encode(rawnetOf(recorder.scan.value)).buffer;
    const id = await store.open('telephone.rawnet', bytes);
    if (!id) return;
    const relative = { value: PHONE_STEP, kind: 'relative' };
    const lengths = needsLengths(recorder.scan.value) ? 'estimated' : 'measured';
    const network = await store.derive(id, 'network', { kind: 'network', step: relative, lengths });
    surface.value = network && (await store.derive(network, 'surface', { kind: 'surface', surface: { edge_length: relative } }));
    if (surface.value) await store.show(surface.value);
  };
  return (
    <div class="phone">
      <header>
        <strong>Batten</strong>
        <button type="button" aria-current={step.value === 'record' ? 'page' : undefined} onClick={() => (step.value = 'record')}>
          Record
        </button>
        <button
          type="button"
          aria-current={step.value === 'surface' ? 'page' : undefined}
          disabled={problem !== null}
          onClick={() => void make()}
        >
          Surface
        </button>
      </header>
      <Messages store={store} />
      {step.value === 'record' ? (
        recorder.current.value ? (
          <Drawing recorder={recorder} curve={recorder.current.value} />
        ) : (
          <Overview recorder={recorder} problem={problem} onSurface={() => void make()} />
        )
      ) : (
        <SurfaceStep store={store} recorder={recorder} surface={surface.value} />
      )}
    </div>
  );
}

function Messages({ store }: { store: Store }) {
  return (
    <ol class="phone-messages" aria-label="Messages">
      {store.notices.value.map((one) => (
        <li key={one.id} class={one.level} role={one.level === 'error' ? 'alert' : undefined}>
          {one.text} {one.remedy && <em>{one.remedy}</em>}
          <button type="button" aria-label="Dismiss" onClick={() => store.dismiss(one.id)}>
            ×
          </button>
        </li>
      ))}
    </ol>
  );
}

function Sensors({ recorder }: { recorder: Recorder }) {
  const rate = recorder.rate.value;
  switch (recorder.sensors.value) {
    case 'ready':
      return (
        <p role="status">
          ✓ sensors {rate ? `${Math.round(rate.rate)} Hz ± ${milliseconds(rate.jitter)}` : ''}
          {rate && rate.rate < 20 && ' — slow: move slowly too'}
        </p>
      );
    case 'asking':
      return <p role="status">Waiting for the sensors…</p>;
    case 'refused':
      return <p role="alert">The browser gives no motion sensors to this page. Allow them in its settings for this site, and load the page again.</p>;
    case 'silent':
      return <p role="alert">No sensor speaks. A telephone has them; the page must come over https, or from this device.</p>;
    default:
      return (
        <button type="button" class="primary" onClick={() => void recorder.listen()}>
          1 Turn the sensors on
        </button>
      );
  }
}

function Overview({ recorder, problem, onSurface }: { recorder: Recorder; problem: string | null; onSurface: () => void }) {
  const boundary = useSignal(false);
  const scan = recorder.scan.value;
  const ready = recorder.sensors.value === 'ready';
  return (
    <main>
      <Sensors recorder={recorder} />
      <p class="hint">Slide the telephone along a line of the object, its upper edge ahead, its back on the surface. Stop where lines cross, hold NODE, and go on when you let it go.</p>
      <div class="row">
        <button type="button" class="primary" disabled={!ready} onClick={() => recorder.begin(boundary.value)}>
          {scan.curves.length === 0 ? '2 New curve' : 'New curve'}
        </button>
        <label class="check">
          <input type="checkbox" checked={boundary.value} onChange={(event) => (boundary.value = event.currentTarget.checked)} /> border
        </label>
      </div>
      {scan.curves.length > 0 && (
        <>
          <label class="unit">
            Lengths are in{' '}
            <select value={scan.unit} onChange={(event) => recorder.setUnit(event.currentTarget.value)}>
              {['mm', 'cm', 'm', 'in'].map((unit) => (
                <option key={unit}>{unit}</option>
              ))}
            </select>
          </label>
          <ul class="curves">
            {scan.curves.map((curve, i) => (
              <li key={`${i} ${curve.name}`}>
                <div>
                  <strong>{curve.name}</strong> {curve.boundary && 'border'} {isClosed(curve) && 'closed'} · nodes{' '}
                  {curve.nodes.map((node) => node.number + 1).join(', ') || 'none'}
                </div>
                <div class="row">
                  <label>
                    length{' '}
                    <NumberInput
                      label={`Length of ${curve.name}`}
                      text={String(curve.length ?? '')}
                      min={0}
                      placeholder="unknown"
                      onTyped={(typed) => recorder.change(i, { length: typed !== null && typed > 0 ? typed : null })}
                    />
                  </label>
                  <button type="button" onClick={() => recorder.remove(i)}>
                    Delete
                  </button>
                </div>
              </li>
            ))}
          </ul>
          {problem ? (
            <p class="hint">{problem}</p>
          ) : (
            <button type="button" class="primary" onClick={onSurface}>
              3 Make the surface
            </button>
          )}
          <div class="row">
            <button type="button" onClick={() => void share(rawnetOf(scan), 'telephone', 'rawnet')}>
              Save the scan
            </button>
            <button type="button" onClick={() => confirm('Delete all curves?') && recorder.clear()}>
              Delete all
            </button>
          </div>
        </>
      )}
      {!recorder.isKept.value && <p role="alert">The storage of the browser is full: save the scan before you close the page.</p>}
    </main>
  );
}

function Drawing({ recorder, curve }: { recorder: Recorder; curve: PhoneCurve }) {
  const numbers = [...new Set([...recorder.scan.value.curves, curve].flatMap((one) => one.nodes.map((node) => node.number)))].sort((a, b) => a - b);
  const seconds = curve.readings[curve.readings.length - 1]?.time ?? 0;
  return (
    <main class="drawing">
      <p role="status">
        <strong>{curve.name}</strong> {curve.boundary ? 'border' : 'interior'} · {short(seconds, 3)} s
      </p>
      <Live curve={curve} />
      <p class={recorder.tooFast.value ? 'fast' : 'calm'}>{recorder.tooFast.value ? 'Too fast: turn more slowly' : recorder.atNode.value ? 'At a node: let go to go on' : 'Recording'}</p>
      <p class="nodes">{curve.nodes.map((node) => `● ${node.number + 1}`).join('  ') || 'Hold NODE at the start.'}</p>
      <button
        type="button"
        class="node"
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
          recorder.pressNode(null);
        }}
        onPointerUp={() => recorder.releaseNode()}
        onPointerCancel={() => recorder.releaseNode()}
      >
        NODE {recorder.nextNumber() + (recorder.atNode.value ? 0 : 1)}
      </button>
      {numbers.length > 0 && (
        <div class="row numbers" role="group" aria-label="A node that is there already">
          {numbers.map((number) => (
            <button
              key={number}
              type="button"
              onPointerDown={(event) => {
                event.currentTarget.setPointerCapture(event.pointerId);
                recorder.pressNode(number);
              }}
              onPointerUp={() => recorder.releaseNode()}
              onPointerCancel={() => recorder.releaseNode()}
            >
              ● {number + 1}
            </button>
          ))}
        </div>
      )}
      <div class="row">
        <button type="button" class="primary" onClick={() => recorder.finish()}>
          Curve is done
        </button>
        <button type="button" disabled={curve.nodes.length === 0} onClick={() => recorder.undoNode()}>
          Undo node
        </button>
      </div>
    </main>
  );
}

/** The curve as it grows, from a little above. */
function Live({ curve }: { curve: PhoneCurve }) {
  const path = pathOf(curve.readings);
  const flat = path.map(([x, y, z]) => [0.87 * x + 0.5 * y, 0.25 * x - 0.43 * y - 0.87 * z] as const);
  const xs = flat.map(([x]) => x);
  const ys = flat.map(([, y]) => y);
  const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const size = Math.max(right - left, bottom - top, 1e-6);
  const at = ([x, y]: readonly [number, number]) => `${(5 + (90 * (x - left)) / size).toFixed(2)},${(5 + (90 * (y - top)) / size).toFixed(2)}`;
  return (
    <svg class="live" viewBox="0 0 100 100" role="img" aria-label="The curve so far">
      <polyline points={flat.map(at).join(' ')} fill="none" stroke="currentColor" stroke-width="1" />
      {curve.nodes.map((node) => {
        const place = flat[node.reading];
        if (!place) return null;
        const [x, y] = at(place).split(',');
        return <circle key={node.reading} cx={x} cy={y} r="2.4" fill="currentColor" />;
      })}
    </svg>
  );
}

function SurfaceStep({ store, recorder, surface }: { store: Store; recorder: Recorder; surface: string | null }) {
  const place = useRef<HTMLDivElement>(null);
  const view = useRef<View | null>(null);
  const stripes = useSignal(false);
  const drawn = surface ? store.drawn.value.get(surface) : undefined;
  useEffect(() => {
    if (place.current && !view.current) {
      try {
        view.current = new View(place.current);
      } catch {
        store.tell('error', 'This browser draws no 3D pictures (WebGL2).');
      }
    }
    view.current?.setObjects(drawn ? [drawn] : []);
    view.current?.setLook({ shading: stripes.value ? 'reflection-lines' : 'shaded', stripes: 28, flat: false, curves: true, nodes: true });
  });
  const work = store.work.value;
  return (
    <main class="surface">
      <div ref={place} class="phone-view" tabIndex={0} role="application" aria-label="3D view" />
      {work && (
        <p role="status">
          {work.what}: {work.stage} <progress max={1} value={work.fraction} />
        </p>
      )}
      {drawn?.mesh && (
        <p role="status">
          {short(drawn.mesh.n_triangles)} triangles, {drawn.mesh.closed ? 'closed' : `${drawn.mesh.n_borders} borders`}
        </p>
      )}
      {[...(drawn?.flaws ?? []), ...(drawn?.warnings ?? [])].map((text) => (
        <p key={text} class="hint">
          {text}
        </p>
      ))}
      <label class="check">
        <input type="checkbox" checked={stripes.value} onChange={(event) => (stripes.value = event.currentTarget.checked)} /> reflection lines
      </label>
      <div class="row">
        <button
          type="button"
          class="primary"
          disabled={!drawn?.mesh}
          onClick={async () => {
            const bytes = surface && (await store.save(surface, 'ply'));
            if (bytes) await share(bytes, 'surface', 'ply');
          }}
        >
          Save PLY
        </button>
        <button type="button" onClick={() => void share(rawnetOf(recorder.scan.value), 'telephone', 'rawnet')}>
          Save scan
        </button>
        <button
          type="button"
          disabled={!drawn}
          onClick={async () => {
            const bytes = await store.save(null, 'batten');
            if (bytes) await share(bytes, 'telephone', 'batten');
          }}
        >
          Save project
        </button>
      </div>
    </main>
  );
}

/** To another program of the telephone where it can, else as a download. */
async function share(data: string | Uint8Array<ArrayBuffer>, name: string, extension: string): Promise<void> {
  const file = new File([data], fileName(name, extension));
  if (navigator.canShare?.({ files: [file] })) {
    try {
      await navigator.share({ files: [file] });
      return;
    } catch (error) {
      if (error instanceof DOMException && error.name === 'AbortError') return;
    }
  }
  download(file, file.name);
}
