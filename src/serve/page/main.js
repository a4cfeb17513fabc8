// Starts the page; tests find it at window.app.

import { App } from './app.js';

window.app = new App();
