// A picture that links to the page of a robot gets a button, which opens that page in the picture's place.
for (const link of document.querySelectorAll('a[href*="robots/"]')) {
  const picture = link.querySelector("img");
  if (!picture) continue;
  const box = document.createElement("div");
  box.className = "live";
  const start = document.createElement("button");
  start.type = "button";
  start.className = "live-start";
  start.textContent = "▶ Start the robot";
  start.addEventListener("click", () => {
    const frame = document.createElement("iframe");
    frame.className = "live-frame";
    frame.title = picture.alt;
    frame.src = link.href;
    box.replaceWith(frame);
    frame.focus();
  });
  link.replaceWith(box);
  box.append(picture, start);
}

// What scrolls sideways can be scrolled by keyboard, too.
for (const box of document.querySelectorAll(".md-typeset__scrollwrap, pre > code")) {
  if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
}
