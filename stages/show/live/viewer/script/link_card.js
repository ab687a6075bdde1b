// What is known of the link that was clicked.

function linkCard(view, body, onClose) {
  const { bodies, links } = view.pack.header;
  const link = links[bodies[body].link] ?? { name: bodies[body].name, mass: bodies[body].mass, parts: [], colliders: [] };
  const close = make("button", { type: "button", class: "live-close", "aria-label": "Close", text: "×", onclick: onClose });
  const lines = [make("header", {}, [make("h3", { text: link.name }), close])];
  lines.push(make("p", { class: "live-mass", text: massText(link.mass) }));
  if (link.parts.length) lines.push(partsFold(link.parts));
  if (link.colliders.length) lines.push(collidersFold(link.colliders));
  return make("div", { class: "live-card" }, lines);
}

function partsFold(parts) {
  const rows = parts.map(({ name, mass }) =>
    make("li", {}, [make("span", { text: name }), make("span", { class: "live-soft", text: massText(mass) })]));
  const title = parts.length === 1 ? "1 CAD part" : `${parts.length} CAD parts`;
  return makeFold(title, [make("ul", { class: "live-parts" }, rows)], parts.length <= 8);
}

function collidersFold(colliders) {
  const rows = colliders.map((one) => {
    const measures = [
      ["stands out", one.stands_out_mm], ["bare", one.bare_mm], ["tolerance", one.tolerance_mm],
    ].filter(([, value]) => value !== null && value !== undefined);
    const text = measures.map(([word, value]) => `${word} ${Number(value.toPrecision(3))}\u00a0mm`).join(", ");
    return make("li", { class: one.within ? "" : "live-beyond" }, [
      make("span", { text: one.part ? `${one.part}: ${one.made}` : one.made }),
      make("span", { class: "live-soft", text }),
    ]);
  });
  const title = colliders.length === 1 ? "1 collider" : `${colliders.length} colliders`;
  return makeFold(title, [make("ul", { class: "live-parts" }, rows)], colliders.length <= 4);
}
