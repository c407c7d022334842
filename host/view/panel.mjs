// The panel beside the picture: readings, settings and what they do.
import { QUANTITIES, rampCss } from "./colours.mjs";
import { TOOLS_MAX } from "./limits.mjs";
import { partsOf } from "./parts.mjs";

/** The element of an id. */
export const $ = (id) => document.getElementById(id);

/** Tools that can be chosen, by a radius [m]. */
const KINDS = {
  sphere: { title: "Ball", text: (radius) => `sphere:${radius}` },
  capsule: { title: "Rod", text: (radius) => `capsule:${round(3 * radius)},${radius}` },
  box: { title: "Block", text: (radius) => `box:${round(radius)},${round(radius)},${round(0.5 * radius)},${round(0.4 * radius)}` },
  "half-space": { title: "Plate", text: (radius) => `half-space:${radius}` },
  blade: { title: "Blade", text: (radius) => `blade:${round(4 * radius)}`, radiusM: ({ edge }) => 0.5 * edge.halfM[0] },
};
/** How long a flag is shown after its last tick [ms]. */
const FLAG_MS = 2500;

const round = (lengthM) => Number(lengthM.toFixed(5));
export const grouped = (number) => Math.round(number).toLocaleString("en");

export class Panel {
  constructor(config) {
    this.config = config;
    this.flags = new Map();
    $("ramp").style.background = rampCss(config.ramp);
    for (const [name, { title }] of Object.entries(QUANTITIES)) $("colour").add(new Option(title, name));
  }

  /** Shows what there is of a body and what its source can do. */
  ready(info, can) {
    const { name, material } = this.config;
    $("name").textContent = document.title = name;
    const stuff = material ? `, ${Number((material.young_pa / 1e3).toPrecision(3))} kPa, ν ${material.poisson}` : "";
    const where = this.config.mode === "live" ? "; a running scene moves the tool" : "";
    this.canBeCut = info.canBeCut;
    for (const row of document.querySelectorAll(".cuts")) row.hidden = !info.canBeCut;
    $("about").textContent = `${grouped(info.cells - (info.spareCells ?? 0))} cells, ${grouped(info.links)} links${stuff}${where}`;
    for (const [id, verb] of [["pause", "pause"], ["step", "step"], ["reset", "reset"], ["save-path", "path"], ["save-model", "path"]]) {
      $(id).hidden = !can.has(verb);
    }
    $("run").hidden = !["pause", "step", "reset"].some((verb) => can.has(verb));
    $("settings").hidden = !["settings", "sweeps"].some((verb) => can.has(verb));
    $("settings").classList.toggle("sweeps-alone", !can.has("settings"));
    $("lift").hidden = !can.has("tool");
    $("tools").hidden = !can.has("tools");
    $("legend").hidden = false;
    $("material").hidden = !(can.has("bake") && material);
    if (material) [$("young").value, $("poisson").value] = [material.young_pa / 1e3, material.poisson];
    $("beside-label").hidden = !info.hasTools;
    this.#without("pressure", !info.hasTools, "held cells have none");
    this.#without("stress", !info.hasShapes, "links have none");
  }

