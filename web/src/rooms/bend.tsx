/** Controls of a mesh that is pulled at. */
import { useEffect, useLayoutEffect } from 'preact/hooks';
import type { App } from '../app';
import { Choice, Figures, LengthSlider, Slider } from '../ui/controls';
import { short } from '../ui/numbers';
import { bendingOf, handlesFile } from './bending';

export function BendPart({ app }: { app: App }) {
  const bending = bendingOf(app);
  const { store } = app;
  const held = bending.held.value;
  const { translation, angle } = bending.motion.value;
  const pulls = bending.tool.value === 'pull';
  // Before the next event, which may be a pointer that goes down.
  useLayoutEffect(() => {
    app.view?.setTool(pulls ? bending : null);
    return () => app.view?.setTool(null);
  }, [app.view, bending, pulls]);
  useEffect(() => () => bending.letGo(), [bending]);
  const objects = store.objects.value;
  const selected = store.selected.value;
  useEffect(() => bending.follow(), [bending, objects, selected]);
  const size = store.drawn.value.get(held?.object ?? selected ?? '')?.mesh?.diameter ?? 1;
  const setTranslation = (k: number, value: number, rest: boolean) =>
    bending.set({ angle, translation: translation.map((old, i) => (i === k ? value : old)) as [number, number, number] }, rest);
  const step = objects.find((one) => one.id === selected && one.request?.kind === 'deform');
  return (
    <>
      <div class="tools" role="group" aria-label="Pointer">
        <button type="button" aria-pressed={pulls} onClick={() => (bending.tool.value = 'pull')}>
          Pull
        </button>
        <button type="button" aria-pressed={!pulls} onClick={() => (bending.tool.value = 'look')}>
          Turn the view
        </button>
      </div>
      <p class="hint">
        {held
          ? 'Drag the red dot, an arrow to move along an axis, or the ring to turn; what is marked moves with it. Another place of the mesh takes hold there.'
          : 'Press on the mesh and drag. The right button or shift turns the view meanwhile; Shift+D takes hold of the middle of the view.'}
      </p>
      {bending.problem.value && (
        <p class="problem" role="alert">
          {bending.problem.value}
        </p>
      )}
      <Slider
        label="Handle"
        help="Radius of what moves as one, of the diameter."
        unit="%"
        min={0.5}
        max={40}
        logarithmic
        value={bending.radius.value}
        disabled={bending.result.value !== null}
        onChange={(value, rest) => {
          bending.radius.value = Number(value.toPrecision(2));
          if (rest) void bending.again();
        }}
      />
      <Slider
        label="Reach"
        help="Farther away nothing moves, of the diameter."
        unit="%"
        min={2}
        max={100}
        logarithmic
        value={bending.reach.value}
        disabled={bending.result.value !== null}
        onChange={(value, rest) => {
          bending.reach.value = Number(value.toPrecision(2));
          if (rest) void bending.again();
        }}
      />
      <Choice
        label="Along"
        help="What the drag of a pointer is bound to."
        value={bending.along.value}
        options={[
          ['view', 'the plane of the view'],
          ['normal', 'the normal of the place'],
          ['x', 'x'],
          ['y', 'y'],
          ['z', 'z'],
        ]}
        onChange={(along) => (bending.along.value = along)}
      />
      {(['x', 'y', 'z'] as const).map((name, k) => (
        <LengthSlider
          key={name}
          label={`Move ${name}`}
          unit={held?.unit ?? ''}
          min={-size / 2}
          max={size / 2}
          digits={4}
          value={translation[k] ?? 0}
          disabled={!held}
          onChange={(value, rest) => setTranslation(k, Number(value.toPrecision(4)), rest)}
        />
      ))}
      <Slider
        label="Turn"
        help="About the normal of the place that is held."
        unit="°"
        min={-180}
        max={180}
        value={angle}
        disabled={!held}
        onChange={(value, rest) => bending.set({ translation, angle: Math.round(value) }, rest)}
      />
      <Choice
        label="Energy"
        help="How what moves along bends."
        value={bending.energy.value}
        options={[
          ['total', 'total curvature'],
          ['bend', 'bending'],
          ['combined', 'stretching and bending'],
          ['stretch', 'stretching'],
        ]}
        onChange={(energy) => {
          bending.energy.value = energy;
          void bending.again();
        }}
      />
      <Choice
        label="Detail"
        help="How small features turn with the surface. While you drag they keep their direction."
        value={bending.detail.value}
        options={[
          ['gauss-newton', 'turns, by normals'],
          ['shape-matching', 'turns, as rigid as possible'],
          ['none', 'keeps its direction'],
        ]}
        onChange={(detail) => {
          bending.detail.value = detail;
          if (bending.result.value) void bending.commit();
        }}
      />
      {held && (
        <Figures
          rows={[
            ['vertices of the handle', short(held.moved.length)],
            ['vertices that stay', short(held.fixed.length)],
          ]}
        />
      )}
      <div class="tools">
        <button type="button" disabled={!held} onClick={() => bending.letGo()}>
          Let go
        </button>
        {step?.request && (
          <button type="button" onClick={() => app.saveText(handlesFile(step.request as NonNullable<typeof step.request>), `${step.name} handles`, 'json')}>
            Save handles.json
          </button>
        )}
      </div>
    </>
  );
}
