// The front of each scene with the picture of each point, the two questions, and a chart a knob.
'use strict';

const kCosts = {
  ms: {text: 'frame', unit: 'ms', of: p => p.ms},
  samples: {text: 'samples shaded', unit: 'a frame', of: p => p.samples > 0 ? p.samples : null},
  texels: {text: 'atlas texels in use', unit: '', of: p => p.texels > 0 ? p.texels : null},
  bytes: {text: 'GPU memory', unit: 'MiB', of: p => p.bytes > 0 ? p.bytes / 1048576 : null},
};
const kErrors = {
  dssim: {text: 'DSSIM', of: p => Math.max(p.dssim, 1e-6)},  // the axis is logarithmic
  psnr: {text: 'PSNR, dB', of: p => p.psnr, reverse: true},
  flip: {text: 'FLIP', of: p => p.flip === null ? null : Math.max(p.flip, 1e-6)},
};
const kViews = {picture: 'image', error: 'error', reference: null};
let drawnCharts = [];

const methodOf = point => point.config.find(([knob]) => knob === 'method')?.[1] ?? '';

// The quartiles of a point as a thin cross, behind the dots.
const kSpreads = {
  id: 'spreads',
  beforeDatasetsDraw(chart) {
    const {ctx, scales: {x, y}} = chart;
    ctx.save();
    ctx.beginPath();
    ctx.rect(chart.chartArea.left, chart.chartArea.top, chart.chartArea.width, chart.chartArea.height);
    ctx.clip();
    ctx.lineWidth = 1;
    for (const dataset of chart.data.datasets) {
      if (!dataset.spreads) continue;
      ctx.strokeStyle = dataset.spreadColour;
      for (const {point} of dataset.data) {
        if (!point || dataset.hidden) continue;
        const [cost, error] = dataset.spreads;
        const cx = x.getPixelForValue(kCosts[cost].of(point));
        const cy = y.getPixelForValue(kErrors[error].of(point));
        ctx.beginPath();
        if (cost === 'ms') {
          ctx.moveTo(x.getPixelForValue(point.ms_low), cy);
          ctx.lineTo(x.getPixelForValue(point.ms_high), cy);
        }
        if (error === 'dssim') {
          ctx.moveTo(cx, y.getPixelForValue(point.dssim_low));
          ctx.lineTo(cx, y.getPixelForValue(point.dssim_high));
        }
        ctx.stroke();
      }
    }
    ctx.restore();
  },
};

function numbersOf(point) {
  return [
    ['ms', `${kLong.format(+point.ms.toPrecision(4))} (${kLong.format(+point.ms_low.toPrecision(4))}–${
               kLong.format(+point.ms_high.toPrecision(4))}, ${point.runs} runs)`],
    ['DSSIM', kLong.format(+point.dssim.toPrecision(4))],
    ['PSNR', point.psnr === null ? '–' : `${kLong.format(+point.psnr.toPrecision(4))} dB`],
    ['FLIP', point.flip === null ? '–' : kLong.format(+point.flip.toPrecision(4))],
    ['samples', kShort.format(point.samples)],
    ['atlas texels', point.texels > 0 ? kShort.format(point.texels) : '–'],
    ['GPU memory', `${kShort.format(point.bytes / 1048576)} MiB`],
  ];
}

class SceneView {
  constructor(section) {
    this.section = section;
    this.scene = kData.scenes[section.dataset.scene];
    this.cost = 'ms';
    this.error = 'dssim';
    this.view = 'picture';
    this.kept = null;
    this.shownPoint = null;
    this.build();
    const front = this.front();
    this.show(front[Math.floor(front.length / 2)]?.index ?? 0);
  }

  front() {
    return this.scene.fronts[`${this.cost}/${this.error}`].map(([index, told]) => ({index, told}));
  }

