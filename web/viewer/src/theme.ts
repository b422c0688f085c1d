/** Light, dark or high contrast: as the person chose, or else as the system says. */

import type { Settings } from "./settings.js";

/** Calls `use` now, and whenever it changes, with whether the page is dark. */
export function followTheme(settings: Settings, use: (isDark: boolean) => void): void {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const contrast = matchMedia("(prefers-contrast: more)");
  const apply = () => {
    const { theme } = settings.now;
    const shown = theme !== "auto" ? theme : contrast.matches ? "contrast" : dark.matches ? "dark" : "light";
    document.documentElement.dataset.theme = shown;
    use(shown !== "light");
  };
  for (const query of [dark, contrast]) query.addEventListener("change", apply);
  settings.follow("theme", apply);
}
