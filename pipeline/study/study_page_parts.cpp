#include "pipeline/study/study_page.h"

namespace wry::pipeline {

std::string_view study_page_style() {
  return R"css(
:root{color-scheme:light dark;--bg:#f4f5f7;--card:#fff;--text:#1c2128;--muted:#5a6470;--line:#d9dde2;--accent:#1f6fb4;--bad:#b3261e;--warn:#8a5a00}
@media(prefers-color-scheme:dark){:root{--bg:#101316;--card:#191d22;--text:#e8eaed;--muted:#9aa4af;--line:#2e343b;--accent:#6db3f2;--bad:#ff8a80;--warn:#e5c158}}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--text);font:14px/1.45 system-ui,'DejaVu Sans',sans-serif}
header{padding:14px 18px 6px}
h1{font-size:19px;margin:0 12px 0 0;display:inline}
h2{font-size:14px;margin:0 0 8px}
a{color:var(--accent)}
#bar{position:sticky;top:0;z-index:5;display:flex;flex-wrap:wrap;gap:8px 14px;align-items:center;padding:8px 18px;background:var(--card);border-block:1px solid var(--line)}
#bar label{display:flex;gap:6px;align-items:center;color:var(--muted)}
#scrub{flex:1 1 220px;min-width:160px}
#frame{font-variant-numeric:tabular-nums;min-width:86px}
input[type=range]{accent-color:var(--accent)}
input[type=number]{width:86px}
button,select,input{font:inherit;color:inherit;background:var(--bg);border:1px solid var(--line);border-radius:5px;padding:3px 8px}
input[type=range]{padding:0}
main{display:grid;grid-template-columns:minmax(300px,420px) 1fr;gap:14px;padding:14px 18px}
@media(max-width:820px){main{grid-template-columns:1fr;padding:10px}}
section{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:12px;min-width:0}
#left{display:flex;flex-direction:column;gap:14px}
#right{display:flex;flex-direction:column;gap:14px;min-width:0}
#focus .picture{width:100%;border-radius:5px}
.slider{display:grid;grid-template-columns:minmax(80px,130px) 1fr minmax(60px,auto);gap:8px;align-items:center;margin:5px 0}
.slider span:first-child{color:var(--muted);overflow:hidden;text-overflow:ellipsis;white-space:nowrap}
.slider span:last-child{text-align:right;font-variant-numeric:tabular-nums}
.facts{display:grid;grid-template-columns:auto 1fr;gap:1px 12px;margin-top:8px;font-variant-numeric:tabular-nums}
.facts dt{color:var(--muted)}.facts dd{margin:0;overflow-wrap:anywhere}
#grid{overflow-x:auto}
#cells{display:grid;gap:6px;width:max-content}
#cells.flow{display:flex;flex-wrap:wrap;width:auto}
.head{align-self:center;text-align:center;max-width:150px;overflow-wrap:anywhere;color:var(--muted);font-variant-numeric:tabular-nums;padding:2px 6px}
.wedge{border:2px solid transparent;border-radius:6px;padding:2px;cursor:pointer;background:none;text-align:left;position:relative}
.wedge.chosen{border-color:var(--accent)}
.wedge .caption{display:block;font-size:11px;color:var(--muted);overflow:hidden;text-overflow:ellipsis;white-space:nowrap}
.picture{display:block;background-repeat:no-repeat;background-color:#2a2d31;border-radius:4px;overflow:hidden;position:relative}
.picture img{position:absolute;inset:0;width:100%;height:100%}
.noimage{display:flex;align-items:center;justify-content:center;padding:6px;font-size:11px;color:#ffb4ab;background:#2b1d1e;text-align:center;overflow:hidden}
.bad{color:var(--bad)}.warn{color:var(--warn)}.muted{color:var(--muted)}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:3px 8px;border-bottom:1px solid var(--line);vertical-align:top}
th{color:var(--muted);font-weight:500;cursor:pointer;white-space:nowrap}
td:first-child{white-space:nowrap}
td.reason{white-space:pre-wrap;overflow-wrap:anywhere}
.scroll{overflow-x:auto}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(300px,1fr));gap:12px}
svg{width:100%;height:auto;display:block}
svg text{fill:var(--muted);font-size:11px}
.gridline{stroke:var(--line)}
)css";
}

std::string_view study_page_body() {
  return R"html(
<header><h1 id="title"></h1><span id="summary" class="muted"></span> <span id="links"></span></header>
<div id="bar">
<button id="play" title="space">play</button>
<input id="scrub" type="range" min="0" max="0" value="0" aria-label="frame">
<span id="frame"></span>
<label>across <select id="xaxis"></select></label>
<label>down <select id="yaxis"></select></label>
<label>size <input id="size" type="range" min="80" max="420" value="200"></label>
<label>keep where <select id="fmeasure"></select></label>
<label>from <input id="fmin" type="number" step="any"></label>
<label>to <input id="fmax" type="number" step="any"></label>
<span id="kept" class="muted"></span>
</div>
<main>
<div id="left">
<section id="focus"><h2 id="fname"></h2><div id="fpicture"></div><div id="sliders"></div><dl class="facts" id="facts"></dl></section>
<section id="failures" hidden><h2>Not done</h2><div class="scroll"><table id="ftable"></table></div></section>
</div>
<div id="right">
<section id="grid"><div id="cells"></div></section>
<section><h2>Measures</h2>
<label>measure <select id="pmeasure"></select></label> <label>over <select id="pparam"></select></label>
<div class="plots"><div id="overparam"></div><div id="overtime"></div></div></section>
<section><h2>All wedges</h2><div class="scroll"><table id="all"></table></div></section>
</div>
</main>
)html";
}

std::string_view study_page_script() {
  return R"js(
'use strict';
const S = JSON.parse(document.getElementById('study').textContent);
const $ = id => document.getElementById(id);
const make = (tag, props, ...kids) => { const e = Object.assign(document.createElement(tag), props || {}); e.append(...kids); return e; };
const frames = [...new Set(S.wedges.flatMap(w => w.strip ? w.strip.frames : []))].sort((a, b) => a - b);
const state = { frame: 0, chosen: S.wedges.find(w => w.strip) || S.wedges[0], x: '', y: '', playing: false };
const varying = S.parameters.filter(p => p.values.length > 1);
const short = v => typeof v === 'number' ? (v === 0 || (Math.abs(v) >= 1e-3 && Math.abs(v) < 1e5) ? String(+v.toPrecision(5)) : v.toExponential(2)) : String(v);

function cellOf(strip, frame) { // the last frame that is there, up to the one asked for
  let i = 0;
  while (i + 1 < strip.frames.length && strip.frames[i + 1] <= frame) ++i;
  return i;
}
function paint(box, wedge, width) {
  const s = wedge.strip;
  if (!s) return;
  const i = cellOf(s, frames[state.frame]), k = width / s.width, rows = Math.ceil(s.frames.length / s.columns);
  box.style.backgroundSize = s.columns * width + 'px ' + rows * s.height * k + 'px';
  box.style.backgroundPosition = -(i % s.columns) * width + 'px ' + -Math.floor(i / s.columns) * s.height * k + 'px';
  box.dataset.frame = s.frames[i];
}
function pictureBox(wedge, width) {
  const s = wedge.strip || (S.wedges.find(w => w.strip) || {}).strip || { width: 16, height: 9 };
  const box = make('span', { className: 'picture' + (wedge.strip ? '' : ' noimage') });
  box.style.width = width + 'px';
  box.style.height = width * s.height / s.width + 'px';
  if (wedge.strip) box.style.backgroundImage = 'url("' + encodeURI(wedge.strip.file) + '")';
  else box.textContent = wedge.outcome + (wedge.reason && width > 160 ? ': ' + wedge.reason : '');
  paint(box, wedge, width);
  return box;
}
function kept(w) {
  const name = $('fmeasure').value;
  if (!name) return true;
  const v = w.measures[name], lo = $('fmin').value, hi = $('fmax').value;
  return v !== undefined && (lo === '' || v >= +lo) && (hi === '' || v <= +hi);
}
// With more parameters than axes, the grid is the slice through the chosen wedge.
function inSlice(w) {
  return varying.every(p => p.key === state.x || p.key === state.y || w.parameters[p.key] === state.chosen.parameters[p.key]);
}
const boxes = new Map();
function wedgeButton(w, width) {
  const box = pictureBox(w, width);
  const b = make('button', { className: 'wedge' + (w === state.chosen ? ' chosen' : ''), title: w.name + (w.reason ? '\n' + w.reason : '') }, box,
    make('span', { className: 'caption' + (w.outcome === 'done' ? '' : ' bad'), textContent: String(w.index).padStart(3, '0') + ' ' + (w.outcome !== 'done' ? w.outcome : state.x ? '' : w.name) }));
  b.dataset.id = w.id;
  b.style.width = width + 6 + 'px';
  b.onclick = () => choose(w);
  boxes.set(w.id, [box, w, width]);
  return b;
}
function drawGrid() {
  const cells = $('cells'), width = +$('size').value;
  boxes.clear();
  cells.replaceChildren();
  const px = S.parameters.find(p => p.key === state.x), py = S.parameters.find(p => p.key === state.y);
  const shown = S.wedges.filter(kept);
  $('kept').textContent = shown.length === S.wedges.length ? '' : shown.length + ' of ' + S.wedges.length;
  cells.className = px ? '' : 'flow';
  if (!px) { shown.forEach(w => cells.append(wedgeButton(w, width))); return; }
  const ys = py ? py.values : [null];
  cells.style.gridTemplateColumns = 'auto repeat(' + px.values.length + ', max-content)';
  cells.append(make('div', { className: 'head' }, px.label + ' \u2192', ...(py ? [make('br'), py.label + ' \u2193'] : [])), ...px.values.map(v => make('div', { className: 'head', textContent: v || '-' })));
  for (const y of ys) {
    cells.append(make('div', { className: 'head', textContent: y === null ? '' : y || '-' }));
    for (const x of px.values) {
      const cell = make('div');
      shown.filter(w => (w.parameters[px.key] ?? '') === x && (!py || (w.parameters[py.key] ?? '') === y) && inSlice(w)).forEach(w => cell.append(wedgeButton(w, width)));
      cells.append(cell);
    }
  }
}
function nearest(key, value) { // the wedge with this value that shares most of the other parameters
  let best = null, bestScore = -1;
  for (const w of S.wedges) {
    if ((w.parameters[key] ?? '') !== value) continue;
    const score = varying.filter(p => w.parameters[p.key] === state.chosen.parameters[p.key]).length;
    if (score > bestScore) { best = w; bestScore = score; }
  }
  return best;
}
function drawSliders() {
  $('sliders').replaceChildren(...varying.map(p => {
    const now = p.values.indexOf(state.chosen.parameters[p.key] ?? '');
    const value = make('span', { textContent: p.values[now] || '-' });
    const slider = make('input', { type: 'range', min: 0, max: p.values.length - 1, value: now, title: p.key });
    slider.dataset.key = p.key;
    slider.oninput = () => { const w = nearest(p.key, p.values[+slider.value]); if (w) choose(w, slider.dataset.key); };
    return make('div', { className: 'slider' }, make('span', { textContent: p.label, title: p.key }), slider, value);
  }));
}
let focusBox = null, loader = 0;
function drawFocus() {
  const w = state.chosen;
  $('fname').textContent = w.id + '  ' + w.name;
  const width = Math.max(200, $('fpicture').clientWidth);
  focusBox = pictureBox(w, width);
  $('fpicture').replaceChildren(focusBox);
  const rows = [['outcome', w.outcome], ...Object.entries(w.measures).map(([k, v]) => [k, short(v)]), ['time', short(w.wall_s) + ' s, ' + short(w.cpu_s) + ' s of a core'], ['memory', Math.round(w.peak_bytes / 1048576) + ' MiB']];
  $('facts').replaceChildren(...rows.flatMap(([k, v]) => [make('dt', { textContent: k }), make('dd', { textContent: v })]), make('dt', { textContent: 'folder' }), make('dd', {}, make('a', { href: encodeURI(w.folder) + '/', textContent: w.folder }), ' ', make('a', { href: encodeURI(w.folder) + '/report.html', textContent: 'report' })));
  sharpen();
}
function sharpen() { // the full picture, once scrubbing rests
  clearTimeout(loader);
  if (!state.chosen.image || state.playing) return;
  loader = setTimeout(() => {
    const img = new Image(), box = focusBox, frame = box.dataset.frame;
    img.onload = () => { if (box === focusBox && box.dataset.frame === frame) box.replaceChildren(img); };
    img.src = encodeURI(state.chosen.image + String(frame).padStart(4, '0') + '.png');
  }, 120);
}
function choose(w, byKey) {
  state.chosen = w;
  drawFocus();
  if (!byKey) drawSliders(); else {
    for (const s of document.querySelectorAll('#sliders input')) {
      const p = varying.find(q => q.key === s.dataset.key);
      s.value = p.values.indexOf(w.parameters[p.key] ?? '');
      s.nextSibling.textContent = p.values[+s.value] || '-';
    }
  }
  drawGrid();
  drawPlots();
}
function setFrame(i) {
  if (!frames.length) return;
  state.frame = Math.max(0, Math.min(frames.length - 1, i));
  $('scrub').value = state.frame;
  $('frame').textContent = 'frame ' + frames[state.frame];
  for (const [box, w, width] of boxes.values()) paint(box, w, width);
  if (focusBox) { focusBox.replaceChildren(...(state.chosen.strip ? [] : [focusBox.textContent])); paint(focusBox, state.chosen, focusBox.clientWidth); sharpen(); }
  const mark = $('now');
  if (mark) { const x = timeX(); mark.setAttribute('x1', x); mark.setAttribute('x2', x); }
}
const COLOURS = ['#4c9ad6', '#e0793f', '#45a56a', '#a878cc', '#c39a1c', '#d8608c', '#21a0a0', '#87919c'];
const NS = 'http://www.w3.org/2000/svg';
const svg = (tag, attrs, text) => { const e = document.createElementNS(NS, tag); for (const k in attrs) e.setAttribute(k, attrs[k]); if (text !== undefined) e.textContent = text; return e; };
function ticks(lo, hi) {
  const raw = (hi - lo) / 5 || 1, p = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].find(k => k * p >= raw * 0.999) * p, list = [];
  for (let v = Math.ceil(lo / step) * step; v <= hi + 1e-9 * step; v += step) list.push(+v.toPrecision(12));
  return list;
}
let timeScale = null;
function timeX() {
  if (!timeScale) return 0;
  return timeScale(frames[state.frame]);
}
// Labels keep off each other: each at the height of its line's end or pushed from there, in order.
function spread(labels, least, top, bottom) {
  labels.sort((a, b) => a.at - b.at);
  labels.forEach((l, i) => { l.y = Math.max(l.at, i ? labels[i - 1].y + least : top); });
  for (let i = labels.length - 1, limit = bottom; i >= 0 && labels[i].y > limit; limit = labels[i].y - least, --i) labels[i].y = limit;
  return labels;
}
const clipped = (text, most) => text.length > most ? text.slice(0, most - 1) + '\u2026' : text;
function plot(title, xlabel, series, names) {
  const longest = Math.min(22, Math.max(0, ...series.map(s => (s.label || '').length)));
  const W = 400, H = 250, L = 52, R = longest ? 18 + 6.3 * longest : 10, T = 24, B = 34, root = svg('svg', { viewBox: '0 0 ' + W + ' ' + H, role: 'img' });
  const pts = series.flatMap(s => s.points).filter(p => Number.isFinite(p[0]) && Number.isFinite(p[1]));
  root.append(svg('text', { x: L, y: 14 }, title));
  if (!pts.length) { root.append(svg('text', { x: W / 2, y: H / 2 }, 'nothing to show')); return [root, null]; }
  let [x0, x1, y0, y1] = [Math.min(...pts.map(p => p[0])), Math.max(...pts.map(p => p[0])), Math.min(...pts.map(p => p[1])), Math.max(...pts.map(p => p[1]))];
  if (x0 === x1) { x0 -= 0.5; x1 += 0.5; }
  if (y0 === y1) { const d = Math.abs(y0) / 2 || 0.5; y0 -= d; y1 += d; }
  const X = v => L + (W - L - R) * (v - x0) / (x1 - x0), Y = v => H - B - (H - T - B) * (v - y0) / (y1 - y0);
  for (const t of ticks(y0, y1)) root.append(svg('line', { class: 'gridline', x1: L, x2: W - R, y1: Y(t), y2: Y(t) }), svg('text', { x: L - 6, y: Y(t) + 4, 'text-anchor': 'end' }, short(t)));
  if (names) { // only as many as there is room for
    const room = (W - L - R) / Math.max(1, names.length - 1), most = Math.max(...names.map(n => n.length)), every = Math.ceil((Math.min(most, 14) * 6.3 + 8) / room);
    names.forEach((n, i) => { if (i % every === 0) root.append(svg('text', { x: X(i), y: H - 18, 'text-anchor': names.length < 2 ? 'middle' : i === 0 ? 'start' : 'middle' }, clipped(n, 14))); });
  }
  else for (const t of ticks(x0, x1)) root.append(svg('line', { class: 'gridline', x1: X(t), x2: X(t), y1: T, y2: H - B }), svg('text', { x: X(t), y: H - 18, 'text-anchor': 'middle' }, short(t)));
  root.append(svg('text', { x: W - R, y: H - 4, 'text-anchor': 'end' }, xlabel));
  const labels = [];
  for (const s of series) {
    const on = s.points.filter(p => Number.isFinite(p[0]) && Number.isFinite(p[1]));
    root.append(svg('polyline', { points: on.map(p => X(p[0]) + ',' + Y(p[1])).join(' '), fill: 'none', stroke: s.colour, 'stroke-width': s.strong ? 2.6 : 1.2, opacity: s.strong ? 1 : 0.55 }));
    if (s.label && on.length) labels.push({ series: s, x: X(on[on.length - 1][0]), at: Y(on[on.length - 1][1]) });
    if (s.dots) on.forEach(p => { const c = svg('circle', { cx: X(p[0]), cy: Y(p[1]), r: p[2] === state.chosen ? 6 : 4, fill: s.colour }); c.append(svg('title', {}, p[2].name)); c.style.cursor = 'pointer'; c.onclick = () => choose(p[2]); root.append(c); });
  }
  for (const l of spread(labels, 12, T, H - B)) {
    const name = svg('text', { class: 'label', x: W - R + 14, y: l.y + 4, style: 'fill:' + l.series.colour, 'font-weight': l.series.strong ? 700 : 400 }, clipped(l.series.label, 22));
    name.append(svg('title', {}, l.series.label));
    root.append(svg('line', { x1: l.x + 5, y1: l.at, x2: W - R + 11, y2: l.y, stroke: l.series.colour, 'stroke-width': 0.8, opacity: 0.6 }), name);
  }
  return [root, X];
}
function drawPlots() {
  const m = $('pmeasure').value, p = S.parameters.find(q => q.key === $('pparam').value);
  if (!m) { $('overparam').textContent = 'This shot has no [[measure]].'; return; }
  if (p) {
    const groups = new Map(); // wedges that differ in this parameter alone lie on one line
    for (const w of S.wedges) {
      if (w.measures[m] === undefined) continue;
      const rest = varying.filter(q => q !== p).map(q => (q.key === 'case' ? '' : q.label + ' ') + (w.parameters[q.key] ?? '-')).join(', ');
      if (!groups.has(rest)) groups.set(rest, []);
      const v = w.parameters[p.key] ?? '';
      groups.get(rest).push([p.numeric ? +v : p.values.indexOf(v), w.measures[m], w]);
    }
    const series = [...groups.entries()].map(([rest, points], i) => ({ points: points.sort((a, b) => a[0] - b[0]), colour: COLOURS[i % COLOURS.length], dots: true, strong: points.some(q => q[2] === state.chosen), label: groups.size > 1 && groups.size <= 16 ? rest : '' }));
    $('overparam').replaceChildren(plot(m + ' at the end', p.label, series, p.numeric ? null : p.values)[0]);
  }
  const curves = S.wedges.filter(w => w.curves[m]).map((w, i) => ({ points: w.curves.frame.map((f, k) => [f, w.curves[m][k] ?? NaN]), colour: w === state.chosen ? 'var(--accent)' : '#87919c', strong: w === state.chosen }));
  const [root, X] = plot(m, 'frame', curves.sort((a, b) => a.strong - b.strong));
  timeScale = X;
  if (X && frames.length) { const x = timeX(); root.append(svg('line', { id: 'now', x1: x, x2: x, y1: 24, y2: 226, stroke: 'var(--bad)' })); }
  $('overtime').replaceChildren(root);
}
function drawTables() {
  const bad = S.wedges.filter(w => w.outcome !== 'done');
  $('failures').hidden = !bad.length;
  $('ftable').replaceChildren(...bad.map(w => { const r = make('tr', {}, make('td', {}, w.id, make('br'), make('span', { className: 'muted', textContent: w.name })), make('td', { className: 'reason bad', textContent: w.outcome + (w.reason ? ': ' + w.reason : '') })); r.onclick = () => choose(w); return r; }));
  const columns = [['wedge', w => w.id], ...S.parameters.map(p => [p.label, w => w.parameters[p.key] ?? '']), ['outcome', w => w.outcome], ...S.measures.map(m => [m, w => w.measures[m] ?? '']), ['time [s]', w => w.wall_s]];
  let order = 0, up = true;
  const fill = () => {
    const value = w => columns[order][1](w), number = v => v !== '' && Number.isFinite(+v);
    const list = [...S.wedges].sort((a, b) => { const [x, y] = [value(a), value(b)]; return (number(x) && number(y) ? x - y : String(x).localeCompare(String(y))) * (up ? 1 : -1); });
    $('all').replaceChildren(make('tr', {}, ...columns.map(([n], i) => { const h = make('th', { textContent: n + (i === order ? (up ? ' \u2191' : ' \u2193') : '') }); h.onclick = () => { up = order === i ? !up : true; order = i; fill(); }; return h; })),
      ...list.map(w => { const r = make('tr', {}, ...columns.map(([, f]) => make('td', { textContent: short(f(w)) }))); r.style.cursor = 'pointer'; r.onclick = () => choose(w); return r; }));
  };
  fill();
}
function options(select, list, chosen) { select.replaceChildren(...list.map(([v, t]) => make('option', { value: v, textContent: t, selected: v === chosen }))); }
function setPlaying(on) {
  state.playing = on;
  $('play').textContent = on ? 'pause' : 'play';
  clearInterval(state.timer);
  if (on) state.timer = setInterval(() => setFrame((state.frame + 1) % frames.length), 1000 / 24);
  else sharpen();
}
function start() {
  $('title').textContent = S.name;
  $('summary').textContent = S.summary;
  for (const [file, text] of [[S.sheet, 'contact sheet'], [S.mosaic, 'film'], ['sweep.csv', 'table']]) if (file) $('links').append(' ', make('a', { href: file, textContent: text }));
  const axes = [['', 'free'], ...varying.map(p => [p.key, p.label])];
  const product = varying.reduce((n, p) => n * p.values.length, 1), isGrid = varying.length > 0 && product === S.wedges.length;
  const by = [...varying].sort((a, b) => b.values.length - a.values.length);
  state.x = isGrid ? by[0].key : '';
  state.y = isGrid && by[1] ? by[1].key : '';
  options($('xaxis'), axes, state.x);
  options($('yaxis'), axes, state.y);
  options($('fmeasure'), [['', 'any'], ...S.measures.map(m => [m, m])], '');
  options($('pmeasure'), S.measures.map(m => [m, m]), S.measures[0]);
  options($('pparam'), varying.map(p => [p.key, p.label]), by[0] && by[0].key);
  const across = S.parameters.find(p => p.key === state.x);
  if (across) $('size').value = Math.floor(($('grid').clientWidth - 140) / across.values.length) - 12; // all columns in sight
  $('scrub').max = Math.max(0, frames.length - 1);
  $('scrub').oninput = () => { setPlaying(false); setFrame(+$('scrub').value); };
  $('play').onclick = () => setPlaying(!state.playing);
  $('size').oninput = drawGrid;
  for (const id of ['fmeasure', 'fmin', 'fmax']) $(id).oninput = drawGrid;
  for (const id of ['pmeasure', 'pparam']) $(id).oninput = drawPlots;
  $('xaxis').oninput = () => { state.x = $('xaxis').value; drawGrid(); };
  $('yaxis').oninput = () => { state.y = $('yaxis').value; drawGrid(); };
  addEventListener('keydown', e => {
    if (e.target.tagName === 'INPUT' || e.target.tagName === 'SELECT') return;
    if (e.key === ' ') { e.preventDefault(); setPlaying(!state.playing); }
    if (e.key === 'ArrowRight') setFrame(state.frame + 1);
    if (e.key === 'ArrowLeft') setFrame(state.frame - 1);
  });
  addEventListener('resize', drawFocus);
  if (!S.wedges.length) return;
  drawTables();
  choose(state.chosen);
  setFrame(frames.length - 1);
}
start();
)js";
}

} // namespace wry::pipeline
