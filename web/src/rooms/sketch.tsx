/** Curves drawn in space, and the surface that they carry, as they are drawn. */
import { useLayoutEffect, useState } from 'preact/hooks';
import type { App } from '../app';
import type { CurveEntry, RequestOptions } from '../document/types';
import { Check, Choice, Figures, LengthSlider, NumberInput, Section, Slider } from '../ui/controls';
import { short } from '../ui/numbers';
import type { Axis } from '../view/drawing';
import { Sentences } from './reconstruct';
import { modelOf, type Purpose, type Sketching, sketchingOf } from './sketching';

const TOOLS: readonly (readonly [Purpose, string, string])[] = [
  ['insert', 'Curve', 'D'],
  ['hole', 'Hole', 'O'],
  ['mirror', 'Half, mirrored', 'Shift+Y'],
  ['glue', 'Glue', 'G'],
  ['skin', 'Skin', 'K'],
  ['align', 'Align', 'A'],
];

/** What to draw next with a tool. */
function instruction(sketch: Sketching, isEmpty: boolean): string {
  const n = sketch.gathered.value.length;
  switch (sketch.purpose.value) {
    case 'insert':
      return isEmpty
        ? 'Draw a closed outline on the grid: the first face.'
        : 'Draw from curve to curve: the stroke lies between them, facing you. The right button or shift turns the view meanwhile.';
    case 'hole':
      return 'Draw a closed stroke on a face to cut it out, or one across curves to take away what lies inside it.';
    case 'mirror':
      return 'Draw one half of a curve: with its image across the line through its ends it becomes a closed one.';
    case 'glue':
      return n === 0 ? 'Draw a stroke from one border to another: one side of the tube.' : 'Draw the second stroke, from the same border to the same other one, on the other side.';
    case 'skin':
      if (sketch.spinesFrom.value !== null)
        return n === sketch.spinesFrom.value ? 'Draw a spine from the first profile to the last, across all of them.' : 'Draw the second spine, on the other side.';
      return n < 2 ? `Draw closed profiles, one after the other, at different offsets. ${n} drawn.` : `${n} profiles. Draw another, or go on to the spines.`;
    case 'align':
      return sketch.curve.value === null ? 'Click on the curve that you will draw again.' : 'Draw the whole curve where it is now: the model moves so that it lies there.';
  }
}

export function SketchPanel({ app }: { app: App }) {
  const { store } = app;
  const sketch = sketchingOf(app);
  const found = modelOf(store.objects.value, store.selected.value);
  const drawing = found !== null && sketch.tool.value === 'draw';
  const axis = sketch.axis.value;
  const offset = sketch.offset.value;
  const ground = sketch.ground.value;
  const symmetry = sketch.symmetry.value;
  const gathered = sketch.gathered.value;
  // Before the next event: a stroke that follows at once belongs to what is chosen now.
  useLayoutEffect(() => {
    sketch.use(drawing ? { ground, axis, offset } : null);
    return () => sketch.use(null);
  }, [sketch, app.view, drawing, axis, offset, ground, symmetry, gathered, found?.model.id]);
  if (!found) return <Welcome sketch={sketch} />;
  const { model, surface } = found;
  const drawn = store.drawn.value.get(surface?.id ?? model.id) ?? store.drawn.value.get(model.id);
  const names = new Set(drawn?.curves.map((one) => one.curve));
  const refusal = sketch.refusal.value;
  const preview = sketch.preview.value;
  const size = app.view?.size() ?? 1;
  return (
    <>
      <h2>{model.name}</h2>
      <Section title="Draw">
        <div class="tools" role="group" aria-label="Tool">
          {TOOLS.map(([purpose, title, keys]) => (
            <button
              key={purpose}
              type="button"
              title={keys}
              aria-pressed={sketch.tool.value === 'draw' && sketch.purpose.value === purpose}
              onClick={() => sketch.choose(purpose)}
            >
              {title}
            </button>
          ))}
          <button type="button" title="V" aria-pressed={sketch.tool.value === 'look'} onClick={() => (sketch.tool.value = 'look')}>
            Turn the view
          </button>
        </div>
        <p class="hint">{instruction(sketch, names.size === 0)}</p>
        {sketch.canBeginSpines() && (
          <button type="button" class="primary" onClick={() => sketch.beginSpines()}>
            Now the spines
          </button>
        )}
        <p class={`hint preview ${preview ? (preview.fits ? 'good' : 'bad') : ''}`} role="status" aria-live="off">
          {preview?.text ?? 'While you draw, what the stroke would meet stands here.'}
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
              sketch.axis.value = value as Axis;
            }
          }}
        />
        <LengthSlider
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
          label="Symmetry"
          help="Every stroke has an image across this plane, and one that begins and ends on it is completed (Y)."
          value={symmetry}
          options={[
            ['off', 'none'],
            ['x', 'across x = 0'],
            ['y', 'across y = 0'],
            ['z', 'across z = 0'],
          ]}
          onChange={(value) => {
            sketch.symmetry.value = value;
            if (value !== 'off' && ground === 'plane') sketch.offset.value = 0;
          }}
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
      </Section>
      {refusal && (
        <div class="refusal" role="alert">
          <p>{refusal.message}</p>
          {refusal.remedy && <p>{refusal.remedy}</p>}
          <div class="tools">
            {refusal.remedies.map((one) => (
              <button key={one.title} type="button" onClick={() => void one.run()}>
                {one.title}
              </button>
            ))}
            <button type="button" onClick={() => sketch.forget()}>
              Forget it
            </button>
          </div>
        </div>
      )}
      <CurvePart sketch={sketch} curves={drawn?.curves ?? []} />
      <MovePart sketch={sketch} unit={model.unit} />
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

