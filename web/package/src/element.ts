// The element `<taffeta-cloth src="flag.toml">`.

import { init } from "./engine.js";
import { Simulation } from "./simulation.js";
import { Viewer } from "./viewer.js";

const STYLE = `
:host { display: block; position: relative; min-height: 12rem; aspect-ratio: 4 / 3; contain: content; color: inherit; font: 1rem system-ui, sans-serif; }
:host([hidden]) { display: none; }
canvas { display: block; width: 100%; height: 100%; touch-action: none; border-radius: inherit; outline-offset: -3px; cursor: grab; }
canvas:active { cursor: grabbing; }
canvas:focus-visible { outline: 3px solid #1a6fd4; }
p { position: absolute; inset: auto 0.5rem 0.5rem; margin: 0; padding: 0.5rem 0.75rem; border-radius: 0.4rem; background: #fff; color: #8a1020; white-space: pre-wrap; }
p:empty { display: none; }
button { position: absolute; inset: auto auto 0.75rem 0.75rem; padding: 0.5rem 1rem; border: 0; border-radius: 0.4rem; background: #14213d; color: #fff; font: inherit; cursor: pointer; }
button[hidden] { display: none; }`;

/** Without a DOM, as in node, the module loads all the same. */
const Base = (globalThis.HTMLElement ?? class {}) as typeof HTMLElement;

/**
 * A cloth on a page. Attributes: `src`, a scene in TOML; `set`, overrides, one a line; `paused`, it waits to be played.
 * Where the user wants less motion, it waits as well. Events: `ready`, `error`, whose `detail` is the `Error`.
 */
export class TaffetaCloth extends Base {
  static observedAttributes = ["src", "set"];
  #viewer: Viewer | undefined;
  #simulation: Simulation | undefined;
  #loading: AbortController | undefined;
  #seen: IntersectionObserver | undefined;

  /** The simulation, once it is there. */
  get simulation(): Simulation | undefined {
    return this.#simulation;
  }

  /** What shows it, once it is there. */
  get viewer(): Viewer | undefined {
    return this.#viewer;
  }

  connectedCallback(): void {
    const root = this.shadowRoot ?? this.attachShadow({ mode: "open" });
    root.innerHTML = `<style>${STYLE}</style><canvas tabindex="0" role="img"></canvas><button type="button" hidden>Play</button><p role="alert"></p>`;
    const canvas = root.querySelector("canvas")!;
    const button = root.querySelector("button")!;
    button.addEventListener("click", () => {
      this.#viewer?.play();
      canvas.focus();
    });
    try {
      this.#viewer = new Viewer(canvas, {
        error: (error) => this.#fail(error),
        playing: (isPlaying) => { button.hidden = isPlaying; },
      });
    } catch (error) {
      this.#fail(error);
      return;
    }
    this.#seen = new IntersectionObserver(([entry]) => {
      if (this.#viewer) this.#viewer.isSeen = entry?.isIntersecting ?? true;
    });
    this.#seen.observe(this);
    void this.#load();
  }

  disconnectedCallback(): void {
    this.#loading?.abort();
    this.#seen?.disconnect();
    this.#viewer?.dispose();
    this.#viewer = undefined;
    this.#simulation?.free();
    this.#simulation = undefined;
  }

  attributeChangedCallback(): void {
    if (this.isConnected && this.#viewer) void this.#load();
  }

  async #load(): Promise<void> {
    this.#loading?.abort();
    const loading = new AbortController();
    this.#loading = loading;
    const src = this.getAttribute("src");
    if (!src) return;
    try {
      await init();
      const set = (this.getAttribute("set") ?? "").split("\n").map((line) => line.trim()).filter((line) => line !== "");
      const simulation = await Simulation.load(src, { set, signal: loading.signal });
      const viewer = this.#viewer;
      if (loading.signal.aborted || !viewer) {
        simulation.free();
        return;
      }
      this.#show(simulation, viewer, src);
    } catch (error) {
      if (!loading.signal.aborted) this.#fail(error);
    }
  }

  #show(simulation: Simulation, viewer: Viewer, src: string): void {
    const old = this.#simulation;
    this.#simulation = simulation;
    viewer.show(simulation);
    old?.free();
    const canvas = this.shadowRoot!.querySelector("canvas")!;
    const names = simulation.bodies.map(({ name }) => name).join(", ");
    canvas.setAttribute("aria-label", this.getAttribute("aria-label") ?? `Simulation of ${names} (${src})`);
    this.#say("");
    const waits = this.hasAttribute("paused") || matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (waits) this.shadowRoot!.querySelector("button")!.hidden = false;
    else viewer.play();
    this.dispatchEvent(new CustomEvent("ready", { detail: simulation }));
  }

  #fail(error: unknown): void {
    this.#say(error instanceof Error ? error.message : String(error));
    this.dispatchEvent(new CustomEvent("error", { detail: error }));
  }

  #say(text: string): void {
    this.shadowRoot!.querySelector("p")!.textContent = text;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "taffeta-cloth": TaffetaCloth;
  }
}

if (globalThis.customElements && !customElements.get("taffeta-cloth")) {
  customElements.define("taffeta-cloth", TaffetaCloth);
}
