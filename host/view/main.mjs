// Puts source, picture, hand, curves and panel together.
import { Camera } from "./camera.mjs";
import { Charts } from "./charts.mjs";
import { Hand } from "./hand.mjs";
import { Live } from "./live.mjs";
import { Own } from "./own.mjs";
import { $, Panel } from "./panel.mjs";
import { partsOf, reachM } from "./parts.mjs";
import { commandOf, fileName, keep, pathText } from "./save.mjs";
import { Scene } from "./scene.mjs";
import { Session } from "./session.mjs";
import { nearestAtRest } from "./surface.mjs";
import { Timeline } from "./timeline.mjs";

/** Place that the label of the force takes [CSS pixels]. */
const LABEL = { width: 72, height: 30 };
const SOURCES = { own: Own, live: Live, session: Session };

class View {
  constructor(config) {
    this.config = config;
    this.camera = new Camera();
    this.scene = new Scene($("picture"), this.camera, config.ramp);
    this.charts = new Charts($("over-time"), $("over-depth"));
    this.panel = new Panel(config);
    this.source = new SOURCES[config.mode](config);
    this.state = null;
    this.depthM = 0;
    this.isPaused = false;
    this.commandTick = null;
    Object.assign(this.source, {
      onready: (body) => this.#ready(body),
      onstate: (state) => this.#take(state),
      onstatus: (text) => ($("status").textContent = text),
      onsetup: () => this.#showSettings(),
    });
    this.#listen();
    new ResizeObserver(() => this.#resize()).observe($("stage"));
    requestAnimationFrame(() => this.#frame());
  }

  #resize() {
    this.camera.resize($("stage").clientWidth, $("stage").clientHeight, this.scene.chain ? 2 : 1);
  }

  #ready(body) {
    this.body = body;
    // Until there is a state of this body nothing is drawn.
    this.state = null;
    $("stage").classList.remove("is-shown");
    this.isAwaited = true;
    this.scene.ready(body);
    this.#showColour();
    this.panel.ready(body.info, this.source.can);
    if (["settings", "sweeps"].some((verb) => this.source.can.has(verb))) {
      this.#showSettings();
    }
    this.charts.clear();
    this.#showCommand(null);
    this.#showPaused(false);
    if (this.source.can.has("seek")) this.timeline = new Timeline(this.source, body.info.session);
    $("status").textContent = "";
  }

