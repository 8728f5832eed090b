'use strict';
/* Builds the page from the numbers in #data: selectors, plots, a table under each, pictures. */
(function () {
const data = JSON.parse(document.getElementById('data').textContent);
const pictures = JSON.parse(document.getElementById('pictures').textContent);
const results = data.results, main = document.getElementById('main');
const dark = matchMedia('(prefers-color-scheme: dark)');
const hasChart = typeof Chart !== 'undefined';

/* ---- small helpers ---- */

function element(tag, attributes, ...children) {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === 'class') e.className = value;
    else if (name.startsWith('on')) e.addEventListener(name.slice(2), value);
    else e.setAttribute(name, value);
  }
  for (const child of children) if (child !== null && child !== undefined) e.append(child);
  return e;
}
const unique = (values) => [...new Set(values)];
const median = (r, key) => (r && r[key] ? r[key].median : NaN);
/* Three digits that count, and no exponent for what people read. */
function number(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e15 || size < 1e-5) return value.toExponential(2);
  if (size >= 100) return String(Math.round(value));
  return value.toFixed(Math.min(8, Math.max(0, 2 - Math.floor(Math.log10(size)))));
}
const between = (times) => (times.low === undefined ? '–' : number(times.low) + '–' + number(times.high));
const whole = (value) => (value === undefined || value === null ? '–' : String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, '\u202f'));
function bytes(value) {
  if (value === undefined || value === null) return '–';
  for (const unit of ['B', 'KiB', 'MiB']) {
    if (value < 1024) return number(value) + ' ' + unit;
    value /= 1024;
  }
  return number(value) + ' GiB';
}
const listsName = (lists) => (lists === 'brute-force' ? 'brute force' : lists);
/* Shadows belong to the case. */
const optionsOf = (r) => (r.options || '').split(',').filter((part) => part && !part.startsWith('shadows='));
const scheme = (r) => listsName(r.lists) + (optionsOf(r).length ? ' (' + optionsOf(r).join(', ') + ')' : '');
const shadowsOf = (r) => ((r.options || '').match(/(?:^|,)shadows=([^,]*)/) || ['', ''])[1];
const caseName = (r) => r.scene + ', ' + r.width + '\u00a0×\u00a0' + r.height + (r.msaa > 1 ? ', MSAA ' + r.msaa : '') +
  (results.some(shadowsOf) ? (shadowsOf(r) ? ', shadows by ' + shadowsOf(r) : ', without shadows') : '');
const lightsOf = (r) => r.lights;
const plural = (count, noun) => whole(count) + ' ' + noun + (count === 1 ? '' : 's');

/* ---- colours ---- */

/* Okabe and Ito's set for all kinds of colour vision, darker on white and lighter on black; with more schemes than colours, dash and marker tell
 * them apart, and they do so from the first one on. */
const palettes = {
  light: ['#0072b2', '#c46a00', '#00805c', '#b3227c', '#3f3f3f', '#2a9bd6', '#8a7a00'],
  dark: ['#5db4ee', '#f2a93b', '#3fd0a4', '#ee8fc4', '#d4d4d4', '#a3d9ff', '#ece05a']
};
const markers = ['circle', 'triangle', 'rect', 'rectRot', 'crossRot', 'star', 'rectRounded', 'cross'];
const dashes = [[], [7, 4], [2, 3], [9, 3, 2, 3]];
const schemes = unique(results.map(scheme));
const variable = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const palette = () => (dark.matches ? palettes.dark : palettes.light);
function style(name) {
  const i = schemes.indexOf(name), p = palette();
  return {color: p[i % p.length], marker: markers[i % markers.length], dash: dashes[(i + Math.floor(i / p.length)) % dashes.length]};
}
const roles = ['geometry', 'shadows', 'lists', 'shading', 'rest'];
const roleNames = {geometry: 'geometry and depth', shadows: 'shadow maps', lists: 'building lists', shading: 'shading', rest: 'exposure, tone mapping'};
function roleColor(role, shade) {
  const p = palette(), base = {geometry: p[4], shadows: p[3], lists: p[1], shading: p[0], rest: p[6]}[role];
  return base + ['ff', 'b8', 'd8', '98'][(shade || 0) % 4];
}

/* ---- state ---- */

const cases = unique(results.map(caseName));
const best = results.reduce((a, b) => (median(b, 'frame_ms') < median(a, 'frame_ms') ? b : a), results[0]);
const state = {case: cases[0], shading: best ? best.shading : '', lights: null, metric: 'frame_ms', hidden: new Set()};
const metrics = {
  frame_ms: 'whole frame', gpu_ms: 'GPU', cpu_ms: 'CPU, record and submit', lists_ms: 'building the lists', shading_ms: 'shading',
  wall_ms: 'wall clock, with waiting'
};
const inCase = () => results.filter((r) => caseName(r) === state.case);
const lightCounts = () => countsOf(inCase());
const lines = () => inCase().filter((r) => r.shading === state.shading);
const shown = () => lines().filter((r) => !state.hidden.has(scheme(r)));
const atLights = () => lines().filter((r) => lightsOf(r) === state.lights);
const shownAt = () => shown().filter((r) => lightsOf(r) === state.lights);
const countsOf = (rows) => unique(rows.map(lightsOf)).sort((a, b) => a - b);
const ideals = (rows) => rows.filter((r) => r.ideal_ms > 0);
const overIdeal = (r) => (r && r.over_ideal > 0 ? number(r.over_ideal) + '×' : '–');
const byTime = (key) => (a, b) => median(a, key) - median(b, key);

function settle() {
  if (!inCase().some((r) => r.shading === state.shading)) {
    const fastest = inCase().sort(byTime('frame_ms'))[0];
    state.shading = fastest ? fastest.shading : '';
  }
  const counts = countsOf(lines());
  if (!counts.includes(state.lights)) state.lights = counts.length ? counts[counts.length - 1] : null;
}

/* ---- tables ---- */

