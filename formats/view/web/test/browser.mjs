/** Checks of a page in headless Chromium. */
import { stat } from "node:fs/promises";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const axe = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

/** A browser with a software renderer. CHROMIUM names another program. */
export function open() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
  });
}

/** The picture of the view as text that differs where it differs. */
const picture = (page) => page.evaluate(() => {
  const { tisserandView: view } = window;
  view.draw();
  const small = document.createElement("canvas");
  small.width = 160;
  small.height = 100;
  const context = small.getContext("2d");
  context.drawImage(view.stage.canvas, 0, 0, 160, 100);
  return Array.from(context.getImageData(0, 0, 160, 100).data);
});

const differing = (a, b) => a.reduce((count, value, k) => count + (Math.abs(value - b[k]) > 12 ? 1 : 0), 0);
const colours = (pixels) => {
  const found = new Set();
  for (let k = 0; k < pixels.length; k += 4) found.add(`${pixels[k] >> 4},${pixels[k + 1] >> 4},${pixels[k + 2] >> 4}`);
  return found.size;
};

/** What is found of a page: figures, and the names of checks that fail. */
export async function check(browser, path) {
  const context = await browser.newContext({ viewport: { width: 1000, height: 900 }, colorScheme: "light" });
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => { if (message.type() === "error") errors.push(message.text()); });
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("dialog", (dialog) => { errors.push(`a name opened a dialog: ${dialog.message()}`); dialog.dismiss(); });
  page.on("request", (request) => { if (!/^(file|data|blob):/.test(request.url())) errors.push(`asked the network: ${request.url()}`); });
  const failed = [];
  const holds = (name, isTrue) => { if (!isTrue) failed.push(name); };
  await page.goto(pathToFileURL(path).href);
  await page.waitForSelector("html[data-drawn=true]", { timeout: 30000 });
  const isPart = await page.evaluate(() => window.tisserandView.isPart);
  const moves = await page.evaluate(() => (window.tisserandView.isPart ? window.tisserandView.description.modes.length > 0 : window.tisserandView.times.length > 1));

  const fps = await page.evaluate(async () => {
    const view = window.tisserandView;
    if (!view.isPlaying) return null;
    const [from, start] = [view.framesDrawn, performance.now()];
    await new Promise((resolve) => setTimeout(resolve, 3000));
    return (1000 * (view.framesDrawn - from)) / (performance.now() - start);
  });
  if (moves) {
    holds("it plays", fps > 0);
    await page.locator("#view canvas").press(" ");
    holds("space pauses", await page.evaluate(() => !window.tisserandView.isPlaying));
    const slide = async (value) => {
      await page.locator("#view input[type=range]").fill(String(value));
      return picture(page);
    };
    const [a, b] = [await slide(isPart ? 250 : 0), await slide(isPart ? 750 : 430)];
    holds("the canvas isn't empty", colours(a) > 3);
    holds("the slider moves the part", differing(a, b) > 20);
    if (isPart) await page.locator("#view input[type=range]").fill("250");
  }
  const before = await picture(page);
  await page.locator("#view canvas").press("ArrowLeft");
  holds("arrows turn the view", differing(before, await picture(page)) > 20);
  const hasShape = await page.evaluate(() => window.tisserandView.bodies.some((body) => body.shape));
  if (hasShape && moves) {
    const plain = await picture(page);
    await page.locator("select[aria-label=Colour]").selectOption("deflection");
    holds("colours show the deflection", differing(plain, await picture(page)) > 10);
    holds("colours have a legend", await page.locator(".legend").isVisible());
  }
  if (isPart && moves && (await page.locator("select[aria-label=Mode] option").count()) > 1) {
    const first = await picture(page);
    await page.locator("select[aria-label=Mode]").selectOption("1");
    holds("another mode is another picture", differing(first, await picture(page)) > 10);
  }
  if (!isPart && moves) {
    await page.evaluate(() => window.tisserandView.pick(window.tisserandView.bodies[0], null));
    holds("a picked body has a history", (await page.locator("#histories .panel").count()) > 0);
    const over = page.locator("#histories .u-over").first();
    await over.hover();
    const values = await page.locator("#histories .panel").first().locator(".u-value").allTextContents();
    holds("curves show values", values.some((value) => /\d/.test(value)));
    await over.click();
    holds("a click on a curve sets the time", await page.evaluate(() => window.tisserandView.time > window.tisserandView.times[0]));
  }
  await page.addScriptTag({ path: axe });
  const violations = [];
  for (const theme of ["light", "dark"]) {
    await page.evaluate((wanted) => { if (document.documentElement.dataset.theme !== wanted) window.tisserandView.toggleTheme(); }, theme);
    const found = await page.evaluate(() => window.axe.run({ runOnly: ["wcag2a", "wcag2aa", "best-practice"] }));
    violations.push(...found.violations.map((one) => `${theme}: ${one.id}: ${one.nodes[0].html.slice(0, 120)}`));
  }
  holds("axe is content", violations.length === 0);
  await page.setViewportSize({ width: 400, height: 800 });
  await page.waitForTimeout(500);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth <= 401 ? [] : [...document.querySelectorAll("body *")].filter((one) => one.getBoundingClientRect().right > 402).slice(0, 4).map((one) => `${one.tagName}.${one.className}`));
  holds(`it fits 400 px: ${wide}`, wide.length === 0);
  const printed = await page.pdf();
  holds("it prints", printed.length > 10000);
  holds("no console error, dialog or request", errors.length === 0);
  const { size } = await stat(path);
  await context.close();
  return { path, bytes: size, fps, violations, errors, failed };
}

/** Saves a picture of a page, or of its view alone. */
export async function shoot(browser, path, target, query, { width = 1100, height = 900, view = false } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: "light" });
  const page = await context.newPage();
  await page.goto(`${pathToFileURL(path).href}?${query}`);
  await page.waitForSelector("html[data-drawn=true]", { timeout: 30000 });
  await page.waitForTimeout(300);
  if (view) await page.locator("#view canvas").screenshot({ path: target });
  else await page.screenshot({ path: target, fullPage: true });
  await context.close();
}

