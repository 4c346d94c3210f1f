/** From a scan to its surface: what the sliders of `batten reconstruct` set, seen at once. */
import { useEffect } from 'preact/hooks';
import type { App } from '../app';
import type { Drawn, ObjectEntry, RequestOptions } from '../document/types';
import { Check, Choice, Figures, Section, Slider } from '../ui/controls';
import { length, percent, short } from '../ui/numbers';
import type { Pin } from '../ui/pins';

/** The scan, network and surface that the selection belongs to. */
export function chainOf(objects: ObjectEntry[], selected: string | null) {
  const find = (id: string | undefined) => objects.find((one) => one.id === id);
  let surface = find(selected ?? undefined);
  if (surface?.kind === 'scan') surface = objects.find((one) => one.source === surface?.id);
  if (surface?.kind === 'network') surface = objects.find((one) => one.source === surface?.id) ?? surface;
  while (surface && surface.request?.kind !== 'surface') {
    const source = find(surface.source);
    if (!source) break;
    surface = source;
  }
  if (surface?.request?.kind !== 'surface') return null;
  const network = find(surface.source);
  const scan = find(network?.source);
  return network && scan ? { scan, network, surface } : null;
}

interface Relative {
  value: number;
  kind: string;
}

export function ReconstructPanel({ app }: { app: App }) {
  const { store } = app;
  const chain = chainOf(store.objects.value, store.selected.value);
  const surfaceDrawn = chain ? store.drawn.value.get(chain.surface.id) : undefined;
  const networkDrawn = chain ? store.drawn.value.get(chain.network.id) : undefined;
  useEffect(() => {
    const asked = chain?.network.request;
    const remedies: Pin['remedies'] = [];
    const patch = (title: string, change: object) =>
      remedies.push({ title, run: () => store.slide(chain?.network.id ?? '', { ...(asked as RequestOptions), ...change }, chain?.surface.id ?? null, true) });
    if (asked?.robust === false) patch('Let wrong readings lose their say', { robust: true });
    if (asked && (asked.sigma as number) < 1.4) patch('Average over more readings', { sigma: Number((1.5 * (asked.sigma as number)).toPrecision(3)) });
    if (asked?.lengths === 'measured') patch('Estimate lengths from closure', { lengths: 'estimated' });
    app.pins.value = surfaceDrawn?.coarse ? [] : pinsOf(surfaceDrawn, networkDrawn?.report?.distrusted ?? [], remedies);
    return () => {
      app.pins.value = [];
    };
  }, [app, surfaceDrawn, networkDrawn]);
  if (!chain) return <Welcome app={app} />;
  const { scan, network, surface } = chain;
  const drawn = store.drawn.value.get(surface.id);
  const report = store.drawn.value.get(network.id)?.report;
  const options = network.request as RequestOptions;
  const filling = surface.request?.surface as RequestOptions & { surface: RequestOptions };
  const isGiven = options.weights === 'given';
  const lambda = isGiven ? (options.lambda as number) : (report?.lambda ?? drawn?.live?.lambda ?? 0);
  const mu = isGiven ? (options.mu as number) : (report?.mu ?? drawn?.live?.mu ?? 0);
  const setNetwork = (patch: object, rest = true) =>
    store.slide(network.id, { ...options, ...patch }, surface.id, rest);
  const setSurface = (patch: object, rest = true) =>
    store.slide(
      surface.id,
      { ...(surface.request as RequestOptions), surface: { ...filling, ...patch } },
      surface.id,
      rest,
    );
  const step = options.step as Relative | null;
  const edge = filling.edge_length as unknown as Relative | null;
  return (
    <>
      <h2>{scan.name}</h2>
      <Section title="Samples">
        <Slider
          label="Step h"
          help="Distance between samples of the curves. Larger is smoother and faster."
          unit="%"
          min={0.4}
          max={6}
          logarithmic
          value={100 * (step?.value ?? 0.016)}
          onChange={(value, rest) => setNetwork({ step: { value: value / 100, kind: 'relative' } }, rest)}
        />
        <Slider
          label="Blur σ"
          help="Radius over which readings are averaged, as a part of the step."
          min={0.05}
          max={2}
          value={options.sigma as number}
          onChange={(value, rest) => setNetwork({ sigma: value }, rest)}
        />
        <Check
          label="Robust"
          help="Readings far off the curve lose their say."
          value={options.robust as boolean}
          onChange={(robust) => setNetwork({ robust })}
        />
      </Section>
      <Section title="Weights">
        <Choice
          label="Weights"
          help="How smooth the curves are against how well they follow the readings."
          value={options.weights as string}
          options={[
            ['auto', 'automatic, from the data'],
            ['thesis', 'λ = 1, μ = 100'],
            ['given', 'as set below'],
          ]}
          onChange={(weights) => setNetwork(weights === 'given' ? { weights, lambda, mu } : { weights })}
        />
        <Slider
          label="λ"
          help="Resists the turning of the frames."
          min={1e-6}
          max={100}
          logarithmic
          value={Math.max(lambda, 1e-6)}
          onChange={(value, rest) => setNetwork({ weights: 'given', lambda: value, mu }, rest)}
        />
        <Slider
          label="μ"
          help="Resists the change of that turning."
          min={1e-6}
          max={1000}
          logarithmic
          value={Math.max(mu, 1e-6)}
          onChange={(value, rest) => setNetwork({ weights: 'given', lambda, mu: value }, rest)}
        />
        <Choice
          label="Lengths"
          help="What the distances of the readings are worth."
          value={options.lengths as string}
          options={[
            ['measured', 'measured'],
            ['estimated', 'estimated from closure'],
          ]}
          onChange={(lengths) => setNetwork({ lengths })}
        />
      </Section>
      <Section title="Surface">
        <Slider
          label="Edge length"
          help="Of the triangles inside patches, as a part of the diameter."
          unit="%"
          min={0.4}
          max={5}
          logarithmic
          value={edge ? 100 * edge.value : 1.2}
          onChange={(value, rest) => setSurface({ edge_length: { value: value / 100, kind: 'relative' } }, rest)}
        />
        <Choice
          label="Method"
          help="How the inside of a patch follows from its curves."
          value={filling.surface.method as string}
          options={[
            ['curvature', 'curvature from normals'],
            ['harmonic', 'harmonic'],
            ['biharmonic', 'biharmonic'],
            ['triharmonic', 'triharmonic'],
            ['biharmonic-normals', 'biharmonic with normals'],
          ]}
          onChange={(method) => setSurface({ surface: { ...filling.surface, method } })}
        />
        <Check
          label="Soft"
          help="The surface may leave the curves a little where that makes it fairer."
          value={filling.surface.soft_constraints as boolean}
          onChange={(soft_constraints) => setSurface({ surface: { ...filling.surface, soft_constraints } })}
        />
      </Section>
      <Section title="Result">
        <Figures
          rows={[
            ['curves', short(drawn?.curves.length)],
            ['readings', short(report?.n_readings)],
            ['samples', short(report?.n_samples)],
            ['loops miss by', report ? `${percent(report.misfit / report.size)} of the size` : '–'],
            ['before', report ? percent(report.misfit_before / report.size) : '–'],
            ['triangles', short(drawn?.mesh?.n_triangles ?? (drawn?.triangles?.length ?? 0) / 3)],
            ['closed', drawn?.mesh ? (drawn.mesh.closed ? 'yes' : `no, ${drawn.mesh.n_borders} borders`) : '–'],
            ['diameter', length(drawn?.mesh?.diameter, surface.unit)],
          ]}
        />
        <Check
          label="How sure it is"
          help="Standard deviations across the surface, as colours. Takes a while, and automatic weights."
          value={app.look.value.shading === 'uncertainty'}
          onChange={(on) => app.setLook({ shading: on ? 'uncertainty' : 'shaded' })}
        />
        <Distrusted app={app} scanCurves={drawn?.curves.map((curve) => curve.name) ?? []} shares={report?.distrusted ?? []} />
        <Sentences title="Warnings" list={[...(drawn?.flaws ?? []), ...(drawn?.warnings ?? [])]} />
      </Section>
    </>
  );
}