/* What does not fit scrolls, and says so: a finger does not look for what it cannot see. */
const boxes = [];
function scrolling(name, content) {
  const hint = element('p', {class: 'hint', hidden: ''}, 'Scroll sideways for more columns \u2192');
  const scroll = element('div', {class: 'scroll', tabindex: '0', role: 'region', 'aria-label': name}, content);
  const box = element('div', {class: 'scroll-box'}, hint, scroll);
  const update = () => {
    const more = scroll.scrollWidth - scroll.clientWidth;
    hint.hidden = more <= 1;
    box.classList.toggle('more', more > 1 && scroll.scrollLeft < more - 1);
  };
  scroll.addEventListener('scroll', update, {passive: true});
  new ResizeObserver(update).observe(scroll);
  boxes.push({scroll, hint, update});
  return box;
}
/* A header that starts with '<' is of a column of text. A row is an array, or {cells, best}. */
function table(name, headers, rows) {
  const text = headers.map((h) => h.startsWith('<'));
  const head = element('tr', null, ...headers.map((h, i) => element('th', {scope: 'col', class: text[i] ? 'text' : ''}, h.replace(/^</, ''))));
  const body = rows.map((row) => {
    const cells = row.cells || row;
    return element('tr', row.best ? {class: 'best'} : null,
      ...cells.map((cell, i) => element('td', text[i] ? {class: 'text'} : null, cell instanceof Node ? cell : String(cell))));
  });
  return scrolling(name, element('table', {'data-name': name}, element('thead', null, head), element('tbody', null, ...body)));
}

/* ---- plots ---- */

const plots = []; /* {section, draw()} in order; each draws itself anew */
let charts = [];

/* p5 to p95 as whiskers on what has `spread` [low, high]. */
const whiskers = {
  id: 'whiskers',
  afterDatasetsDraw(chart) {
    const context = chart.ctx, across = chart.options.indexAxis === 'y', scale = across ? chart.scales.x : chart.scales.y;
    context.save();
    context.lineWidth = 1.5;
    chart.data.datasets.forEach((dataset, d) => {
      if (!dataset.spreads) return;
      context.strokeStyle = dataset.whisker || dataset.borderColor;
      chart.getDatasetMeta(d).data.forEach((point, i) => {
        const spread = dataset.spreads[i];
        if (!spread || !Number.isFinite(spread[0])) return;
        const a = scale.getPixelForValue(spread[0]), b = scale.getPixelForValue(spread[1]);
        context.beginPath();
        if (across) {
          context.moveTo(a, point.y);
          context.lineTo(b, point.y);
          for (const end of [a, b]) {
            context.moveTo(end, point.y - 4);
            context.lineTo(end, point.y + 4);
          }
        } else {
          context.moveTo(point.x, a);
          context.lineTo(point.x, b);
        }
        context.stroke();
      });
    });
    context.restore();
  }
};
/* A vertical line with a word on it, for bounds on bar plots. */
const bound = {
  id: 'bound',
  afterDatasetsDraw(chart) {
    const value = chart.options.plugins.bound && chart.options.plugins.bound.value;
    if (!Number.isFinite(value)) return;
    const x = chart.scales.x.getPixelForValue(value), area = chart.chartArea, context = chart.ctx;
    context.save();
    context.strokeStyle = variable('--text');
    context.setLineDash([5, 4]);
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, area.top);
    context.lineTo(x, area.bottom);
    context.stroke();
    context.restore();
  }
};

/* A logarithmic axis has no 0. Where values are 0 they get a place of their own beyond the least one, behind a break. */
const axisBreak = {
  id: 'axisBreak',
  afterDraw(chart) {
    const context = chart.ctx, area = chart.chartArea;
    for (const scale of Object.values(chart.scales)) {
      const log = scale.options.log;
      if (!log || !log.zero) continue;
      const at = scale.getPixelForValue(log.gap);
      context.save();
      context.strokeStyle = variable('--soft');
      context.lineWidth = 1.5;
      context.beginPath();
      for (const shift of [-3, 3])
        if (scale.axis === 'x') {
          context.moveTo(at + shift - 3, area.bottom + 5);
          context.lineTo(at + shift + 3, area.bottom - 5);
        } else {
          context.moveTo(area.left - 5, at + shift + 3);
          context.lineTo(area.left + 5, at + shift - 3);
        }
      context.stroke();
      context.setLineDash([2, 4]);
      context.lineWidth = 1;
      context.beginPath();
      context.moveTo(scale.axis === 'x' ? at : area.left, scale.axis === 'x' ? area.top : at);
      context.lineTo(scale.axis === 'x' ? at : area.right, scale.axis === 'x' ? area.bottom : at);
      context.stroke();
      context.restore();
    }
  }
};

function plot(container, name, height, config) {
  if (!hasChart) return;
  const canvas = element('canvas', {role: 'img', 'aria-label': name + '; the table below has its numbers'});
  container.append(element('div', {class: 'plot', style: 'height:' + height + 'px'}, canvas));
  config.options = Object.assign({
    responsive: true, maintainAspectRatio: false, animation: false, interaction: {mode: 'nearest', intersect: false}
  }, config.options);
  config.options.plugins = Object.assign({legend: {display: false}}, config.options.plugins);
  config.plugins = [whiskers, bound, axisBreak];
  charts.push(new Chart(canvas, config));
}

function axis(title, type, more) {
  return Object.assign({
    type: type, title: {display: true, text: title, color: variable('--soft')}, grid: {color: variable('--line')},
    ticks: {color: variable('--soft'), maxRotation: 0, autoSkip: true}
  }, more);
}
/* Where values stand on a logarithmic axis: by their logarithm, and 0 in a place of its own. */
function logScale(values) {
  const range = values.filter((v) => v > 0), zero = values.some((v) => v === 0);
  const low = Math.log10(range.length ? Math.min(...range) : 1), high = Math.log10(range.length ? Math.max(...range) : 1);
  const span = Math.max(high - low, 0.4), nil = low - 0.17 * span, pad = 0.04 * span;
  return {zero, nil, low, gap: (low + nil) / 2, min: (zero ? nil : low) - pad, max: high + pad, place: (v) => (v > 0 ? Math.log10(v) : nil)};
}
/* The numbers on such an axis, at least two: 1, 2 and 5 of each decade, or only 1 where there are many; in a narrow range, even steps. */
function logMarks(log) {
  const least = log.zero ? log.low : log.min, decades = log.max - log.low, marks = [];
  const keep = decades > 4 ? [1] : decades > 2 ? [1, 3] : decades > 0.7 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 8];
  for (let power = Math.floor(log.low); power <= Math.ceil(log.max); power++)
    for (const digit of keep) marks.push(Number((digit * Math.pow(10, power)).toPrecision(3)));
  const inside = marks.filter((mark) => Math.log10(mark) >= least && Math.log10(mark) <= log.max);
  if (inside.length > 1) return inside;
  /* The largest step of 1, 2 or 5 that fits twice into the range: two marks at least, whatever the range begins with. */
  const from = Math.pow(10, least), to = Math.pow(10, log.max), half = (to - from) / 2, power = Math.pow(10, Math.floor(Math.log10(half)));
  const step = power * ([5, 2].find((digit) => digit * power <= half) || 1), steps = [];
  for (let mark = Math.ceil(from / step) * step; mark <= to; mark += step) steps.push(Number(mark.toPrecision(9)));
  return steps;
}
/* A logarithmic axis; `at`: the values that carry numbers, if not those of logMarks(). */
function logAxis(title, log, at, format) {
  const shown = format || ((value) => (value >= 1e4 ? value / 1000 + 'k' : String(Number(number(value)))));
  return axis(title, 'linear', {
    log, min: log.min, max: log.max,
    afterBuildTicks(scale) {
      const marks = at ? at.filter((v) => v > 0) : logMarks(log);
      scale.ticks = (log.zero ? [{value: log.nil}] : []).concat(unique(marks).map((mark) => ({value: Math.log10(mark)})));
    },
    ticks: {color: variable('--soft'), maxRotation: 0, autoSkip: !!at, callback: (value) => (log.zero && value === log.nil ? '0' : shown(Number(Math.pow(10, value).toPrecision(6))))}
  });
}
const lightsAxis = (log, counts) => logAxis('lights', log, counts, (value) => (value >= 10000 ? Math.round(value / 1000) + 'k' : String(Math.round(value))));
/* Names as axis labels: one part of the options a line, so that they fit a phone. */
const labelOf = (r) => [listsName(r.lists)].concat(optionsOf(r));
const barHeight = (rows, perRow, label) => 86 + rows.reduce((sum, r) => sum + Math.max(perRow, 15 * label(r).length + 8), 0);
const nameAxis = () => ({grid: {display: false}, ticks: {color: variable('--text'), autoSkip: false, font: {size: 12}}});

