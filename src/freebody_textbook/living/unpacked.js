// Inflates what Python wrote for the page, its data and its script, and runs the script: nothing is
// fetched, and the page's policy names its text.
const inflated = (packed) => {
  const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")));
};
let page;
(async () => {
  page = await inflated("PAGE").json();
  const script = document.createElement("script");
  script.textContent = await inflated("SCRIPT").text();
  document.body.append(script);
})();
