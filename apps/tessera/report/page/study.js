// The charts of each scene, and its videos, which run together.
'use strict';

const kAtlasColours = ['--c1', '--c3', '--c6', '--c4'];
const kWarpColours = ['--c2', '--c5', '--c7'];
const kStageColours = ['#4e79a7', '#f28e2b', '#59a14f', '#e15759', '#76b7b2', '#edc948', '#b07aa1', '#ff9da7'];
let drawnCharts = [];

function lines(parent, scene, key, title, unit, axis, logarithmic) {
  const used = scene.methods.filter(method => method[key].length > 0);
  if (used.length === 0) return;
  const options = baseOptions();
  options.scales.x.type = logarithmic ? 'logarithmic' : 'linear';
  options.scales.x.title = {display: true, text: axis, color: themeColour('--soft')};
  // A tick at each value that was measured, and nowhere else.
  const values = used[0][key].map(point => point.x);
  options.scales.x.afterBuildTicks = scale => { scale.ticks = values.map(value => ({value})); };
  options.scales.x.ticks.callback = value => kShort.format(value);
  options.scales.x.ticks.autoSkip = false;
  // One value has no extent.
  if (values.length > 1) {
    options.scales.x.min = values[0];
    options.scales.x.max = values[values.length - 1];
  }
  options.scales.y.ticks.maxTicksLimit = 7;
  options.scales.y.grace = '4%';
  options.plugins.tooltip.callbacks.title = items => `${kShort.format(items[0].parsed.x)} ${axis.split(', ').pop()}`;
  options.plugins.tooltip.callbacks.label = item => ` ${item.dataset.label}: ${item.parsed.y.toFixed(4)}`;
  options.plugins.tooltip.itemSort = (a, b) => b.parsed.y - a.parsed.y;
  let atlases = 0;
  let warps = 0;
  const datasets = used.map(method => {
    const colour = themeColour(method.atlas ? kAtlasColours[atlases++ % kAtlasColours.length]
                                            : kWarpColours[warps++ % kWarpColours.length]);
    return {
      label: method.name,
      data: method[key],
      borderColor: colour,
      backgroundColor: colour,
      borderWidth: 2,
      borderDash: method.atlas ? [] : [6, 4],
      pointRadius: 3,
      pointStyle: method.atlas ? 'circle' : 'rect',
    };
  });
  const {canvas} = chartBox(parent, title, unit);
  drawnCharts.push(new Chart(canvas, {type: 'line', data: {datasets}, options}));
}

function stages(parent, list, title, unit) {
  if (list.length === 0) return;
  const options = baseOptions();
  options.indexAxis = 'y';
  options.scales.x.stacked = true;
  options.scales.y.stacked = true;
  options.scales.y.display = false;
  options.interaction = {mode: 'nearest', intersect: true};
  options.plugins.tooltip.callbacks.label = item => ` ${item.dataset.label}: ${kLong.format(item.parsed.x)} ms`;
  const datasets = list.map((stage, index) => ({
    label: `${stage.name} ${kShort.format(stage.ms)}`,
    data: [stage.ms],
    backgroundColor: kStageColours[index % kStageColours.length],
    borderColor: themeColour('--card'),
    borderWidth: {right: 1},
    maxBarThickness: 48,
  }));
  const {canvas} = chartBox(parent, title, unit);
  drawnCharts.push(new Chart(canvas, {type: 'bar', data: {labels: [''], datasets}, options}));
}

function paint() {
  for (const chart of drawnCharts) chart.destroy();
  drawnCharts = [];
  document.querySelectorAll('.scene').forEach(section => {
    const scene = kData.scenes[section.dataset.scene];
    const parent = section.querySelector('.figures');
    parent.replaceChildren();
    lines(parent, scene, 'latency', 'Latency', `MSSIM at ${kData.serverHz} Hz, ${kData.mbit} Mbit/s`,
          'network latency, ms', false);
    lines(parent, scene, 'rate', 'Server rate', `MSSIM at 0 ms, ${kData.mbit} Mbit/s`, 'server frames a second, Hz', true);
    lines(parent, scene, 'bitrate', 'Bitrate', `MSSIM at 0 ms, ${kData.serverHz} Hz`, 'video, Mbit/s', true);
    const line = section.querySelector('.timeline');
    if (line === null) return;
    line.replaceChildren();
    stages(line, scene.viewer, 'As the viewer measures it', 'ms; “server” is both ways of the network and a server’s frame');
    stages(line, scene.server, 'A server’s frame', 'ms');
  });
}

// One button for all videos of a scene; they start together, and again together after each round.
function startVideos(section) {
  const button = section.querySelector('.play');
  if (button === null) return;
  const videos = [...section.querySelectorAll('video')];
  const speed = section.querySelector('.speed');
  const set = () => videos.forEach(video => { video.playbackRate = Number(speed.value); });
  speed.addEventListener('change', set);
  button.addEventListener('click', () => {
    const playing = button.textContent === 'Pause';
    button.textContent = playing ? 'Play' : 'Pause';
    set();
    if (playing) videos.forEach(video => video.pause());
    else {
      videos.forEach(video => { video.currentTime = videos[0].currentTime; });
      videos.forEach(video => video.play());
    }
  });
}

document.querySelectorAll('.scene').forEach(startVideos);
startTheme(paint);