function swatch(name) {
  const s = style(name), svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  const shapes = {
    circle: '<circle cx="15" cy="7" r="4"/>', triangle: '<path d="M15 2l5 9h-10z"/>', rect: '<path d="M11 3h8v8h-8z"/>',
    rectRot: '<path d="M15 1.5l5.5 5.5-5.5 5.5-5.5-5.5z"/>', crossRot: '<path d="M11 3l8 8m0-8l-8 8" fill="none"/>',
    star: '<path d="M15 2v10m-5-5h10m-8.5-3.5l7 7m0-7l-7 7" fill="none"/>', rectRounded: '<rect x="11" y="3" width="8" height="8" rx="3"/>',
    cross: '<path d="M15 2v10m-5-5h10" fill="none"/>'
  };
  svg.setAttribute('width', 30); svg.setAttribute('height', 14); svg.setAttribute('aria-hidden', 'true');
  svg.innerHTML = '<path d="M0 7h30" fill="none" stroke-dasharray="' + s.dash.join(' ') + '"/>' + shapes[s.marker];
  svg.style.cssText = 'flex:none;stroke:' + s.color + ';fill:' + s.color + ';stroke-width:2';
  return svg;
}
/* Switches schemes on and off in all plots; of many, leaves the fastest. */
function legend() {
  const names = unique(lines().map(scheme)), press = (selector) => {
    redraw();
    const again = document.querySelector('.legend button' + selector);
    if (again) again.focus({preventScroll: true});
  };
  const buttons = names.map((name) => element('button', {
    type: 'button', 'data-scheme': name, 'aria-pressed': String(!state.hidden.has(name)), onclick() {
      if (!state.hidden.delete(name)) state.hidden.add(name);
      press('[data-scheme="' + CSS.escape(name) + '"]');
    }
  }, swatch(name), name));
  if (names.length > 6) {
    const fastest = atLights().sort(byTime('frame_ms')).map(scheme).slice(0, 5);
    buttons.push(element('button', {type: 'button', 'data-choice': 'few', onclick() {
      state.hidden = new Set(names.filter((name) => !fastest.includes(name)));
      press('[data-choice="few"]');
    }}, 'only the 5 fastest'), element('button', {type: 'button', 'data-choice': 'all', onclick() {
      state.hidden.clear();
      press('[data-choice="all"]');
    }}, 'all of them'));
  }
  return element('div', {class: 'legend', role: 'group', 'aria-label': 'Light lists shown'}, ...buttons);
}
const roleLegend = (keys, color, names) => element('div', {class: 'legend'}, ...keys.map((role) => {
  const box = element('i');
  box.style.background = color(role);
  return element('span', {class: 'key'}, box, names[role]);
}));

/* Lines over the numbers of lights: {label, look, rows}; `key` is of times, or a function; `more` are lines besides. */
function linesPlot(container, name, lines, key, title, more) {
  const timed = typeof key === 'string', value = timed ? (r) => median(r, key) : key, known = (r) => Number.isFinite(value(r));
  const all = lines.concat(more || []).flatMap((line) => line.rows.map((r) => (line.value || value)(r)));
  const whisker = (r) => (timed && lines.length <= 6 ? [r[key].p5, r[key].p95] : null); /* of many lines they would only hide one another */
  const heights = logScale(all.concat(lines.flatMap((line) => line.rows.filter(known).flatMap((r) => whisker(r) || []))).filter(Number.isFinite));
  const counts = countsOf(lines.flatMap((line) => line.rows)), lights = logScale(counts);
  const datasets = lines.concat(more || []).map((line) => {
    const own = line.rows.filter((r) => Number.isFinite((line.value || value)(r))).sort((a, b) => lightsOf(a) - lightsOf(b));
    const points = [], spreads = [];
    for (const r of own) {
      const y = (line.value || value)(r), spread = line.value ? null : whisker(r);
      points.push({x: lights.place(lightsOf(r)), y: heights.place(y), lights: lightsOf(r), real: y});
      spreads.push(spread ? spread.map(heights.place) : null);
      if (lightsOf(r) === 0) { /* no line leads over the break */
        points.push({x: lights.gap, y: NaN});
        spreads.push(null);
      }
    }
    return Object.assign({
      label: line.label, data: points, spreads, borderColor: line.look.color, backgroundColor: line.look.color, borderDash: line.look.dash, borderWidth: 2,
      pointStyle: line.look.marker, pointRadius: 5, pointHoverRadius: 7, pointBorderWidth: 2
    }, line.dataset);
  });
  plot(container, name, 380, {
    type: 'line', data: {datasets},
    options: {
      scales: {x: lightsAxis(lights, counts), y: logAxis(title, heights)},
      plugins: {tooltip: {callbacks: {
        title: (items) => plural(items[0].raw.lights, 'light'), label: (item) => item.dataset.label + ': ' + number(item.raw.real)
      }}}
    }
  });
}
/* One line per kind of lists. */
function linePlot(container, name, key, title, more) {
  const rows = shown(), names = schemes.filter((s) => rows.some((r) => scheme(r) === s));
  linesPlot(container, name, names.map((s) => ({label: s, look: style(s), rows: rows.filter((r) => scheme(r) === s)})), key, title, more);
}
/* `sets`: {label, color, value(r), spread(r)?}; bars lie along x, one row for each result. */
function barPlot(container, name, rows, title, sets, more) {
  const options = more || {}, stacked = !!options.stacked;
  const spreads = sets.flatMap((set) => (set.spread ? rows.flatMap(set.spread) : []));
  const log = options.log ? logScale(rows.flatMap((r) => sets.map((set) => set.value(r))).concat(spreads).concat(options.bound > 0 ? options.bound : [])) : null;
  const place = log ? log.place : (v) => v, x = log ? logAxis(title, log) : axis(title, 'linear', {beginAtZero: true, suggestedMax: Math.max(0, ...spreads)});
  if (stacked) x.stacked = true;
  plot(container, name, barHeight(rows, sets.length > 1 && !stacked ? 40 : 30, options.label || labelOf), {
    type: 'bar',
    data: {
      labels: rows.map(options.label || labelOf),
      datasets: sets.map((set) => ({
        label: set.label, data: rows.map((r) => place(set.value(r))), real: rows.map((r) => set.value(r)), base: log ? log.min : undefined,
        backgroundColor: set.colors ? rows.map(set.colors) : set.color, borderColor: variable('--panel'), borderWidth: stacked ? {right: 1} : 0,
        maxBarThickness: 26, whisker: variable('--text'), spreads: set.spread ? rows.map((r) => set.spread(r).map(place)) : null
      }))
    },
    options: {
      indexAxis: 'y', scales: {x: x, y: Object.assign(nameAxis(), {stacked: stacked})},
      interaction: {mode: stacked ? 'nearest' : 'index', intersect: stacked, axis: stacked ? 'xy' : 'y'},
      plugins: {bound: {value: options.bound > 0 ? place(options.bound) : NaN}, tooltip: {callbacks: {
        title: (items) => String(items[0].label).replace(/,/g, ' '),
        label: (item) => item.dataset.label + ': ' + (options.format || number)(item.dataset.real[item.dataIndex])
      }}}
    }
  });
}

