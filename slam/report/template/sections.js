/// A part that fails on unforeseen data must not take the others with it.
function attempt(part) {
  try {
    part();
  } catch (problem) {
    byId("notes").append(h("li", {}, `${part.name}: ${problem.message}`));
    byId("warnings").hidden = false;
    console.error(problem);
  }
}

/// Sections in which nothing was drawn disappear, the others are linked from the bar.
function showSections() {
  for (const section of document.querySelectorAll("section[data-title]")) {
    if (!section.querySelector(".panel:not(:empty)")) {
      section.hidden = true;
      continue;
    }
    byId("sections").append(h("a", {href: "#" + section.id}, section.dataset.title));
  }
}
