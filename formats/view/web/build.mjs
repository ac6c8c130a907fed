// Bundles the viewer: ../bundle/viewer.js, viewer.css and LICENSES.txt.
import { readFile, writeFile, mkdir } from "node:fs/promises";
import { build } from "esbuild";

const bundle = new URL("../bundle/", import.meta.url);
const modules = new URL("node_modules/", import.meta.url);
await mkdir(bundle, { recursive: true });
const made = await build({
  entryPoints: ["src/main.js"],
  absWorkingDir: new URL(".", import.meta.url).pathname,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "none",
  write: false,
});
const script = made.outputFiles[0].text.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
const style = [
  await readFile(new URL("uplot/dist/uPlot.min.css", modules), "utf8"),
  await readFile(new URL("src/style.css", import.meta.url), "utf8"),
].join("\n");
const licences = await Promise.all(
  [["three", "three.js"], ["uplot", "uPlot"]].map(async ([folder, name]) => {
    const { version } = JSON.parse(await readFile(new URL(`${folder}/package.json`, modules), "utf8"));
    const text = await readFile(new URL(`${folder}/LICENSE`, modules), "utf8");
    return `${name} ${version}\n\n${text.trim()}\n`;
  }),
);
// A file that stays as it is keeps its time, or everything that it is built into would be built again.
const write = async (name, text) => {
  const file = new URL(name, bundle);
  const before = await readFile(file, "utf8").catch(() => null);
  if (text !== before) await writeFile(file, text);
};
await write("viewer.js", script);
await write("viewer.css", style);
await write("LICENSES.txt", licences.join("\n----\n\n"));
console.log(`viewer.js ${script.length} bytes, viewer.css ${style.length} bytes`);
