// What the page carries in compressed form: bytes in base64 inside a script element that the browser does
// not run, inflated by the browser itself. Nothing is fetched.

let THREE = null; // three.js, from loadThree() on

function bytesOfBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const plain = atob(text);
  const bytes = new Uint8Array(plain.length);
  for (let i = 0; i < plain.length; i++) bytes[i] = plain.charCodeAt(i);
  return bytes;
}

async function inflated(base64) {
  const stream = new Blob([bytesOfBase64(base64)]).stream();
  const plain = stream.pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(plain).arrayBuffer());
}

async function inflatedText(base64) {
  return new TextDecoder().decode(await inflated(base64));
}

// The content of an element, "" where the page has none. It is let go: the text of the engine is large.
function taken(id) {
  const element = document.getElementById(id);
  const content = element ? element.textContent.trim() : "";
  if (element) element.remove();
  return content;
}

// What a script of one function leaves in the name that it declares.
function evaluated(code, name) {
  return new Function(`${code}\nreturn ${name};`)();
}

async function loadThree() {
  THREE = evaluated(await inflatedText(taken("linkwright-three")), "THREE");
}

// The engine's parts in base64, from this page or from the file that several pages share; else null.
function enginePieces() {
  const shared = globalThis.linkwrightEngine;
  if (shared) return shared;
  const wasm = taken("linkwright-wasm");
  return wasm ? { wasm, glue: taken("linkwright-glue") } : null;
}
