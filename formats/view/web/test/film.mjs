/**
 * Pictures of pages in motion, to make a film of: the view of each page at evenly spread times.
 *   node test/film.mjs --frames 40 --size 340x255 --share 0.5 --out FOLDER PAGE.html...
 * --share: how much of the run is shown.
 * FOLDER gets NAME-00.png, NAME-01.png ... of each NAME.html.
 */
import { mkdir } from "node:fs/promises";
import { basename, join } from "node:path";
import { parseArgs } from "node:util";
import { pathToFileURL } from "node:url";
import { open } from "./browser.mjs";

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { frames: { type: "string", default: "40" }, size: { type: "string", default: "340x255" }, share: { type: "string", default: "1" }, out: { type: "string", default: "frames" } },
});
const frames = Number(values.frames);
const [width, height] = values.size.split("x").map(Number);
await mkdir(values.out, { recursive: true });
const browser = await open();
for (const path of positionals) {
  const page = await browser.newPage({ viewport: { width, height: 900 }, colorScheme: "light" });
  await page.goto(`${pathToFileURL(path).href}?still&colour=deflection`);
  await page.waitForSelector("html[data-drawn=true]", { timeout: 30000 });
  await page.addStyleTag({ content: `#view canvas { width: ${width}px !important; height: ${height}px !important; }` });
  await page.waitForTimeout(300);
  const slider = page.locator("#view input[type=range]");
  const largest = Number(await slider.getAttribute("max"));
  for (let frame = 0; frame < frames; frame++) {
    await slider.fill(String(Math.round((Number(values.share) * largest * frame) / frames)));
    await page.evaluate(() => window.tisserandView.draw());
    const name = `${basename(path, ".html")}-${String(frame).padStart(2, "0")}.png`;
    await page.locator("#view canvas").screenshot({ path: join(values.out, name) });
  }
  await page.close();
}
await browser.close();
