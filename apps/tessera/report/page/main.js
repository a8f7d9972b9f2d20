// Builds each scene's pictures and charts from the embedded data.
'use strict';

let drawnCharts = [];

function choice(label, options, selected, onChange) {
  const wrap = element('label', '', label + ' ');
  const select = element('select');
  options.forEach(({value, text}) => {
    const option = element('option', '', text);
    option.value = value;
    select.append(option);
  });
  select.value = selected;
  select.addEventListener('change', onChange);
  wrap.append(select);
  return {wrap, select};
}

function frameOf(method, frame) {
  return method.frames.find(candidate => candidate.frame === frame);
}

// Atlas pictures are large and may be there for some frames only: the nearest one stands in.
function nearestAtlas(method, frame) {
  const having = method.frames.filter(candidate => candidate.atlas);
  having.sort((a, b) => Math.abs(a.frame - frame) - Math.abs(b.frame - frame));
  return having[0];
}

function perFrame(method, frame) {
  const known = [['MSSIM', method.series.mssim[frame]], ['FLIP', method.series.flip[frame]]]
                    .filter(([, value]) => typeof value === 'number');
  return known.map(([name, value]) => `${name} ${value.toFixed(4)}`).join(' · ');
}

function legend(full) {
  const box = element('div', 'legend');
  const ramp = element('i');
  ramp.style.background = `linear-gradient(to right, ${kData.stops.join(', ')})`;
  box.append(ramp, ...[0, full / 2, full].map(value => element('span', '', String(+value.toPrecision(3)))));
  return box;
}

function figure(title, stage, bar) {
  const node = element('figure');
  const head = element('div', 'bar');
  head.append(element('h3', '', title), ...bar, zoomButtons(stage));
  node.append(head, stage.root);
  return node;
}

function buildPictures(parent, scene) {
  const methods = scene.methods.filter(method => method.frames.some(frame => frame.image));
  if (methods.length === 0) {
    parent.remove();
    return;
  }
  const frames = [...new Set(methods.flatMap(method => method.frames.map(frame => frame.frame)))].sort((a, b) => a - b);
  const methodOptions = methods.map((method, index) => ({value: String(index), text: method.name}));
  const view = new View();
  const compare = new Stage(view, scene.width, scene.height);
  const divider = new Divider(compare);
  const errorStage = new Stage(view, scene.width, scene.height);
  errorStage.addLayer();
  const atlasStage = new Stage(new View(), 2, 1);
  atlasStage.addLayer();
  atlasStage.images[0].addEventListener('load', () => {
    const image = atlasStage.images[0];
    atlasStage.aspect(image.naturalWidth, image.naturalHeight);
  });

  const left = choice('Left', methodOptions, '0', update);
  const right = choice('Right', methodOptions, String(Math.min(1, methods.length - 1)), update);
  const frame = choice('Frame', frames.map(value => ({value: String(value), text: String(value)})), String(frames[0]),
                       update);
  const swap = element('button', '', '⇄');
  swap.type = 'button';
  swap.title = 'Swap left and right';
  swap.setAttribute('aria-label', swap.title);
  swap.addEventListener('click', () => {
    [left.select.value, right.select.value] = [right.select.value, left.select.value];
    update();
  });
  const readout = element('div', 'readout');
  readout.setAttribute('aria-live', 'polite');
  const errorNote = element('small');
  const atlasNote = element('small');

  const main = figure('Pictures', compare, [left.wrap, swap, right.wrap, frame.wrap]);
  main.append(readout);
  const errorFigure = figure(`Error, ${scene.errorMetric}`, errorStage, [errorNote]);
  errorFigure.append(legend(scene.errorFull));
  const atlasFigure = figure('Shading atlas', atlasStage, [atlasNote]);
  const side = element('div', 'side');
  // A run without the metric has no map of it at all.
  if (methods.some(method => method.frames.some(candidate => candidate.error))) side.append(errorFigure);
  side.append(atlasFigure);
  parent.append(main, side);

  function update() {
    const number = Number(frame.select.value);
    const chosen = [methods[left.select.value], methods[right.select.value]];
    chosen.forEach((method, index) => divider.show(index, frameOf(method, number)?.image, method.name));
    readout.textContent = chosen.map(method => [method, perFrame(method, number)])
                              .filter(([, text]) => text)
                              .map(([method, text]) => `${method.name}: ${text}`)
                              .join('   |   ') || ' ';
    // The error and the atlas follow the right side, or the left one where only that has them.
    const [first, second] = chosen;
    const withError = frameOf(second, number)?.error ? second : first;
    const error = frameOf(withError, number)?.error;
    errorStage.show(0, error, `${scene.errorMetric} of ${withError.name}`);
    errorNote.textContent = error ? withError.name : '';
    errorStage.empty.textContent = `No error map: ${second.name} is the reference`;
    const withAtlas = nearestAtlas(second, number) ? second : first;
    const atlas = nearestAtlas(withAtlas, number);
    atlasStage.show(0, atlas?.atlas, `Shading atlas of ${withAtlas.name}`);
    atlasNote.textContent = atlas ? withAtlas.name + (atlas.frame === number ? '' : `, frame ${atlas.frame}`) : '';
    atlasStage.empty.textContent = `${second.name} has no atlas picture`;
  }
  update();
}

function paint() {
  for (const chart of drawnCharts) chart.destroy();
  drawnCharts = [];
  document.querySelectorAll('.figure').forEach(section => {
    const parent = section.querySelector('.charts');
    parent.replaceChildren();
    drawnCharts.push(...drawFigure(parent, kData.figures[section.dataset.figure]));
  });
  document.querySelectorAll('.scene').forEach(section => {
    const methods = kData.scenes[section.dataset.scene].methods;
    const parent = section.querySelector('.charts');
    parent.replaceChildren();
    const curve = curveChart(parent, methods);
    if (curve) drawnCharts.push(curve);
    drawnCharts.push(...drawCharts(parent, methods));
    section.querySelectorAll('.swatch[data-method]').forEach(swatch => {
      swatch.style.background = methodColour(Number(swatch.dataset.method));
    });
  });
}

document.querySelectorAll('.scene').forEach(section => {
  const scene = kData.scenes[section.dataset.scene];
  buildPictures(section.querySelector('.pictures'), scene);
  buildKinds(section.querySelector('.kinds'), scene);
  buildCrops(section.querySelector('.crops'), scene);
});
startTheme(paint);
