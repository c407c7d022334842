// Drives a headless Chromium over its pipe: no library, no port.
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

/** Without a GPU, without anything that asks a network. */
const FLAGS = [
  "--headless", "--no-sandbox", "--remote-debugging-pipe", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
  "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
  "--disable-default-apps", "--disable-dev-shm-usage", "--hide-scrollbars",
];
/** Longest wait for anything: two busy cores are slow [ms]. */
const LIMIT_MS = 120_000;

export class Browser {
  static async start({ width = 1280, height = 800, chromium = "chromium", isPhone = false, scheme = "light", scale = 1 } = {}) {
    const browser = new Browser();
    browser.folder = mkdtempSync(join(tmpdir(), "chaincell-view-"));
    browser.process = spawn(chromium, [...FLAGS, `--user-data-dir=${browser.folder}`, `--window-size=${width},${height}`, "about:blank"], {
      stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"],
    });
    browser.ended = new Promise((end) => browser.process.once("exit", end));
    browser.#listen();
    const { targetInfos } = await browser.send("Target.getTargets");
    const { targetId } = targetInfos.find(({ type }) => type === "page");
    ({ sessionId: browser.session } = await browser.send("Target.attachToTarget", { targetId, flatten: true }));
    for (const domain of ["Page", "Runtime", "Log"]) await browser.page(`${domain}.enable`);
    browser.downloads = join(browser.folder, "downloads");
    mkdirSync(browser.downloads);
    await browser.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: browser.downloads });
    await browser.page("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: scale, mobile: isPhone });
    if (isPhone) await browser.page("Emulation.setTouchEmulationEnabled", { enabled: true });
    await browser.page("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
    return browser;
  }

  constructor() {
    this.next = 1;
    this.waiting = new Map();
    /** What the page's console said, errors that nobody caught, and what the policy refused. */
    this.console = [];
  }

  #listen() {
    let text = "";
    this.process.stdio[4].setEncoding("utf8").on("data", (piece) => {
      text += piece;
      for (let end = text.indexOf("\0"); end >= 0; end = text.indexOf("\0")) {
        this.#heard(JSON.parse(text.slice(0, end)));
        text = text.slice(end + 1);
      }
    });
  }

  #heard({ id, result, error, method, params }) {
    const waiting = this.waiting.get(id);
    this.waiting.delete(id);
    if (waiting) error ? waiting.fail(new Error(error.message)) : waiting.give(result);
    if (method === "Runtime.consoleAPICalled") this.console.push(params.args.map((one) => one.value ?? one.description).join(" "));
    if (method === "Runtime.exceptionThrown") this.console.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    if (method === "Log.entryAdded") this.console.push(params.entry.text);
  }

  send(method, params = {}, sessionId) {
    const id = this.next++;
    this.process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    return new Promise((give, fail) => {
      this.waiting.set(id, { give, fail });
      this.ended.then(() => fail(new Error(`the browser ended before ${method}`)));
    });
  }

  page(method, params) {
    return this.send(method, params, this.session);
  }

  goto(url) {
    return this.page("Page.navigate", { url });
  }

  /** Returns what an expression of the page comes to. */
  async evaluate(expression) {
    const { result, exceptionDetails } = await this.page("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  /** Waits until an expression is true, with a generous limit. */
  async until(expression, limitMs = LIMIT_MS) {
    const end = Date.now() + limitMs;
    while (!(await this.evaluate(expression))) {
      if (Date.now() > end) throw new Error(`not within ${limitMs / 1000} s: ${expression}\nconsole: ${this.console.join("\n")}`);
      await new Promise((go) => setTimeout(go, 30));
    }
  }

  mouse(type, x, y, more = {}) {
    return this.page("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons: type === "mouseReleased" ? 0 : 1, clickCount: 1, ...more });
  }

  move(x, y) {
    return this.page("Input.dispatchMouseEvent", { type: "mouseMoved", x, y });
  }

  wheel(x, y, deltaY) {
    return this.page("Input.dispatchMouseEvent", { type: "mouseWheel", x, y, deltaX: 0, deltaY });
  }

  touch(type, points) {
    return this.page("Input.dispatchTouchEvent", { type, touchPoints: points });
  }

  async key(key, code = key) {
    await this.page("Input.dispatchKeyEvent", { type: "keyDown", key, code });
    await this.page("Input.dispatchKeyEvent", { type: "keyUp", key, code });
  }

  /** Clicks in the middle of an element. */
  async click(id) {
    const [x, y] = await this.evaluate(`(() => { const e = document.getElementById("${id}"); e.scrollIntoView({ block: "nearest" });
      const { left, top, width, height } = e.getBoundingClientRect(); return [left + width / 2, top + height / 2]; })()`);
    await this.mouse("mousePressed", x, y);
    await this.mouse("mouseReleased", x, y);
  }

  /** Returns a picture of the page as PNG, and writes it to a file. */
  async picture(file) {
    const { data } = await this.page("Page.captureScreenshot", { format: "png" });
    const png = Buffer.from(data, "base64");
    if (file) writeFileSync(file, png);
    return png;
  }

  /** Waits for a download with that end of its name and returns its bytes. */
  async downloaded(end) {
    const limit = Date.now() + LIMIT_MS;
    for (;;) {
      const found = readdirSync(this.downloads).find((name) => name.endsWith(end));
      if (found) return readFileSync(join(this.downloads, found));
      if (Date.now() > limit) throw new Error(`no download ${end}`);
      await new Promise((go) => setTimeout(go, 50));
    }
  }

  /** Processor seconds of all processes of the browser so far. */
  async processorS() {
    const { processInfo } = await this.send("SystemInfo.getProcessInfo");
    return processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0);
  }

  async stop() {
    this.send("Browser.close").catch(() => {});
    const late = setTimeout(() => this.process.kill("SIGKILL"), 5000);
    await this.ended;
    clearTimeout(late);
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5, retryDelay: 200 });
  }
}
