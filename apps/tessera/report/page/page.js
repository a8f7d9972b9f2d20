// What the pages share: their data, elements, the theme, and how charts look.
'use strict';

const kData = JSON.parse(document.getElementById('data').textContent);

function element(tag, className, text) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text !== undefined) node.textContent = text;
  return node;
}

function themeColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function chartBox(parent, title, unit) {
  const box = element('div', 'chart');
  const heading = element('h3', '', title + ' ');
  heading.append(element('small', '', unit));
  const plot = element('div', 'plot');
  const canvas = element('canvas');
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `${title}, ${unit}; the table holds the numbers`);
  plot.append(canvas);
  box.append(heading, plot);
  parent.append(box);
  return {plot, canvas};
}

const kShort = new Intl.NumberFormat('en', {notation: 'compact', maximumSignificantDigits: 4});
const kLong = new Intl.NumberFormat('en', {maximumSignificantDigits: 6});

// A dashed line's square in the legend would be dashed too.
function solidLabels(chart) {
  return Chart.defaults.plugins.legend.labels.generateLabels(chart).map(label => ({...label, lineDash: []}));
}

function baseOptions() {
  const soft = themeColour('--soft');
  const grid = {color: themeColour('--line'), borderColor: themeColour('--line')};
  return {
    animation: false,
    responsive: true,
    maintainAspectRatio: false,
    interaction: {mode: 'index', intersect: false},
    plugins: {
      legend: {labels: {color: soft, boxWidth: 12, boxHeight: 12, padding: 10, generateLabels: solidLabels}, position: 'bottom'},
      tooltip: {callbacks: {}},
    },
    scales: {x: {ticks: {color: soft}, grid}, y: {ticks: {color: soft}, grid}},
  };
}

// `paint` draws what takes the theme's colours: now, and whenever the theme changes.
function startTheme(paint) {
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const set = theme => {
    document.documentElement.dataset.theme = theme;
    paint();
  };
  const follow = () => set(dark.matches ? 'dark' : 'light');
  follow();
  dark.addEventListener('change', follow);
  document.getElementById('theme').addEventListener('click', () => {
    set(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark');
  });
  addEventListener('beforeprint', () => set('light'));
}
