/** Numbers as people read them. */
import { signal } from '@preact/signals';

const DEGREE = Math.PI / 180;

/** Four significant digits, thousands apart: 60,572; 0.01234. */
export function short(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (Number.isInteger(value)) return value.toLocaleString('en');
  return Number(value.toPrecision(digits)).toLocaleString('en', { maximumSignificantDigits: digits });
}

/** Metres. */
const UNITS: Record<string, number> = { um: 1e-6, mm: 1e-3, cm: 1e-2, m: 1, km: 1e3, in: 0.0254, ft: 0.3048 };
export const SHOWN_UNITS = ['mm', 'cm', 'm', 'in'] as const;

/** The unit that lengths are shown in; empty: each object's own. */
export const shownUnit = signal('');

/** How a length in a unit is shown: times `factor`, in `unit`. Without a unit that is known it stays as it is. */
export function shown(unit: string): { factor: number; unit: string } {
  const [from, to] = [UNITS[unit], UNITS[shownUnit.value]];
  return from && to ? { factor: from / to, unit: shownUnit.value } : { factor: 1, unit };
}

/** @param power 2 for areas, 3 for volumes. */
export function length(value: number | null | undefined, unit: string, power: 1 | 2 | 3 = 1): string {
  const { factor, unit: name } = shown(unit);
  const text = short(value === null || value === undefined ? value : value * factor ** power);
  return name ? `${text} ${name}${['', '', '²', '³'][power]}` : text;
}

export function degrees(radians: number | null | undefined): string {
  return radians === null || radians === undefined ? '–' : `${short(radians / DEGREE, 3)}°`;
}

export function percent(share: number | null | undefined): string {
  return share === null || share === undefined ? '–' : `${short(100 * share, 3)} %`;
}

export function milliseconds(ms: number): string {
  return ms < 1000 ? `${Math.round(ms)} ms` : `${short(ms / 1000, 3)} s`;
}

export const toRadians = (degrees: number): number => degrees * DEGREE;