/** Curves whose readings the robust loss holds for wrong in a good part: to be recorded again. */
function Distrusted(props: { app: App; scanCurves: string[]; shares: number[] }) {
  const list = props.shares
    .map((share, i) => ({ share, name: props.scanCurves[i] || `curve ${i + 1}` }))
    .filter((one) => one.share > DISTRUSTED_ABOVE)
    .sort((a, b) => b.share - a.share);
  if (list.length === 0) return null;
  return (
    <>
      <h3>Record again</h3>
      <ul class="plain">
        {list.map((one) => (
          <li key={one.name}>
            {one.name}: {percent(one.share)} of its readings are distrusted
          </li>
        ))}
      </ul>
    </>
  );
}

/** The share of the readings of a curve from which on it is worth telling. */
const DISTRUSTED_ABOVE = 0.02;

/** What is to be said of places: curves that are distrusted, and sentences that name a place or a curve. */
function pinsOf(drawn: Drawn | undefined, shares: number[], remedies: Pin['remedies']): Pin[] {
  if (!drawn) return [];
  const middleOf = (c: number): Pin['place'] | null => {
    const curve = drawn.curves[c];
    const v = curve && drawn.network?.vertices[curve.first + Math.floor(curve.n / 2)];
    if (v === undefined) return null;
    return [0, 1, 2].map((k) => (drawn.network?.positions[3 * v + k] ?? 0) + (drawn.origin[k] ?? 0)) as Pin['place'];
  };
  const pins: Pin[] = [];
  shares.forEach((share, c) => {
    const place = share > DISTRUSTED_ABOVE ? middleOf(c) : null;
    const name = drawn.curves[c]?.name || `curve ${c + 1}`;
    if (place) pins.push({ place, text: `${name}: ${percent(share)} of its readings are distrusted. Record it again.`, remedies });
  });
  for (const text of [...drawn.flaws, ...drawn.warnings]) {
    const place = /\((-?[\d.e+-]+), (-?[\d.e+-]+), (-?[\d.e+-]+)\)/.exec(text);
    const curve = /\bcurve (\d+)/.exec(text);
    if (place) pins.push({ place: place.slice(1, 4).map(Number) as Pin['place'], text, remedies });
    else if (curve) {
      const at = middleOf(Number(curve[1])); // sentences of the engine count from 0
      if (at) pins.push({ place: at, text, remedies });
    }
  }
  return pins.slice(0, 30);
}