/** The curve that was clicked on. */
function CurvePart({ sketch, curves }: { sketch: Sketching; curves: CurveEntry[] }) {
  const [whole, setWhole] = useState(true);
  const curve = sketch.curve.value;
  const edges = curves.filter((one) => one.curve === curve);
  const picked = curves[sketch.piece.value ?? -1];
  const piece = edges.length > 1 && picked?.curve === curve && picked.ends ? picked : null;
  const shown = (!whole && piece) || edges[0];
  const hint = <p class="empty">Click on a curve.</p>;
  return (
    <Section title="Curve">
      {curve === null || !shown ? (
        hint
      ) : (
        <>
          <p>
            <strong>c{curve}</strong>, {edges.length === 1 ? 'one piece' : `${edges.length} pieces`}
          </p>
          <Slider
            label="Sharpness"
            help="0 smooth, 1 an edge. The surface follows while it moves."
            min={0}
            max={1}
            value={shown.sharpness ?? 0}
            onChange={(value, rest) => sketch.setSharpness(Number(value.toFixed(2)), rest, whole || !piece?.ends ? null : piece.ends)}
          />
          {piece && <Check label="The whole curve" help="Off: only the piece that was clicked on." value={whole} onChange={setWhole} />}
          <div class="tools">
            <button type="button" title="M" onClick={() => void sketch.edit({ op: 'mirror', curve: `c${curve}` })}>
              Mirror
            </button>
            <button type="button" title="X" onClick={() => void sketch.remove()}>
              Delete
            </button>
          </div>
        </>
      )}
    </Section>
  );
}

/** The whole model moved, turned, scaled or mirrored. */
function MovePart({ sketch, unit }: { sketch: Sketching; unit: string }) {
  const [move, setMove] = useState<[number, number, number]>([0, 0, 0]);
  const [axis, setAxis] = useState<Axis>('z');
  const [angle, setAngle] = useState(0);
  const [scale, setScale] = useState(1);
  return (
    <Section title="Move the model" open={false}>
      <div class="triple">
        {(['x', 'y', 'z'] as const).map((name, k) => (
          <label key={name}>
            {name}
            <NumberInput
              label={`Move along ${name}, ${unit}`}
              text={String(move[k])}
              onTyped={(typed) => setMove(move.map((old, i) => (i === k ? (typed ?? 0) : old)) as [number, number, number])}
            />
          </label>
        ))}
        <span class="unit">{unit}</span>
      </div>
      <Choice
        label="About"
        help="The axis through the origin that it is turned about; a mirror lies across it."
        value={axis}
        options={[
          ['x', 'x'],
          ['y', 'y'],
          ['z', 'z'],
        ]}
        onChange={setAxis}
      />
      <Slider label="Turn" help="Counter-clockwise, seen against the axis." unit="°" min={-180} max={180} value={angle} onChange={(value) => setAngle(Math.round(value))} />
      <Slider label="Scale" help="1 keeps the size." min={0.1} max={10} logarithmic value={scale} onChange={(value) => setScale(Number(value.toPrecision(3)))} />
      <div class="tools">
        <button type="button" onClick={() => void sketch.transform(move, { axis, angle }, scale)}>
          Move
        </button>
        <button type="button" onClick={() => void sketch.transform([0, 0, 0], { axis, angle: 0 }, 1, true)}>
          Mirror all across {axis}
        </button>
      </div>
    </Section>
  );
}

function Welcome({ sketch }: { sketch: Sketching }) {
  return (
    <div class="welcome">
      <h2>Draw a surface</h2>
      <p>A closed outline first, then curves from curve to curve. The surface grows as you draw.</p>
      <button type="button" class="primary" onClick={() => void sketch.begin()}>
        New sketch
      </button>
    </div>
  );
}
