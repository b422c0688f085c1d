/** The page in English. Its shape is what every language has to say: a text that is missing elsewhere does not compile. */

type Kind = "missing" | "network" | "refused" | "not-front" | "damaged" | "too-new" | "memory" | "engine" | "closed";
/** What the two ends of a legend say. */
type Ends = readonly [from: string, to: string];
/** Title, what happened, what to do: what stands between backticks is to be typed. */
export type Failed = readonly [title: string, what: string, remedy: string];

export const en = {
  language: "Language",
  pictureLabel: (name: string) => `Picture of ${name}. Arrow keys turn it; question mark lists all keys.`,
  hint: "Drag to turn · right drag to move · wheel to go nearer · ? for keys",
  flyHint: "Flying: W A S D or arrows to move · drag to look · wheel changes the speed · Esc ends",

  title: {
    size: (triangles: string, bytes: string) => `${triangles} triangles, ${bytes}`,
    loaded: (name: string, size: string) => `${name} is loaded: ${size}.`,
  },

  loading: {
    start: "Loading …",
    fetching: (name: string, done: string) => `Loading ${name} … ${done}`,
    building: (name: string, done: string) => `Building ${name} … ${done}`,
    /** By the program's own names. */
    phases: {
      send: "sending", wait: "waiting for another build", read: "reading", clean: "cleaning", survey: "looking at its shape",
      simplify: "simplifying", measure: "measuring errors", write: "writing",
    } as Record<string, string>,
  },

  tools: {
    name: "View",
    fit: "Show all",
    home: "First view",
    sides: "Look from",
    fly: "Fly",
    measure: "Measure",
    crosshair: "Crosshair",
    compare: "Compare with the original",
    shot: "Save the picture",
    link: "Copy a link to this view",
    tell: "Say from where one looks",
    keys: "Keys",
    open: "Open a file",
    theme: "Theme",
  },
  sides: { front: "Front", back: "Back", left: "Left", right: "Right", top: "Top", bottom: "Bottom" },

  panel: {
    name: "Front",
    digest: (triangles: string, error: string) => `${triangles} triangles · ${error}`,
    figures: "Figures",
    of: "Figures of",
    all: "All models",
    triangles: "Triangles",
    vertices: "Vertices",
    partOf: (part: string, whole: string) => `${part} of ${whole}`,
    error: "Error",
    errorAt: "Error at the pivot",
    updates: "Updates",
    evaluations: "Evaluations",
    engine: "Last frame",
    upload: "Upload",
    engineMemory: "Engine memory",
    gpuMemory: "Graphics memory",
    rate: "Frame rate",
    perSecond: (n: string) => `${n} per second`,
    still: "at rest",
    copy: "Copy as JSON",
    copied: "Copied.",
    notCopied: "The browser did not let the page copy. Here it is, to be copied by hand:",
    linkCopied: "A link to this view is copied.",
  },

  models: {
    name: "Models",
    visible: (name: string) => `Show ${name}`,
    line: (triangles: string, error: string) => `${triangles} triangles, ${error}`,
  },

  quality: {
    name: "Quality",
    tolerance: "Tolerance",
    triangles: "Triangle budget",
    bytes: "Memory budget",
    time: "Time per frame",
    none: "no limit",
    frustum: "Coarse outside the picture",
    orientation: "Coarse where it faces away",
    freeze: "Freeze front",
    frozen: "The front is frozen: it stays as it is while you look around. Lines show what it was made for.",
    thawed: "The front follows the view again.",
    trianglesBite: (error: string, asked: string) =>
      `The triangle budget is used up: the picture is within ${error} of the original instead of ${asked}.`,
    bytesBite: (error: string, asked: string) =>
      `The memory budget is used up: the picture is within ${error} of the original instead of ${asked}.`,
    memoryEnds: (error: string, asked: string) =>
      `The browser gives no more memory: the picture is within ${error} of the original instead of ${asked}.`,
  },

  look: {
    name: "Look",
    colorBy: "Colour by",
    colors: { none: "Material", error: "Error", level: "Level", age: "Age", cone: "Spread of normals" },
    legend: {
      error: (least: string, most: string): Ends => [least, most],
      level: (most: string): Ends => ["base mesh", `level ${most}`],
      age: (most: string): Ends => ["just now", `${most} frames ago`],
      cone: (): Ends => ["one direction", "all directions"],
    },
    surface: "Surface",
    surfaces: { lit: "Lit", matcap: "Matcap", flat: "Flat facets" },
    vertexColors: "Vertex colours",
    wireframe: "Wireframe",
    spheres: "Bounding spheres of the next updates",
    background: "Background",
    backgrounds: { studio: "Studio", white: "White", grey: "Grey", black: "Black", custom: "Own colour" },
  },

  compare: {
    name: "Comparison",
    on: "Compare with the original",
    most: "Triangles of the original, at most",
    handle: "Divider between the front and the original",
    front: "Front",
    original: (triangles: string) => `Original, ${triangles} triangles`,
    limited: (triangles: string, whole: string) => `Original, limited to ${triangles} of ${whole} triangles`,
    loading: "The original is loading …",
    failed: (why: string) => `The original cannot be shown: ${why}`,
    at: (percent: string) => `Front on the left ${percent}`,
  },

  navigation: {
    name: "Axes and units",
    up: "Up is",
    asInFile: "as the file says",
    unit: "One unit is",
    units: { none: "not said", mm: "a millimetre", cm: "a centimetre", m: "a metre", km: "a kilometre", in: "an inch", ft: "a foot" },
    orbiting: "Turning around the model.",
  },

  measure: {
    name: "Measure",
    on: "Measure distances",
    crosshair: "Crosshair in the middle",
    first: "Click the first point, or aim with the crosshair and press Enter.",
    second: "Now the second point.",
    none: "There is no surface at this point.",
    distance: "Distance",
    between: (distance: string, uncertainty: string) => `${distance} ± ${uncertainty}`,
    said: (distance: string, uncertainty: string) => `The distance is ${distance}, give or take ${uncertainty}.`,
    clear: "Clear",
    cleared: "Measurements are cleared.",
    position: "Position",
    normal: "Normal",
    error: "Error",
    update: "Update",
    finest: "as in the original",
    level: (n: string) => `level ${n}`,
  },

  tell: {
    from: {
      front: "the front", frontRight: "the front right", right: "the right", backRight: "the back right",
      back: "the back", backLeft: "the back left", left: "the left", frontLeft: "the front left",
    },
    height: { level: "", above: " and a little above", highAbove: " and high above", below: " and a little below", farBelow: " and far below" },
    straight: { top: "straight above", bottom: "straight below" },
    seen: (from: string) => `Seen from ${from}`,
    fills: (part: string) => `, filling ${part} of the picture.`,
    parts: {
      speck: "a speck", tenth: "a tenth", quarter: "a quarter", third: "a third", half: "half", twoThirds: "two thirds",
      threeQuarters: "three quarters", all: "all",
    },
    close: (times: string) => `, so near that all of it would be ${times} times as large as the picture.`,
    outside: ". The model is outside the picture.",
  },

  page: {
    name: "Page",
    themes: { auto: "as the system", light: "Light", dark: "Dark", contrast: "High contrast" },
  },

  drop: {
    here: "Drop a file here to open it",
    what: "A .front file, a mesh (PLY, OBJ, STL, OFF, GLB) or heights (GeoTIFF, DEM, ASC)",
    frontOnly: "A .front file",
    unknown: (name: string) => `${name} is no file that this page can open.`,
    unknownRemedy: "Drop a .front file, a mesh as PLY, OBJ, STL, OFF or GLB, or heights as GeoTIFF, DEM or ASC.",
    noBuild: (name: string) => `${name} is a mesh, and this server cannot build hierarchies.`,
    noBuildRemedy: "Run `meshfront view` on your machine and drop it there, or build a .front file with `meshfront build` and drop that.",
    notOpened: "The file was not opened",
    notBuilt: "The mesh could not be built",
    broken: "The connection to the local program broke off.",
    brokenRemedy: "Check that `meshfront view` is still running, then drop the file again.",
  },

  failures: {
    retry: "Try again",
    close: "Close",
    reload: "Reload the page",
    kinds: {
      missing: ["There is no such file", "Check the address, or build the file with `meshfront build`."],
      network: ["The file did not arrive", "Check that the server is still running, then try again."],
      refused: ["The server would not send the file", "Check what the server's log says of this file."],
      "not-front": ["This is not a .front file", "Build a .front file from the mesh with `meshfront build`, and open that."],
      damaged: ["The file is damaged", "Copy or download the file again, or rebuild it from its source with `meshfront build`."],
      "too-new": ["The file is too new", "Update Meshfront, or rebuild the file with this version."],
      memory: ["The model needs more memory than the browser gives", "Close other tabs, or build a smaller file with `meshfront build`, then try again."],
      engine: ["The engine stopped", "Reload the page; if that does not help, try a browser with WebAssembly and more memory."],
      closed: ["The model was closed", ""],
    } as Record<Kind, readonly [title: string, remedy: string]>,
    noWebgl: [
      "This browser cannot draw in three dimensions",
      "WebGL 2 is missing or switched off.",
      "Switch on hardware acceleration in the browser's settings, update the graphics driver, or try another browser.",
    ] as Failed,
    lost: [
      "The graphics card was reset",
      "The picture is lost for the moment; the model is still here.",
      "It usually comes back by itself in a few seconds. If not, reload the page: the address keeps the view.",
    ] as Failed,
    restored: "The picture is back.",
  },

  keys: {
    title: "Keys",
    where: "They work while the picture has the focus (Tab leads there).",
    close: "Close",
    list: [
      ["Arrows", "turn"],
      ["Shift + arrows", "move"],
      ["+ −", "nearer, farther"],
      ["F", "show all"],
      ["H", "first view"],
      ["1 – 6", "front, back, left, right, top, bottom"],
      ["G", "fly: W A S D or arrows move, Q E down and up, Shift + arrows look, + − speed; Esc ends"],
      ["X", "crosshair: what is in the middle of the picture"],
      ["M", "measure; Enter sets a point at the crosshair, Backspace clears"],
      ["C", "compare with the original; the divider takes arrow keys"],
      ["Z", "freeze the front"],
      ["P", "save the picture"],
      ["L", "copy a link to this view"],
      ["T", "say from where one looks"],
      ["O", "open a file"],
      ["?", "this list"],
    ] as readonly (readonly [string, string])[],
  },
};

/** What every language says. */
export type Texts = typeof en;
