// The motion of a pointer while it drags. Browsers report it as `pointermove` once a picture, as it is drawn; where they
// report it earlier, too, it is followed at once: what is dragged then lags by less than a picture.

const SPACING = 8; // from one report to the next [ms]

// Calls `move(pixel)` for each motion over a canvas: while `dragging()` as soon as it is known, else once a picture.
export function follow(canvas, dragging, move) {
  let last = 0; // when the pointer was followed [ms]
  let where = [NaN, NaN];
  const take = (event) => {
    const at = [event.offsetX, event.offsetY];
    if (at[0] === where[0] && at[1] === where[1]) return;
    last = event.timeStamp;
    where = at;
    move(at);
  };
  canvas.addEventListener("pointerrawupdate", (event) => dragging() && event.timeStamp - last >= SPACING && take(event));
  canvas.addEventListener("pointermove", take);
  canvas.addEventListener("pointerdown", () => (where = [NaN, NaN]));
}
