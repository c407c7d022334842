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

const SOURCES = { own: Own, live: Live, session: Session };

class View {
  constructor(config) {
    this.config = config;
    this.camera = new Camera();
    this.scene = new Scene($("picture"), this.camera);
    this.charts = new Charts($("over-time"), $("over-depth"));
    this.panel = new Panel(config);
    this.source = new SOURCES[config.mode](config);
    this.state = null;
    this.depthM = 0;
    this.isPaused = false;
    Object.assign(this.source, {
      onready: (body) => this.#ready(body),
      onstate: (state) => this.#take(state),
      onstatus: (text) => ($("status").textContent = text),
    });
    this.#listen();
    new ResizeObserver(() => this.camera.resize($("stage").clientWidth, $("stage").clientHeight)).observe($("stage"));
    requestAnimationFrame(() => this.#frame());
  }

  #ready(body) {
    this.body = body;
    this.scene.ready(body);
    this.panel.ready(body.info, this.source.can);
    if (["settings", "sweeps"].some((verb) => this.source.can.has(verb))) {
      this.panel.settings(this.source.setup, body.info.unitM, (settings) => this.#change(settings));
    }
    this.charts.clear();
    this.#showPaused(false);
    if (this.source.can.has("seek")) this.timeline = new Timeline(this.source, body.info.session);
    $("hint").hidden = !this.source.can.has("tool");
    $("status").textContent = "";
  }

  #take(state) {
    const isFirst = !this.state;
    this.state = state;
    this.scene.take(state);
    this.charts.add(state.trail);
    if (state.trail.length) this.depthM = state.trail[state.trail.length - 1].depthM;
    this.timeline?.show(state);
    if (state.session?.isAtEnd && !this.isPaused) this.#pause(true);
    if (isFirst) this.firstStateMs = performance.now();
  }

  /** The first tool, with how far it reaches. */
  #tool() {
    const tool = this.state?.tools[0];
    if (!tool || !this.source.can.has("tool")) return null;
    const reach = Math.min(reachM(partsOf(tool.kind)), this.scene.size / 3);
    return { ...tool, reachM: reach };
  }

  /** The surface's normal at rest where the tool is nearest; it stays while the tool touches. */
  #normal() {
    const [tool] = this.state.tools;
    if (tool.contacts === 0 || !this.normal) this.normal = nearestAtRest(this.body, tool.positionM).normal;
    return this.normal;
  }

  #listen() {
    this.hand = new Hand($("stage"), this.camera, {
      tool: () => this.#tool(), size: () => this.scene.size, normal: () => this.#normal(),
      move: (pose) => this.source.tool(pose), touched: () => ($("hint").hidden = true),
    });
    $("colour").onchange = () => this.scene.setLook({ colour: $("colour").value });
    for (const id of ["wires", "links", "fixed"]) $(id).onchange = () => this.scene.setLook({ [id]: $(id).checked });
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
    const verbs = { " ": () => this.#pause(!this.isPaused), ".": () => $("step").click(), r: () => this.#reset() };
    if (verbs[event.key]) verbs[event.key]();
    else if (!this.hand.key(event.key)) return;
    event.preventDefault();
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
    $("replay").hidden = true;
    this.charts.clear();
    this.source.reset();
  }

  #change(settings) {
    $("hint").hidden = true;
    $("replay").hidden = true;
    $("status").textContent = "";
    this.source.settings(settings);
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
    keep(`${this.fileName()}.csv`, pathText(poses), "text/csv");
    const isWhole = 8 * ticks === poses.length;
    const end = isWhole ? `   # ${ticks} ticks, state hash ${hash}` : "   # the first ten minutes";
    $("command").textContent = commandOf(this.fileName(), this.source.setup, this.body.info.sweepsMax) + end;
    $("replay").hidden = false;
    $("replay").scrollIntoView({ block: "nearest" });
  }

  #frame() {
    requestAnimationFrame(() => this.#frame());
    if (this.held) this.hand.hold(this.held);
    const isDrawn = this.scene.draw();
    this.charts.draw();
    if (!isDrawn) return;
    if (this.state !== this.shown) this.panel.show(this.state, this.depthM);
    this.shown = this.state;
    this.panel.legend(this.scene.look.colour, this.scene.scale.end);
    this.#showLabel();
    this.frames = (this.frames ?? 0) + 1;
  }

  /** The force beside its arrow. */
  #showLabel() {
    const tip = this.scene.forceTip();
    $("label").hidden = !tip;
    if (!tip) return;
    $("label").textContent = `${tip.forceN.toFixed(2)} N`;
    const x = Math.min(Math.max(tip.x + 10, 4), this.camera.width - 72);
    const y = Math.min(Math.max(tip.y - 24, 4), this.camera.height - 30);
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
