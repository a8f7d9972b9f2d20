// Pictures that can be zoomed and moved, and two of them under a divider.
'use strict';

const kMaxZoom = 32;

// Which part of a picture is in sight: `zoom` >= 1 and the middle in 0..1 of the picture. Stages may share one.
class View {
  constructor() {
    this.zoom = 1;
    this.x = 0.5;
    this.y = 0.5;
    this.watchers = [];
  }

  set(zoom, x, y) {
    this.zoom = Math.min(kMaxZoom, Math.max(1, zoom));
    const half = 0.5 / this.zoom;  // the picture always covers the stage
    this.x = Math.min(1 - half, Math.max(half, x));
    this.y = Math.min(1 - half, Math.max(half, y));
    for (const watcher of this.watchers) watcher();
  }

  // Zooms so that the point at (u, v) of the stage, 0..1, stays where it is.
  zoomAt(factor, u = 0.5, v = 0.5) {
    const zoom = Math.min(kMaxZoom, Math.max(1, this.zoom * factor));
    const keep = 1 / this.zoom - 1 / zoom;
    this.set(zoom, this.x + (u - 0.5) * keep, this.y + (v - 0.5) * keep);
  }

  pan(du, dv) {
    this.set(this.zoom, this.x + du / this.zoom, this.y + dv / this.zoom);
  }
}

// A box with the pictures' aspect ratio and one or more layers, all placed by the same view.
class Stage {
  constructor(view, width, height) {
    this.view = view;
    this.root = element('div', 'stage');
    this.root.tabIndex = 0;
    this.images = [];
    this.empty = element('div', 'empty', 'No picture');
    this.root.append(this.empty);
    this.aspect(width, height);
    this.split = null;  // set by Divider: (u) => void while the divider is dragged
    this.nearSplit = () => false;
    view.watchers.push(() => this.place());
    new ResizeObserver(() => this.place()).observe(this.root);
    this.listen();
  }

  aspect(width, height) {
    this.root.style.aspectRatio = `${Math.max(1, width)} / ${Math.max(1, height)}`;
  }

  addLayer() {
    const layer = element('div', 'layer');
    const image = element('img');
    image.alt = '';
    image.draggable = false;
    image.addEventListener('load', () => this.place());
    layer.append(image);
    this.root.append(layer);
    this.images.push(image);
    return layer;
  }

  show(index, source, description) {
    const image = this.images[index];
    image.hidden = !source;
    if (source && image.getAttribute('src') !== source) image.src = source;
    image.alt = description;
    this.empty.hidden = this.images.some(other => !other.hidden);
  }

  place() {
    const {zoom, x, y} = this.view;
    const width = this.root.clientWidth;
    const height = this.root.clientHeight;
    this.root.classList.toggle('zoomed', zoom > 1);
    for (const image of this.images) {
      image.style.transform =
          `translate(${width * (0.5 - x * zoom)}px, ${height * (0.5 - y * zoom)}px) scale(${zoom})`;
      const pixels = image.naturalWidth > 0 ? width * zoom * devicePixelRatio / image.naturalWidth : 1;
      image.classList.toggle('sharp', pixels >= 1.5);
    }
  }

