// Keeps the files of this version, so that the page opens without a network. build.sh fills in VERSION and FILES.
const CACHE = "cosmic-VERSION";
const FILES = ["./", /* FILES */];

addEventListener("install", event => {
  event.waitUntil(caches.open(CACHE).then(cache => cache.addAll(FILES)).then(() => self.skipWaiting()));
});

addEventListener("activate", event => {
  const forget = names => Promise.all(names.filter(name => name.startsWith("cosmic-") && name !== CACHE).map(name => caches.delete(name)));
  event.waitUntil(caches.keys().then(forget));
});

// The names of all files but the page contain the version, so the cache is never out of date. The page comes from the
// network if there is one.
addEventListener("fetch", event => {
  if (event.request.method !== "GET" || !event.request.url.startsWith(registration.scope)) return;
  const kept = () => caches.match(event.request, { ignoreSearch: event.request.mode === "navigate" });
  event.respondWith(event.request.mode === "navigate"
    ? fetch(event.request).catch(kept)
    : kept().then(found => found ?? fetch(event.request)));
});
