// Sends requests to the worker and returns its answers.

/** An error that the library reported. */
export class Refused extends Error {}

/** The error of a request whose worker stopped before it answered. `onstop` has already told the page. */
export class Stopped extends Error {}

/** A request that takes longer than this should be noticed, milliseconds. Attempts of a design are seen anyway. */
const LONG = 400;

export class Client {
  #worker = null;
  #waiting = new Map();
  #next = 0;
  /** Whether the worker has loaded the library. */
  #loaded = false;

  /**
   * @param listeners are called
   *   - `onstop` with a message if a panic or a lack of memory stops the worker,
   *   - `onmissing` with a message if the library cannot be loaded,
   *   - `onload` with the fraction of the library that is loaded, 1 at the end,
   *   - `onwait` with whether a request takes long.
   */
  constructor(listeners = {}) {
    const none = () => {};
    Object.assign(this, { onstop: none, onmissing: none, onload: none, onwait: none }, listeners);
    this.start();
  }

  /** Milliseconds since the worker began its current request; 0 if it is idle or still loading. */
  get busyFor() {
    const [first] = this.#waiting.values();
    return first && this.#loaded ? performance.now() - first.since : 0;
  }

  /** Starts a new worker. The work of the old worker is lost. */
  start(script = "worker.js") {
    this.#end("the worker was restarted");
    this.#loaded = false;
    this.#worker = new Worker(new URL(script, import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }) => {
      if (data.missing !== undefined) this.#miss(data.missing);
      else if (data.loaded !== undefined) this.#load(data.loaded);
      else this.#answer(data);
    };
    this.#worker.onerror = ({ message }) => this.#loaded ? this.#stop(message) : this.#miss(message || "the worker cannot be loaded");
  }

  /** Ends the worker for good. */
  end() {
    this.#end("the worker was ended");
  }

  /** Sends a request. The promise resolves to the answer. */
  ask(request) {
    return new Promise((resolve, reject) => {
      if (!this.#worker) return reject(new Stopped("the worker has stopped"));
      const now = performance.now();
      this.#waiting.set(++this.#next, { resolve, reject, since: now, asked: request.do === "iterate" ? Infinity : now });
      if (request.do !== "iterate") setTimeout(() => this.#tellWaiting(), LONG);
      this.#worker.postMessage([this.#next, request]);
    });
  }

  #tellWaiting() {
    const takesLong = ({ asked }) => performance.now() - asked >= LONG;
    this.onwait(this.#loaded && [...this.#waiting.values()].some(takesLong));
  }

  #load(share) {
    this.#loaded = share === 1;
    this.#begun();
    this.onload(share);
  }

  /** Notes that the worker now begins its oldest request. */
  #begun() {
    for (const request of this.#waiting.values()) request.since = performance.now();
  }

  #answer({ number, ok, error, stopped }) {
    const asked = this.#waiting.get(number);
    this.#waiting.delete(number);
    this.#begun();
    this.#tellWaiting();
    if (stopped) {
      asked.reject(new Stopped(error));
      this.#stop(error);
    } else if (error !== undefined) {
      asked.reject(new Refused(error));
    } else {
      asked.resolve(ok);
    }
  }

  #stop(message) {
    this.#end(message);
    this.onstop(message);
  }

  #miss(message) {
    this.#end(message);
    this.onmissing(message);
  }

  #end(message) {
    this.#worker?.terminate();
    this.#worker = null;
    for (const { reject } of this.#waiting.values()) reject(new Stopped(message));
    this.#waiting.clear();
    this.#tellWaiting();
  }
}
