// Writes a ZIP archive whose members are stored, not compressed (PNGs already are).

const table = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let bit = 0; bit < 8; ++bit) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

export function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = table[(crc ^ byte) & 255] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

/** Little-endian numbers: pairs of size in bytes and value. */
function packed(...fields) {
  const view = new DataView(new ArrayBuffer(fields.reduce((total, [size]) => total + size, 0)));
  let at = 0;
  for (const [size, value] of fields) {
    if (size === 2) view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += size;
  }
  return new Uint8Array(view.buffer);
}

/** Date and time as MS-DOS wrote them, two seconds apart. */
const dosTime = (date) => (date.getHours() << 11) | (date.getMinutes() << 5) | (date.getSeconds() >> 1);
const dosDate = (date) => ((date.getFullYear() - 1980) << 9) | ((date.getMonth() + 1) << 5) | date.getDate();

export const mostMembers = 65535;  // without ZIP64
export const mostBytes = 0xffffffff;  // without ZIP64

/** `members`: [{name, bytes}], mostMembers at most. Throws when the archive would be too large for the plain format. */
export function zip(members, date = new Date()) {
  const parts = [], directory = [];
  let offset = 0;
  for (const { name, bytes } of members) {
    const text = new TextEncoder().encode(name);
    const utf8Names = 1 << 11, stored = 0, version = 20;
    const common = [[2, version], [2, utf8Names], [2, stored], [2, dosTime(date)], [2, dosDate(date)],
                    [4, crc32(bytes)], [4, bytes.length], [4, bytes.length], [2, text.length], [2, 0]];
    parts.push(packed([4, 0x04034b50], ...common), text, bytes);
    directory.push(packed([4, 0x02014b50], [2, version], ...common, [2, 0], [2, 0], [2, 0], [4, 0], [4, offset]), text);
    offset += 30 + text.length + bytes.length;
    if (offset > mostBytes) throw new Error('a ZIP holds at most 4 GiB');
  }
  const size = directory.reduce((total, part) => total + part.length, 0);
  const end = packed([4, 0x06054b50], [2, 0], [2, 0], [2, members.length], [2, members.length], [4, size],
                     [4, offset], [2, 0]);
  return new Blob([...parts, ...directory, end], { type: 'application/zip' });
}
