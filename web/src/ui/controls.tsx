/** The few controls that panels are made of: native elements with a name, a unit and one sentence of help. */
import type { ComponentChildren } from 'preact';
import { useId, useState } from 'preact/hooks';
import { shown } from './numbers';

interface Labelled {
  label: string;
  help?: string;
}

export function Section(props: { title: string; children: ComponentChildren; open?: boolean }) {
  return (
    <details class="section" open={props.open ?? true}>
      <summary>{props.title}</summary>
      <div class="section-body">{props.children}</div>
    </details>
  );
}

/**
 * A number to be typed, handed on when it is finished: with Enter, or when the field is left. What is being typed stays
 * when another value arrives meanwhile, as one does at the end of a step; Escape takes it back.
 */
export function NumberInput(props: {
  label: string;
  /** What the field shows while nothing is typed. */
  text: string;
  min?: number;
  max?: number;
  placeholder?: string;
  disabled?: boolean | undefined;
  /** @param value null where the field was left empty or holds no number */
  onTyped: (value: number | null) => void;
}) {
  const [draft, setDraft] = useState<string | null>(null);
  return (
    <input
      type="number"
      inputMode="decimal"
      step="any"
      aria-label={props.label}
      value={draft ?? props.text}
      min={props.min}
      max={props.max}
      placeholder={props.placeholder}
      disabled={props.disabled}
      onInput={(event) => setDraft(event.currentTarget.value)}
      onKeyDown={(event) => {
        if (event.key === 'Escape') setDraft(null);
      }}
      onBlur={() => setDraft(null)}
      onChange={(event) => {
        const typed = event.currentTarget.value;
        setDraft(null);
        props.onTyped(typed !== '' && Number.isFinite(Number(typed)) ? Number(typed) : null);
      }}
    />
  );
}

/** A slider with its number, which can be typed too. Linear, or in equal ratios. */
export function Slider(
  props: Labelled & {
    value: number;
    min: number;
    max: number;
    step?: number;
    logarithmic?: boolean;
    unit?: string;
    digits?: number;
    disabled?: boolean;
    /** While it moves: `rest` is false; once when it rests: true. */
    onChange: (value: number, rest: boolean) => void;
  },
) {
  const id = useId();
  const log = props.logarithmic ?? false;
  const to = (value: number) => (log ? Math.log10(value) : value);
  const from = (place: number) => (log ? 10 ** place : place);
  const digits = props.digits ?? 3;
  const rounded = Number(props.value.toPrecision(digits));
  const text = rounded !== 0 && Math.abs(rounded) < 1e-3 ? rounded.toExponential(1) : String(rounded);
  const value = Math.min(props.max, Math.max(props.min, props.value));
  return (
    <div class="field">
      <label for={id} title={props.help}>
        {props.label}
      </label>
      <input
        id={id}
        type="range"
        min={to(props.min)}
        max={to(props.max)}
        step={log ? 0.02 : (props.step ?? 'any')}
        value={to(value)}
        disabled={props.disabled}
        title={props.help}
        onInput={(event) => props.onChange(from(Number(event.currentTarget.value)), false)}
        onChange={(event) => props.onChange(from(Number(event.currentTarget.value)), true)}
      />
      <span class="number">
        <NumberInput
          label={`${props.label}${props.unit ? `, ${props.unit}` : ''}`}
          text={text}
          min={props.min}
          max={props.max}
          disabled={props.disabled}
          onTyped={(typed) => {
            if (typed !== null) props.onChange(Math.min(props.max, Math.max(props.min, typed)), true);
          }}
        />
        <span class="unit">{props.unit ?? ''}</span>
      </span>
      {props.help && <small class="help">{props.help}</small>}
    </div>
  );
}

/** A slider of a length, in the unit that lengths are shown in. @param unit of the value. */
export function LengthSlider(props: Parameters<typeof Slider>[0] & { unit: string }) {
  const { factor, unit } = shown(props.unit);
  return (
    <Slider
      {...props}
      unit={unit}
      value={props.value * factor}
      min={props.min * factor}
      max={props.max * factor}
      onChange={(value, rest) => props.onChange(value / factor, rest)}
    />
  );
}

export function Choice<T extends string>(
  props: Labelled & { value: T; options: readonly (readonly [T, string])[]; disabled?: boolean; onChange: (value: T) => void },
) {
  const id = useId();
  return (
    <div class="field">
      <label for={id} title={props.help}>
        {props.label}
      </label>
      <select
        id={id}
        value={props.value}
        disabled={props.disabled}
        onChange={(event) => props.onChange(event.currentTarget.value as T)}
      >
        {props.options.map(([value, title]) => (
          <option key={value} value={value}>
            {title}
          </option>
        ))}
      </select>
      {props.help && <small class="help">{props.help}</small>}
    </div>
  );
}

export function Check(props: Labelled & { value: boolean; onChange: (value: boolean) => void }) {
  return (
    <div class="field check">
      <label title={props.help}>
        <input type="checkbox" checked={props.value} onChange={(event) => props.onChange(event.currentTarget.checked)} />
        {props.label}
      </label>
      {props.help && <small class="help">{props.help}</small>}
    </div>
  );
}

export function Figures(props: { rows: readonly (readonly [string, string])[] }) {
  return (
    <dl class="figures">
      {props.rows.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}
