/**
 * Checks pages, a line of JSON for each; exit 1 if a check fails.
 *   node test/check_page.mjs [--most MILLISECONDS] PAGE.html...      processor time that a picture may take
 *   node test/check_page.mjs --picture OUT.png [--query 'still&time=0.5'] [--view] PAGE.html
 */
import { parseArgs } from "node:util";
import { check, open, shoot } from "./browser.mjs";

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { picture: { type: "string" }, query: { type: "string", default: "still" }, view: { type: "boolean", default: false }, most: { type: "string" } },
});
if (positionals.length === 0) {
  console.error("check_page: name pages, such as target/pages/*.html; .ci/browser makes them");
  process.exit(2);
}
const browser = await open();
let isGood = true;
for (const path of positionals) {
  if (values.picture) {
    await shoot(browser, path, values.picture, values.query, { view: values.view });
    continue;
  }
  const found = await check(browser, path, { most: Number(values.most ?? Infinity) });
  console.log(JSON.stringify(found));
  isGood &&= found.failed.length === 0;
}
await browser.close();
process.exit(isGood ? 0 : 1);
