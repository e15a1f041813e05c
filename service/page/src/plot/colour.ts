/** Colours of the style sheet, for a canvas. */

/** Return a colour as a canvas takes it, with the light that is on. */
export function resolve(colour: string): string {
  const probe = document.createElement("i");
  probe.style.color = colour.startsWith("--") ? `var(${colour})` : colour;
  document.body.append(probe);
  const found = getComputedStyle(probe).color;
  probe.remove();
  return found;
}

export function rgb(colour: string): [number, number, number] {
  const context = document.createElement("canvas").getContext("2d", { willReadFrequently: true })!;
  context.fillStyle = resolve(colour);
  context.fillRect(0, 0, 1, 1);
  const [r, g, b] = context.getImageData(0, 0, 1, 1).data;
  return [r, g, b];
}

/** Return the colour of curve `index` of `count`: hues from blue by green to orange, alike in lightness. */
export function tone(index: number, count: number): string {
  if (count <= 1) return "--accent";
  const hue = 262 - (index / Math.max(count - 1, 1)) * 222;
  return `light-dark(oklch(0.53 0.14 ${hue.toFixed(0)}), oklch(0.76 0.13 ${hue.toFixed(0)}))`;
}

/** Call `draw` whenever the light changes: a canvas keeps the colours of before. */
export function onLightChange(draw: () => void): () => void {
  const query = matchMedia("(prefers-color-scheme: dark)");
  query.addEventListener("change", draw);
  addEventListener("lightchange", draw);
  return () => {
    query.removeEventListener("change", draw);
    removeEventListener("lightchange", draw);
  };
}
