/** Numbers as text, rounded to what is known. */

/** Return a number with `digits` significant digits, without useless zeros of the exponent. */
export function short(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${minus(String(Number(mantissa)))}·${power(Number(exponent))}`;
  }
  return minus(String(Number(value.toPrecision(digits))));
}

/** Return a value with its standard error in brackets, `0.04999(1)`: the error has one digit, or two below 2. */
export function withError(value: number, error: number | null | undefined): string {
  if (!error || !Number.isFinite(error) || !Number.isFinite(value)) return short(value, 5);
  const leading = Math.floor(Math.log10(error));
  const digits = error / 10 ** leading < 1.95 ? 1 : 0;
  const places = digits - leading;
  if (places < 0 || places > 9) return `${short(value)} ± ${short(error, 2)}`;
  return `${minus(value.toFixed(places))}(${Math.round(error * 10 ** places)})`;
}

export function percent(share: number): string {
  if (share > 0.9995) return "> 99.9 %";
  if (share < 0.001) return "< 0.1 %";
  return `${Number((100 * share).toPrecision(3))} %`;
}

export function minus(text: string): string {
  return text.replace("-", "−");
}

/** Return a power of ten as text. */
export const power = (exponent: number) => `10${superscript(exponent)}`;

function superscript(exponent: number): string {
  return [...String(exponent)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
}

/** Return a name of the API as words: `extra_mass` as `extra mass`. */
export function words(name: string): string {
  return name.replaceAll("_", " ").replaceAll("-", " ");
}

export type Place = string | { members: number[] } | { channels: string[] } | { dofs: string[] } | null;

const MOST_NAMED = 4;

function channelText(channels: string[]): string {
  if (channels.length > MOST_NAMED) return `${channels.length} channels, ${channels[0]} to ${channels.at(-1)}`;
  return `${channels.length > 1 ? "channels" : "channel"} ${channels.join(", ")}`;
}

export function placeText(at: Place): string {
  if (at === null) return "everywhere";
  if (typeof at === "string") return `at ${at}`;
  if ("members" in at) return `${at.members.length > 1 ? "members" : "member"} ${at.members.join(", ")}`;
  if ("channels" in at) return channelText(at.channels);
  return `at ${at.dofs.join(", ")}`;
}

/** Return a time of the service in the reader's own. */
export const timeText = (iso: string) => new Date(iso).toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
