// What Python wrote for the page, inflated by the browser: nothing is fetched.

const bytes = Uint8Array.from(atob("PAGE"), (c) => c.charCodeAt(0));
const page = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).json();
