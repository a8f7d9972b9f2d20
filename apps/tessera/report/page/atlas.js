// What atlases hold: their texels by kind, the places where most is slanted, and samples against quality.
'use strict';

function share(value, whole) {
  return `${(100 * value / whole).toFixed(1)} %`;
}

function buildKinds(parent, scene) {
  const methods = scene.methods.filter(method => method.kindPicture);
  if (methods.length === 0) {
    parent.remove();
    return;
  }
  parent.append(element('h3', '', 'Atlases: the fullest part, coloured by kind of sample'));
  for (const method of methods) {
    const stage = new Stage(new View(), 2, 1);
    const note = element('small');
    stage.addLayer();
    stage.images[0].addEventListener('load', () => {
      const image = stage.images[0];
      stage.aspect(image.naturalWidth, image.naturalHeight);
      note.textContent = `${image.naturalWidth} × ${image.naturalHeight} texels`;
    });
    stage.show(0, method.kindPicture, `Atlas of ${method.name}, coloured by kind of sample`);
    const node = figure(method.name, stage, [note]);
    const key = element('div', 'key');
    const all = method.kinds.reduce((sum, kind) => sum + kind.samples, 0);
    for (const kind of method.kinds.filter(kind => kind.samples > 0)) {
      const entry = element('span');
      const swatch = element('i', 'swatch');
      swatch.style.background = kind.color;
      entry.append(swatch, `${kind.name} ${share(kind.samples, all)}`);
      key.append(entry);
    }
    node.append(key);
    parent.append(node);
  }
}

const kCropGap = 8;

function buildCrops(parent, scene) {
  if (scene.crops.length === 0) {
    parent.remove();
    return;
  }
  parent.append(element('h3', '', 'Where most is slanted'));
  for (const crop of scene.crops) {
    // As large as lets all stand in one row, but whole pixels; twice as large at least.
    const most = (parent.clientWidth + kCropGap) / crop.pictures.length - kCropGap;
    const zoom = Math.min(4, Math.max(2, Math.floor(most / crop.width)));
    const box = element('div', 'crop');
    box.append(element('p', 'facts', `Frame ${crop.frame}, ${crop.width} × ${crop.height} pixels at ${crop.x}, ${crop.y}, ` +
        `${zoom} times as large: ${share(crop.slantedShare, 1)} of them show slanted triangles. MSSIM is of the crop alone.`));
    const row = element('div', 'row');
    const best = Math.max(...crop.pictures.slice(1).map(picture => picture.mssim));
    crop.pictures.forEach((picture, index) => {
      const node = element('figure');
      const image = element('img');
      image.src = picture.image;
      image.width = crop.width * zoom;
      image.height = crop.height * zoom;
      image.style.height = 'auto';
      image.alt = `${picture.method}, enlarged`;
      const caption = element('figcaption', '', `${picture.method} `);
      if (index > 0)
        caption.append(element('span', picture.mssim === best ? 'best' : '', `MSSIM ${picture.mssim.toFixed(4)}`));
      node.append(image, caption);
      row.append(node);
    });
    box.append(row);
    parent.append(box);
  }
}

function curveChart(parent, methods) {
  const used = methods.map((method, index) => ({method, index})).filter(({method}) => method.curve.length > 0);
  if (used.length === 0) return null;
  const options = baseOptions();
  options.interaction = {mode: 'nearest', intersect: false};
  options.scales.x.type = 'logarithmic';
  options.scales.x.title = {display: true, text: 'samples a pixel', color: themeColour('--soft')};
  options.scales.x.ticks.callback = value => kShort.format(value);
  const costs = used.flatMap(({method}) => method.curve.map(point => point.x));
  options.scales.x.min = 0.85 * Math.min(...costs);
  options.scales.x.max = 1.15 * Math.max(...costs);
  // A tick at each of 1, 2, 5 of a power of ten: what Chart.js leaves of its own is uneven.
  options.scales.x.afterBuildTicks = axis => {
    axis.ticks = [-3, -2, -1, 0, 1, 2].flatMap(power => [1, 2, 3, 5, 7].map(digit => digit * 10 ** power))
                     .filter(value => value >= axis.min && value <= axis.max).map(value => ({value}));
  };
  options.scales.y.grace = '5%';
  options.plugins.tooltip.callbacks.title = () => '';
  options.plugins.tooltip.callbacks.label = item => ` ${item.dataset.label}, bias ${kLong.format(item.raw.bias)}: ` +
      `${item.parsed.x.toFixed(2)} samples a pixel, MSSIM ${item.parsed.y.toFixed(4)}`;
  const datasets = used.map(({method, index}) => ({
    label: method.name,
    data: [...method.curve].sort((a, b) => a.x - b.x),
    showLine: true,
    borderColor: methodColour(index),
    backgroundColor: methodColour(index),
    borderWidth: 2,
    pointRadius: 4,
  }));
  const {plot, canvas} = chartBox(parent, 'Samples against quality', 'MSSIM, a point a bias');
  plot.parentElement.classList.add('wide');
  return new Chart(canvas, {type: 'scatter', data: {datasets}, options});
}