export function Sentences(props: { title: string; list: string[] }) {
  if (props.list.length === 0) return null;
  return (
    <>
      <h3>{props.title}</h3>
      <ul class="sentences">
        {props.list.map((text) => (
          <li key={text}>{text}</li>
        ))}
      </ul>
    </>
  );
}

/** What is in the folder that the server was started for. */
function FolderList({ app }: { app: App }) {
  const folder = app.folder.value;
  if (!folder) return null;
  return (
    <>
      <h3>In {folder.folder}</h3>
      <ul class="files">
        {folder.files.map((file) => (
          <li key={file.number}>
            <button type="button" class="link" onClick={() => void app.openServerFile(file)}>
              {file.name}
            </button>
          </li>
        ))}
      </ul>
      {folder.left_out > 0 && <p class="hint">{folder.left_out} more are not listed.</p>}
    </>
  );
}

function Welcome({ app }: { app: App }) {
  return (
    <div class="welcome">
      <h2>From curves to a surface</h2>
      <p>Open a scan (.rawnet, a sensor log), a curve network, or a mesh. Nothing leaves this computer.</p>
      <button type="button" class="primary" onClick={() => void app.openSample()}>
        Open the sample scan
      </button>
      <button type="button" onClick={() => void app.chooseFiles()}>
        Open a file…
      </button>
      <FolderList app={app} />
    </div>
  );
}