/* ---- sections ---- */

function addPlot(id, title, text, draw) {
  const body = element('div'), section = element('section', {id: id}, element('h2', null, title), element('p', {class: 'note'}, text), body);
  plots.push({id, section, draw: () => { body.replaceChildren(); draw(body); }});
}
const many = () => lightCounts().length > 1;
/* The first row of a table is the best one. */
const ranked = (rows, cells) => rows.map((r, i) => ({best: i === 0, cells: cells(r)}));

const orderLook = (name) => {
  const all = unique(results.map((r) => r.shading)), i = all.indexOf(name), p = palette();
  return {color: p[i % p.length], marker: markers[i % markers.length], dash: dashes[(i + Math.floor(i / p.length)) % dashes.length]};
};
addPlot('orders', 'Shading paths', 'Each with the lists that it is fastest with here: medians of the whole frame; the true median is in the interval "between" with 95 % confidence (of all frames, if there are fewer than six). Whiskers span from the 5th to the 95th percentile.',
  (body) => {
  const key = 'frame_ms', fastest = (rows) => rows.slice().sort(byTime(key))[0], at = inCase().filter((r) => lightsOf(r) === state.lights);
  const bestOf = (rows) => unique(rows.map((r) => r.shading)).map((name) => fastest(rows.filter((r) => r.shading === name))).sort(byTime(key));
  const rows = bestOf(at), most = rows.length ? median(rows[rows.length - 1], key) : 0;
  const brute = (r) => at.find((o) => o.shading === r.shading && o.lists === 'brute-force' && (o.ways || '') === (r.ways || ''));
  barPlot(body, 'Time of shading paths', rows, 'ms', [{
    label: 'whole frame, ms', value: (r) => median(r, key), colors: (r) => orderLook(r.shading).color, spread: (r) => [r[key].p5, r[key].p95]
  }], {label: (r) => [r.shading, 'with ' + listsName(r.lists)].concat(optionsOf(r)), log: most > 30 * median(rows[0], key)});
  if (many()) {
    const orders = unique(inCase().map((r) => r.shading));
    body.append(roleLegend(orders, (name) => orderLook(name).color, Object.fromEntries(orders.map((name) => [name, name]))));
    linesPlot(body, 'Time of shading paths over lights', orders.map((name) => ({
      label: name, look: orderLook(name),
      rows: lightCounts().map((n) => fastest(inCase().filter((r) => r.shading === name && lightsOf(r) === n))).filter(Boolean)
    })), key, 'ms');
  }
  body.append(table('orders-fastest', [plural(state.lights, 'light'), '<fastest with', 'frame, ms', 'between', 'of the fastest', 'of its ideal', 'brute force takes'], ranked(rows, (r) =>
    [r.shading, scheme(r), number(median(r, key)), between(r[key]), number(median(r, key) / median(rows[0], key)) + '×', overIdeal(r),
      brute(r) && brute(r) !== r ? number(median(brute(r), key) / median(r, key)) + '×' : '–'])));
});

addPlot('time', 'Light lists', 'Medians; whiskers span from the 5th to the 95th percentile. A whole frame is the longer of GPU and CPU, which work ' +
  'side by side; handing results to the CPU is left out. Dashed, and in brackets as multiples of it: the ideal, this frame with perfect lists that cost nothing, ' +
  'where such lists were measured.', (body) => {
  const key = state.metric, counts = countsOf(lines());
  body.append(
    element('div', {class: 'choice'}, select('Time of', Object.keys(metrics), key, (value) => { state.metric = value; redraw(); }, (k) => metrics[k])),
    legend());
  /* Of the path as a whole: of several frames that differ by more than lists, the least. */
  const least = (rows) => rows.reduce((a, b) => (b.ideal_ms < a.ideal_ms ? b : a));
  const ideal = key === 'frame_ms' ? counts.map((n) => ideals(lines()).filter((r) => lightsOf(r) === n)).filter((rows) => rows.length).map(least) : [];
  if (many()) linePlot(body, 'Time over lights', key, 'ms', ideal.length ? [{
    label: 'ideal', rows: ideal, value: (r) => r.ideal_ms, look: {color: variable('--text'), dash: [5, 4], marker: 'line'}, dataset: {pointRadius: 0}
  }] : []);
  else barPlot(body, 'Time', shownAt().sort(byTime(key)), 'ms', [{
    label: metrics[key] + ', ms', value: (r) => median(r, key), colors: (r) => style(scheme(r)).color, spread: (r) => [r[key].p5, r[key].p95]
  }], {bound: ideal.length ? ideal[0].ideal_ms : NaN});
  const at = (name, n) => lines().find((r) => scheme(r) === name && lightsOf(r) === n);
  const last = (name) => {
    const time = median(at(name, counts[counts.length - 1]), key);
    return Number.isNaN(time) ? Infinity : time;
  };
  const cell = (r) => (r ? number(r[key].median) + ' (' + between(r[key]) + ')' + (ideal.length && r.over_ideal ? ' (' + overIdeal(r) + ')' : '') : '–');
  const names = unique(lines().map(scheme)).sort((a, b) => last(a) - last(b));
  body.append(table('time', ['ms, median (between)'].concat(counts.map((n) => plural(n, 'light'))),
    ranked(names, (name) => [name].concat(counts.map((n) => cell(at(name, n)))))));
});

