// The WebSocket to the server: messages both ways, questions, and coming back after it was lost.

const headBytes = 48;
export const kinds = { picture: 0, snapshot: 1, movie: 2 };
const types = ['image/jpeg', 'image/png', 'image/x-exr', 'video/mp4'];  // of files, by format
const firstWait = 250, longestWait = 8000;  // milliseconds before the next attempt

/** The head of a binary message and the file that follows it. */
function readBinary(buffer) {
  const view = new DataView(buffer), type = types[view.getUint8(23)];
  return {
    kind: view.getUint32(4, true), number: view.getUint32(8, true), seq: view.getUint32(12, true),
    width: view.getUint16(16, true), height: view.getUint16(18, true), level: view.getUint8(20),
    levels: view.getUint8(21), atRest: view.getUint8(22) === 1, seconds: view.getFloat32(24, true),
    rate: view.getFloat32(28, true), time: view.getFloat64(32, true), error: view.getFloat32(40, true),
    pictures: view.getUint32(44, true),
    blob: new Blob([new Uint8Array(buffer, headBytes)], { type }),
  };
}

/** Whether the server says so; a WebSocket that it refuses looks like one that nobody answers. */
async function isWrong(token) {
  try {
    const headers = { 'Ringsplat-Token': token };
    return (await fetch(new URL('token', document.baseURI), { headers, cache: 'no-store' })).status === 403;
  } catch {
    return false;
  }
}

/**
 * Calls handlers.message(json), handlers.binary(head) and handlers.status('connecting' | 'open' | 'lost' |
 * 'ended' | 'refused'). `token` is asked for at each attempt; without the right one there are no more.
 */
export class Connection {
  constructor(token, handlers) {
    this.token = token;
    this.handlers = handlers;
    this.wait = firstWait;
    this.status = 'connecting';
    this.socket = null;
    this.timer = 0;
    this.waiting = new Map();  // by id
    this.nextId = 1;
  }

  open() {
    clearTimeout(this.timer);
    this.become('connecting');
    if (!this.token()) return void this.become('refused');
    const address = new URL('ws', document.baseURI);  // relative: works behind a path prefix
    address.protocol = address.protocol === 'https:' ? 'wss:' : 'ws:';
    address.hash = '';
    const socket = this.socket = new WebSocket(address, ['ringsplat.v1', 'token.' + this.token()]);
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({ data }) => {
      if (socket === this.socket) this.take(data);
    };
    socket.onclose = async () => {
      if (this.status === 'connecting' && (await isWrong(this.token())) && socket === this.socket) this.become('refused');
      else if (socket === this.socket && this.status !== 'ended') {
        this.become('lost');
        this.timer = setTimeout(() => this.open(), this.wait * (0.75 + 0.5 * Math.random()));
        this.wait = Math.min(2 * this.wait, longestWait);
      }
    };
  }

  /** Drops the connection and makes a new one at once, as when a new token came. */
  reopen() {
    this.wait = firstWait;
    const old = this.socket;
    this.open();
    old?.close();
  }

  /** Leaves without coming back by itself. */
  close() {
    clearTimeout(this.timer);
    const old = this.socket;
    this.socket = null;
    this.become('lost');
    old?.close(1000);
  }

  take(data) {
    if (typeof data !== 'string') return void this.handlers.binary(readBinary(data));
    const message = JSON.parse(data);
    if (message.type === 'hello') {
      this.wait = firstWait;
      this.become('open');
    }
    if (message.type === 'end') this.become('ended');
    this.handlers.message(message);
  }

  become(status) {
    if (this.status === status) return;
    this.status = status;
    this.handlers.status(status);
  }

  /** False when there is nobody to send to. */
  send(message) {
    if (this.status !== 'open' || this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  // Questions to the server that are answered by one message with the same id.

  /** Resolves with the answer; rejects when the connection is lost or the asker gives up. */
  ask(message, signal) {
    const id = message.id ?? this.nextId++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      signal?.addEventListener('abort', () => this.fail(id, 'cancelled'));
      if (signal?.aborted) this.fail(id, 'cancelled');
      else if (!this.send({ ...message, id })) this.fail(id, 'there is no connection');
    });
  }

  answer(id, value) {
    this.waiting.get(id)?.resolve(value);
    this.waiting.delete(id);
  }
  /** True when somebody waited for it. */
  fail(id, message) {
    this.waiting.get(id)?.reject(new Error(message));
    return this.waiting.delete(id);
  }
  failAll(message) {
    for (const id of [...this.waiting.keys()]) this.fail(id, message);
  }
}
