/** Numbers as people read them. */

const DEGREE = Math.PI / 180;

/** Four significant digits, thousands apart: 60,572; 0.01234. */
export function short(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (Number.isInteger(value)) return value.toLocaleString('en');
  return Number(value.toPrecision(digits)).toLocaleString('en', { maximumSignificantDigits: digits });
}

export function length(value: number | null | undefined, unit: string): string {
  return unit ? `${short(value)} ${unit}` : short(value);
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
