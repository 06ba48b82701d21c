// The bytes of a robot as text in a link: base64 with the characters that addresses allow. Two bytes at the end are a checksum,
// so that a link that lost or changed a character is not another robot.

import { hashOf } from "./link.js";

function checksum(bytes) {
  const hash = hashOf(bytes);
  return [(hash >>> 24) ^ (hash >>> 8 & 255), (hash >>> 16 & 255) ^ (hash & 255)];
}

export function toText(bytes) {
  return btoa(String.fromCharCode(...bytes, ...checksum(bytes))).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** The bytes of a text; null if the text is not valid or its checksum is wrong. */
export function toBytes(text) {
  try {
    const all = [...atob(text.replaceAll("-", "+").replaceAll("_", "/"))].map(byte => byte.charCodeAt(0));
    const bytes = all.slice(0, -2);
    return String(checksum(bytes)) === String(all.slice(-2)) ? bytes : null;
  } catch {
    return null;
  }
}
