/** Fills the places of a page. What is in the page without it stays if anything fails. */
import { Arrays } from "./arrays.js";
import { drawCharts } from "./charts.js";
import { element } from "./elements.js";
import { Histories } from "./histories.js";
import { Viewer } from "./viewer.js";

async function start() {
  const place = document.getElementById("view");
  const say = (text) => place?.replaceChildren(element("p", { class: "failed" }, text));
  let description;
  let arrays;
  try {
    description = JSON.parse(document.getElementById("description").textContent);
    arrays = await Arrays.inflate(document.getElementById("arrays").textContent);
  } catch (error) {
    return say(`The data of this page can't be read: ${error.message}`);
  }
  let viewer = null;
  if (place) {
    try {
      viewer = new Viewer(place, description, arrays);
      window.tisserandView = viewer;
    } catch (error) {
      const why = /WebGL/i.test(String(error.message)) ? "This browser has no WebGL; tables and curves below are complete." : `The view can't be drawn: ${error.message}`;
      say(why);
      document.documentElement.dataset.drawn = "true";
    }
  }
  const curves = document.getElementById("histories");
  if (curves && description.histories?.length > 0) {
    const histories = new Histories(curves, description, arrays, (time) => viewer?.setTime(time));
    if (viewer) {
      viewer.onTime = (time) => histories.show(time);
      viewer.onPick = (body, node) => follow(histories, description, body, node, viewer.times);
      viewer.needsDraw = true;
    }
  }
  drawCharts(description, arrays);
}

/** Curves of a body or of one of its nodes. */
function follow(histories, description, body, node, times) {
  const place = body.group.position.clone();
  const turn = body.group.quaternion.clone();
  const curves = ["x", "y", "z"].slice(0, description.dimension).map((name) => ({ name, values: new Float32Array(times.length) }));
  const deflection = new Float32Array(times.length);
  const amplitudes = new Float64Array(body.amplitudes.length);
  times.forEach((time, k) => {
    body.motion.pose(time, place, turn);
    let at = place.clone();
    if (node != null) {
      const u = body.shape.displacement(node, body.motion.amplitude(time, amplitudes));
      deflection[k] = Math.hypot(...u);
      const x = body.shape.positions;
      at = at.set(x[3 * node] + u[0], x[3 * node + 1] + u[1], x[3 * node + 2] + u[2]).applyQuaternion(turn).add(place);
    }
    const coordinates = at.toArray();
    curves.forEach((curve, axis) => (curve.values[k] = coordinates[axis]));
  });
  const unit = description.units.length;
  if (node == null) return histories.picked(`${body.name}, origin of its frame`, unit, times, curves);
  const title = `${body.name}, deflection of node ${body.shape.nodes[node]}`;
  histories.picked(title, unit, times, [{ name: "deflection", values: deflection }]);
}

/** Tables that are wider than the page scroll with keys too. */
function reachTables() {
  for (const place of document.querySelectorAll(".wide")) {
    new ResizeObserver(() => {
      if (place.scrollWidth > place.clientWidth) place.setAttribute("tabindex", "0");
      else place.removeAttribute("tabindex");
    }).observe(place);
  }
}

reachTables();
start();
