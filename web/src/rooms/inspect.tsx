/** How good a surface is: patterns of light, curvatures, distances, and a verdict per curve. */
import { useEffect, useState } from 'preact/hooks';
import type { App, Look } from '../app';
import { Check, Choice, Figures, LengthSlider, Section, Slider } from '../ui/controls';
import { degrees, length, percent, shown, short, toRadians } from '../ui/numbers';
import { type Axis, probingOf } from './probing';

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
            ...(object.request?.kind === 'surface' ? [['uncertainty', 'how sure it is'] as const] : []),
            ['wireframe', 'triangles'],
          ]}
          onChange={(shading) => app.setLook({ shading: shading as Look['shading'] })}
        />
        <Slider
          label="Stripes"
          help="Over half a turn."
          min={4}
          max={120}
          step={1}
          value={look.stripes}
          onChange={(stripes) => app.setLook({ stripes })}
        />
        <Check
          label="Flat triangles"
          help="Each triangle by its own normal: the mesh as it is."
          value={look.flat}
          onChange={(flat) => app.setLook({ flat })}
        />
        <Check label="Curves" value={look.curves} onChange={(curves) => app.setLook({ curves })} />
      </Section>
      <LinesPart app={app} id={object.id} hasCurves={drawn.curves.length > 0} isMesh={mesh !== undefined} unit={object.unit} version={drawn.version} />
      {mesh && <SectionPart app={app} id={object.id} unit={object.unit} />}
      <MeasurePart app={app} unit={object.unit} />
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
              ['diameter', length(mesh.diameter, object.unit)],
              ['area', length(mesh.area, object.unit, 2)],
              ['volume', mesh.volume === null ? '–' : length(mesh.volume, object.unit, 3)],
              ['edges', `${length(mesh.shortest_edge, object.unit)} … ${length(mesh.longest_edge, object.unit)}`],
              ['mean edge', length(mesh.mean_edge, object.unit)],
              ['angles', `${degrees(mesh.smallest_angle)} … ${degrees(mesh.largest_angle)}`],
              ['mean smallest angle', degrees(mesh.mean_smallest_angle)],
              ['angles below 20°', percent(mesh.slivers)],
              ['mean, worst aspect', `${short(mesh.mean_aspect, 3)}, ${short(mesh.worst_aspect, 3)}`],
              ['vertices of six edges', percent(mesh.regular)],
            ]}
          />
          <p class="hint">The aspect of a triangle is its circumradius over twice its inradius: 1 where its sides are equal.</p>
          {mesh.worst && (
            <button type="button" onClick={() => app.pointAt(object.id, mesh.worst as [number, number, number])}>
              Show the worst triangle
            </button>
          )}
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

/** Combs along curves and crosses of principal directions. */
function LinesPart(props: { app: App; id: string; hasCurves: boolean; isMesh: boolean; unit: string; version: number }) {
  const { app, id } = props;
  const probing = probingOf(app);
  const { combs, combLength, directions, cut, largest } = probing;
  // Moved by its slider the section follows by itself.
  useEffect(() => void probing.show(id), [probing, app.view, id, props.version, combs.value, combLength.value, directions.value, cut.value === null]);
  useEffect(
    () => () => {
      void probing.show(null);
      probing.setMeasuring(false);
    },
    [probing],
  );
  return (
    <Section title="Curvature" open={false}>
      {props.hasCurves ? (
        <Check label="Combs along curves" help="As long as the curve is curved, away from the surface where it bends outward." value={combs.value} onChange={(on) => (combs.value = on)} />
      ) : (
        <p class="hint">Combs are drawn along curves; this mesh was not made of any.</p>
      )}
      <Slider
        label="Longest"
        help="Of the longest quill, as a part of what is seen."
        unit="%"
        min={1}
        max={60}
        value={combLength.value}
        disabled={!combs.value}
        onChange={(value) => (combLength.value = Math.round(value))}
      />
      {combs.value && largest.value !== null && (
        <Figures rows={[['smallest radius', largest.value > 0 ? length(1 / largest.value, props.unit) : 'straight']]} />
      )}
      {props.isMesh && (
        <Check
          label="Principal directions"
          help="Orange where the surface is curved most, blue across."
          value={directions.value}
          onChange={(on) => (directions.value = on)}
        />
      )}
    </Section>
  );
}

function SectionPart({ app, id, unit }: { app: App; id: string; unit: string }) {
  const probing = probingOf(app);
  const cut = probing.cut.value;
  const found = probing.section.value;
  const [low, high] = cut ? probing.extent(id, cut.axis) : [0, 1];
  const { factor, unit: shownAs } = shown(unit);
  const csv = () =>
    [`curve,closed,length ${shownAs},area ${shownAs}^2`, ...(found?.curves ?? []).map((one, i) =>
      [i, one.closed, one.length * factor, one.area === null ? '' : one.area * factor * factor].join(','))].join('\n');
  const move = (axis: Axis, wanted: number) => {
    const offset = probing.readable(id, axis, wanted);
    probing.cut.value = { axis, offset };
    probing.moveCut(id, axis, offset);
  };
  return (
    <Section title="Section" open={cut !== null}>
      <Check label="Cut by a plane" help="The curves in which it meets the surface." value={cut !== null} onChange={() => probing.toggleCut()} />
      {cut && (
        <>
          <Choice
            label="Across"
            help="The axis that the plane is square to."
            value={cut.axis}
            options={[
              ['x', 'x'],
              ['y', 'y'],
              ['z', 'z'],
            ]}
            onChange={(axis) => {
              const [from, to] = probing.extent(id, axis);
              move(axis, (from + to) / 2);
            }}
          />
          <LengthSlider
            label="At"
            help="Where it cuts the axis."
            unit={unit}
            min={low}
            max={high}
            value={cut.offset}
            onChange={(value) => move(cut.axis, value)}
          />
          {found && (
            <Figures
              rows={[
                ['curves', short(found.curves.length)],
                ['length', length(found.length, unit)],
                ['area inside', found.curves.some((one) => one.closed) ? length(found.area, unit, 2) : '–'],
              ]}
            />
          )}
          <div class="tools">
            <button type="button" disabled={!found?.curves.length} onClick={() => void probing.keepSection(id)}>
              Keep as a network
            </button>
            <button type="button" disabled={!found?.curves.length} onClick={() => app.saveText(csv(), 'section', 'csv')}>
              Save lengths as CSV
            </button>
          </div>
        </>
      )}
    </Section>
  );
}

function MeasurePart({ app, unit }: { app: App; unit: string }) {
  const probing = probingOf(app);
  const on = probing.measuring.value;
  const [a, b] = probing.picked.value;
  const way = a && b ? a.place.map((x, i) => (b.place[i] ?? 0) - x) : null;
  const cosine = a?.normal && b?.normal ? a.normal.reduce((sum, x, i) => sum + x * (b.normal?.[i] ?? 0), 0) : null;
  return (
    <Section title="Measure" open={on}>
      <Check label="Between two places" help="Click on the surface or on a curve, twice. A drag turns the view." value={on} onChange={(value) => probing.setMeasuring(value)} />
      {on && (
        <Figures
          rows={[
            ['distance', way ? length(Math.hypot(...way), unit) : '–'],
            ...(['x', 'y', 'z'] as const).map((axis, k) => [`along ${axis}`, way ? length(way[k], unit) : '–'] as const),
            ['between the normals', cosine === null ? '–' : degrees(Math.acos(Math.max(-1, Math.min(1, cosine))))],
          ]}
        />
      )}
    </Section>
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
          if (value) app.showDistances(id, value);
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