  build() {
    const front = this.section.querySelector('.front');
    const axes = element('div', 'axes');
    const choose = (title, options, key) => {
      const label = element('label', '', title);
      const select = element('select');
      for (const name of Object.keys(options)) {
        const option = element('option', '', `${options[name].text} ${options[name].unit ?? ''}`);
        option.value = name;
        select.append(option);
      }
      select.addEventListener('change', () => {
        this[key] = select.value;
        paint();
      });
      label.append(select);
      axes.append(label);
    };
    choose('Cost', kCosts, 'cost');
    choose('Error', kErrors, 'error');
    this.counted = element('span');
    axes.append(this.counted);
    this.plot = element('div', 'plot');
    const shown = element('div', 'shown');
    this.title = element('h3');
    const bar = element('div', 'bar');
    this.buttons = Object.keys(kViews).map(name => {
      const button = element('button', '', name);
      button.type = 'button';
      button.addEventListener('click', () => {
        this.view = name;
        this.refresh();
      });
      bar.append(button);
      return button;
    });
    this.keptNote = element('span', 'readout');
    bar.append(this.keptNote);
    this.image = element('img');
    this.image.style.aspectRatio = `${this.scene.width} / ${this.scene.height}`;
    this.legend = element('div', 'legend');
    const ramp = element('i');
    ramp.style.background = `linear-gradient(90deg, ${kData.stops.join(',')})`;
    this.legend.append(ramp, element('span', '', 'FLIP 0'), element('span', '', kLong.format(this.scene.errorFull / 2)),
                       element('span', '', `${kLong.format(this.scene.errorFull)} and more`));
    this.numbers = element('dl', 'numbers');
    this.config = element('p', 'config');
    shown.append(this.title, bar, this.image, this.legend, this.numbers, this.config);
    front.append(axes, this.plot, shown);
    this.buildQuestions();
    this.section.querySelectorAll('tr[data-point]').forEach(row => {
      row.addEventListener('click', () => this.keep(+row.dataset.point, true));
    });
  }

  // `answer` chooses among the points for the number asked for.
  ask(parent, before, after, step, start, answer) {
    const box = element('div');
    const label = element('label', '', before);
    const input = element('input');
    input.type = 'number';
    input.min = 0;
    input.step = step;
    input.value = start;
    label.append(input, element('span', '', after));
    const text = element('p');
    const reply = () => {
      const index = answer(+input.value);
      text.replaceChildren();
      if (index === null) {
        text.textContent = 'Nothing that was measured.';
        return;
      }
      const point = this.scene.points[index];
      const link = element('a', '', point.name);
      link.tabIndex = 0;
      link.addEventListener('click', () => this.keep(index, true));
      link.addEventListener('keydown', event => event.key === 'Enter' && this.keep(index, true));
      text.append(link, `: ${kLong.format(+point.ms.toPrecision(4))} ms, DSSIM ${kLong.format(+point.dssim.toPrecision(3))}, ${
                            kShort.format(point.samples)} samples.`);
    };
    input.addEventListener('input', reply);
    box.append(label, text);
    parent.append(box);
    reply();
  }

  buildQuestions() {
    const parent = this.section.querySelector('.ask');
    const points = this.scene.points;
    const least = (wanted, key, second) => points.reduce((best, point, index) => {
      if (!wanted(point)) return best;
      if (best === null) return index;
      const a = point[key] - points[best][key];
      return a < 0 || (a === 0 && point[second] < points[best][second]) ? index : best;
    }, null);
    const front = this.scene.fronts['ms/dssim'];
    const middle = points[front[Math.floor(front.length / 2)][0]];
    this.ask(parent, 'I have', 'ms a frame: what is the best I can have?', 1, Math.ceil(middle.ms),
             ms => least(point => point.ms <= ms, 'dssim', 'ms'));
    this.ask(parent, 'I need a DSSIM of', 'or less: what is the cheapest?', 0.001, (Math.ceil(middle.dssim * 1000) / 1000).toString(),
             dssim => least(point => point.dssim <= dssim, 'ms', 'dssim'));
  }

  keep(index, always) {
    this.kept = this.kept === index && !always ? null : index;
    this.show(index);
    if (always) this.section.querySelector('.front').scrollIntoView({block: 'nearest', behavior: 'smooth'});
  }

  point(index) {
    if (this.kept === null && index !== this.shownPoint) this.show(index);
  }

  show(index) {
    this.shownPoint = index;
    this.refresh();
  }

  refresh() {
    const point = this.scene.points[this.shownPoint];
    this.title.textContent = point.name;
    this.keptNote.textContent = this.kept === null ? '' : 'kept: click the dot again to let go';
    this.buttons.forEach(button => button.setAttribute('aria-pressed', button.textContent === this.view));
    const key = kViews[this.view];
    this.image.src = (key ? point[key] : this.scene.reference) ?? '';
    this.image.alt = `${this.view}: ${point.name}`;
    this.legend.style.visibility = this.view === 'error' ? 'visible' : 'hidden';
    this.numbers.replaceChildren(...numbersOf(point).map(([name, value]) => {
      const row = element('div');
      row.append(element('dt', '', name), element('dd', '', value));
      return row;
    }));
    this.config.textContent = point.config.map(([knob, value]) => `${knob} ${value}`).join(' · ');
    this.frontChart?.draw();
  }

