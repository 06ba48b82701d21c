// The page's end of the worker.

/** A refusal in the library's words. */
export class Refused extends Error {}

/** What a request ends with whose worker stopped; `onstop` has told the page by then. */
export class Stopped extends Error {}

export class Client {
  #worker = null;
  #waiting = new Map();
  #next = 0;

  /** @param onstop is called with a message when a panic, or a lack of memory, stops the worker. */
  constructor(onstop) {
    this.onstop = onstop;
    this.start();
  }

  /** Ends what there is and starts a new worker. */
  start() {
    this.#end("started anew");
    this.#worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }) => this.#answer(data);
    this.#worker.onerror = event => this.#stop(event.message || "the worker cannot be loaded");
  }

  /** Carries out a request: a promise of `{ok, numbers}`. */
  ask(request) {
    return new Promise((resolve, reject) => {
      if (!this.#worker) return reject(new Stopped("the worker has stopped"));
      this.#waiting.set(++this.#next, { resolve, reject });
      this.#worker.postMessage([this.#next, request]);
    });
  }

  #answer({ number, ok, numbers, error, stopped }) {
    const asked = this.#waiting.get(number);
    this.#waiting.delete(number);
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
