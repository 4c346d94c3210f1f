/** Steps on meshes. Each makes a new object, so that the one before stays to compare with, and undo takes it back. */
import { useEffect, useState } from 'preact/hooks';
import type { App } from '../app';
import type { RequestOptions } from '../document/types';
import { Check, Choice, Figures, Section, Slider } from '../ui/controls';
import { degrees, short } from '../ui/numbers';
import { addDivider } from '../view/divider';
import { BendPart } from './bend';
import { bendingOf } from './bending';
import { Sentences } from './reconstruct';

type Step = 'fair' | 'repair' | 'remesh' | 'simplify' | 'subdivide' | 'deform';

interface Settings {
  fairMethod: string;
  keepBoundary: boolean;
  vertices: number;
  adaptivity: number;
  keepEdges: number;
  remove: number;
  scheme: string;
  levels: number;
  weld: 'auto' | 'length' | 'off';
  /** Of the diameter, in per cent. */
  weldLength: number;
  orient: boolean;
  holes: 'none' | 'small' | 'all';
  holeEdges: number;
  energy: string;
  detail: string;
}

/** What the engine calls all holes. */
const ALL_HOLES = 2 ** 31 - 1;

/** The request of a step, and the command line that does the same. */
export function stepOf(step: Step, settings: Settings, name: string): { request: RequestOptions; command: string } {
  const file = `${name.replace(/\s+/g, '-')}.ply`;
  const start = `batten ${step} ${file} -o ${file.replace('.ply', `-${step}.ply`)}`;
  const radians = (settings.keepEdges * Math.PI) / 180;
  switch (step) {
    case 'fair':
      return {
        request: { kind: 'fair', method: settings.fairMethod, keep_boundary: settings.keepBoundary },
        command: `${start} --method ${settings.fairMethod}${settings.keepBoundary ? ' --keep-boundary' : ''}`,
      };
    case 'remesh':
      return {
        request: { kind: 'remesh', n_vertices: settings.vertices, adaptivity: settings.adaptivity, keep_edges: radians },
        command: `${start} --vertices ${settings.vertices} --adaptivity ${settings.adaptivity} --keep-edges ${settings.keepEdges}deg`,
      };
    case 'repair': {
      const weld = settings.weld === 'length' ? ` --weld ${settings.weldLength}%` : settings.weld === 'off' ? ' --weld off' : '';
      const holes = settings.holes === 'all' ? ' --fill-holes all' : settings.holes === 'small' ? ` --fill-holes ${settings.holeEdges}` : '';
      return {
        request: {
          kind: 'repair',
          weld: settings.weld !== 'off',
          weld_length: settings.weld === 'length' ? { value: settings.weldLength / 100, kind: 'relative' } : null,
          orient: settings.orient,
          fill_holes: settings.holes === 'all' ? ALL_HOLES : settings.holes === 'small' ? settings.holeEdges : 0,
        },
        command: `${start}${weld}${settings.orient ? ' --orient' : ''}${holes}`,
      };
    }
    case 'deform': // the request is made while it is dragged
      return { request: { kind: 'deform' }, command: `${start} --handles handles.json --energy ${settings.energy} --nonlinear ${settings.detail}` };
    case 'simplify':
      return {
        request: { kind: 'simplify', remove: settings.remove / 100 },
        command: `${start} --remove ${settings.remove}%`,
      };
    case 'subdivide':
      return {
        request: { kind: 'subdivide', scheme: settings.scheme, levels: settings.levels },
        command: `${start} --scheme ${settings.scheme} --levels ${settings.levels}`,
      };
  }
}

const TITLES: Record<Step, string> = {
  fair: 'Remove noise',
  repair: 'Repair',
  remesh: 'New triangles',
  simplify: 'Fewer triangles',
  subdivide: 'Subdivide',
  deform: 'Deform',
};

