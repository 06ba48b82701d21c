// Opens pages in the installed browsers and collects their errors.
import puppeteer from "puppeteer-core";
import { existsSync } from "node:fs";

const PLACES = {
  chrome: ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"],
  firefox: ["/usr/bin/firefox-esr", "/usr/bin/firefox"],
};

/** The path of a browser; undefined if it is not installed. */
export const installed = browser => PLACES[browser].find(existsSync);

export async function launch(browser, options = {}) {
  const args = browser === "chrome" ? ["--no-sandbox", "--autoplay-policy=no-user-gesture-required"] : ["--width=1280", "--height=900"];
  return puppeteer.launch({ browser, executablePath: installed(browser), args, protocolTimeout: 600_000, ...options });
}

/** Whether pages of a browser can be told which features of media they have. In Firefox, only preferences can. */
const tellsFeatures = async browser => !(await browser.version()).includes("irefox");

/** Opens a page. Returns the page, and a list that collects its errors and its requests to other servers. */
export async function open(browser, address, { width = 1280, height = 900, touch = false, features = [] } = {}) {
  const page = await browser.newPage();
  const faults = [];
  page.on("console", message => { if (["error", "warn"].includes(message.type())) faults.push(`console: ${message.text()}`); });
  page.on("pageerror", error => faults.push(`error: ${error.message}`));
  page.on("request", request => {
    const url = request.url();
    if (!url.startsWith(new URL(address).origin) && !/^(blob|data):/.test(url)) faults.push(`request: ${url}`);
  });
  page.on("requestfailed", request => faults.push(`failed: ${request.url()}`));
  await page.setViewport({ width, height, hasTouch: touch });
  if (features.length > 0 && await tellsFeatures(browser)) await page.emulateMediaFeatures(features);
  await page.goto(address);
  return { page, faults };
}

export const text = (page, id) => page.$eval(`#${id}`, element => element.textContent);

/** Waits until a control is enabled. */
export const ready = (page, id = "design") => page.waitForSelector(`#${id}:enabled`, { timeout: 60_000 });

/** Waits until the main button shows these words. */
export async function says(page, words, timeout = 120_000) {
  await page.waitForFunction(words => document.getElementById("design").textContent === words, { timeout }, words);
}