  at(event) {
    const box = this.root.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  listen() {
    this.root.addEventListener('wheel', event => {
      if (!event.ctrlKey && !event.metaKey) return;  // the page scrolls
      event.preventDefault();
      this.view.zoomAt(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0025)), ...this.at(event));
    }, {passive: false});
    this.root.addEventListener('dblclick', event => this.view.zoomAt(event.shiftKey ? 0.5 : 2, ...this.at(event)));
    this.root.addEventListener('pointerdown', event => this.drag(event));
    this.root.addEventListener('keydown', event => this.key(event));
  }

  drag(event) {
    if (event.button !== 0) return;
    const splitting = this.split && (this.view.zoom === 1 || this.nearSplit(this.at(event)[0]));
    if (!splitting && this.view.zoom === 1) return;
    this.root.setPointerCapture(event.pointerId);
    this.root.classList.add('moving');
    let last = this.at(event);
    if (splitting) this.split(last[0]);
    const move = moved => {
      const now = this.at(moved);
      if (splitting) this.split(now[0]);
      else this.view.pan(last[0] - now[0], last[1] - now[1]);
      last = now;
    };
    const end = () => {
      this.root.removeEventListener('pointermove', move);
      this.root.classList.remove('moving');
    };
    this.root.addEventListener('pointermove', move);
    this.root.addEventListener('pointerup', end, {once: true});
    this.root.addEventListener('pointercancel', end, {once: true});
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const pan = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[event.key];
    if (event.key === '+' || event.key === '=') this.view.zoomAt(2);
    else if (event.key === '-') this.view.zoomAt(0.5);
    else if (event.key === '0') this.view.set(1, 0.5, 0.5);
    else if (pan && this.view.zoom > 1 && (event.shiftKey || !this.split)) this.view.pan(...pan);
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }
}

// Buttons that work a view; 1:1 shows one pixel of the picture as one pixel of the screen.
function zoomButtons(stage) {
  const view = stage.view;
  const group = element('span', 'zoom push');
  const button = (text, title, action) => {
    const node = element('button', '', text);
    node.type = 'button';
    node.title = title;
    node.setAttribute('aria-label', title);
    node.addEventListener('click', action);
    group.append(node);
  };
  const output = element('output');
  button('−', 'Zoom out', () => view.zoomAt(0.5));
  group.append(output);
  button('+', 'Zoom in', () => view.zoomAt(2));
  button('1:1', 'One picture pixel to one screen pixel', () => {
    const width = Math.max(...stage.images.map(image => image.naturalWidth));
    view.set(width / (stage.root.clientWidth * devicePixelRatio), view.x, view.y);
  });
  button('Fit', 'The whole picture', () => view.set(1, 0.5, 0.5));
  const show = () => { output.textContent = `${view.zoom.toFixed(view.zoom < 10 ? 1 : 0)} ×`; };
  view.watchers.push(show);
  show();
  return group;
}

// A stage of two layers: the second one is seen to the right of the divider.
class Divider {
  constructor(stage) {
    this.stage = stage;
    stage.addLayer();
    this.right = stage.addLayer();
    this.tags = [element('span', 'tag left'), element('span', 'tag right')];
    this.line = element('div', 'divider');
    stage.root.append(this.line, ...this.tags);
    stage.root.classList.add('split');
    stage.root.setAttribute('role', 'slider');
    stage.root.setAttribute('aria-valuemin', '0');
    stage.root.setAttribute('aria-valuemax', '100');
    stage.split = u => this.set(u);
    stage.nearSplit = u => Math.abs(u - this.position) * stage.root.clientWidth < 24;
    stage.root.addEventListener('keydown', event => this.key(event));
    this.set(0.5);
  }

  set(position) {
    this.position = Math.min(1, Math.max(0, position));
    const percent = this.position * 100;
    this.line.style.left = `${percent}%`;
    this.right.style.clipPath = `inset(0 0 0 ${percent}%)`;
    this.stage.root.setAttribute('aria-valuenow', percent.toFixed(0));
    this.tags[0].style.opacity = percent > 8 ? 1 : 0;
    this.tags[1].style.opacity = percent < 92 ? 1 : 0;
  }

  show(side, source, label) {
    this.stage.show(side, source, label);
    this.tags[side].textContent = label;
    const [left, right] = this.tags.map(tag => tag.textContent);
    this.stage.root.setAttribute('aria-label', `Divider between ${left} on the left and ${right} on the right`);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    const step = {ArrowLeft: -0.01, ArrowRight: 0.01, ArrowDown: -0.01, ArrowUp: 0.01,
                  PageDown: -0.1, PageUp: 0.1}[event.key];
    if (step !== undefined) this.set(this.position + step);
    else if (event.key === 'Home') this.set(0);
    else if (event.key === 'End') this.set(1);
    else return;
    event.preventDefault();
  }
}
