// The charts of each scene: what the atlas holds over the frames, by allocator; and bias and time of all of them.
'use strict';

const kAreas = [
  {label: 'live', colour: '#3f9e5b'},
  {label: 'end of superblocks', colour: '#4378c6'},
  {label: 'on stacks', colour: '#cf4a45'},
  {label: 'inaccessible', colour: '#ec902f'},
  {label: 'free', colour: '#8d6cc0'},
];
const kRunColours = 8;
let drawnCharts = [];

function frameOptions(length) {
  const options = baseOptions();
  options.scales.x.title = {display: true, text: 'frame', color: themeColour('--soft')};
  options.scales.x.ticks.maxRotation = 0;
  options.scales.x.ticks.autoSkipPadding = 16;
  options.scales.y.ticks.maxTicksLimit = 6;
  options.scales.y.ticks.callback = value => kShort.format(value);
  options.plugins.tooltip.callbacks.title = items => `frame ${items[0].label}`;
  options.plugins.tooltip.callbacks.label = item => ` ${item.dataset.label}: ${kLong.format(item.parsed.y)}`;
  return {options, labels: [...Array(length).keys()]};
}

function areaChart(parent, run, megapixels) {
  const {options, labels} = frameOptions(run.areas[0].length);
  options.scales.y.stacked = true;
  options.scales.y.min = 0;
  options.scales.y.max = megapixels;
  const datasets = kAreas.map((area, index) => ({
    label: area.label,
    data: run.areas[index],
    fill: index === 0 ? 'origin' : '-1',
    backgroundColor: area.colour,
    borderColor: area.colour,
    borderWidth: 0,
    pointRadius: 0,
  }));
  const {canvas} = chartBox(parent, `${run.name} (${run.oomFrames}, ${run.resets})`, '2^20 texels');
  return new Chart(canvas, {type: 'line', data: {labels, datasets}, options});
}

function linesChart(parent, runs, key, title, unit, scale) {
  const {options, labels} = frameOptions(runs[0][key].length);
  options.scales.y.type = scale;
  const datasets = runs.map((run, index) => ({
    label: run.name,
    data: run[key],
    borderColor: themeColour(`--c${index % kRunColours}`),
    backgroundColor: themeColour(`--c${index % kRunColours}`),
    borderWidth: 1.5,
    pointRadius: 0,
  }));
  const {canvas} = chartBox(parent, title, unit);
  return new Chart(canvas, {type: 'line', data: {labels, datasets}, options});
}

function paint() {
  for (const chart of drawnCharts) chart.destroy();
  drawnCharts = [];
  document.querySelectorAll('.scene').forEach(section => {
    const {megapixels, runs} = kData.scenes[section.dataset.scene];
    const parent = section.querySelector('.charts');
    parent.replaceChildren();
    drawnCharts.push(...runs.map(run => areaChart(parent, run, megapixels)));
    drawnCharts.push(linesChart(parent, runs, 'bias', 'Bias in force', 'log2 of area', 'linear'));
    drawnCharts.push(linesChart(parent, runs, 'ms', 'Level selection and allocation', 'ms', 'logarithmic'));
  });
}

startTheme(paint);
