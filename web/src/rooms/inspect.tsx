/** How good a surface is: patterns of light, curvatures, distances, and a verdict per curve. */
import { useState } from 'preact/hooks';
import type { App, Look } from '../app';
import { Check, Choice, Figures, Section, Slider } from '../ui/controls';
import { degrees, length, short, toRadians } from '../ui/numbers';

export function InspectPanel({ app }: { app: App }) {
  const { store } = app;
  const object = store.selectedObject.value;
  const drawn = object ? store.drawn.value.get(object.id) : undefined;
  const look = app.look.value;
  if (!object || !drawn) return <p class="empty">Select a surface or a network in the outline.</p>;
  const mesh = drawn.mesh;
  return (
    <>
      <h2>{object.name}</h2>
      <Section title="Show">
        <Choice
          label="Shading"
          help="Stripes that break show where the surface is not smooth."
          value={look.shading}
          options={[
            ['shaded', 'shaded'],
            ['isophotes', 'isophotes'],
            ['reflection-lines', 'reflection lines'],
            ['normal-map', 'normals'],
            ['mean-curvature', 'mean curvature'],
            ['gaussian-curvature', 'Gaussian curvature'],
            ['wireframe', 'triangles'],
          ]}
          onChange={(shading) => void app.setLook({ shading: shading as Look['shading'] })}
        />
        <Slider
          label="Stripes"
          help="Over half a turn."
          min={4}
          max={120}
          step={1}
          value={look.stripes}
          onChange={(stripes) => void app.setLook({ stripes })}
        />
        <Check
          label="Flat triangles"
          help="Each triangle by its own normal: the mesh as it is."
          value={look.flat}
          onChange={(flat) => void app.setLook({ flat })}
        />
        <Check label="Curves" value={look.curves} onChange={(curves) => void app.setLook({ curves })} />
      </Section>
      {mesh && <DistancePart app={app} id={object.id} unit={object.unit} />}
      {mesh && <ContinuityPart app={app} id={object.id} unit={object.unit} hasCurves={drawn.curves.length > 0} />}
      {mesh && (
        <Section title="Mesh">
          <Figures
            rows={[
              ['vertices', short(mesh.n_vertices)],
              ['triangles', short(mesh.n_triangles)],
              ['closed', mesh.closed ? 'yes' : `no, ${mesh.n_borders} borders`],
              ['pieces', short(mesh.n_components)],
              ['handles', mesh.genus === null ? '–' : short(mesh.genus)],
              ['smallest angle', degrees(mesh.smallest_angle)],
              ['mean edge', length(mesh.mean_edge, object.unit)],
              ['diameter', length(mesh.diameter, object.unit)],
            ]}
          />
          {mesh.problems.map((problem) => (
            <p class="problem" key={problem}>
              {problem}
            </p>
          ))}
        </Section>
      )}
    </>
  );
}

function DistancePart({ app, id, unit }: { app: App; id: string; unit: string }) {
  const { store } = app;
  const others = store.objects.value.filter((one) => one.kind === 'mesh' && one.id !== id);
  const [truth, setTruth] = useState('');
  const values = store.values.value;
  const figures = values?.object === id ? values.figures : undefined;
  if (others.length === 0) return null;
  return (
    <Section title="Distance" open={false}>
      <Choice
        label="To"
        help="Distance of every vertex from another mesh, both where they are."
        value={truth}
        options={[['', 'choose a mesh'] as const, ...others.map((one) => [one.id, one.name] as const)]}
        onChange={(value) => {
          setTruth(value);
          if (value) void app.showDistances(id, value);
        }}
      />
      {figures && (
        <Figures
          rows={[
            ['mean', length(figures.mean, unit)],
            ['root mean square', length(figures.rms, unit)],
            ['largest', length(figures.max, unit)],
          ]}
        />
      )}
    </Section>
  );
}

function ContinuityPart({ app, id, unit, hasCurves }: { app: App; id: string; unit: string; hasCurves: boolean }) {
  const { store } = app;
  const networks = store.objects.value.filter((one) => one.kind === 'network');
  const [tolerance, setTolerance] = useState(0.5);
  const [curves, setCurves] = useState('');
  const found = store.continuity.value?.object === id ? store.continuity.value : null;
  const needed = !hasCurves && !curves;
  const rows = found ? [...found.curves].sort((a, b) => b.normal_jump - a.normal_jump) : [];
  const csv = () =>
    ['curve,verdict,gap,normal jump deg,curvature jump', ...(found?.curves ?? []).map((one) =>
      [`"${one.name}"`, one.verdict, one.gap, (180 / Math.PI) * one.normal_jump, one.curvature_jump].join(','))].join('\n');
  return (
    <Section title="Continuity">
      {!hasCurves && (
        <Choice
          label="Curves"
          value={curves}
          options={[['', 'choose a network'] as const, ...networks.map((one) => [one.id, one.name] as const)]}
          onChange={setCurves}
        />
      )}
      <Slider
        label="Tolerance"
        help="The largest jump of the normal across a curve that passes as smooth."
        unit="°"
        min={0.05}
        max={10}
        logarithmic
        value={tolerance}
        onChange={(value, rest) => {
          setTolerance(value);
          if (rest && found) void store.computeContinuity(id, toRadians(value), curves || undefined);
        }}
      />
      <button
        type="button"
        disabled={needed}
        onClick={() => void store.computeContinuity(id, toRadians(tolerance), curves || undefined)}
      >
        Check all curves
      </button>
      {found && (
        <>
          <p role="status">
            {found.n_failed === 0
              ? `All ${found.n_checked} smooth curves pass.`
              : `${found.n_failed} of ${found.n_checked} smooth curves fail.`}
          </p>
          <table class="verdicts">
            <thead>
              <tr>
                <th scope="col">Curve</th>
                <th scope="col">Normal</th>
                <th scope="col">Gap</th>
                <th scope="col" aria-label="Verdict" />
              </tr>
            </thead>
            <tbody>
              {rows.map((one) => (
                <tr key={one.name} class={one.verdict}>
                  <td>
                    <button type="button" class="link" onClick={() => app.pointAt(id, one.worst)} title="Show the worst place">
                      {one.name}
                    </button>
                  </td>
                  <td>{one.verdict === 'border' ? 'border' : degrees(one.normal_jump)}</td>
                  <td>{one.verdict === 'border' ? '' : length(one.gap, unit)}</td>
                  <td>{one.verdict === 'pass' ? '✓' : one.verdict === 'fail' ? '✗' : one.verdict === 'sharp' ? 'sharp' : ''}</td>
                </tr>
              ))}
            </tbody>
          </table>
          <button type="button" onClick={() => app.saveText(csv(), 'continuity', 'csv')}>
            Save as CSV
          </button>
        </>
      )}
    </Section>
  );
}
