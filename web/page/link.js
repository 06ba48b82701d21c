// Reads the part of an address after `#`: names, such as `#Anna` and `#Anna+Ben`, or a link with settings, which has a `=`.

/** The most characters of a name, and the most names of a link. */
const LONGEST = 40;
const MOST = 4;

/** What a sentence leaves at the end of a link. */
const ENDS = /[).,;]+$/;
/** Characters that are not shown, or that change the order of others; and `=`, which a name cannot have. */
const UNSEEN = /[\p{Cc}\p{Cs}\u202a-\u202e\u2066-\u2069=]/gu;

function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** A name as it is shown; empty if nothing is left of it. */
function cleaned(text) {
  const name = text.normalize("NFC").replace(UNSEEN, "").trim();
  return Array.from(name).slice(0, LONGEST).join("").trim();
}

/** A name of a link, in few characters for a message. */
export const cut = name => Array.from(name).length > LONGEST ? `${Array.from(name).slice(0, LONGEST).join("")}…` : name;

/** The hash FNV-1a of bytes, with 32 bits. */
export const hashOf = bytes => bytes.reduce((hash, byte) => Math.imul(hash ^ byte, 0x01000193), 0x811c9dc5) >>> 0;

/** The seed of a name: the hash of its small letters in UTF-8. It must never change. */
export const seedOf = name => hashOf(new TextEncoder().encode(name.toLowerCase().normalize("NFC")));

/** The different names in a text, in which `+` is between two names. */
export function namesIn(text, read = name => name) {
  const names = text.split("+").map(name => cleaned(read(name))).filter(name => name !== "");
  return names.filter((name, k) => names.findIndex(other => seedOf(other) === seedOf(name)) === k).slice(0, MOST);
}

/** The address of names. */
export const linkOf = names => `#${names.map(encodeURIComponent).join("+")}`;

/** Reads the part of an address after `#`: { names, link }, one of which is empty. */
export function readLink(hash) {
  const raw = hash.slice(1).replaceAll("&amp;", "&").replace(ENDS, "");
  const whole = raw.includes("=") ? raw : decoded(raw);
  const link = new URLSearchParams();
  if (!whole.includes("=")) return { names: namesIn(raw, decoded), link };
  for (const [key, value] of new URLSearchParams(whole)) link.append(key.toLowerCase(), value);
  return { names: [], link };
}
