// Checks that Lighthouse's score for accessibility is 100. Exits with 1 if it is lower.
import lighthouse from "lighthouse";
import { fileURLToPath } from "node:url";
import { installed, launch } from "./browsers.mjs";
import { serve } from "./serve.mjs";

if (!installed("chrome")) {
  console.log("SKIPPED: no Chromium: no score of Lighthouse");
  process.exit(0);
}
const server = await serve(fileURLToPath(new URL("../dist", import.meta.url)));
const browser = await launch("chrome");
try {
  const port = Number(new URL(browser.wsEndpoint()).port);
  const { lhr } = await lighthouse(server.address, { port, onlyCategories: ["accessibility"], output: "json", logLevel: "error" });
  const score = Math.round(100 * lhr.categories.accessibility.score);
  const failed = Object.values(lhr.audits).filter(audit => audit.score !== null && audit.score < 1);
  for (const audit of failed) console.log(`     ${audit.title}: ${JSON.stringify(audit.details?.items?.map(item => item.node?.snippet))}`);
  console.log(`${score === 100 ? "ok  " : "FAIL"} Lighthouse: accessibility ${score}`);
  process.exitCode = score === 100 ? 0 : 1;
} finally {
  await browser.close();
  server.close();
}
