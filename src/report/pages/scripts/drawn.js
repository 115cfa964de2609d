// What was really drawn, written on each plot after it: points by curve, and pixels in the curve's
// colour. Tests read it; a reader sees nothing of it.

const kSameColour = 60;  // distance of red, green and blue together
const kVisible = 40;     // of 255

function pixelsOf(canvas, colour) {
  const wanted = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  const copy = element('canvas', {width: canvas.width, height: canvas.height});
  const pen = copy.getContext('2d', {willReadFrequently: true});
  pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(0, 0, copy.width, copy.height).data;
  let count = 0;
  for (let k = 0; k < data.length; k += 4) {
    const away = Math.abs(data[k] - wanted[0]) + Math.abs(data[k + 1] - wanted[1]) +
        Math.abs(data[k + 2] - wanted[2]);
    if (data[k + 3] > kVisible && away < kSameColour) ++count;
  }
  return count;
}

/** @param curves  [{name, colour, points}] */
function noteDrawn(plot, canvas, curves) {
  const list = (value) => curves.map((c) => c.name + ':' + value(c)).join(' ');
  plot.dataset.points = list((c) => c.points);
  plot.dataset.pixels = list((c) => pixelsOf(canvas, c.colour));
}