  options(costs, errors) {
    const options = baseOptions();
    const soft = themeColour('--soft');
    options.interaction = {mode: 'nearest', intersect: true};
    options.scales.x.type = 'logarithmic';
    options.scales.x.title = {display: true, text: `${kCosts[this.cost].text} ${kCosts[this.cost].unit}`, color: soft};
    options.scales.y.title = {display: true, text: kErrors[this.error].text, color: soft};
    const scale = (axis, values, logarithmic) => {
      // Ends close to the dots leave no empty decades; but what is alike is not to look different.
      let low = Math.min(...values);
      let high = Math.max(...values);
      axis.ticks.autoSkipPadding = 14;
      axis.ticks.maxRotation = 0;
      if (logarithmic) {
        axis.type = 'logarithmic';
        const room = Math.max(Math.pow(high / low, 0.06), Math.sqrt(1.3 * low / high), 1.02);
        axis.min = low / room;
        axis.max = high * room;
      } else {
        const room = Math.max(0.06 * (high - low), 0.5 * (1 - (high - low)));
        axis.min = low - room;
        axis.max = high + room;
      }
      axis.ticks.callback = value => kShort.format(+value.toPrecision(3));
      if (logarithmic)
        axis.afterBuildTicks = built => {
          built.ticks = roundTicks(built.min, built.max).map(value => ({value}));
        };
    };
    scale(options.scales.x, costs, true);
    scale(options.scales.y, errors, !kErrors[this.error].reverse);
    options.scales.y.reverse = Boolean(kErrors[this.error].reverse);
    options.plugins.tooltip.callbacks.title = () => '';
    options.onHover = (event, items, chart) => {
      event.native.target.style.cursor = items.length > 0 ? 'pointer' : 'default';
      const data = items.length > 0 ? chart.data.datasets[items[0].datasetIndex].data[items[0].index] : null;
      if (data) this.point(data.index);
    };
    options.onClick = (event, items, chart) => {
      const data = items.length > 0 ? chart.data.datasets[items[0].datasetIndex].data[items[0].index] : null;
      if (data) this.keep(data.index, false);
    };
    return options;
  }

  at(index) {
    const point = this.scene.points[index];
    return {x: kCosts[this.cost].of(point), y: kErrors[this.error].of(point), point, index};
  }

  paint() {
    const {points, knobs} = this.scene;
    const front = this.front();
    this.counted.textContent =
        `${front.length} of ${points.length} on the front, ${front.filter(({told}) => told).length} of them distinguishable`;
    const all = points.map((point, index) => this.at(index)).filter(({x, y}) => x !== null && y !== null);
    const options = this.options(all.map(({x}) => x), all.map(({y}) => y));
    options.plugins.tooltip.callbacks.label = item => ` ${item.raw.point.name}`;
    const accent = themeColour('--accent');
    const methods = [...new Set(points.map(methodOf))];
    const colour = method => themeColour(`--c${methods.indexOf(method) % 8}`);
    const onFront = new Set(front.map(({index}) => index));
    const datasets = [{
      label: 'Pareto front',
      type: 'line',
      data: front.map(({index}) => this.at(index)),
      spreads: [this.cost, this.error],
      spreadColour: accent,
      borderColor: accent,
      backgroundColor: front.map(({index, told}) => told ? colour(methodOf(points[index])) : themeColour('--card')),
      pointBorderColor: front.map(({index}) => colour(methodOf(points[index]))),
      borderWidth: 1.5,
      stepped: 'before',
      pointRadius: front.map(({told}) => told ? 5.5 : 4.5),
      pointHoverRadius: 8,
      pointBorderWidth: 1.5,
      order: 0,
    }];
    for (const method of methods)
      datasets.push({
        label: method,
        data: all.filter(({index, point}) => methodOf(point) === method && !onFront.has(index)),
        backgroundColor: colour(method) + 'b0',
        borderWidth: 0,
        pointRadius: 4,
        pointHoverRadius: 7,
        order: 1,
      });
    options.plugins.legend.labels.generateLabels = chart =>
        Chart.defaults.plugins.legend.labels.generateLabels(chart).map(
            label => label.datasetIndex === 0 ? {...label, fillStyle: accent, strokeStyle: accent} : label);
    this.plot.replaceChildren();
    const canvas = element('canvas');
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', 'Pareto front of cost and error; the tables hold the numbers');
    this.plot.append(canvas);
    this.frontChart = new Chart(canvas, {type: 'scatter', data: {datasets}, options, plugins: [kSpreads, this.ring()]});
    const charts = [this.frontChart];
    const parent = this.section.querySelector('.knobs');
    parent.replaceChildren();
    for (const knob of knobs) charts.push(this.knobChart(parent, knob));
    return charts.filter(chart => chart !== null);
  }

