// Starts the view. Whatever this browser lacks, the page says so in a line and shows what is left.

async function startLinkwright(root) {
  const page = new Page(root);
  page.tell("Loading …");
  const fail = (words) => {
    root.dataset.state = "still";
    page.tell(words);
    return null;
  };
  if (typeof DecompressionStream === "undefined") {
    return fail("This browser is too old for the view in 3D: it has no DecompressionStream.");
  }
  const context = page.canvas.getContext("webgl2", { alpha: true, antialias: true });
  if (!context) return fail("The view in 3D needs WebGL 2, which this browser does not offer or has switched off.");
  const pack = await Pack.read();
  await loadThree();
  root.dataset.state = "live";
  const view = new View(pack, context, page);
  page.connect(view);
  new Pointer(view);
  page.tell("Paused");
  view.draw();
  await new Promise((painted) => setTimeout(painted, 0));
  await startEngine(view, page);
  return view;
}

async function startEngine(view, page) {
  const { header } = view.pack;
  const without = (reason) => {
    page.root.dataset.engine = "none";
    page.tell(`${reason} The sliders pose the robot.`);
  };
  if (!header.engine) return without(`No simulation: ${header.no_engine || "there is no model for it"}.`);
  if (page.root.dataset.engine === "none") return page.tell("The sliders pose the robot.");
  const pieces = enginePieces();
  if (!pieces) return without(`The engine of this page is missing: ${page.root.dataset.shared} is not beside it.`);
  if (typeof WebAssembly === "undefined") return without("No simulation: WebAssembly is switched off in this browser.");
  try {
    page.tell("Loading MuJoCo …");
    view.engine = await Engine.start(view.pack, pieces);
  } catch (error) {
    return without(`No simulation: MuJoCo ${page.version} could not load the model (${error.message}).`);
  }
  page.root.dataset.engine = "ready";
  begin(view, page);
}

// Begins to simulate, unless the visitor wants no motion or the robot would only fall.
function begin(view, page) {
  const { joints, actuators } = view.pack.header;
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) view.pause("Ready: paused, as this device asks for less motion");
  else if (joints.some(({ type }) => type !== "free") && actuators.length === 0) {
    view.pause("Ready: paused, as nothing drives the joints and the robot would fall");
  } else view.run();
}

// For tests and for the console: `await linkwright.ready`, then
//   matrix(body)    the pose of a body as it is drawn, 16 numbers, column by column
//   pose(name, value, ...)   moves a joint [rad, m], as its slider does
//   kinematics(qpos)   xpos and xquat of all bodies at these joint values
//   open()          how far relations and loops are open [m, rad]
//   step(seconds)   simulates so long, whatever the clock says
//   info()          state, draw calls, triangles; of the last frame the script's time and the engine's share [ms]
function hookOf(view) {
  const { header } = view.pack;
  return {
    view,
    header,
    matrix: (body) => Array.from(view.robot.bones[body].matrixWorld.elements),
    qpos: () => Array.from(view.qpos),
    pose(name, ...value) {
      view.pose(header.joints.find((joint) => joint.name === name), value);
      view.update();
      return Array.from(view.qpos);
    },
    kinematics(qpos) {
      const one = new Kinematics(header);
      one.qpos.set(qpos);
      one.update();
      return { xpos: Array.from(one.xpos), xquat: Array.from(one.xquat) };
    },
    open() {
      const { closing, kinematics } = view;
      kinematics.qpos.set(view.qpos);
      kinematics.update();
      return closing.measure(closing.residual);
    },
    step(seconds) {
      if (view.posedSince) view.intoEngine();
      for (let i = 0; i < Math.round(seconds / view.engine.timestep); i++) view.engine.step();
      view.engine.look();
      return Array.from(view.engine.views.qpos);
    },
    info: () => ({
      running: view.running, engine: Boolean(view.engine), calls: view.stage.renderer.info.render.calls,
      triangles: view.stage.renderer.info.render.triangles, scriptTime: view.scriptTime, stepTime: view.stepTime,
    }),
  };
}

const liveRoot = document.getElementById("live");
globalThis.linkwright = {
  ready: startLinkwright(liveRoot)
    .then((view) => view && Object.assign(globalThis.linkwright, hookOf(view)))
    .catch((error) => {
      liveRoot.dataset.state = "still";
      liveRoot.querySelector(".live-word").textContent = `The view could not start: ${error.message}`;
    })
    .then(() => true),
};

// The licences, inflated when somebody opens them.
for (const fold of document.querySelectorAll("details[data-licences]")) {
  fold.addEventListener("toggle", async () => {
    const shown = fold.querySelector("pre");
    if (!fold.open || shown.textContent) return;
    const own = fold.querySelector("script").textContent.trim();
    const all = [own, ...(globalThis.linkwrightEngine?.licences ?? [])].join(" ").split(/\s+/);
    shown.textContent = (await Promise.all(all.map(inflatedText))).join("\n\n");
  });
}