addPlot('passes', 'Where the time goes', 'Every pass of the GPU, one piece of the bar each; pieces of one kind have one colour. Touch a piece for ' +
  'its name.', (body) => {
  const rows = shownAt().sort(byTime('gpu_ms')), sorted = atLights().sort(byTime('gpu_ms'));
  const pass = (r, name) => r.passes.find((p) => p.name === name);
  const all = new Map(sorted.flatMap((r) => r.passes.map((p) => [p.name, p.role])));
  const sets = roles.flatMap((role) => [...all].filter(([, kind]) => kind === role).map(([name], i) => ({
    label: name + ', ms', color: roleColor(role, i), value: (r) => (pass(r, name) ? pass(r, name).median : 0)
  })));
  body.append(roleLegend(roles, roleColor, roleNames));
  barPlot(body, 'Passes', rows, 'ms', sets, {stacked: true});
  body.append(
    table('passes', ['ms, medians'].concat(roles.map((role) => roleNames[role]), 'all passes', 'CPU'), ranked(sorted, (r) =>
      [scheme(r)].concat(roles.map((role) => number(median(r, role + '_ms'))), number(median(r, 'gpu_ms')), number(median(r, 'cpu_ms'))))),
    element('details', null, element('summary', null, 'Every pass'),
      table('every-pass', ['pass, ms', '<kind'].concat(sorted.map(scheme)), [...all].map(([name, role]) =>
        [name, role].concat(sorted.map((r) => (pass(r, name) ? number(pass(r, name).median) : '–')))))));
});

addPlot('evaluations', 'Lights per pixel', 'How many lights a pixel evaluates on average, exactly counted, against the least possible: those that ' +
  'truly reach its surface (dashed).', (body) => {
  const counted = (r) => r.per_pixel !== undefined, fewest = (a, b) => a.per_pixel - b.per_pixel;
  const rows = shownAt().filter(counted).sort(fewest), least = rows.length ? rows[0].useful_per_pixel : 0;
  body.append(legend());
  if (many()) {
    const points = countsOf(lines()).map((n) => lines().find((r) => lightsOf(r) === n)).filter((r) => r && r.useful_per_pixel !== undefined);
    linePlot(body, 'Lights per pixel over lights', (r) => r.per_pixel, 'lights per pixel', [{
      label: 'least possible', rows: points, value: (r) => r.useful_per_pixel, look: {color: variable('--text'), dash: [5, 4], marker: 'line'},
      dataset: {pointRadius: 0}
    }]);
  } else {
    barPlot(body, 'Lights per pixel', rows, 'lights per pixel',
      [{label: 'lights per pixel', value: (r) => r.per_pixel, colors: (r) => style(scheme(r)).color}],
      {bound: least, log: rows.some((r) => r.per_pixel > 30 * (least || 1))});
  }
  const ratio = (r) => (r.useful_per_pixel > 0 ? number(r.per_pixel / r.useful_per_pixel) + '×' : '–');
  body.append(table('evaluations', [plural(state.lights, 'light'), 'per pixel', 'least possible', 'ratio', 'most of a pixel', 'evaluations'],
    ranked(atLights().filter(counted).sort(fewest), (r) =>
      [scheme(r), number(r.per_pixel), number(r.useful_per_pixel), ratio(r), whole(r.max_per_pixel), whole(r.evaluations)])));
});

addPlot('balance', 'Building lists against shading', 'Tighter lists cost more to build and save shading: the nearer to the lower left, the better. At 0 ' +
  'stands what builds no lists on the GPU in this frame.', (body) => {
  const build = (r) => median(r, 'lists_ms'), shade = (r) => median(r, 'shading_ms'), both = (r) => build(r) + shade(r);
  const rows = shownAt(), across = logScale(rows.map(build)), up = logScale(rows.map(shade));
  body.append(legend());
  plot(body, 'List time against shading time', 340, {
    type: 'scatter',
    data: {datasets: rows.map((r) => {
      const look = style(scheme(r));
      return {
        label: scheme(r), data: [{x: across.place(build(r)), y: up.place(shade(r))}], real: r, borderColor: look.color, backgroundColor: look.color,
        pointStyle: look.marker, pointRadius: 7, pointHoverRadius: 9, pointBorderWidth: 2
      };
    })},
    options: {
      scales: {x: logAxis('building lists, ms', across), y: logAxis('shading, ms', up)},
      plugins: {tooltip: {callbacks: {
        label: (item) => item.dataset.label + ': lists ' + number(build(item.dataset.real)) + ' ms, shading ' + number(shade(item.dataset.real)) + ' ms'
      }}}
    }
  });
  const part = (r) => (both(r) > 0 ? Math.round(100 * build(r) / both(r)) + ' %' : '–');
  body.append(table('balance', ['ms, medians', 'lists', 'shading', 'both', 'lists, part of both'],
    ranked(atLights().sort((a, b) => both(a) - both(b)), (r) => [scheme(r), number(build(r)), number(shade(r)), number(both(r)), part(r)])));
});

addPlot('memory', 'Memory of the lists', 'Reserved, and the part of it that this frame fills.', (body) => {
  const used = (r) => r.list_used_bytes || 0, least = (a, b) => used(a) - used(b), p = palette();
  const names = {used: 'used by this frame', reserved: 'reserved'}, colors = {used: p[0], reserved: p[1]};
  const kibibytes = (value) => (value || 0) / 1024;
  body.append(roleLegend(['used', 'reserved'], (k) => colors[k], names));
  barPlot(body, 'Memory of the lists', shownAt().sort(least), 'KiB', [
    {label: names.used, color: colors.used, value: (r) => kibibytes(r.list_used_bytes)},
    {label: names.reserved, color: colors.reserved, value: (r) => kibibytes(r.list_bytes)}
  ], {log: true, format: (value) => number(value) + ' KiB'});
  body.append(table('memory', [plural(state.lights, 'light'), 'used', 'reserved', 'entries', 'cells', 'cells that overflowed'],
    atLights().sort(least).map((r) =>
      [scheme(r), bytes(r.list_used_bytes), bytes(r.list_bytes), whole(r.list_entries), whole(r.cells), whole(r.overflow_cells)])));
});

