/** Keeps the site in the browser, so that it opens without a network after the first visit. */

/* `files.js` is written beside this file with the site: its version and its files. */
importScripts("files.js");

const { version, paths } = self.SITE;
const NAME = `latolato ${version}`;
// Of the compiled code a browser needs the variant that it runs, which its page names.
const variant = new URL(self.location.href).searchParams.get("variant") ?? "";
const variantOf = (path) => /^kernels\/\w+(.*)\.wasm$/.exec(path)?.[1];
const needed = paths.filter((path) => [undefined, variant].includes(variantOf(path)));

self.addEventListener("install", (event) => event.waitUntil((async () => {
  const cache = await caches.open(NAME);
  // Past the browser's own cache, which may have files of an earlier version.
  await cache.addAll(["./", ...needed].map((path) => new Request(path, { cache: "reload" })));
  await self.skipWaiting();
})()));

self.addEventListener("activate", (event) => event.waitUntil((async () => {
  for (const name of await caches.keys())
    if (name.startsWith("latolato ") && name !== NAME) await caches.delete(name);
  await self.clients.claim();
})()));

self.addEventListener("fetch", (event) => {
  const { request } = event;
  const { origin, pathname } = new URL(request.url);
  if (request.method !== "GET" || origin !== self.location.origin) return;
  const path = pathname.slice(new URL("./", self.location.href).pathname.length);
  // The report and the documentation are kept as they are read.
  const isLater = /^(report|docs)\//.test(path);
  event.respondWith((async () => {
    const cache = await caches.open(NAME);
    const kept = await cache.match(request, { ignoreSearch: true });
    if (kept && !isLater) return kept;
    try {
      const response = await fetch(request);
      if (isLater && response.ok) await cache.put(request, response.clone());
      return response;
    } catch (error) {
      if (kept) return kept;
      if (request.mode !== "navigate") throw error;
      return Response.redirect("./#not-stored"); // the toy, which says so
    }
  })());
});
