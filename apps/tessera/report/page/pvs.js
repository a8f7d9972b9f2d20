// The charts of each scene: coverage and overestimation along the path, a line a way to predict.
'use strict';

const kRunColours = 8;
let drawnCharts = [];

function lines(parent, scene, key, title, unit, scale = 'linear') {
  const options = baseOptions();
  options.scales.x.title = {display: true, text: 'seconds along the path', color: themeColour('--soft')};
  options.scales.x.ticks.maxRotation = 0;
  options.scales.x.ticks.autoSkipPadding = 16;
  options.scales.y.type = scale;
  options.scales.y.ticks.maxTicksLimit = 6;
  options.plugins.tooltip.callbacks.title = items => `${items[0].label} s`;
  options.plugins.tooltip.callbacks.label = item => ` ${item.dataset.label}: ${kLong.format(item.parsed.y)}`;
  const datasets = scene.runs.map((run, index) => ({
    label: run.name,
    data: run[key],
    borderColor: themeColour(`--c${index % kRunColours}`),
    backgroundColor: themeColour(`--c${index % kRunColours}`),
    borderWidth: 1.5,
    pointRadius: scene.times.length <= 24 ? 3 : 0,
  }));
  const {canvas} = chartBox(parent, title, unit);
  return new Chart(canvas, {type: 'line', data: {labels: scene.times, datasets}, options});
}

function paint() {
  for (const chart of drawnCharts) chart.destroy();
  drawnCharts = [];
  document.querySelectorAll('.scene').forEach(section => {
    const scene = kData.scenes[section.dataset.scene];
    const parent = section.querySelector('.charts');
    parent.replaceChildren();
    drawnCharts.push(lines(parent, scene, 'coverage', 'Coverage', '% of the shown pixels'));
    drawnCharts.push(lines(parent, scene, 'missed', 'Missed', 'pixels a view', 'logarithmic'));
    drawnCharts.push(lines(parent, scene, 'overestimation', 'Overestimation', '% of the shown pixels'));
  });
}

startTheme(paint);