  // Around the point whose picture is shown.
  ring() {
    return {
      id: 'ring',
      afterDatasetsDraw: chart => {
        const {x, y} = this.at(this.shownPoint);
        if (x === null || y === null) return;
        const {ctx} = chart;
        ctx.save();
        ctx.strokeStyle = themeColour('--ink');
        ctx.lineWidth = 2;
        ctx.beginPath();
        ctx.arc(chart.scales.x.getPixelForValue(x), chart.scales.y.getPixelForValue(y), 10, 0, 2 * Math.PI);
        ctx.stroke();
        ctx.restore();
      },
    };
  }

  knobChart(parent, knob) {
    const curves = knob.curves.map(curve => ({
      ...curve,
      data: curve.points.map((index, i) => ({...this.at(index), value: curve.values[i], told: curve.told[i]}))
                .filter(({x, y}) => x !== null && y !== null),
    })).filter(curve => curve.data.length > 0);
    if (curves.length === 0) return null;
    const dots = curves.flatMap(({data}) => data);
    const options = this.options(dots.map(({x}) => x), dots.map(({y}) => y));
    options.plugins.legend.display = curves.length > 1;
    options.plugins.tooltip.callbacks.label = item =>
        ` ${item.dataset.label ? item.dataset.label + ', ' : ''}${item.raw.value}: ${kLong.format(+item.raw.x.toPrecision(4))}, ${
            kLong.format(+item.raw.y.toPrecision(4))}`;
    const {plot, canvas} = chartBox(parent, knob.label, curves.length > 1 || !curves[0].with ? '' : `in ${curves[0].with}`);
    plot.before(element('p', 'sentence', knob.sentence));
    const datasets = curves.map((curve, i) => ({
      label: curve.with,
      type: 'line',
      data: curve.data,
      spreads: [this.cost, this.error],
      spreadColour: themeColour(`--c${i + 1}`),
      borderColor: themeColour(`--c${i + 1}`) + '70',
      // A line between words would say that they have an order.
      showLine: curve.values.every(value => !isNaN(value)),
      backgroundColor: curve.data.map(({told}) => told ? themeColour(`--c${i + 1}`) : themeColour('--card')),
      pointBorderColor: themeColour(`--c${i + 1}`),
      borderWidth: 1.5,
      pointRadius: curve.data.map(({value}) => value === curve.standard ? 6 : 3.5),
      pointHoverRadius: 8,
    }));
    return new Chart(canvas, {type: 'line', data: {datasets}, options, plugins: [kSpreads, kValueNames]});
  }
}

// The value beside each dot, where there is room.
const kValueNames = {
  id: 'names',
  afterDatasetsDraw(chart) {
    const {ctx, chartArea} = chart;
    ctx.save();
    ctx.font = '11px system-ui, sans-serif';
    ctx.fillStyle = themeColour('--ink');
    const taken = [];
    chart.data.datasets.forEach((dataset, d) => chart.getDatasetMeta(d).data.forEach((dot, i) => {
      const text = String(dataset.data[i].value);
      const width = ctx.measureText(text).width;
      for (const [dx, dy] of [[7, -7], [-7 - width, -7], [7, 14], [-7 - width, 14]]) {
        const box = {left: dot.x + dx - 1, right: dot.x + dx + width + 1, top: dot.y + dy - 10, bottom: dot.y + dy + 2};
        if (box.left < chartArea.left || box.right > chartArea.right || box.top < chartArea.top - 8) continue;
        if (taken.some(b => b.left < box.right && box.left < b.right && b.top < box.bottom && box.top < b.bottom)) continue;
        taken.push(box);
        ctx.fillText(text, dot.x + dx, dot.y + dy);
        break;
      }
    }));
    ctx.restore();
  },
};

function roundTicks(min, max) {
  const ticks = [];
  const steps = max / min > 8 ? [1, 2, 5] : max / min > 2.5 ? [1, 1.5, 2, 3, 4, 5, 7] : null;
  if (steps === null) {
    const rough = (max - min) / 6;
    const power = Math.pow(10, Math.floor(Math.log10(rough)));
    const step = [1, 2, 5, 10].map(s => s * power).find(s => s >= rough);
    for (let value = Math.ceil(min / step) * step; value <= max; value += step) ticks.push(value);
    return ticks;
  }
  for (let decade = Math.pow(10, Math.floor(Math.log10(min))); decade <= max; decade *= 10)
    for (const step of steps)
      if (step * decade >= min && step * decade <= max) ticks.push(step * decade);
  return ticks;
}

const kScenes = [...document.querySelectorAll('.scene')].map(section => new SceneView(section));

function paint() {
  for (const chart of drawnCharts) chart.destroy();
  drawnCharts = kScenes.flatMap(scene => scene.paint());
}

startTheme(paint);
