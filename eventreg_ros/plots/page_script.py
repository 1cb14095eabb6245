# SPDX-License-Identifier: Apache-2.0
"""What pages do: charts of one span zoom and pan together, by buttons, keys, wheel and pointer."""

from __future__ import annotations

SCRIPT = """
'use strict';
const ACROSS = 100000, LEAST = 1 / 2000, views = new Map();
const charts = [...document.querySelectorAll('.chart')].map((figure) => {
  const [start, stop] = figure.dataset.span.split(' ').map(Number);
  views.set(figure.dataset.span, [0, 1]);
  return { figure, start, length: stop - start || 1, key: figure.dataset.span };
});
const round = (least) => {
  const size = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((m) => m * size).find((step) => step >= least * (1 - 1e-9));
};
const label = (value, step) => {
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return (Math.abs(value) >= 1e6 ? String(value) : value.toFixed(digits)).replace('-', '\\u2212');
};
const draw = (chart) => {
  const [a, b] = views.get(chart.key), part = b - a, { figure } = chart;
  const at = (x) => `${(100 * (x - a)) / part}%`;
  const width = figure.querySelector('.time').getBoundingClientRect().width;
  const from = chart.start + a * chart.length, to = chart.start + b * chart.length;
  const step = round((to - from) / Math.max(2, Math.min(10, width / 60)));
  const ticks = [];
  for (let n = Math.ceil(from / step - 1e-9); n * step <= to + 1e-9 * step; n += 1) {
    ticks.push([at((n * step - chart.start) / chart.length), label(n * step, step)]);
  }
  figure.querySelector('.ticks').innerHTML = ticks
    .map(([x, words]) => `<text x="${x}" y="15" text-anchor="middle">${words}</text>`).join('');
  const lines = ticks.map(([x]) => `<line x1="${x}" x2="${x}" y2="100%"/>`).join('');
  figure.querySelectorAll('.grid').forEach((grid) => { grid.innerHTML = lines; });
  figure.querySelectorAll('.data').forEach((data) => {
    const height = data.getAttribute('viewBox').split(' ')[3];
    data.setAttribute('viewBox', `${ACROSS * a} 0 ${ACROSS * part} ${height}`);
  });
  figure.querySelectorAll('[data-a]').forEach((element) => {
    const { a: left, b: right } = element.dataset;
    element.setAttribute('x', at(left));
    if (right) element.setAttribute('width', `${(100 * (right - left)) / part}%`);
  });
  figure.querySelectorAll('.points').forEach((points) => {
    points.classList.toggle('sparse', points.dataset.count * part < width / 5);
  });
  const exact = (t) => Number(t.toFixed(Math.max(0, 2 - Math.floor(Math.log10(step)))));
  figure.querySelector('output').textContent = part < 1 ? `t = ${exact(from)} to ${exact(to)}` : '';
};
const show = (chart, a, part) => {
  const size = Math.min(1, Math.max(LEAST, part)), left = Math.min(1 - size, Math.max(0, a));
  views.set(chart.key, [left, left + size]);
  charts.filter(({ key }) => key === chart.key).forEach(draw);
};
const zoom = (chart, factor, centre = 0.5) => {
  const [a, b] = views.get(chart.key), size = Math.min(1, Math.max(LEAST, (b - a) * factor));
  show(chart, a + (b - a - size) * centre, size);
};
const move = (chart, share) => {
  const [a, b] = views.get(chart.key);
  show(chart, a + (b - a) * share, b - a);
};
const deeds = {
  in: (chart) => zoom(chart, 0.5), out: (chart) => zoom(chart, 2),
  back: (chart) => move(chart, -0.25), on: (chart) => move(chart, 0.25),
  all: (chart) => show(chart, 0, 1),
};
const keys = {
  '+': 'in', '=': 'in', '-': 'out', _: 'out', ArrowLeft: 'back', ArrowRight: 'on', 0: 'all',
};
charts.forEach((chart) => {
  const view = chart.figure.querySelector('.view'), tools = chart.figure.querySelector('.tools');
  const place = (event) => {
    const box = chart.figure.querySelector('.area').getBoundingClientRect();
    return Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
  };
  let held = null;
  tools.hidden = false;
  tools.addEventListener('click', (event) => {
    const deed = deeds[event.target.dataset.do];
    if (deed) deed(chart);
  });
  chart.figure.addEventListener('keydown', (event) => {
    const deed = deeds[keys[event.key]];
    if (!deed || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    deed(chart);
  });
  view.addEventListener('wheel', (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(chart, event.deltaY > 0 ? 1.25 : 0.8, place(event));
  }, { passive: false });
  view.addEventListener('dblclick', (event) => {
    zoom(chart, event.shiftKey ? 2 : 0.5, place(event));
  });
  view.addEventListener('pointerdown', (event) => {
    const [a, b] = views.get(chart.key);
    if (event.button === 0 && b - a < 1) held = { a, part: b - a, from: place(event) };
  });
  view.addEventListener('pointermove', (event) => {
    if (!held || !event.buttons) { held = null; return; }
    show(chart, held.a + (held.from - place(event)) * held.part, held.part);
  });
  draw(chart);
});
document.querySelectorAll('.hint').forEach((hint) => { hint.hidden = false; });
window.addEventListener('resize', () => charts.forEach(draw));
"""
"""Without it the page shows the same charts, whole. It reads nothing but the page."""