addPlot('traffic', 'Traffic of images', 'Bytes that the passes of a frame load, store, sample and write of its images, by formats and operations, ' +
  'not measured; textures and buffers are left out.', (body) => {
  const all = (r) => (r.image_bytes_read || 0) + (r.image_bytes_written || 0), least = (a, b) => all(a) - all(b), p = palette();
  const names = {read: 'read', written: 'written'}, colors = {read: p[0], written: p[1]};
  const mebibytes = (value) => (value || 0) / 1048576;
  body.append(roleLegend(['read', 'written'], (k) => colors[k], names));
  barPlot(body, 'Traffic of images', shownAt().sort(least), 'MiB', [
    {label: names.read, color: colors.read, value: (r) => mebibytes(r.image_bytes_read)},
    {label: names.written, color: colors.written, value: (r) => mebibytes(r.image_bytes_written)}
  ], {format: (value) => number(value) + ' MiB'});
  body.append(table('traffic', [plural(state.lights, 'light'), 'read', 'written', 'read a pixel', 'written a pixel'],
    atLights().sort(least).map((r) => [scheme(r), bytes(r.image_bytes_read), bytes(r.image_bytes_written),
      bytes(r.image_bytes_read / (r.width * r.height)), bytes(r.image_bytes_written / (r.width * r.height))])));
});

/* ---- pictures ---- */

function figure(uri, text, alt) {
  return element('figure', null, element('img', {src: uri, alt: alt, loading: 'lazy'}), element('figcaption', null, text));
}
addPlot('pictures', 'Pictures', 'Every picture was compared with the reference of the same shading path (G-buffer, transparency and decals being the same), bit for bit, before tone ' +
  'mapping.', (body) => {
  const all = inCase().filter((r) => lightsOf(r) === state.lights), grid = element('div', {class: 'pictures'}), reference = data.settings.reference;
  const find = (r, lists, options, kind) => {
    const lights = r.asked_lights === null ? -1 : r.asked_lights;
    return pictures[[r.scene, lights, r.width + 'x' + r.height, r.msaa, r.shading, lists, options, kind].join('|')];
  };
  const add = (uri, text, alt) => { if (uri) grid.append(figure(uri, text, alt)); };
  /* Orders, and what else of a frame was varied, have a reference each. */
  const order = (r) => r.shading + (r.ways ? ' (' + r.ways.replace(/,/g, ', ') + ')' : '');
  const orders = unique(all.map(order)), first = (name) => all.find((r) => order(r) === name);
  const of = (name, kind) => find(first(name), reference, first(name).ways || '', kind);
  const base = orders.find((name) => of(name, 'reference') && !of(name, 'shading')); /* what the others were compared with */
  for (const name of orders) {
    add(of(name, 'reference'), name + ' with ' + (reference === 'brute-force' ? 'brute force' : reference + ' lists') + ': the reference', 'The scene, shaded ' + name);
    add(of(name, 'shading'), name + ' against ' + base + ', difference × 16', 'Differences of two ways to shade');
  }
  for (const r of atLights()) {
    const own = (kind) => find(r, r.lists, r.options, kind), equal = r.equal === true ? '; picture equal to the reference' : '';
    add(own('picture'), scheme(r) + ': DIFFERS', 'A picture that differs from the reference');
    add(own('difference'), scheme(r) + ': difference, the greatest (' + number(r.max_difference) + ' cd/m²) shown white', 'Where it differs');
    add(own('lights'), scheme(r) + ': lights per pixel' + equal, 'Heat map of lights per pixel');
  }
  const none = 'No pictures were kept of this number of lights; the one with most lights of each scene has them.';
  body.append(grid.children.length ? grid : element('p', {class: 'note'}, none));
  const verdict = (r) => (r.equal ? 'equal' : r.equal === false ? 'DIFFERS' : 'not compared' + (r.unchecked ? ': ' + r.unchecked : ''));
  body.append(table('pictures', ['lists', '<shading', '<picture', 'pixels that differ', 'greatest difference, cd/m²'], all.map((r) => [
    scheme(r), r.shading, element('span', {class: r.equal ? 'good' : r.equal === false ? 'bad' : ''}, verdict(r)),
    r.equal === null ? '–' : whole(r.differing_pixels), r.equal === null ? '–' : number(r.max_difference)
  ])));
});

/* ---- the rest of the page ---- */

