// The page's end of the worker.

/** A refusal in the library's words. */
export class Refused extends Error {}

/** What a request ends with whose worker stopped; `onstop` has told the page by then. */
export class Stopped extends Error {}

export class Client {
  #worker = null;
  #waiting = new Map();
  #next = 0;
  /** Whether the worker has loaded the library, and so can compute. */
  #loaded = false;

  /** @param onstop is called with a message when a panic, or a lack of memory, stops the worker. */
  constructor(onstop) {
    this.onstop = onstop;
    this.start();
  }

  /** Milliseconds since the worker began its current request; 0 if it is idle or still loading. */
  get busyFor() {
    const [first] = this.#waiting.values();
    return first && this.#loaded ? performance.now() - first.since : 0;
  }

  /** Replaces the worker by a new one. The work of the old worker is lost. */
  start() {
    this.#end("started anew");
    this.#loaded = false;
    this.#worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }) => data.loaded ? this.#load() : this.#answer(data);
    this.#worker.onerror = event => this.#stop(event.message || "the worker cannot be loaded");
  }

  /** Carries out a request: a promise of `{ok, numbers}`. */
  ask(request) {
    return new Promise((resolve, reject) => {
      if (!this.#worker) return reject(new Stopped("the worker has stopped"));
      this.#waiting.set(++this.#next, { resolve, reject, since: performance.now() });
      this.#worker.postMessage([this.#next, request]);
    });
  }

  #load() {
    this.#loaded = true;
    this.#begun();
  }

  /** Notes that the worker begins its oldest request now. */
  #begun() {
    for (const request of this.#waiting.values()) request.since = performance.now();
  }

  #answer({ number, ok, numbers, error, stopped }) {
    const asked = this.#waiting.get(number);
    this.#waiting.delete(number);
    this.#begun();
    if (stopped) {
      asked.reject(new Stopped(error));
      this.#stop(error);
    } else if (error !== undefined) {
      asked.reject(new Refused(error));
    } else {
      asked.resolve({ ok, numbers });
    }
  }

  #stop(message) {
    this.#end(message);
    this.onstop(message);
  }

  #end(message) {
    this.#worker?.terminate();
    this.#worker = null;
    for (const { reject } of this.#waiting.values()) reject(new Stopped(message));
    this.#waiting.clear();
  }
}
