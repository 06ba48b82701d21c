// The library in WebAssembly. Requests and answers are JSON.

/** An error that the library reported. The library can still be used, unlike after any other exception of `ask`. */
export class Refusal extends Error {}

export class Engine {
  #exports;

  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.#exports = new WebAssembly.Instance(module, {}).exports;
  }

  /** The size of the library's memory. It never shrinks. */
  get bytes() {
    return this.#exports.memory.buffer.byteLength;
  }

  /** Carries out a request and returns the answer. */
  ask(request) {
    const { memory, input, ask, answer, length } = this.#exports;
    const bytes = new TextEncoder().encode(JSON.stringify(request));
    const at = input(bytes.length);
    new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
    const text = () => new TextDecoder().decode(new Uint8Array(memory.buffer, answer(), length()));
    try {
      ask();
    } catch (trap) {
      // A panic leaves its message; a lack of memory or of stack leaves none.
      throw new Error(text() || `the computation stopped: ${trap.message}`);
    }
    const { ok, error } = JSON.parse(text());
    if (error !== undefined) throw new Refusal(error);
    return ok;
  }

  /** Measures the finished robot until nothing is left to measure. Returns the last answer. */
  judge() {
    for (;;) {
      const answer = this.ask({ do: "judge" });
      if (answer.measured !== null) return answer;
    }
  }
}
