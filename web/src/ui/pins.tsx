/** Numbered marks over the view for what is wrong, each with its sentence and what can be done about it. */
import { useEffect, useRef, useState } from 'preact/hooks';
import type { App } from '../app';

export interface Pin {
  /** In coordinates of the model. */
  place: [number, number, number];
  text: string;
  remedies: { title: string; run: () => void }[];
}

export function Pins({ app }: { app: App }) {
  const list = app.pins.value;
  const place = useRef<HTMLDivElement>(null);
  const [open, setOpen] = useState<number | null>(null);
  const { view } = app;
  useEffect(() => {
    if (!view) return;
    const follow = () => {
      const marks = place.current?.querySelectorAll<HTMLElement>('.pin') ?? [];
      marks.forEach((mark, i) => {
        const pin = list[i];
        if (!pin) return;
        const at = view.onScreen(view.fromModel(pin.place));
        const inside = at.x > 0 && at.y > 0 && at.x < view.element.clientWidth && at.y < view.element.clientHeight;
        mark.style.visibility = inside ? '' : 'hidden';
        mark.style.left = `${at.x}px`;
        mark.style.top = `${at.y}px`;
      });
    };
    follow();
    view.onDrawn.add(follow);
    return () => void view.onDrawn.delete(follow);
  }, [view, list]);
  const shown = open === null ? undefined : list[open];
  return (
    <div ref={place} class="pins">
      {list.map((pin, i) => (
        <button
          key={pin.text}
          type="button"
          class="pin"
          aria-label={`${i + 1}: ${pin.text}`}
          aria-expanded={open === i}
          title={pin.text}
          onClick={() => setOpen(open === i ? null : i)}
        >
          {i + 1}
        </button>
      ))}
      {shown && (
        <div class="pin-text" role="status">
          <p>{shown.text}</p>
          <div class="tools">
            {shown.remedies.map((one) => (
              <button key={one.title} type="button" onClick={one.run}>
                {one.title}
              </button>
            ))}
            <button type="button" onClick={() => setOpen(null)}>
              Close
            </button>
          </div>
        </div>
      )}
    </div>
  );
}
