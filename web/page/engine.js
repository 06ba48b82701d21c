// The library in WebAssembly: requests and answers as JSON, with an array of numbers beside an answer.

/** An error that the library gave in words; it goes on. Any other exception of `ask` ends it. */
export class Refusal extends Error {}

export class Engine {
  #exports;

  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.#exports = new WebAssembly.Instance(module, {}).exports;
  }

  /** Carries out a request: the answer's value, and a copy of its numbers. */
  ask(request) {
    const { memory, input, ask, answer, length, numbers, count } = this.#exports;
    const bytes = new TextEncoder().encode(JSON.stringify(request));
    const at = input(bytes.length);
    new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
    const text = () => new TextDecoder().decode(new Uint8Array(memory.buffer, answer(), length()));
    try {
      ask();
    } catch (trap) {
      // A panic left its message; a lack of memory or of stack leaves none.
      throw new Error(text() || `the computation stopped: ${trap.message}`);
    }
    const { ok, error } = JSON.parse(text());
    if (error !== undefined) throw new Refusal(error);
    return { ok, numbers: new Float32Array(memory.buffer, numbers(), count()).slice() };
  }
}