function select(label, values, chosen, change, name) {
  const options = values.map((value) => element('option', null, name ? name(value) : String(value)));
  const control = element('select', {onchange() { change(values[control.selectedIndex]); }}, ...options);
  control.selectedIndex = Math.max(0, values.indexOf(chosen));
  return element('label', null, label, control);
}
const controls = element('div', {class: 'controls'});
function drawControls() {
  controls.replaceChildren(
    select('Scene', cases, state.case, (value) => { state.case = value; redraw(); }),
    select('Shading', unique(inCase().map((r) => r.shading)), state.shading, (value) => { state.shading = value; redraw(); }),
    select('Lights', countsOf(lines()), state.lights, (value) => { state.lights = value; redraw(); }, (n) => whole(n)));
}
const frameCounts = () => {
  const counts = results.map((r) => r.frames), least = Math.min(...counts), most = Math.max(...counts);
  return results.length ? (least < most ? least + ' to ' + most : String(least)) : String(data.settings.frames);
};
function drawHead() {
  const s = data.settings, d = data.device;
  const facts = [
    ['Device', d.name], ['Driver', d.driver + ', Vulkan ' + d.vulkan], ['Kind', d.type],
    ['Machine', data.machine.processor + ', ' + plural(data.machine.cores, 'core') + ', ' + data.machine.kernel],
    ['Load before', number(data.machine.load_before)], ['Program', data.program.version + ', commit ' + data.program.commit],
    ['Measured', data.date], ['Scenes', unique(results.map((r) => r.scene)).join(', ')],
    ['Frames', frameCounts() + ' of each in turn, after ' + s.warm_up + ' to warm up' + (s.camera_path ? ', along ' + s.camera_path : '')]
  ];
  document.getElementById('head').append(...facts.map(([name, value]) =>
    element('div', null, element('dt', null, name), element('dd', null, value))));
}
const groupCount = () => unique(results.map((r) => caseName(r) + '|' + lightsOf(r))).length;
/* Of each case the fastest way, the next, and brute force. */
function drawCases() {
  const key = 'frame_ms', groups = new Map();
  for (const r of results) {
    const name = caseName(r) + '|' + lightsOf(r);
    groups.set(name, (groups.get(name) || []).concat(r));
  }
  const way = (r) => r.shading + ' with ' + (r.lists === 'brute-force' ? 'brute force' : r.lists + ' lists') + (optionsOf(r).length ? ' (' + optionsOf(r).join(', ') + ')' : '');
  const clear = (a, b) => b[key].low > a[key].high;
  return table('cases', ['<case', 'lights', '<fastest', 'ms', 'between', '<next', 'times as fast', 'than brute force'], [...groups.values()].map((rows) => {
    const [first, next] = rows.sort(byTime(key)), brute = rows.find((r) => r.lists === 'brute-force'), times = (r) => number(median(r, key) / median(first, key)) + '×';
    return [caseName(first), whole(lightsOf(first)), way(first), number(median(first, key)), between(first[key]), next ? way(next) : '–',
      next ? times(next) + (clear(first, next) ? '' : ', within the spread') : '–', brute && brute !== first ? times(brute) : '–'];
  }));
}
function drawConclusions() {
  const line = (text) => element('li', text.startsWith('WRONG') ? {class: 'bad'} : null, text);
  /* Wrong pictures first, then the cases with most lights, which come last in the plan. */
  const all = data.conclusions.slice().reverse().sort((a, b) => b.startsWith('WRONG') - a.startsWith('WRONG'));
  const equal = results.filter((r) => r.equal === true).length, compared = results.filter((r) => r.equal !== null).length;
  const said = compared ? equal + ' of ' + plural(compared, 'picture') + ' equal the reference to the last bit.' : 'No picture was compared.';
  const cut = results.filter((r) => !r.complete).length, notes = [];
  if (data.device.type === 'cpu') notes.push('The device is a CPU: read ratios, not milliseconds.');
  if (data.likely) notes.push('Only the likely pairs were measured; fanal bench --all measures every one.');
  if (cut) notes.push(plural(cut, 'result') + ' of fewer frames than asked for: --resume goes on.');
  const rest = all.slice(3);
  return element('section', {id: 'conclusions'},
    ...(data.warnings || []).map((text) => element('p', {class: 'warning'}, text)),
    groupCount() > 1 ? drawCases() : null,
    element('ul', {class: 'lead'}, ...all.slice(0, 3).map(line), element('li', {class: equal === compared ? 'good' : 'bad'}, said)),
    rest.length ? element('details', null, element('summary', null, rest.length + ' more'), element('ul', {class: 'lead'}, ...rest.map(line))) : null,
    notes.length ? element('p', {class: 'note'}, notes.join(' ')) : null, groupCount() > 1 ? null : drawCases());
}
function wrap(text, width) {
  const out = [''];
  for (const word of text.split(' ')) {
    const longer = (out[out.length - 1] + ' ' + word).trim();
    if (longer.length > width && out[out.length - 1]) out.push(word);
    else out[out.length - 1] = longer;
  }
  return out;
}
function drawSuite() {
  const suite = data.suite, p = palette(), colors = {source: p[4], ours: p[0]};
  const body = element('section', {id: 'suite'}, element('h2', null, suite.title), element('p', {class: 'headline'}, suite.headline),
    suite.warning ? element('p', {class: 'warning'}, suite.warning) : null,
    element('p', {class: 'note'}, 'Ratios of the source beside ours, measured in one run on this device. One that is nearer to the source\u2019s than its spread (±) is undecided.'));
  const looks = {reached: 'good', missed: 'bad', 'wrong picture': 'bad', undecided: 'undecided'};
  const verdict = (row) => element('span', {class: looks[row.verdict] || ''}, row.verdict);
  const wanted = (row) => (row.source === null ? '–' : (row.comparison === '>=' ? '≥ ' : '≤ ') + number(row.source));
  const known = suite.rows.filter((row) => row.source !== null && row.ours !== null);
  if (known.length) {
    body.append(roleLegend(['source', 'ours'], (k) => colors[k], {source: 'source', ours: 'ours'}));
    barPlot(body, 'Ratios', known, 'ratio', ['source', 'ours'].map((k) => ({
      label: k, color: colors[k], value: (row) => row[k],
      spread: (row) => (k === 'ours' && row.spread < row.ours ? [row.ours - row.spread, row.ours + row.spread] : [row[k], row[k]])
    })),
      {label: (row) => wrap(row.quantity, 20), log: true});
  }
  body.append(table('suite', ['<quantity', 'source', 'ours', '±', '<verdict', '<scene'], suite.rows.map((row) =>
    [row.quantity, wanted(row), number(row.ours), number(row.spread), verdict(row), row.scene])));
  return body;
}
function drawNumbers() {
  const time = (key) => (r) => number(median(r, key));
  const columns = [
    ['lists', scheme], ['<shading', (r) => r.shading], ['<case', caseName], ['lights', (r) => whole(r.lights)], ['frame', time('frame_ms')],
    ['GPU', time('gpu_ms')], ['CPU', time('cpu_ms')], ['lists', time('lists_ms')], ['shading', time('shading_ms')],
    ['frames', (r) => whole(r.frames)], ['lights per pixel', (r) => number(r.per_pixel)], ['entries', (r) => whole(r.list_entries)]
  ];
  const section = element('section', {id: 'numbers'}, element('h2', null, 'All numbers'),
    element('p', {class: 'note'}, 'Medians, times in ms; results.csv and results.json have more.'),
    element('details', null, element('summary', null, plural(results.length, 'result')),
      table('numbers', columns.map((c) => c[0]), results.map((r) => columns.map((c) => c[1](r))))));
  if (data.skipped.length)
    section.append(element('details', null, element('summary', null, plural(data.skipped.length, 'pair') + ' left out'),
      table('skipped', ['lists', '<shading', '<case', '<reason'], data.skipped.map((s) => [scheme(s), s.shading, caseName(s), s.reason]))));
  return section;
}

function drawAntialiasing() {
  return element('section', {id: 'antialiasing'}, element('h2', null, 'Antialiasing'),
    element('p', {class: 'note'}, 'Pictures against the mean of 64 frames that sample pixels at different places; error is the mean difference of a channel, of 255, and extra is over the same shading without antialiasing. Times in ms.'),
    table('antialiasing', ['<scene', '<method', 'frame', 'extra', 'error', 'PSNR, dB', 'SSIM', 'error removed per ms'],
      data.antialiasing.map((r) => [r.scene, r.method, number(r.frame_ms), number(r.extra_ms), number(r.mean_error), number(r.psnr), number(r.ssim),
        r.removed_per_ms === null ? '–' : number(r.removed_per_ms)])));
}

