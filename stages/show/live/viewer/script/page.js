// The elements of the page that the view speaks through.

class Page {
  constructor(root) {
    this.root = root;
    this.canvas = root.querySelector("canvas");
    this.still = root.querySelector(".live-still");
    this.word = root.querySelector(".live-word");
    this.notes = root.querySelector(".live-notes");
    this.side = root.querySelector(".live-side");
    this.card = root.querySelector(".live-picked");
    this.runButton = root.querySelector(".live-toggle");
    this.keyframes = root.querySelector(".live-keyframe");
    this.rate = root.querySelector(".live-rate");
    this.links = root.querySelector(".live-links");
    this.version = root.dataset.version;
  }

  tell(text) {
    this.word.textContent = text;
  }

  note(text) {
    this.notes.append(make("li", { text }));
  }

  showRunning(running) {
    this.runButton.dataset.running = running;
    this.rate.hidden = true;
    this.runButton.querySelector("span").textContent = running ? "Pause" : "Run";
  }

  showRate(rate) {
    this.rate.hidden = rate > 0.9;
    this.rate.textContent = `at ${rate.toFixed(rate < 0.095 ? 2 : 1)} of real time`;
  }

  showLink(body) {
    this.links.value = body === null ? "" : this.firstBody(body);
    this.card.replaceChildren();
    if (body !== null) this.card.append(linkCard(this.view, body, () => this.view.pick(null)));
  }

  // Connects buttons and toggles with a view.
  connect(view) {
    this.view = view;
    this.panel = new Panel(view, this.side);
    this.runButton.addEventListener("click", () => view.toggle());
    this.root.querySelector(".live-reset").addEventListener("click", () => this.reset(view));
    this.root.querySelector(".live-look").addEventListener("click", () => (view.stage.home(), view.draw()));
    for (const box of this.root.querySelectorAll("[data-layer]")) {
      box.checked = view.layers[box.dataset.layer].visible;
      box.addEventListener("change", () => view.show(box.dataset.layer, box.checked));
    }
    this.connectLinks(view);
    this.connectKeyframes(view);
    this.connectWindow(view);
    this.tellHeader(view.pack.header);
  }

  reset(view) {
    this.keyframes.value = "0";
    view.reset();
  }

  // The links by their first bodies: what a click picks, for the keyboard.
  connectLinks(view) {
    const { bodies, links } = view.pack.header;
    bodies.forEach(({ name, link }, body) => {
      if (body === 0 || this.firstBody(body) !== body) return;
      this.links.append(make("option", { value: body, text: links[link]?.name ?? name }));
    });
    this.links.addEventListener("change", () => view.pick(this.links.value ? Number(this.links.value) : null));
  }

  firstBody(body) {
    const { bodies } = this.view.pack.header;
    const { link } = bodies[body];
    return link === null || link === undefined ? body : bodies.findIndex((one) => one.link === link);
  }

  connectKeyframes(view) {
    const { keyframes } = view.pack.header;
    keyframes.forEach(({ name }, index) => this.keyframes.append(make("option", { value: index, text: name })));
    this.keyframes.closest("label").hidden = keyframes.length < 2;
    this.keyframes.addEventListener("change", () => view.reset(keyframes[this.keyframes.value]));
  }

  connectWindow(view) {
    const seen = { page: !document.hidden, view: true };
    const wait = () => {
      view.waiting = !(seen.page && seen.view);
      view.last = null;
      view.draw();
    };
    document.addEventListener("visibilitychange", () => ((seen.page = !document.hidden), wait()));
    new IntersectionObserver(([entry]) => ((seen.view = entry.isIntersecting), wait())).observe(this.canvas);
    new ResizeObserver(() => (view.stage.resize(), view.draw())).observe(this.canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (view.stage.colour(), view.draw()));
    addEventListener("beforeprint", () => this.keepStill(view));
    this.canvas.addEventListener("webglcontextlost", () => view.pause("Paused: the browser has released the memory of the 3D view"));
    this.canvas.addEventListener("webglcontextrestored", () => view.pause());
  }

  // For paper: the view as it is now, in the place of what moves.
  keepStill(view) {
    view.update();
    view.stage.render();
    this.still.replaceChildren(make("img", { src: this.canvas.toDataURL(), alt: "The robot as shown" }));
  }

  tellHeader({ thinned, engine }) {
    if (thinned) {
      const [shown, all] = [thinned.faces, thinned.of_faces].map((count) => count.toLocaleString("en"));
      this.note(`Shown with ${shown} of its ${all} triangles, so that this page stays small; the files have all.`);
    }
    for (const { what, place, instead } of engine?.lacks ?? []) {
      this.note(`MuJoCo ${this.version} of this page lacks ${what} (${place})${instead ? `: ${instead}` : ""}.`);
    }
  }
}