export function ProcessPanel({ app }: { app: App }) {
  const { store } = app;
  const object = store.selectedObject.value;
  const [step, setStep] = useState<Step>('fair');
  const [settings, setSettings] = useState<Settings>({
    fairMethod: 'auto',
    keepBoundary: false,
    vertices: 0,
    adaptivity: 0.1,
    keepEdges: 30,
    remove: 50,
    scheme: 'catmull-clark',
    levels: 2,
    weld: 'auto',
    weldLength: 0.01,
    orient: false,
    holes: 'none',
    holeEdges: 50,
    energy: 'total',
    detail: 'gauss-newton',
  });
  const isBoth = app.seen.value === 'both';
  useEffect(() => {
    if (isBoth && app.view && object?.source) return addDivider(app.view, object.source, object.id);
  }, [isBoth, app.view, object?.source, object?.id]);
  useEffect(() => () => void app.setSeen('after'), [app]);
  if (object?.kind !== 'mesh') return <p class="empty">Select a mesh in the outline.</p>;
  const set = (patch: Partial<Settings>) => setSettings({ ...settings, ...patch });
  const drawn = store.drawn.value.get(object.id);
  const before = object.source ? store.drawn.value.get(object.source) : undefined;
  const bending = bendingOf(app);
  const used = { ...settings, energy: bending.energy.value, detail: bending.detail.value, vertices: settings.vertices || (drawn?.mesh?.n_vertices ?? 1000) };
  const { request, command } = stepOf(step, used, object.name);
  const isResult = object.request !== undefined && object.request.kind in TITLES;
  return (
    <>
      <h2>{object.name}</h2>
      <Section title="Step">
        <Choice
          label="Do"
          value={step}
          options={(Object.keys(TITLES) as Step[]).map((one) => [one, TITLES[one]] as const)}
          onChange={setStep}
        />
        {step === 'fair' && (
          <>
            <Choice
              label="Method"
              help="Automatic measures the noise and keeps edges."
              value={settings.fairMethod}
              options={[
                ['auto', 'automatic'],
                ['nlsdf', 'nonlocal surface diffusion'],
                ['sdf', 'surface diffusion'],
                ['mcf', 'mean curvature flow'],
                ['bilaplacian', 'bi-Laplacian'],
                ['amcf', 'anisotropic mean curvature flow'],
                ['tv', 'total variation'],
                ['taubin', 'Taubin'],
              ]}
              onChange={(fairMethod) => set({ fairMethod })}
            />
            <Check label="Keep the border" value={settings.keepBoundary} onChange={(keepBoundary) => set({ keepBoundary })} />
          </>
        )}
        {step === 'remesh' && (
          <>
            <Slider
              label="Vertices"
              min={50}
              max={500_000}
              logarithmic
              value={used.vertices}
              onChange={(value) => set({ vertices: Math.round(value) })}
            />
            <Slider
              label="Adaptivity"
              help="0: edges of one length. 1: as fine as curvature asks."
              min={0}
              max={1}
              value={settings.adaptivity}
              onChange={(adaptivity) => set({ adaptivity })}
            />
            <Slider
              label="Keep edges above"
              unit="°"
              min={5}
              max={180}
              value={settings.keepEdges}
              onChange={(keepEdges) => set({ keepEdges: Math.round(keepEdges) })}
            />
          </>
        )}
        {step === 'repair' && (
          <>
            <Choice
              label="Weld"
              help="Borders that lie on each other become one."
              value={settings.weld}
              options={[
                ['auto', 'as the mesh suggests'],
                ['length', 'up to a distance'],
                ['off', 'not'],
              ]}
              onChange={(weld) => set({ weld })}
            />
            {settings.weld === 'length' && (
              <Slider
                label="Distance"
                help="Up to which borders are welded, of the diameter."
                unit="%"
                min={0.0001}
                max={1}
                logarithmic
                value={settings.weldLength}
                onChange={(weldLength) => set({ weldLength: Number(weldLength.toPrecision(2)) })}
              />
            )}
            <Choice
              label="Holes"
              help="Filled by fair surfaces that follow what is around them."
              value={settings.holes}
              options={[
                ['none', 'left open'],
                ['small', 'filled up to a size'],
                ['all', 'all filled'],
              ]}
              onChange={(holes) => set({ holes })}
            />
            {settings.holes === 'small' && (
              <Slider
                label="Edges"
                help="Of the largest hole that is filled."
                min={3}
                max={1000}
                logarithmic
                value={settings.holeEdges}
                onChange={(value) => set({ holeEdges: Math.round(value) })}
              />
            )}
            <Check
              label="Turn closed parts outward"
              help="And inward those that lie within another."
              value={settings.orient}
              onChange={(orient) => set({ orient })}
            />
          </>
        )}
        {step === 'deform' && <BendPart app={app} />}
        {step === 'simplify' && (
          <Slider
            label="Remove"
            unit="%"
            help="Of the triangles."
            min={1}
            max={99.9}
            value={settings.remove}
            onChange={(remove) => set({ remove: Number(remove.toPrecision(3)) })}
          />
        )}
        {step === 'subdivide' && (
          <>
            <Choice
              label="Scheme"
              value={settings.scheme}
              options={[
                ['catmull-clark', 'Catmull–Clark'],
                ['nuliss', 'NULISS, through the vertices'],
                ['nulissmod', 'NULISS, modified'],
                ['linear', 'linear'],
              ]}
              onChange={(scheme) => set({ scheme })}
            />
            <Slider
              label="Levels"
              help="Each level has four times as many triangles."
              min={1}
              max={5}
              step={1}
              value={settings.levels}
              onChange={(levels) => set({ levels: Math.round(levels) })}
            />
          </>
        )}
        {step !== 'deform' && (<button type="button" class="primary" onClick={() => void app.process(object.id, `${object.name} ${step}`, request)}>
          {TITLES[step]}
        </button>)}
        <label class="command">
          The same on the command line
          <input type="text" readOnly value={command} onFocus={(event) => event.currentTarget.select()} />
        </label>
      </Section>
      {isResult && (
        <Section title="Before and after">
          <Choice
            label="Show"
            value={app.seen.value}
            options={[
              ['after', 'after'],
              ['before', 'before'],
              ['both', 'side by side'],
            ]}
            onChange={(value) => void app.setSeen(value)}
          />
          <Figures
            rows={[
              ['triangles', `${short(before?.mesh?.n_triangles)} → ${short(drawn?.mesh?.n_triangles)}`],
              ['smallest angle', `${degrees(before?.mesh?.smallest_angle)} → ${degrees(drawn?.mesh?.smallest_angle)}`],
              ['closed', drawn?.mesh ? (drawn.mesh.closed ? 'yes' : 'no') : '–'],
            ]}
          />
          <Sentences title="Done" list={drawn?.done ?? []} />
          <Sentences title="Left" list={object.request?.kind === 'repair' ? (drawn?.flaws ?? []) : []} />
          <Sentences title="Warnings" list={drawn?.warnings ?? []} />
          <button type="button" onClick={() => void app.throwAway(object.id)}>
            Throw away
          </button>
        </Section>
      )}
    </>
  );
}