  /** The first picture of a body is there: the hint comes, and time begins. */
  #begin() {
    this.isAwaited = false;
    $("stage").classList.add("is-shown");
    $("hint").hidden = !this.source.can.has("tool");
    this.source.shown?.();
  }

  #showSettings() {
    const choose = (tool) => this.#choose(tool);
    this.panel.settings(this.source.setup, this.body.info.unitM, (settings) => this.#change(settings), choose);
  }

  /** The tool that keys, wheel and readings go with. */
  get chosen() {
    return this.source.setup?.chosen ?? 0;
  }

  #choose(tool) {
    if (tool === this.chosen) return;
    this.source.settings({ chosen: tool });
    this.#showChosen();
  }

  #showChosen() {
    this.normal = null;
    this.depthM = 0;
    this.charts.clear();
    this.scene.choose(this.chosen);
    this.#showSettings();
  }

  #take(state) {
    this.state = state;
    if (this.commandTick !== null && state.tick !== this.commandTick) this.#showCommand(null);
    this.scene.take(state);
    this.charts.add(state.trail);
    if (state.trail.length) this.depthM = state.trail[state.trail.length - 1].depthM;
    this.timeline?.show(state);
    if (state.session?.isAtEnd && !this.isPaused) this.#pause(true);
  }

  /** The source computes what the colours show, of the cells of the surface. */
  #showColour() {
    this.source.show($("colour").value, this.scene.figure.surface);
  }

  /** The tools that can be moved, with how far each reaches. */
  #tools() {
    if (!this.state || !this.source.can.has("tool")) return [];
    return this.state.tools.map((tool) => ({ ...tool, reachM: Math.min(reachM(partsOf(tool.kind)), this.scene.size / 3) }));
  }

  /** The surface's normal at rest where the chosen tool is nearest; it stays while the tool touches. */
  #normal() {
    const tool = this.state.tools[this.chosen];
    if (tool.contacts === 0 || !this.normal) this.normal = nearestAtRest(this.body, tool.positionM).normal;
    return this.normal;
  }

  #listen() {
    this.hand = new Hand($("stage"), this.camera, {
      tools: () => this.#tools(), chosen: () => this.chosen, choose: (tool) => this.#choose(tool),
      size: () => this.scene.size, normal: () => this.#normal(),
      move: (pose) => this.source.tool(this.chosen, pose), touched: () => ($("hint").hidden = true),
    });
    $("colour").onchange = () => {
      this.scene.setLook({ colour: $("colour").value });
      this.#showColour();
    };
    for (const id of ["wires", "links", "fixed"]) $(id).onchange = () => this.scene.setLook({ [id]: $(id).checked });
    $("beside").onchange = () => this.#compare($("beside").checked);
    $("pause").onclick = () => this.#pause(!this.isPaused);
    $("step").onclick = () => {
      this.#pause(true);
      this.source.step();
    };
    $("reset").onclick = () => this.#reset();
    $("save-picture").onclick = () => this.#savePicture();
    $("save-path").onclick = () => this.#savePath();
    $("save-model").onclick = () => keep(`${this.fileName()}.chaincell`, this.source.image, "application/octet-stream");
    $("material").onsubmit = (event) => this.#bake(event);
    for (const [id, direction] of [["up", 1], ["down", -1]]) {
      $(id).onpointerdown = (event) => {
        event.stopPropagation();
        $(id).setPointerCapture(event.pointerId);
        this.held = direction;
      };
      $(id).onpointerup = $(id).onpointercancel = () => (this.held = 0);
    }
    $("legend").onpointerdown = (event) => event.stopPropagation();
    addEventListener("keydown", (event) => this.#key(event));
  }

  #key(event) {
    if (event.target.closest("input, select, button") || event.ctrlKey || event.metaKey || event.altKey) return;
    const verbs = { o: () => this.#open(1), c: () => this.#open(-1), " ": () => this.#pause(!this.isPaused), ".": () => $("step").click(), r: () => this.#reset() };
    if (verbs[event.key]) verbs[event.key]();
    else if (!this.hand.key(event.key)) return;
    event.preventDefault();
  }

  /** Opens scissors by a notch of their slider, below 0 closes them. */
  #open(notches) {
    const slider = $("opening");
    if (slider.hidden) return;
    slider.stepUp(notches);
    slider.oninput();
  }

  /** ChainMail beside the body, or the body alone. */
  #compare(on) {
    this.scene.compare(on);
    $("captions").hidden = !on;
    this.#resize();
  }

  #pause(on) {
    if (!this.source.can.has("pause")) return;
    this.#showPaused(on);
    this.source.pause(on);
  }

  #showPaused(on) {
    this.isPaused = on;
    $("pause").textContent = on ? "Go on" : "Pause";
  }

  #reset() {
    if (!this.source.can.has("reset")) return;
    $("hint").hidden = true;
    this.#showCommand(null);
    this.charts.clear();
    this.depthM = 0;
    this.source.reset();
  }

  #change(settings) {
    $("hint").hidden = true;
    this.#showCommand(null);
    $("status").textContent = "";
    this.source.settings(settings);
    if ("tools" in settings) this.#showChosen();
  }

  async #bake(event) {
    event.preventDefault();
    const material = { young_pa: 1e3 * Number($("young").value), poisson: Number($("poisson").value) };
    $("bake").disabled = true;
    $("status").textContent = "Baking";
    try {
      await this.source.bake(material);
      this.config.material = material;
    } catch (why) {
      $("status").textContent = why.message;
    }
    $("bake").disabled = false;
  }

  fileName() {
    return fileName(this.config.name);
  }

  #savePicture() {
    const background = getComputedStyle(document.documentElement).getPropertyValue("--paper");
    this.scene.picture(background).toBlob((png) => keep(`${this.fileName()}.png`, png, "image/png"));
  }

  async #savePath() {
    this.#pause(true);
    const { poses, ticks, hash } = await this.source.path();
    const tools = Math.max(this.source.setup.tools.length, 1);
    keep(`${this.fileName()}.csv`, pathText(poses, this.source.setup.tools), "text/csv");
    const isWhole = (8 * tools + 1) * ticks === poses.length;
    const end = isWhole ? `   # ${ticks} ticks, state hash ${hash}` : "   # the first ten minutes";
    this.#showCommand({ tick: ticks, text: commandOf(this.fileName(), this.source.setup, this.body.info.sweepsMax) + end });
    $("replay").scrollIntoView({ block: "nearest" });
  }

  /** Shows the command that plays what was saved, until the body goes on; null shows none. */
  #showCommand(command) {
    this.commandTick = command?.tick ?? null;
    $("command").textContent = command?.text ?? "";
    $("replay").hidden = !command;
  }

  #frame() {
    requestAnimationFrame(() => this.#frame());
    if (!this.state) return;
    if (this.held) this.hand.hold(this.held);
    if (this.scene.renew()) this.#showColour();
    const isDrawn = this.scene.draw();
    // The body comes first.
    if (!this.isAwaited) this.charts.draw();
    if (!isDrawn) return;
    if (this.state !== this.shown) this.panel.show(this.state, this.depthM, this.chosen);
    this.shown = this.state;
    this.panel.legend(this.scene.look.colour, this.scene.scale.end);
    this.#showLabel();
    if (this.isAwaited) this.#begin();
    this.frames = (this.frames ?? 0) + 1;
  }

  /** The force beside its arrow, or beyond its end where there is no place beside it. */
  #showLabel() {
    const tip = this.scene.forceTip();
    $("label").hidden = !tip;
    if (!tip) return;
    $("label").textContent = `${tip.forceN.toFixed(2)} N`;
    const { width, height } = this.camera;
    const isBeside = tip.x + 10 <= width - LABEL.width;
    const x = Math.min(Math.max(tip.x + 10, 4), width - LABEL.width);
    const above = tip.y - (isBeside ? 24 : LABEL.height);
    const y = Math.min(Math.max(!isBeside && tip.isDown ? tip.y + 6 : above, 4), height - LABEL.height);
    $("label").style.transform = `translate(${Math.round(x)}px, ${Math.round(y)}px)`;
  }
}

const config = JSON.parse($("config").textContent);
try {
  const view = new View(config);
  /** For scripts on this page: what is shown, and where it comes from. */
  globalThis.chaincell = view;
  await view.source.start();
} catch (why) {
  $("status").textContent = why.message;
}
