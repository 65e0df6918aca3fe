// Values where the pointer is, zoom, and download of figures. Without it the page says the same.
'use strict';
(() => {
  const axis = (text) => {
    const [kind, ...n] = text.split(' ');
    const [lo, hi, a, b] = n.map(Number);
    const f = kind === 'log' ? Math.log : (v) => v, g = kind === 'log' ? Math.exp : (v) => v;
    return { kind, a, b, lo: f(lo), hi: f(hi), f, g };
  };
  const value = (x, at) => x.g(x.lo + (at - x.a) / (x.b - x.a) * (x.hi - x.lo));
  const place = (x, v) => x.a + (x.f(v) - x.lo) / (x.hi - x.lo) * (x.b - x.a);
  const number = (v) => {
    if (v === 0 || (Math.abs(v) >= 1e-3 && Math.abs(v) < 1e5)) return String(+v.toPrecision(4)).replace('-', '−');
    return v.toExponential(2).replace('-', '−');
  };
  const ns = 'http://www.w3.org/2000/svg';
  const make = (tag, attributes, parent) => {
    const e = document.createElementNS(ns, tag);
    for (const k in attributes) e.setAttribute(k, attributes[k]);
    return parent.appendChild(e);
  };
  // Round ticks, as in the figure itself.
  const ticks = (x) => {
    if (x.kind === 'log' && x.hi - x.lo > Math.log(10) * 1.2) {
      const found = [];
      for (let d = Math.floor(x.lo / Math.LN10); d <= Math.ceil(x.hi / Math.LN10); d++) found.push(10 ** d);
      return found;
    }
    const lo = x.g(x.lo), hi = x.g(x.hi), rough = (hi - lo) / 6, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999);
    const found = [];
    for (let k = Math.ceil(lo / step); k * step <= hi; k++) found.push(k * step);
    return found;
  };

  let count = 0;
  document.querySelectorAll('svg.chart').forEach((svg) => {
    const x = axis(svg.dataset.x), y = axis(svg.dataset.y);
    const whole = { x: [x.lo, x.hi], y: [y.lo, y.hi] };
    const plot = svg.querySelector('g.plot'), axes = svg.querySelector('g.axes');
    const original = axes.innerHTML;
    const texts = [...axes.querySelectorAll('text')].slice(-2).map((t) => t.outerHTML).join('');
    const clip = make('clipPath', { id: 'clip' + count }, svg);
    make('rect', { x: x.a, y: y.b, width: x.b - x.a, height: y.a - y.b }, clip);
    plot.setAttribute('clip-path', `url(#clip${count++})`);
    // Every drawn point in the coordinates of its axes.
    const shapes = [...plot.querySelectorAll('polyline, polygon, circle')].map((e) => {
      const pairs = e.tagName === 'circle' ? [[+e.getAttribute('cx'), +e.getAttribute('cy')]]
        : e.getAttribute('points').trim().split(/\s+/).filter(Boolean).map((p) => p.split(',').map(Number));
      return { e, data: pairs.map(([a, b]) => [value(x, a), value(y, b)]) };
    });
    const series = [...plot.querySelectorAll('g[data-told]')].map((g) => ({
      told: g.dataset.told,
      colour: (g.querySelector('[stroke]') || g).getAttribute('stroke'),
      data: shapes.filter((s) => g.contains(s.e) && s.e.tagName !== 'polygon').flatMap((s) => s.data),
    })).filter((s) => s.data.length);

    const draw = () => {
      for (const { e, data } of shapes) {
        const at = data.map(([a, b]) => [place(x, a).toFixed(2), place(y, b).toFixed(2)]);
        if (e.tagName === 'circle') { e.setAttribute('cx', at[0][0]); e.setAttribute('cy', at[0][1]); }
        else e.setAttribute('points', at.map((p) => p.join(',')).join(' '));
      }
      if (x.lo === whole.x[0] && x.hi === whole.x[1] && y.lo === whole.y[0] && y.hi === whole.y[1]) {
        axes.innerHTML = original;
        return;
      }
      axes.innerHTML = '';
      const text = (t, attributes) => { make('text', { fill: '#6a737d', ...attributes }, axes).textContent = number(t); };
      for (const t of ticks(y)) {
        const at = place(y, t);
        make('line', { x1: x.a, x2: x.b, y1: at, y2: at, stroke: '#e6e8eb' }, axes);
        text(t, { x: x.a - 7, y: at + 4, 'text-anchor': 'end' });
      }
      for (const t of ticks(x)) {
        const at = place(x, t);
        make('line', { x1: at, x2: at, y1: y.a, y2: y.a + 5, stroke: '#6a737d' }, axes);
        text(t, { x: at, y: y.a + 18, 'text-anchor': 'middle' });
      }
      make('line', { x1: x.a, x2: x.b, y1: y.a, y2: y.a, stroke: '#6a737d' }, axes);
      axes.insertAdjacentHTML('beforeend', texts);
    };

    const holder = document.createElement('div');
    holder.className = 'live';
    svg.replaceWith(holder);
    holder.append(svg);
    const tip = holder.appendChild(document.createElement('div'));
    tip.className = 'tip';
    const cross = make('line', { y1: y.b, y2: y.a, stroke: '#6a737d', 'stroke-dasharray': '2 3', visibility: 'hidden' }, svg);
    const box = make('rect', { fill: '#0072b2', 'fill-opacity': 0.12, visibility: 'hidden' }, svg);
    const at = (event) => {
      const r = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / r.width;
      return [(event.clientX - r.left) * scale, (event.clientY - r.top) * scale];
    };
    const inside = ([a, b]) => a >= x.a && a <= x.b && b >= y.b && b <= y.a;
    const hide = () => { tip.style.display = 'none'; cross.setAttribute('visibility', 'hidden'); };
    let from = null;
    svg.addEventListener('pointermove', (event) => {
      const p = at(event);
      if (from) {
        const [a, b] = [0, 1].map((i) => [Math.min(from[i], p[i]), Math.abs(from[i] - p[i])]);
        for (const [k, v] of Object.entries({ x: a[0], width: a[1], y: b[0], height: b[1], visibility: 'visible' })) box.setAttribute(k, v);
        return hide();
      }
      if (!inside(p) || !series.length) return hide();
      const near = (s) => s.data.reduce((best, d) => Math.abs(place(x, d[0]) - p[0]) < Math.abs(place(x, best[0]) - p[0]) ? d : best);
      let found = series.map((s) => ({ ...s, near: near(s) }));
      const first = found.reduce((best, s) => Math.abs(place(x, s.near[0]) - p[0]) < Math.abs(place(x, best.near[0]) - p[0]) ? s : best).near[0];
      found = found.filter((s) => Math.abs(place(x, s.near[0]) - place(x, first)) < 8);
      // Of very many the nearest.
      found.sort((a, b) => Math.abs(place(y, a.near[1]) - p[1]) - Math.abs(place(y, b.near[1]) - p[1]));
      tip.replaceChildren(Object.assign(document.createElement('b'), { textContent: number(first) }));
      for (const s of found.slice(0, 6)) {
        const line = tip.appendChild(document.createElement('div'));
        line.textContent = `${s.told} ${number(s.near[1])}`;
        line.style.color = s.colour;
      }
      const r = holder.getBoundingClientRect();
      tip.style.display = 'block';
      const left = event.clientX - r.left, over = left + tip.offsetWidth + 16 > r.width;
      tip.style.left = Math.max(0, over ? left - tip.offsetWidth - 12 : left + 12) + 'px';
      tip.style.top = Math.max(0, event.clientY - r.top - 10) + 'px';
      const c = place(x, first);
      for (const [k, v] of Object.entries({ x1: c, x2: c, visibility: 'visible' })) cross.setAttribute(k, v);
    });
    svg.addEventListener('pointerleave', hide);
    svg.addEventListener('pointerdown', (event) => {
      const p = at(event);
      if (event.pointerType === 'mouse' && inside(p)) { from = p; svg.setPointerCapture(event.pointerId); event.preventDefault(); }
    });
    svg.addEventListener('pointerup', (event) => {
      if (!from) return;
      const to = at(event), start = from;
      from = null;
      box.setAttribute('visibility', 'hidden');
      const range = (axis, i) => {
        const limit = (v) => Math.min(Math.max(v, Math.min(axis.a, axis.b)), Math.max(axis.a, axis.b));
        const ends = [limit(start[i]), limit(to[i])].map((v) => axis.f(value(axis, v)));
        return [Math.min(...ends), Math.max(...ends)];
      };
      if (Math.abs(start[0] - to[0]) < 6 && Math.abs(start[1] - to[1]) < 6) return;
      const [rx, ry] = [range(x, 0), range(y, 1)];
      if (Math.abs(start[0] - to[0]) >= 6) [x.lo, x.hi] = rx;
      if (Math.abs(start[1] - to[1]) >= 6) [y.lo, y.hi] = ry;
      draw();
    });
    const reset = () => { [x.lo, x.hi] = whole.x; [y.lo, y.hi] = whole.y; draw(); };
    svg.addEventListener('dblclick', reset);

    const save = (name, type, text) => {
      const a = document.createElement('a');
      a.href = URL.createObjectURL(new Blob([text], { type }));
      a.download = name;
      a.click();
      setTimeout(() => URL.revokeObjectURL(a.href), 1000);
    };
    const name = (svg.querySelector('title')?.textContent || 'figure').replace(/[^\p{L}\p{N}]+/gu, '_');
    const buttons = holder.appendChild(document.createElement('div'));
    buttons.className = 'buttons';
    const button = (text, title, act) => {
      const b = buttons.appendChild(document.createElement('button'));
      Object.assign(b, { type: 'button', textContent: text, title });
      b.addEventListener('click', act);
    };
    button('whole', 'Undo the zoom (also: double click)', reset);
    button('SVG', 'Save the figure', () => save(name + '.svg', 'image/svg+xml', new XMLSerializer().serializeToString(svg)));
    button('CSV', 'Save what is drawn as numbers', () => {
      const quoted = (t) => `"${t.replace(/"/g, '""')}"`;
      const rows = series.flatMap((s) => s.data.map(([a, b]) => `${quoted(s.told)},${+a.toPrecision(5)},${+b.toPrecision(5)}`));
      save(name + '.csv', 'text/csv', 'series,x,y\n' + rows.join('\n') + '\n');
    });
  });
})();
