// Records a film of the walk from the canvas, in a format that the browser can write.

const KINDS = [["video/webm;codecs=vp9", "webm"], ["video/webm;codecs=vp8", "webm"], ["video/webm", "webm"], ["video/mp4", "mp4"]];

/** A film with fewer bytes has only a header. */
const HEADER = 1000;
/** How long the encoder may take to write more than that after the end of the walk, milliseconds. */
const PATIENCE = 5000;

/** The kind of film that this browser can record; null if it cannot record films. */
export function filmKind() {
  if (!("MediaRecorder" in globalThis) || !("captureStream" in HTMLCanvasElement.prototype)) return null;
  return KINDS.find(([type]) => MediaRecorder.isTypeSupported(type)) ?? null;
}

/**
 * Records one walk from its beginning to its end, at the player's speed.
 * @param label returns the text in the corner at a time.
 * @param title is two lines: the title of the film and the address of the page.
 * @param onprogress is called with the fraction that is recorded, from 0 to 1.
 * @returns the film and its file extension.
 */
export async function film({ canvas, player, label, colours, onprogress, title, signal }) {
  const [type, ending] = filmKind();
  const copy = Object.assign(document.createElement("canvas"), evenSize(canvas));
  const pen = copy.getContext("2d", { alpha: false });
  const recorder = new MediaRecorder(copy.captureStream(30), { mimeType: type, videoBitsPerSecond: 6e6 });
  const parts = [];
  recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  const stopped = new Promise(resolve => recorder.addEventListener("stop", resolve));
  const before = { playing: player.playing, withVoid: player.withVoid };
  Object.assign(player, { playing: true, withVoid: false, time: 0 });
  recorder.start();
  for (let last = 0; ; last = player.time) {
    await new Promise(requestAnimationFrame);
    // Stop if the walk has begun again or the robot stands at its end, or another robot is shown.
    if (player.time < last || player.time >= player.walk.landing || signal.aborted) break;
    copyFrame(pen, canvas, colours, label(player.time), title);
    onprogress(player.time / player.walk.duration);
  }
  // On a busy machine the encoder may have written only the header by now.
  const isEmpty = () => parts.reduce((sum, { size }) => sum + size, 0) < HEADER;
  for (const end = performance.now() + PATIENCE; isEmpty() && performance.now() < end && !signal.aborted;) {
    recorder.requestData();
    await new Promise(resolve => setTimeout(resolve, 100));
  }
  recorder.stop();
  await stopped;
  Object.assign(player, before);
  signal.throwIfAborted();
  return { blob: new Blob(parts, { type }), ending };
}

/** The size of the canvas, at most 1920 pixels wide, in even numbers because encoders need them. */
function evenSize({ width, height }) {
  const scale = Math.min(1, 1920 / width);
  return { width: 2 * Math.round(width * scale / 2), height: 2 * Math.round(height * scale / 2) };
}

function copyFrame(pen, canvas, { paper, ink }, label, [title, address]) {
  const { width, height } = pen.canvas;
  pen.fillStyle = paper;
  pen.fillRect(0, 0, width, height);
  pen.drawImage(canvas, 0, 0, width, height);
  pen.fillStyle = ink;
  pen.font = `600 ${Math.round(height / 20)}px system-ui, sans-serif`;
  pen.fillText(label, height / 24, height / 4.6);
  pen.fillText(title, height / 24, height / 12);
  pen.font = `${Math.round(height / 30)}px system-ui, sans-serif`;
  pen.fillText(address, height / 24, height / 7.6);
}

/** Lets the browser save a file. */
export function save(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60e3);
}
