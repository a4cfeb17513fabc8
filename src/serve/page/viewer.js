// A first page: shows the volume and turns it by dragging.
const base = new URL(".", location.href);
base.protocol = base.protocol.replace("http", "ws");
const socket = new WebSocket(new URL("ws", base), ["ringsplat.v1", "token." + location.hash.slice(1)]);
socket.binaryType = "arraybuffer";
const picture = document.getElementById("picture"), line = document.getElementById("line");
let azimuth = 0, elevation = 0, seq = 0;
const ask = (moving) => socket.send(JSON.stringify({ type: "view", seq: ++seq, moving, width: 512, height: 512,
  time: performance.now(), state: { camera: { azimuth, elevation } } }));
socket.onopen = () => ask(false);
socket.onmessage = (event) => {
  if (typeof event.data === "string") return;
  const head = new DataView(event.data);
  URL.revokeObjectURL(picture.src);
  picture.src = URL.createObjectURL(new Blob([new Uint8Array(event.data, 48)], { type: "image/jpeg" }));
  line.textContent = `level ${head.getUint8(20)} of ${head.getUint8(21)}, ${(1e3 * head.getFloat32(24, true)).toFixed(1)} ms`;
  socket.send(JSON.stringify({ type: "ack", picture: head.getUint32(8, true) }));
};
picture.draggable = false;
picture.onpointermove = (event) => {
  if (!event.buttons) return;
  azimuth -= event.movementX / 2;
  elevation += event.movementY / 2;
  ask(true);
};
picture.onpointerup = () => ask(false);
