/** Five steps on the sample scan, for who has never seen it. Shown once; found again by "Tour". */
import { signal } from '@preact/signals';
import type { App } from '../app';

interface TourStep {
  text: string;
  /** What the button beside it does, so that nobody has to look for it. */
  action?: { title: string; run: (app: App) => void | Promise<void> };
}

const STEPS: TourStep[] = [
  {
    text: 'Nine curves traced on a rounded box by a device with errors, and the surface through them. Drag to turn it, use the wheel or two fingers to come nearer.',
  },
  {
    text: 'On the right stands what can be set, with a sentence each. Move Step h: the surface follows while you move, and is made whole when you let go.',
  },
  {
    text: 'Lamps mirrored in the surface show what light will show: where the stripes break, the surface does.',
    action: {
      title: 'Show reflection lines',
      run: (app) => {
        app.room.value = 'inspect';
        return app.setLook({ shading: 'reflection-lines' });
      },
    },
  },
  {
    text: 'A picture can mislead. Batten measures how the surface meets across every curve and says pass or fail; the worst place is a click away.',
    action: {
      title: 'Check all curves',
      run: (app) => {
        const id = app.store.selected.value;
        return id ? app.store.computeContinuity(id, (0.5 * Math.PI) / 180) : undefined;
      },
    },
  },
  {
    text: 'Save the surface above, or drop a scan, a curve network or a mesh of your own here. Ctrl+K finds every command; undo goes over everything.',
  },
];

const KEY = 'batten-tour-seen';
const at = signal<number | null>(null);

/** On the first visit alone, unless it is asked for. */
export function startTour(always = false): void {
  try {
    if (!always && localStorage.getItem(KEY)) return;
    localStorage.setItem(KEY, 'yes');
  } catch {
    if (!always) return; // a browser that keeps nothing would show it each time
  }
  at.value = 0;
}

export function Tour({ app }: { app: App }) {
  const index = at.value;
  const step = index === null ? undefined : STEPS[index];
  if (index === null || !step) return null;
  const isLast = index === STEPS.length - 1;
  return (
    <section class="tour" aria-label={`Tour, step ${index + 1} of ${STEPS.length}`}>
      <p>{step.text}</p>
      <div class="tools">
        {step.action && (
          <button type="button" onClick={() => void step.action?.run(app)}>
            {step.action.title}
          </button>
        )}
        <button type="button" class="primary" onClick={() => (at.value = isLast ? null : index + 1)}>
          {isLast ? 'Begin' : `Next (${index + 1} of ${STEPS.length})`}
        </button>
        {!isLast && (
          <button type="button" onClick={() => (at.value = null)}>
            Leave
          </button>
        )}
      </div>
    </section>
  );
}
