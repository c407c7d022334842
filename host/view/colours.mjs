// Colours of numbers on the body, with the scale that the legend shows.

/** What a colour may stand for: words, unit, and how a number is shown. */
export const QUANTITIES = {
  displacement: { title: "Displacement", unit: "mm", factor: 1e3, from: 0, leastEnd: 1e-3 },
  stretch: { title: "Largest surface stretch", unit: "", factor: 1, from: 1, leastEnd: 1.02 },
  stress: { title: "Stress (von Mises)", unit: "kPa", factor: 1e-3, from: 0, leastEnd: 10 },
  pressure: { title: "Contact pressure", unit: "kPa", factor: 1e-3, from: 0, leastEnd: 100 },
};

/** Colours of red, green and blue from 0 to 255 as CSS, from left to right. */
export function rampCss(ramp) {
  const stops = ramp.map((colour) => `rgb(${colour.join(" ")})`);
  return `linear-gradient(90deg, ${stops.join(", ")})`;
}

/** The end of a scale: it grows at once to the next round number, and shrinks where far too long. */
export class Scale {
  constructor() {
    this.end = 0;
  }

  follow(most, { from, leastEnd, factor }) {
    const wanted = Math.max(most, leastEnd);
    if (wanted > this.end || wanted - from < 0.3 * (this.end - from)) {
      this.end = from + roundUp(factor * (wanted - from)) / factor;
    }
    return this.end;
  }
}

/** The next of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten. */
export function roundUp(number) {
  const power = 10 ** Math.floor(Math.log10(number));
  const step = [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((step) => step * power >= number * 0.9999);
  return step * power;
}