/* What a suite made of the results: a cell is text, a number, or nothing; whole numbers count something. */
function drawTables() {
  const cell = (value) => (typeof value === 'string' ? value : Number.isInteger(value) ? whole(value) : number(value));
  return element('section', {id: 'tables'}, ...data.tables.filter((t) => t.rows.length).flatMap((t) => [
    element('h2', null, t.title),
    table(t.name, t.columns, t.rows.map((row) => t.columns.map((c, i) => cell(row[i])))),
    t.lines.length ? element('ul', {class: 'lead'}, ...t.lines.map((line) => element('li', null, line))) : null
  ]));
}

let suiteSection = null;
function redraw() {
  settle();
  for (const chart of charts) chart.destroy();
  charts = [];
  drawControls();
  if (suiteSection) {
    const next = drawSuite();
    suiteSection.replaceWith(next);
    suiteSection = next;
  }
  for (const p of plots) p.draw();
}

function start() {
  drawHead();
  if (data.antialiasing) main.append(drawAntialiasing());
  if (!results.length) {
    if (data.antialiasing) return;
    main.append(element('section', null, element('p', null, 'Nothing was measured.')));
    return;
  }
  if (hasChart) {
    Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
    Chart.defaults.font.size = 12;
  }
  if (data.suite) {
    suiteSection = element('section');
    main.append(suiteSection);
  }
  main.append(drawConclusions());
  if (data.tables) main.append(drawTables());
  if (!hasChart) main.append(element('section', null, element('p', {class: 'note'}, 'This page was made without the charting library: tables only.')));
  main.append(document.getElementById('head'));
  main.append(controls);
  for (const p of plots) main.append(p.section);
  main.append(drawNumbers());
  redraw();
  dark.addEventListener('change', redraw);
  const wanted = document.getElementById(location.hash.slice(1)); /* report.html#memory */
  if (wanted) wanted.scrollIntoView();
  document.getElementById('foot').append('Made by ' + data.program.version + (hasChart ? ' with Chart.js ' + Chart.version : '') + '.');
}

/* ---- looking at itself ---- */

/* report.html?selftest adds what it finds as JSON, for the test of this page. */
const errors = [];
addEventListener('error', (event) => errors.push(String(event.message)));
addEventListener('securitypolicyviolation', (event) => errors.push('blocked: ' + event.blockedURI));
function drawn(canvas) {
  const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data, colors = new Set();
  let count = 0;
  for (let i = 0; i < pixels.length; i += 4) if (pixels[i + 3]) { count++; colors.add(pixels[i] << 16 | pixels[i + 1] << 8 | pixels[i + 2]); }
  return {label: canvas.getAttribute('aria-label'), pixels: count, colors: colors.size, width: canvas.clientWidth};
}
function selftest() {
  const page = document.documentElement, width = page.clientWidth;
  const report = {errors, width, scroll: page.scrollWidth, tables: {}, wide: [], legend: null, states: 0};
  for (const details of document.querySelectorAll('details')) details.open = true;
  /* A table that does not fit says so, one that fits does not. */
  report.scrolled = report.mute = 0;
  for (const box of boxes.filter((b) => b.scroll.isConnected && b.scroll.clientWidth)) {
    box.update();
    const more = box.scroll.scrollWidth > box.scroll.clientWidth + 1;
    report.scrolled += more;
    report.mute += more !== (box.hint.offsetHeight > 0);
  }
  for (const e of document.querySelectorAll('body *')) {
    const inside = e.closest('.scroll');
    if ((!inside || inside === e) && e.getBoundingClientRect().right > width + 0.5) report.wide.push(e.tagName + '.' + e.className);
  }
  report.scroll = Math.max(report.scroll, page.scrollWidth);
  report.canvases = [...document.querySelectorAll('canvas')].map(drawn);
  /* Axes that show a 0: how far it is from the least value, and the points that stand there. */
  report.zeros = charts.flatMap((chart) => Object.values(chart.scales).filter((scale) => scale.options.log && scale.options.log.zero).map((scale) => {
    const at = scale.getPixelForValue(scale.options.log.nil), tick = scale.ticks.find((t) => t.label === '0');
    const points = chart.data.datasets.flatMap((d, i) => chart.getDatasetMeta(i).data.map((p) => p[scale.axis])).filter((p) => Math.abs(p - at) < 0.5);
    return {name: chart.canvas.getAttribute('aria-label'), axis: scale.axis, apart: Math.abs(at - scale.getPixelForValue(scale.options.log.low)),
      labelled: !!tick && Math.abs(scale.getPixelForValue(tick.value) - at) < 0.5, points: points.length};
  }));
  report.bare = charts.flatMap((chart) => Object.values(chart.scales)).filter((scale) => scale.options.log && scale.ticks.length < 2).length;
  /* Ranges of all widths and places: none may leave an axis with one number. */
  report.ranges = 0;
  for (let i = 0; i < 4000; i++)
    report.ranges += logMarks(logScale([Math.pow(10, i % 1000 / 97 - 4), Math.pow(10, i % 1000 / 97 - 4 + Math.pow(i / 4000, 4) * 6)])).length < 2;
  report.text = document.body.innerText;
  report.lead = main.querySelector('section').textContent;
  for (const t of document.querySelectorAll('table')) {
    const rows = [...t.tBodies[0].rows];
    report.tables[t.dataset.name] = {rows: rows.length, text: rows.map((row) => [...row.cells].map((c) => c.textContent))};
  }
  report.images = [...document.images].map((image) => image.complete && image.naturalWidth > 0);
  report.requests = performance.getEntriesByType('resource').filter((e) => !e.name.startsWith('data:')).map((e) => e.name);
  const button = document.querySelector('#time .legend button'), time = () => charts.find((c) => /^(Time over lights|Time);/.test(c.canvas.getAttribute('aria-label'))).data;
  if (button && charts.length) {
    const count = () => time().datasets.length + time().labels.length;
    report.legend = [count()];
    button.click();
    report.legend.push(count());
    document.querySelector('#time .legend button').click();
  }
  /* Every choice that the selectors offer can be drawn. */
  const draw = () => { redraw(); report.states++; };
  for (state.case of cases)
    for (state.shading of unique(inCase().map((r) => r.shading)))
      for (state.lights of countsOf(lines())) draw();
  for (state.metric of Object.keys(metrics)) draw();
  document.body.append(element('pre', {id: 'selftest', hidden: ''}, JSON.stringify(report)));
  if (parent !== window) parent.postMessage(JSON.stringify(report), '*');
}

start();
if (location.search.includes('selftest')) {
  for (const image of document.images) image.loading = 'eager';
  addEventListener('load', () => setTimeout(selftest, 100));
}
}());
