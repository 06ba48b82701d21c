// Sends requests to the worker and returns its answers.

/** An error that the library reported. */
export class Refused extends Error {}

/** The error of a request whose worker stopped before it answered. `onstop` has already told the page. */
export class Stopped extends Error {}

export class Client {
  #worker = null;
  #waiting = new Map();
  #next = 0;
  /** Whether the worker has loaded the library. */
  #loaded = false;

  /**
   * @param onstop is called with a message if a panic or a lack of memory stops the worker.
   * @param onload is called with the fraction of the library that is loaded, 1 at the end.
   */
  constructor(onstop, onload = () => {}) {
    Object.assign(this, { onstop, onload });
    this.start();
  }

  /** Milliseconds since the worker began its current request; 0 if it is idle or still loading. */
  get busyFor() {
    const [first] = this.#waiting.values();
    return first && this.#loaded ? performance.now() - first.since : 0;
  }

  /** Starts a new worker. The work of the old worker is lost. */
  start() {
    this.#end("the worker was restarted");
    this.#loaded = false;
    this.#worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }) => data.loaded === undefined ? this.#answer(data) : this.#load(data.loaded);
    this.#worker.onerror = event => this.#stop(event.message || "the worker cannot be loaded");
  }

  /** Ends the worker for good. */
  end() {
    this.#end("the worker was ended");
  }

  /** Sends a request. The promise resolves to the answer. */
  ask(request) {
    return new Promise((resolve, reject) => {
      if (!this.#worker) return reject(new Stopped("the worker has stopped"));
      this.#waiting.set(++this.#next, { resolve, reject, since: performance.now() });
      this.#worker.postMessage([this.#next, request]);
    });
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

  #end(message) {
    this.#worker?.terminate();
    this.#worker = null;
    for (const { reject } of this.#waiting.values()) reject(new Stopped(message));
    this.#waiting.clear();
  }
}
