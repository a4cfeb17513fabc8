// Undo and redo of the scene.

const kept = ['camera', 'transfer_function', 'clip', 'clip_planes', 'cut', 'light', 'mode', 'isovalue', 'materials', 'shading', 'background', 'channels',
  'tints', 'compare', 'difference'];
const mostSteps = 200;

const partOf = (state) => Object.fromEntries(kept.map((key) => [key, state[key]]));
const isSame = (a, b) => kept.every((key) => a[key] === b[key] || JSON.stringify(a[key]) === JSON.stringify(b[key]));

/** What goes on (a drag) is one step: `commit` it at its end. */
export class History {
  constructor() {
    this.clear(null);
  }
  clear(state) {
    this.past = [];
    this.future = [];
    this.present = state && partOf(state);
  }
  commit(state) {
    const now = partOf(state);
    if (this.present && isSame(now, this.present)) return;
    if (this.present) this.past.push(this.present);
    if (this.past.length > mostSteps) this.past.shift();
    this.present = now;
    this.future = [];
  }
  /** What changes by itself is no step. */
  replace({ camera, ...part }) {
    if (this.present) this.present = { ...this.present, ...part, camera: { ...this.present.camera, ...camera } };
  }
  /** Undoes a step, or does it again: the part of the scene to show; null where there is none. */
  step(again) {
    const [from, to] = again ? [this.future, this.past] : [this.past, this.future];
    if (!from.length) return null;
    to.push(this.present);
    return (this.present = from.pop());
  }
}
