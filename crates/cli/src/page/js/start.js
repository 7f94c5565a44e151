// Puts the page together.

function themes() {
  const button = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen = null;
  const show = () => {
    const dark = chosen ?? system.matches;
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    button.setAttribute("aria-pressed", String(dark));
  };
  button.addEventListener("click", () => { chosen = !(chosen ?? system.matches); show(); });
  system.addEventListener("change", show);
  show();
}

async function start() {
  themes();
  const main = document.getElementById("main");
  document.getElementById("title").textContent = data.title;
  const kinds = data.documents.map((d) => (d.kind === "accuracy" ? `accuracy of ${d.json.methods.length} methods` : `${d.json.method}, ${short(d.json.wall_seconds)} s`));
  document.getElementById("summary").textContent = kinds.join("; ");
  document.getElementById("footer").textContent = `Made by ${data.generator} from ${data.documents.map((d) => d.file).concat(data.pictures.map((p) => p.file)).join(", ")}.`;
  main.append(warnings());
  const pictures = await loadPictures();
  if (pictures.length) {
    const reference = data.reference === null ? null : pictures[data.reference];
    const looked = section(2, pictures.length > 1 ? "Pictures" : "Picture", pictures.length > 1 ? "Pictures" : "Picture");
    main.append(looked);
    looked.append(viewer(pictures, reference), comparisons(pictures) ?? "");
  }
  for (const document_ of data.documents) main.append(document_.kind === "accuracy" ? accuracySections(document_) : renderSections(document_));
  contents();
  document.documentElement.dataset.ready = "true";
}

start().catch((error) => {
  document.getElementById("main").append(element("p", { class: "warnings", role: "alert" }, `The page could not be drawn: ${error.message}. Its data is intact; a browser of 2023 or later is needed.`));
  throw error;
});