  /** Greys out what a body does not have, and says why. */
  #without(quantity, lacks, why) {
    const option = $("colour").querySelector(`[value=${quantity}]`);
    option.disabled = lacks;
    option.textContent = `${QUANTITIES[quantity].title}${lacks ? `: ${why}` : ""}`;
  }

  /** Buttons that choose a tool, add one and take the chosen one away. */
  #tools({ tools, chosen }, choose, change) {
    const button = (text, title, act) => {
      const made = document.createElement("button");
      Object.assign(made, { textContent: text, title, onclick: act });
      return made;
    };
    const each = tools.map((_, index) => {
      const made = button(String(index + 1), `Tool ${index + 1}: keys, wheel and readings go with it`, () => choose(index));
      made.setAttribute("aria-pressed", index === chosen);
      return made;
    });
    const add = button("Add a tool", "Another one like this, the body at rest", () => change({ tools: [...tools, tools[chosen]], chosen: tools.length }));
    add.disabled = tools.length >= TOOLS_MAX;
    add.id = "add-tool";
    const remove = button("Remove", "Takes the chosen tool away, the body at rest", () =>
      change({ tools: tools.filter((_, index) => index !== chosen), chosen: Math.max(0, chosen - 1) }));
    remove.id = "remove-tool";
    $("tools").replaceChildren(...(tools.length > 1 ? [...each, add, remove] : [add]));
  }

  /** Fills in the settings of the chosen tool; `change` gets what the user sets, `choose` the tool of a button. */
  settings(setup, unitM, change, choose) {
    const kind = setup.tools[setup.chosen];
    this.#tools(setup, choose, change);
    $("sweeps").value = setup.sweeps;
    $("friction").value = setup.friction;
    $("kind").replaceChildren();
    const parts = kind ? partsOf(kind) : [];
    const radiusM = parts.length ? (KINDS[parts[0].kind]?.radiusM?.(parts[0]) ?? parts[0].radiusM) : 0.01;
    const known = parts.length === 1 && kind in this.#texts(radiusM) ? parts[0].kind : "own";
    if (known === "own") $("kind").add(new Option(kind ?? "Held cells", "own"));
    const kinds = Object.entries(KINDS).filter(([name]) => name !== "blade" || this.canBeCut);
    if (kind) for (const [name, { title }] of kinds) $("kind").add(new Option(title, name));
    $("kind").value = known;
    const step = unitM > 0.004 ? 0.5 : 0.1;
    Object.assign($("radius"), { min: step * Math.ceil((400 * unitM) / step), max: step * Math.ceil((2500 * unitM) / step), step });
    $("radius").value = 1e3 * radiusM;
    for (const part of document.querySelectorAll(".scissors")) part.hidden = !setup.tools.some((tool) => tool.includes("scissors"));
    if (setup.openingRad) $("opening").value = Math.round((180 / Math.PI) * setup.openingRad);
    const tell = () => {
      $("opening-text").textContent = `${$("opening").value}°`;
      $("sweeps-text").textContent = $("sweeps").value;
      $("friction-text").textContent = Number($("friction").value).toFixed(2);
      $("radius-text").textContent = `${Number($("radius").value)} mm`;
      $("radius").disabled = $("kind").value === "own";
      $("friction").disabled = !kind;
    };
    const wanted = () => ($("kind").value === "own" ? kind : KINDS[$("kind").value].text(round($("radius").value / 1e3)));
    $("kind").onchange = $("radius").onchange = () => change({ tools: setup.tools.with(setup.chosen, wanted()) });
    $("friction").onchange = () => change({ friction: Number($("friction").value) });
    $("sweeps").onchange = () => change({ sweeps: Number($("sweeps").value) });
    $("opening").oninput = () => {
      tell();
      change({ openingRad: (Math.PI / 180) * Number($("opening").value) });
    };
    $("settings").oninput = tell;
    tell();
  }

  #texts(radiusM) {
    return Object.fromEntries(Object.values(KINDS).map(({ text }) => [text(radiusM), true]));
  }

  /** Shows a state, with the readings of the chosen tool. */
  show(state, depthM, chosen) {
    const tool = state.tools[chosen];
    $("force").textContent = tool ? Math.hypot(...tool.forceN).toFixed(3) : "";
    $("error").textContent = tool?.contacts ? errorText(tool.errorN) : "";
    $("depth").textContent = Number.isNaN(depthM) ? "–" : (1e3 * depthM).toFixed(1);
    $("energy").textContent = `${(1e3 * state.energyJ).toFixed(3)} mJ`;
    $("torque").textContent = tool ? `${(1e3 * Math.hypot(...tool.torqueNM)).toFixed(2)} mN m` : "";
    $("contacts").textContent = tool?.contacts ?? "";
    $("made").textContent = state.sweeps;
    if (state.cuts) [$("cut").textContent, $("cut-work").textContent] = [cutText(state.cuts), `${(1e3 * state.cuts.workJ).toFixed(3)} mJ`];
    $("step-us").textContent = state.stepUs > 0 ? `${grouped(state.stepUs)} of 1,000 µs` : "";
    $("budget").value = state.stepUs;
    $("rate").textContent = `${grouped(state.ticksPerS)} ticks a second`;
    $("hash").textContent = state.hash ?? "";
    this.#showFlags(state.tools.reduce((all, one) => all | one.flags, 0));
  }

  /** Flags in words; one stays a while after its last tick. */
  #showFlags(flags) {
    const now = performance.now();
    for (const { bit } of this.config.flags) if (flags & bit) this.flags.set(bit, now);
    const shown = this.config.flags.filter(({ bit }) => now - (this.flags.get(bit) ?? -Infinity) < FLAG_MS);
    const key = shown.map(({ bit }) => bit * ((flags & bit) === 0 ? -1 : 1)).join();
    if (key === this.shownFlags) return;
    this.shownFlags = key;
    $("flags").replaceChildren(...shown.map(({ bit, name, meaning }) => {
      const item = document.createElement("li");
      item.textContent = name;
      item.title = meaning;
      item.className = flags & bit ? "" : "past";
      return item;
    }));
  }

  /** Shows the scale of the colours. */
  legend(colour, end) {
    const { unit, factor, from } = QUANTITIES[colour];
    const text = (value) => `${Number((factor * value).toPrecision(3))}${unit && ` ${unit}`}`;
    $("low").textContent = text(from);
    $("high").textContent = text(end);
  }
}

/** How far a body is cut. */
function cutText({ areaM2, openedFaces, torn }) {
  if (openedFaces === 0) return "whole";
  return torn > 0 ? `torn at ${grouped(torn)} cells` : `${(1e6 * areaM2).toFixed(0)} mm²`;
}

/** The estimated error of a force, which is below 0 where it is not known. */
function errorText(errorN) {
  return errorN >= 0 ? `± ${errorN.toFixed(3)} N` : "not known";
}
