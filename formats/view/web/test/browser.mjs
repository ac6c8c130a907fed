/** Checks of a page in headless Chromium. */
import { readdir, readFile, stat } from "node:fs/promises";
import { createRequire } from "node:module";
import { availableParallelism, loadavg } from "node:os";
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

/** Seconds of processor time that this process's children, and theirs, have used; null where there is no /proc. */
async function processorTime() {
  const processes = new Map();
  try {
    for (const id of (await readdir("/proc")).filter((name) => /^\d+$/.test(name))) {
      const text = await readFile(`/proc/${id}/stat`, "utf8").catch(() => null);
      if (!text) continue;
      const fields = text.slice(text.lastIndexOf(")") + 2).split(" ");
      processes.set(id, { parent: fields[1], seconds: (Number(fields[11]) + Number(fields[12])) / 100 });
    }
  } catch {
    return null;
  }
  const found = [String(process.pid)];
  for (const parent of found) for (const [id, one] of processes) if (one.parent === parent) found.push(id);
  return found.slice(1).reduce((sum, id) => sum + processes.get(id).seconds, 0);
}

/**
 * Pictures a second and what one costs. A loaded machine shows fewer of them; their processor time it hardly changes,
 * so that this is what a limit can hold.
 */
async function pace(page, milliseconds = 3000) {
  const now = () => page.evaluate(() => [window.tisserandView.framesDrawn, performance.now()]);
  await page.waitForTimeout(1500); // until the picture is as coarse as it gets
  const [before, [first, start]] = [await processorTime(), await now()];
  await page.waitForTimeout(milliseconds);
  const [after, [last, end]] = [await processorTime(), await now()];
  const pictures = Math.max(last - first, 1);
  const { width, height } = await page.evaluate(() => ({ width: window.tisserandView.stage.canvas.width, height: window.tisserandView.stage.canvas.height }));
  const round = (value) => Math.round(10 * value) / 10;
  return {
    fps: round((1000 * (last - first)) / (end - start)),
    cpuMsPerPicture: before == null ? null : round((1000 * (after - before)) / pictures),
    resolution: `${width}x${height}`,
    load: round(loadavg()[0]),
    processors: availableParallelism(),
  };
}

/** What is found of a page: figures, and the names of checks that fail. `most`: milliseconds of processor time that a picture may take. */
export async function check(browser, path, { most = Infinity } = {}) {
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
  await page.waitForSelector("html[data-drawn=true]", { timeout: 60000 });
  const isPart = await page.evaluate(() => window.tisserandView.isPart);
  const moves = await page.evaluate(() => (window.tisserandView.isPart ? window.tisserandView.description.modes.length > 0 : window.tisserandView.times.length > 1));
  const speed = moves ? await pace(page) : null;
  if (moves) {
    holds("it plays", speed.fps > 0);
    holds(`a picture takes ${speed.cpuMsPerPicture} ms of processor time, more than ${most}`, !(speed.cpuMsPerPicture > most));
    // A machine with time to spare shows what the limit promises.
    if (Number.isFinite(most) && speed.load < 0.5 * speed.processors) holds(`${speed.fps} pictures a second, fewer than 30`, speed.fps >= 30);
    await page.keyboard.press(" ");
    holds("space pauses from anywhere", await page.evaluate(() => !window.tisserandView.isPlaying));
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
  const wheel = await page.evaluate(() => {
    document.activeElement.blur();
    const { canvas, camera } = window.tisserandView.stage;
    const far = camera.position.length();
    const roll = () => canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: 120, bubbles: true, cancelable: true }));
    const isScrolled = roll();
    const still = camera.position.length() === far;
    canvas.focus();
    return { isScrolled, still, zooms: !roll() && camera.position.length() !== far };
  });
  holds("the wheel scrolls the page", wheel.isScrolled && wheel.still);
  holds("the wheel zooms once the picture has the focus", wheel.zooms);
  if (hasShape) {
    const node = await page.evaluate(() => window.tisserandView.bodies.find((body) => body.shape).shape.nodes[0]);
    await page.locator("input[aria-label=Node]").fill(String(node));
    await page.locator("input[aria-label=Node]").press("Enter");
    holds("a node is picked by its number", (await page.locator(".told").textContent()).includes(`node ${node} `));
    const marked = await page.evaluate(() => { const view = window.tisserandView; view.draw(); return view.picking.marker.visible; });
    holds("the picked node is marked", marked);
  }
  // The signs on a mesh follow it: no further from their nodes in any deflection than at rest.
  holds("signs follow deflections", await page.evaluate(() => {
    const view = window.tisserandView;
    const usual = view.scale;
    view.setScale((view.isPart ? 1 : 10) * usual);
    view.draw();
    let follow = true;
    for (const { members } of view.glyphs.kinds) {
      for (const { shown, place } of members) {
        if (!shown.patterns) continue;
        const { body } = shown;
        const x = body.shape.positions;
        const at = body.group.worldToLocal(place.clone()).toArray();
        const u = body.shape.displacements(body.amplitudes, new Float32Array(x.length));
        const nearest = (point, scale) => {
          let best = Infinity;
          for (let k = 0; k < x.length; k += 3) best = Math.min(best, Math.hypot(...[0, 1, 2].map((axis) => x[k + axis] + scale * u[k + axis] - point[axis])));
          return best;
        };
        if (nearest(at, body.scale) > nearest(shown.position.toArray(), 0) + 0.005 * view.description.size) follow = false;
      }
    }
    view.setScale(usual);
    view.draw();
    return follow;
  }));
  const charts = page.locator(".chart .u-over");
  if ((await charts.count()) > 0) {
    await charts.first().hover();
    const values = await page.locator(".chart").first().locator(".u-value").allTextContents();
    holds(`charts show values: ${values}`, values.some((value) => /[1-9]/.test(value)));
  }
  if (!isPart && moves) {
    await page.locator("select[aria-label=Body]").selectOption("0").catch(() => page.evaluate(() => window.tisserandView.pick(window.tisserandView.bodies[0], null)));
    holds("a picked body has a history", (await page.locator("#histories .panel").count()) > 0);
    const over = page.locator("#histories .u-over").first();
    await over.hover();
    const values = await page.locator("#histories .panel").first().locator(".u-value").allTextContents();
    holds("curves show values", values.some((value) => /\d/.test(value)));
    await page.locator("#view input[type=range]").fill("0");
    await over.dblclick();
    await page.waitForTimeout(600);
    const first = () => page.evaluate(() => window.tisserandView.time === window.tisserandView.times[0]);
    holds("a double click on a curve leaves the time", await first());
    await over.click();
    await page.waitForTimeout(600);
    holds("a click on a curve sets the time", !(await first()));
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
  holds("it is dark again after printing", (await page.evaluate(() => document.documentElement.dataset.theme)) === "dark");
  holds("no console error, dialog or request", errors.length === 0);
  if (hasShape) {
    const ways = [];
    for (const way of ["shader", "processor"]) {
      await page.setViewportSize({ width: 1000, height: 900 });
      await page.goto(`${pathToFileURL(path).href}?still&deflect=${way}`);
      await page.waitForSelector("html[data-drawn=true]", { timeout: 60000 });
      if (!isPart && moves) await page.locator("#view input[type=range]").fill("430");
      ways.push(await picture(page));
    }
    holds("shader and processor deflect alike", differing(...ways) < 20);
  }
  const { size } = await stat(path);
  holds("it is below 5 MB", size < 5e6);
  await context.close();
  return { path, bytes: size, ...speed, violations, errors, failed };
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

