/** Keys of the view: everywhere on the page where nothing is being typed; arrows only in the picture, since they scroll the page. */

export const KEYS = "Space: play or pause. [ and ]: a step back or on. + and −: nearer, farther. 1 to 6: views, 0: home. h: this line. In the picture: arrows turn it, Escape leaves it.";

const TURN = 0.12;

/** Keys act on the viewer from now on. */
export function listen(viewer, canvas) {
  const anywhere = {
    " ": () => viewer.toggle(), h: () => viewer.help(), "[": () => viewer.step(-1), "]": () => viewer.step(1),
    "+": () => viewer.stage.move(0, 0, 0.87), "=": () => viewer.stage.move(0, 0, 0.87), "-": () => viewer.stage.move(0, 0, 1.15),
    0: () => viewer.look("home"), 1: () => viewer.look("front"), 2: () => viewer.look("back"), 3: () => viewer.look("left"),
    4: () => viewer.look("right"), 5: () => viewer.look("top"), 6: () => viewer.look("bottom"),
  };
  const inPicture = {
    ArrowLeft: () => viewer.stage.move(-TURN, 0, 1), ArrowRight: () => viewer.stage.move(TURN, 0, 1),
    ArrowUp: () => viewer.stage.move(0, TURN, 1), ArrowDown: () => viewer.stage.move(0, -TURN, 1), Escape: () => canvas.blur(),
  };
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || isTyped(target)) return;
    if (key === " " && target.matches?.("button, summary, a, input[type=checkbox]")) return;
    const action = anywhere[key] ?? (target === canvas ? inPicture[key] : undefined);
    if (!action) return;
    event.preventDefault();
    action();
    viewer.needsDraw = true;
  });
}

const isTyped = (target) => target.isContentEditable || target.matches?.("select, textarea, input:not([type=range]):not([type=checkbox])");
