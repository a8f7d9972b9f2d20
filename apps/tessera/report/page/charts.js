// The charts of one scene, drawn by Chart.js in the colours of the page's theme.
'use strict';

const kMethodColours = 8;
const kPassColours = ['#4e79a7', '#f28e2b', '#59a14f', '#e15759', '#76b7b2', '#edc948', '#b07aa1', '#ff9da7',
                      '#9c755f', '#8a949e'];
const kSeries = [
  {key: 'frameMs', title: 'Frame time', unit: 'ms', zero: true},
  {key: 'mssim', title: 'MSSIM against forward', unit: '1 is equal', zero: false},
  {key: 'flip', title: 'FLIP against forward', unit: '0 is equal', zero: true},
  {key: 'samplesShaded', title: 'Samples shaded', unit: 'samples', zero: true},
  {key: 'atlasTexelsUsed', title: 'Atlas texels used', unit: 'texels', zero: true},
  {key: 'bias', title: 'Level bias in force', unit: 'levels', zero: false},
];

function methodColour(index) {
  return themeColour(`--c${index % kMethodColours}`);
}

function seriesChart(parent, series, methods) {
  const used = methods.map((method, index) => ({method, index}))
                   .filter(({method}) => method.series[series.key].some(value => value !== null));
  if (used.length === 0) return null;
  const length = Math.max(...used.map(({method}) => method.series[series.key].length));
  const options = baseOptions();
  options.scales.x.title = {display: true, text: 'frame', color: themeColour('--soft')};
  options.scales.x.ticks.maxRotation = 0;
  options.scales.x.ticks.autoSkipPadding = 16;
  options.scales.y.beginAtZero = series.zero;
  options.scales.y.grace = '5%';
  options.scales.y.ticks.maxTicksLimit = 6;
  options.scales.y.ticks.callback = value => kShort.format(value);
  options.plugins.tooltip.callbacks.title = items => `frame ${items[0].label}`;
  options.plugins.tooltip.callbacks.label = item => ` ${item.dataset.label}: ${kLong.format(item.parsed.y)}`;
  const datasets = used.map(({method, index}) => ({
    label: method.name,
    data: method.series[series.key],
    borderColor: methodColour(index),
    backgroundColor: methodColour(index),
    borderWidth: 2,
    borderDash: index === 0 ? [5, 4] : [],
    pointRadius: length <= 24 ? 3 : 0,
    pointHitRadius: 8,
  }));
  const {canvas} = chartBox(parent, series.title, series.unit);
  return new Chart(canvas, {type: 'line', data: {labels: [...Array(length).keys()], datasets}, options});
}

function passChart(parent, methods) {
  const names = [...new Set(methods.flatMap(method => method.passes.map(pass => pass.name)))];
  if (names.length === 0) return null;
  const options = baseOptions();
  options.indexAxis = 'y';
  options.scales.x.stacked = true;
  options.scales.y.stacked = true;
  options.scales.y.grid = {display: false};
  options.interaction = {mode: 'nearest', intersect: true};
  options.plugins.tooltip.callbacks.label =
      item => ` ${item.dataset.label}: ${kLong.format(item.parsed.x)} ms`;
  const datasets = names.map((name, index) => ({
    label: name,
    data: methods.map(method => method.passes.find(pass => pass.name === name)?.median ?? null),
    backgroundColor: kPassColours[index % kPassColours.length],
    borderColor: themeColour('--card'),
    borderWidth: {right: 1},
    maxBarThickness: 34,
  }));
  const {plot, canvas} = chartBox(parent, 'Where the time goes', 'ms, median of each pass');
  plot.style.height = `${Math.max(220, 110 + 46 * methods.length)}px`;
  return new Chart(canvas, {type: 'bar', data: {labels: methods.map(method => method.name), datasets}, options});
}

function drawCharts(parent, methods) {
  const charts = [passChart(parent, methods), ...kSeries.map(series => seriesChart(parent, series, methods))];
  return charts.filter(chart => chart !== null);
}

// Bars of one number: a group a scene, a colour a method.
function barChart(parent, title, unit, figure, key, share) {
  const labels = [...new Set(figure.scenes.flatMap(scene => scene.bars.map(bar => bar.label)))];
  const valueOf = (scene, label) => scene.bars.find(bar => bar.label === label)?.[key] ?? null;
  if (!figure.scenes.some(scene => scene.bars.some(bar => bar[key] !== null))) return null;
  const format = value => share ? `${kLong.format(+(100 * value).toPrecision(4))} %` : kLong.format(value);
  const options = baseOptions();
  options.interaction = {mode: 'nearest', intersect: true};
  options.scales.x.grid = {display: false};
  options.scales.y.ticks.callback = format;
  options.scales.y.beginAtZero = share;
  // Qualities crowd together near 1: the axis starts below the least of them, at a round number.
  const least = Math.min(...figure.scenes.flatMap(scene => scene.bars.map(bar => bar[key] ?? 1)));
  if (!share) {
    options.scales.y.min = Math.max(0, Math.floor(10 * least - 0.5) / 10);
    options.scales.y.max = 1;
  }
  options.plugins.tooltip.callbacks.label = item => ` ${item.dataset.label}: ${format(item.parsed.y)}`;
  const datasets = labels.map((label, index) => ({
    label,
    data: figure.scenes.map(scene => valueOf(scene, label)),
    backgroundColor: methodColour(index),
    maxBarThickness: 34,
  }));
  const {plot, canvas} = chartBox(parent, title, unit);
  plot.style.height = '300px';
  const names = figure.scenes.map(scene => scene.file.replace(/^.*[\\/]/, ''));
  return new Chart(canvas, {type: 'bar', data: {labels: names, datasets}, options});
}

function drawFigure(parent, figure) {
  return [
    barChart(parent, 'Samples shaded', 'of the pixels of one picture', figure, 'shaded_per_target_pixel', true),
    barChart(parent, 'MSSIM against forward', '1 is equal', figure, 'mssim', false),
    barChart(parent, 'MSSIM of the right eye alone', '1 is equal', figure, 'mssim_right_eye', false),
    barChart(parent, 'MSSIM by acuity', '1 is equal', figure, 'mssim_acuity', false),
  ].filter(chart => chart !== null);
}
