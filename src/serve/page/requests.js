// Questions to the server that are answered by one message with the same id.

export class Requests {
  constructor(send) {
    this.send = send;
    this.waiting = new Map();
    this.next = 1;
  }

  newId() {
    return this.next++;
  }

  /** Resolves with the answer; rejects when the connection is lost or the asker gives up. */
  ask(message, signal) {
    const id = message.id ?? this.newId();
    return new Promise((resolve, reject) => {
      if (signal?.aborted) return reject(new Error('cancelled'));
      const settle = (end) => (value) => {
        this.waiting.delete(id);
        signal?.removeEventListener('abort', onAbort);
        end(value);
      };
      const onAbort = () => this.waiting.get(id)?.reject(new Error('cancelled'));
      this.waiting.set(id, { resolve: settle(resolve), reject: settle(reject) });
      signal?.addEventListener('abort', onAbort);
      if (!this.send({ ...message, id })) this.waiting.get(id).reject(new Error('there is no connection'));
      return undefined;
    });
  }

  /** True when somebody waited for it. */
  answer(id, value) {
    const asker = this.waiting.get(id);
    asker?.resolve(value);
    return asker !== undefined;
  }
  fail(id, message) {
    const asker = this.waiting.get(id);
    asker?.reject(new Error(message));
    return asker !== undefined;
  }
  failAll(message) {
    for (const { reject } of [...this.waiting.values()]) reject(new Error(message));
  }
}
