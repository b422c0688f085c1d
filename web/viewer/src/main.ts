/** The page that `meshfront view` serves: models side by side, a front of each, one budget, one panel. */

import { readAddress } from "./address.js";
import { type Meshfront, start } from "./app.js";
import { element } from "./dom.js";
import { makeFailure } from "./failure.js";
import { Settings } from "./settings.js";
import { makeStage, type Stage } from "./stage.js";
import { setLanguage } from "./texts/index.js";
import { followTheme } from "./theme.js";

declare global {
  interface Window { meshfront: Meshfront }
}

const address = readAddress(location.search, navigator.languages);
const settings = new Settings(address.values);
settings.follow("language", setLanguage);

let stage: Stage | undefined;
try {
  stage = makeStage(element<HTMLCanvasElement>("picture"));
} catch {
  element("picture").hidden = true;
  followTheme(settings, () => {});
  element("loading").hidden = true;
  makeFailure().show((t) => t.failures.noWebgl, { reload: true });
}
if (stage) window.meshfront = start(stage, settings, address);
