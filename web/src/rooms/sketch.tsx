/** Curves drawn in space, and the surface that they carry, as they are drawn. */
import { useEffect } from 'preact/hooks';
import type { App } from '../app';
import type { RequestOptions } from '../document/types';
import { Check, Choice, Figures, Section, Slider } from '../ui/controls';
import { short } from '../ui/numbers';
import { Sentences } from './reconstruct';
import { modelOf } from './sketching';

export function SketchPanel({ app }: { app: App }) {
  const { store, sketch } = app;
  const found = modelOf(store.objects.value, store.selected.value);
  const drawing = found !== null && sketch.tool.value === 'draw';
  const axis = sketch.axis.value;
  const offset = sketch.offset.value;
  const ground = sketch.ground.value;
  useEffect(() => {
    if (app.drawing) {
      app.drawing.enabled = drawing;
      app.drawing.axis = axis;
      app.drawing.offset = offset;
      app.drawing.ground = ground;
    }
    app.view?.setGrid(drawing && ground === 'plane' ? { axis, offset } : null);
    return () => {
      if (app.drawing) app.drawing.enabled = false;
      app.view?.setGrid(null);
    };
  }, [app, app.drawing, drawing, axis, offset, ground, found?.model.id]);
  if (!found) return <Welcome app={app} />;
  const { model, surface } = found;
  const drawn = store.drawn.value.get(surface?.id ?? model.id) ?? store.drawn.value.get(model.id);
  const curve = sketch.curve.value;
  const edges = drawn?.curves.filter((one) => one.curve === curve) ?? [];
  const names = new Set(drawn?.curves.map((one) => one.curve));
  const refusal = sketch.refusal.value;
  const size = app.view?.size() ?? 1;
  return (
    <>
      <h2>{model.name}</h2>
      <Section title="Draw">
        <div class="tools" role="group" aria-label="Tool">
          <button type="button" aria-pressed={sketch.tool.value === 'draw'} onClick={() => (sketch.tool.value = 'draw')}>
            Draw (D)
          </button>
          <button type="button" aria-pressed={sketch.tool.value === 'look'} onClick={() => (sketch.tool.value = 'look')}>
            Turn (V)
          </button>
        </div>
        <p class="hint">
          {names.size === 0
            ? 'Draw a closed outline on the grid: the first face.'
            : 'Draw from curve to curve: the stroke lies between them, facing you. The right button or shift turns the view meanwhile.'}
        </p>
        <Choice
          label="Lies on"
          help="Strokes that do not run from curve to curve."
          value={ground === 'surface' ? 'surface' : axis}
          options={[
            ['z', 'a level plane'],
            ['x', 'a plane across x'],
            ['y', 'a plane across y'],
            ['surface', 'the surface under it'],
          ]}
          onChange={(value) => {
            if (value === 'surface') sketch.ground.value = 'surface';
            else {
              sketch.ground.value = 'plane';
              sketch.axis.value = value as 'x' | 'y' | 'z';
            }
          }}
        />
        <Slider
          label="Offset"
          help="Of the plane from the origin."
          unit={model.unit}
          min={-2 * size}
          max={2 * size}
          value={offset}
          disabled={ground === 'surface'}
          onChange={(value) => (sketch.offset.value = Number(value.toPrecision(3)))}
        />
        <Choice
          label="Goes to"
          help="Where a stroke could divide a face or close an opening beside it."
          value={sketch.into.value}
          options={[
            ['auto', 'what fits'],
            ['face', 'a face'],
            ['opening', 'an opening'],
          ]}
          onChange={(into) => (sketch.into.value = into)}
        />
        <Check label="Sharp" help="The new curve is an edge." value={sketch.sharp.value} onChange={(value) => (sketch.sharp.value = value)} />
        <div class="tools">
          <button
            type="button"
            aria-pressed={sketch.purpose.value === 'hole'}
            onClick={() => (sketch.purpose.value = sketch.purpose.value === 'hole' ? 'insert' : 'hole')}
          >
            Next stroke cuts a hole
          </button>
        </div>
      </Section>
      {refusal && (
        <div class="refusal" role="alert">
          <p>{refusal.message}</p>
          {refusal.remedy && <p>{refusal.remedy}</p>}
          <div class="tools">
            <button type="button" onClick={() => void app.sketch.again('opening')}>
              Into the opening
            </button>
            <button type="button" onClick={() => void app.sketch.again('face')}>
              Into the face
            </button>
            <button type="button" onClick={() => app.sketch.forget()}>
              Forget it
            </button>
          </div>
        </div>
      )}
      <Section title="Curve">
        {curve === null || edges.length === 0 ? (
          <p class="empty">Click on a curve.</p>
        ) : (
          <>
            <p>
              <strong>c{curve}</strong>, {edges.length === 1 ? 'one piece' : `${edges.length} pieces`}
            </p>
            <Slider
              label="Sharpness"
              help="0 smooth, 1 an edge."
              min={0}
              max={1}
              value={edges[0]?.sharpness ?? 0}
              onChange={(value, rest) => rest && void app.sketch.edit({ op: 'sharpness', curve: `c${curve}`, value })}
            />
            <div class="tools">
              <button type="button" onClick={() => void app.sketch.edit({ op: 'mirror', curve: `c${curve}` })}>
                Mirror
              </button>
              <button type="button" onClick={() => void app.sketch.remove()}>
                Delete
              </button>
            </div>
          </>
        )}
      </Section>
      {surface && (
        <Section title="Surface">
          <Choice
            label="Method"
            value={(surface.request as RequestOptions).method as string}
            options={[
              ['v2', 'diffusion: the fairest'],
              ['v1', 'Coons patches: the fastest'],
              ['curvature', 'filled network'],
            ]}
            onChange={(method) => store.slide(surface.id, { ...(surface.request as RequestOptions), method }, null, true)}
          />
          <Slider
            label="Fineness"
            help="Levels of subdivision; each has four times as many triangles."
            min={0}
            max={4}
            step={1}
            value={(surface.request as RequestOptions).levels as number}
            onChange={(levels, rest) =>
              rest && store.slide(surface.id, { ...(surface.request as RequestOptions), levels: Math.round(levels) }, null, true)
            }
          />
          <Figures
            rows={[
              ['curves', short(names.size)],
              ['triangles', short(drawn?.mesh?.n_triangles)],
              ['closed', drawn?.mesh ? (drawn.mesh.closed ? 'yes' : `no, ${drawn.mesh.n_borders} borders`) : '–'],
            ]}
          />
          <Sentences title="Warnings" list={[...(drawn?.flaws ?? []), ...(drawn?.warnings ?? [])]} />
        </Section>
      )}
    </>
  );
}

function Welcome({ app }: { app: App }) {
  return (
    <div class="welcome">
      <h2>Draw a surface</h2>
      <p>A closed outline first, then curves from curve to curve. The surface grows as you draw.</p>
      <button type="button" class="primary" onClick={() => void app.sketch.begin()}>
        New sketch
      </button>
    </div>
  );
}
