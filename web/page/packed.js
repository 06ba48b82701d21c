// The bytes of a robot as text in a link: base64 with the characters that addresses allow.

export function toText(bytes) {
  return btoa(String.fromCharCode(...bytes)).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** The bytes of a text; null if the text is not valid. */
export function toBytes(text) {
  try {
    return [...atob(text.replaceAll("-", "+").replaceAll("_", "/"))].map(byte => byte.charCodeAt(0));
  } catch {
    return null;
  }
}
