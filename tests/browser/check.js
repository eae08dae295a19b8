// Judges the page that is open and gives its faults, each as "kind: what and where". `view` tells how it is shown:
// {width, dark, paper}.
(async view => {
  await document.fonts.ready;
  // What is folded must be legible as well.
  for (const folded of document.querySelectorAll('details')) folded.open = true;
  const faults = [];
  const fault = (kind, text) => faults.push(`${kind}: ${text}`);
  const short = text => JSON.stringify(text.replace(/\s+/g, ' ').trim().slice(0, 60));
  const root = document.documentElement;

  // The view is the one that was asked for.
  const media = query => matchMedia(query).matches;
  if (innerWidth !== view.width) fault('view', `${innerWidth} px wide, not ${view.width}`);
  if (media('(prefers-color-scheme: dark)') !== view.dark) fault('view', 'not the colour scheme that was asked for');
  if (media('print') !== view.paper) fault('view', 'not the medium that was asked for');

  // ---- What is a text, and where.

  // The four corners of a box in the coordinates of an SVG element.
  const corners = (box, matrix) => [[0, 0], [1, 0], [1, 1], [0, 1]].map(([u, v]) => {
    const p = new DOMPoint(box.x + u * box.width, box.y + v * box.height).matrixTransform(matrix);
    return [p.x, p.y];
  });
  const bounds = quad => {
    const x = quad.map(p => p[0]), y = quad.map(p => p[1]);
    return { left: Math.min(...x), right: Math.max(...x), top: Math.min(...y), bottom: Math.max(...y) };
  };
  const seen = element => element.checkVisibility({ opacityProperty: true, visibilityProperty: true });
  const texts = [];
  const add = (element, text, quad, size) => texts.push({ element, text, quad, box: bounds(quad), size });

  for (const element of document.querySelectorAll('svg text')) {
    if (!seen(element) || !element.textContent.trim()) continue;
    const matrix = element.getScreenCTM();
    const scale = Math.hypot(matrix.b, matrix.d);
    add(element, element.textContent, corners(element.getBBox(), matrix), parseFloat(getComputedStyle(element).fontSize) * scale);
  }
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode());) {
    const element = node.parentElement;
    if (!node.data.trim() || element.closest('svg,script,style,template,noscript') || !seen(element)) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const r of range.getClientRects()) {
      if (r.width < 0.5 || r.height < 0.5) continue;
      add(element, node.data, corners(r, new DOMMatrix()), parseFloat(getComputedStyle(element).fontSize));
    }
  }
  if (!texts.length) fault('empty', 'there is no text');

  // ---- No text over another one.

  // How deep two convex quadrilaterals lie in each other along the direction in which it is least.
  const depth = (a, b) => {
    let least = Infinity;
    for (const quad of [a, b]) {
      for (let k = 0; k < 2; k++) {
        const [dx, dy] = [quad[k + 1][0] - quad[k][0], quad[k + 1][1] - quad[k][1]];
        const length = Math.hypot(dx, dy);
        if (length < 1e-6) return 0;
        const along = q => q.map(([x, y]) => (x * dx + y * dy) / length);
        const [u, v] = [along(a), along(b)];
        least = Math.min(least, Math.max(...u) - Math.min(...v), Math.max(...v) - Math.min(...u));
      }
    }
    return least;
  };
  texts.sort((a, b) => a.box.top - b.box.top);
  texts.forEach((a, k) => {
    for (let j = k + 1; j < texts.length && texts[j].box.top < a.box.bottom - 2; j++) {
      const b = texts[j];
      if (a.box.left < b.box.right - 2 && b.box.left < a.box.right - 2 && depth(a.quad, b.quad) > 2) {
        fault('overlap', `${short(a.text)} and ${short(b.text)}, by ${depth(a.quad, b.quad).toFixed(1)} px`);
      }
    }
  });

  // ---- No text cut, by whatever is around it; what can be scrolled sideways is not cut, except on paper.

  for (const { element, text, box } of texts) {
    const rest = { ...box };
    const first = element.namespaceURI.endsWith('svg') ? element.parentElement : element;
    for (let e = first; e && e !== root; e = e.parentElement) {
      const style = getComputedStyle(e);
      const frame = e.getBoundingClientRect();
      const turn = { x: style.overflowX, y: style.overflowY };
      if (e.localName === 'body' || style.display === 'inline' && e.localName !== 'svg') continue;
      if (turn.y !== 'visible' && (rest.top < frame.top - 1 || rest.bottom > frame.bottom + 1)) {
        fault('cut', `${short(text)} by <${e.localName}>, above or below`);
        break;
      }
      const out = rest.left < frame.left - 1 || rest.right > frame.right + 1;
      if (turn.x === 'visible' || !out) continue;
      if (view.paper || !['auto', 'scroll'].includes(turn.x)) {
        fault('cut', `${short(text)} by <${e.localName}>, at a side`);
        break;
      }
      Object.assign(rest, { left: Math.max(rest.left, frame.left), right: Math.min(rest.right, frame.right) });
      if (rest.left >= rest.right) break;
    }
    if (rest.left < -1 || rest.top < -1) fault('cut', `${short(text)} by the edge of the page`);
  }
  const wide = Math.max(document.scrollingElement.scrollWidth, document.body.scrollWidth);
  if (wide > innerWidth) fault('width', `the page is ${wide} px wide`);

  // ---- Contrast and size.

  const brush = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
  const known = new Map();
  const colour = (text, opacity = 1) => {
    if (!known.has(text)) {
      brush.clearRect(0, 0, 1, 1);
      brush.fillStyle = text;
      brush.fillRect(0, 0, 1, 1);
      const [r, g, b, a] = brush.getImageData(0, 0, 1, 1).data;
      known.set(text, [r, g, b, a / 255]);
    }
    const [r, g, b, a] = known.get(text);
    return [r, g, b, a * opacity];
  };
  const over = ([r, g, b, a], under) => [r, g, b].map((v, k) => a * v + (1 - a) * under[k]);
  const luminance = rgb => {
    const [r, g, b] = rgb.map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (a, b) => {
    const [u, v] = [luminance(a), luminance(b)];
    return (Math.max(u, v) + 0.05) / (Math.min(u, v) + 0.05);
  };
  const opacity = element => {
    let all = 1;
    for (let e = element; e; e = e.parentElement) all *= Number(getComputedStyle(e).opacity);
    return all;
  };
  // What is behind an element of the page: the canvas of the browser, and the backgrounds above it.
  const ground = element => {
    const layers = [];
    for (let e = element; e; e = e.parentElement) {
      const style = getComputedStyle(e);
      if (style.backgroundImage !== 'none') fault('background', `a picture behind <${e.localName}>`);
      layers.push(colour(style.backgroundColor));
    }
    const canvas = view.paper || !view.dark || !getComputedStyle(root).colorScheme.includes('dark') ? 255 : 18;
    return layers.reverse().reduce((under, layer) => over(layer, under), [canvas, canvas, canvas]);
  };
  // What is behind a point of a picture: the areas that are painted before the text and hold the point.
  const behind = (element, [x, y]) => {
    const svg = element.ownerSVGElement;
    let under = ground(svg);
    for (const shape of svg.querySelectorAll('rect,path,circle,ellipse,polygon,polyline')) {
      if (!(shape.compareDocumentPosition(element) & Node.DOCUMENT_POSITION_FOLLOWING)) break;
      const style = getComputedStyle(shape);
      if (style.fill === 'none' || !seen(shape) || shape.closest('clipPath,defs')) continue;
      const box = shape.getBoundingClientRect();
      if (x < box.left || x > box.right || y < box.top || y > box.bottom) continue;
      const own = new DOMPoint(x, y).matrixTransform(shape.getScreenCTM().inverse());
      if (shape.isPointInFill(own)) under = over(colour(style.fill, Number(style.fillOpacity) * opacity(shape)), under);
    }
    return under;
  };
  const told = new Set();
  const tell = (kind, text) => {
    if (!told.has(text)) fault(kind, text);
    told.add(text);
  };
  for (const { element, text, quad, size } of texts) {
    const style = getComputedStyle(element);
    const drawn = element.namespaceURI.endsWith('svg');
    const [a, , c] = quad;
    let grounds;
    if (!drawn) grounds = [ground(element)];
    else if (style.paintOrder.startsWith('stroke') && parseFloat(style.strokeWidth) >= 3) grounds = [colour(style.stroke).slice(0, 3)];
    else grounds = [0.1, 0.5, 0.9].flatMap(u => [0.3, 0.7].map(v => behind(element, [a[0] + u * (c[0] - a[0]), a[1] + v * (c[1] - a[1])])));
    const ink = drawn ? colour(style.fill, Number(style.fillOpacity)) : colour(style.color);
    ink[3] *= opacity(element);
    const large = size >= 24 || size >= 18.66 && Number(style.fontWeight) >= 700;
    const worst = Math.min(...grounds.map(g => contrast(over(ink, g), g)));
    if (worst < (large ? 3 : 4.5)) tell('contrast', `${worst.toFixed(2)} of ${short(text)}`);
    if (size < 9) tell('small', `${size.toFixed(1)} px of ${short(text)}`);
  }

  // ---- Names, languages, references.

  const ids = new Map();
  for (const element of document.querySelectorAll('[id]')) ids.set(element.id, (ids.get(element.id) ?? 0) + 1);
  for (const [id, count] of ids) if (count > 1) fault('id', `${id} stands ${count} times`);
  const goal = (id, from) => {
    if (!ids.has(id)) fault('reference', `${from} to #${id}, which is not there`);
  };
  const called = element => {
    const by = (element.getAttribute('aria-labelledby') ?? '').split(/\s+/).filter(Boolean);
    const parts = by.map(id => document.getElementById(id)?.textContent ?? '');
    const title = [...element.children].find(e => e.localName === 'title');
    return [...parts, element.getAttribute('aria-label') ?? '', title?.textContent ?? ''].join('').trim();
  };
  for (const element of document.querySelectorAll('*')) {
    for (const { name, value } of element.attributes) {
      if (['aria-labelledby', 'aria-describedby', 'aria-controls', 'for', 'headers'].includes(name)) {
        value.split(/\s+/).filter(Boolean).forEach(id => goal(id, name));
      } else if (name.endsWith('href') && value.startsWith('#') && value.length > 1) {
        goal(decodeURIComponent(value.slice(1)), name);
      }
      for (const [, id] of value.matchAll(/url\(["']?#([^"')]+)/g)) goal(id, name);
    }
    if (element.localName === 'style') {
      for (const [, id] of element.textContent.matchAll(/url\(["']?#([^"')]+)/g)) goal(id, 'a style');
    }
  }
  for (const svg of document.querySelectorAll('svg')) {
    if (svg.parentElement.closest('svg')) continue;
    if (svg.getAttribute('role') !== 'img') fault('picture', `#${svg.id} has no role=img`);
    if (!called(svg)) fault('picture', `#${svg.id} has no name`);
  }
  for (const table of document.querySelectorAll('table')) {
    if (!table.querySelector('th')) fault('table', `${short(table.textContent)} has no headings`);
  }
  if (!root.lang) fault('language', 'the page tells none');
  if (!document.title.trim()) fault('title', 'the page has none');
  return faults;
})
