// Files that a person opens.

import { element } from './dom.js';

/** Asks for a text file; null when none was chosen. */
export function openText(accept) {
  return new Promise((resolve, reject) => {
    const input = element('input', { type: 'file', accept, class: 'unseen', 'aria-label': 'File' });
    const done = (result) => {
      input.remove();
      resolve(result);
    };
    input.addEventListener('change', async () => {
      const file = input.files[0];
      if (!file) return done(null);
      try {
        done({ name: file.name, text: await file.text() });
      } catch (error) {
        input.remove();
        reject(error);
      }
    });
    input.addEventListener('cancel', () => done(null));
    document.body.append(input);
    input.click();
  });
}

/** A file's name of what the volume is called: letters that every system takes. */
export const fileStem = (name) => (name.replace(/\.(nrrd|nhdr|mhd|mha|nii|nii\.gz|raw|vtk|tiff?)$/i, '')
  .replace(/[^\p{L}\p{N}._-]+/gu, '-').slice(0, 80) || 'volume');
