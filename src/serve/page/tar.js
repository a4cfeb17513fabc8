// Writes a TAR archive (POSIX 1003.1-1988, ustar).

const block = 512;
export const mostMembers = 65535;  // which the page holds in memory

/** Of a longer name the archive has the last 100 bytes. */
function header(name, size, seconds) {
  const head = new Uint8Array(block), put = (at, bytes) => head.set(bytes, at);
  const text = (words) => new TextEncoder().encode(words), octal = (number, digits) => number.toString(8).padStart(digits, '0');
  put(0, text(name).slice(-100));
  put(100, text(`0000644\0${'0000000\0'.repeat(2)}${octal(size, 11)}\0${octal(seconds, 11)}\0${' '.repeat(8)}0`));
  put(257, text('ustar\x0000'));
  put(148, text(`${octal(head.reduce((sum, byte) => sum + byte), 6)}\0`));
  return head;
}

/** `members`: [{name, bytes}], each below 8 GiB. */
export function tar(members, seconds = Math.floor(Date.now() / 1000)) {
  const parts = members.flatMap(({ name, bytes }) =>
    [header(name, bytes.length, seconds), bytes, new Uint8Array(-bytes.length & (block - 1))]);
  return new Blob([...parts, new Uint8Array(2 * block)], { type: 'application/x-tar' });
}
